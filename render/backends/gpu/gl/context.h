// render/backends/gpu/gl/context.h: a headless GL 4.5 core context through EGL, on a device of the caller's
// choice. One thread owns GL: the context is current on the thread that made it, for as long as it lives.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

// The device of OpenGL that is asked for.

/// The device: "auto" (first that is not software, else software), "software" (Mesa's llvmpipe), or a number
/// from listGlDevices().
struct GlDeviceChoice {
    std::string text = "auto";
};

struct GlDevice {
    int number = 0;
    bool software = false;
    std::string extensions;
};
/// EGL devices of this machine; empty where EGL cannot list them.
std::vector<GlDevice> listGlDevices();

/// Throws InputError for a choice that is neither a word nor a listed number; opens nothing. For commands
/// that work for long before they need the device.
void checkGlDevice(const GlDeviceChoice& choice);

/// True if the system knows of a device that could draw: false without asking, or loading, OpenGL.
bool mayHaveGpu();
/// Of a GL_RENDERER: Mesa's llvmpipe or softpipe.
bool isSoftwareRenderer(std::string_view renderer);

class GlContext {
  public:
    /// Throws Error naming the missing part; InputError for a choice that is neither a word nor a listed
    /// number. A GPU that was asked for by number and turns out to be llvmpipe is an error, never a quiet
    /// fallback.
    explicit GlContext(const GlDeviceChoice& choice);
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    const std::string& renderer() const { return renderer_; } // GL_RENDERER
    const std::string& version() const { return version_; }   // GL_VERSION
    bool software() const { return software_; }
    int max3dTextureSize() const { return max3dTextureSize_; }
    std::int64_t maxStorageBlockBytes() const { return maxStorageBlockBytes_; }
    /// Most bytes one 3D texture may have here: llvmpipe fails above 2 GiB and is told to stay at 1.
    std::size_t maxTextureBytes() const { return software_ ? std::size_t{1} << 30 : std::size_t{1} << 36; }
    /// GL debug messages of high severity since the start.
    const std::vector<std::string>& errors() const { return *errors_; }

  private:
    void* display_ = nullptr;
    void* context_ = nullptr;
    std::string renderer_, version_;
    bool software_ = false;
    int max3dTextureSize_ = 0;
    std::int64_t maxStorageBlockBytes_ = 0;
    std::unique_ptr<std::vector<std::string>> errors_ = std::make_unique<std::vector<std::string>>();
};

} // namespace tessera
