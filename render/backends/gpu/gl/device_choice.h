// render/backends/gpu/gl/device_choice.h: the device of OpenGL that is asked for.
#pragma once

#include <string>

namespace tessera {

/// The device: "auto" (first that is not software, else software), "software" (Mesa's llvmpipe), or a number
/// from listGlDevices().
struct GlDeviceChoice {
    std::string text = "auto";
};

} // namespace tessera
