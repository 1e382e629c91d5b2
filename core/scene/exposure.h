// core/scene/exposure.h: the look of sums along rays: the light that tissue sends or takes, and the water
// that takes as much X-ray light (docs/sampling.md, "Sums along rays").
#pragma once

#include "core/image/image.h"
#include "core/scene/mode.h"

#include <glm/vec4.hpp>
#include <optional>

namespace tessera {

/// A sum is what a ray gathers of a medium `kThin` times as dense: colour and alpha.
struct Exposure {
    static constexpr float kThin = 0x1p-48f;

    Mode mode = Mode::emission; // or absorption, radiograph
    ValueColour colour = ValueColour::window;
    std::optional<GreyWindow> window; // of sums; none: from 0 to the greatest

    /// From 0 to the greatest sum that a picture of sums has.
    GreyWindow windowOf(const Image& sums) const;
    /// Premultiplied colour, linear light.
    /// @param window  has no effect on absorption
    /// @param meets  the ray meets what is drawn of the volume
    glm::vec4 shown(const glm::vec4& sum, const GreyWindow& window, bool meets) const;
};

/// Of a mode that adds up along rays. Throws InputError for windows and colours that such a mode has not.
Exposure exposureOf(Mode mode, ValueColour colour, const WindowChoice& window);

/// The extinction of a radiograph: 0 of air, 1 of water, linear in HU. Its integral is in mm of water.
/// @param highest  HU, of the volume
TransferFunction radiographFunction(double highest);
/// Shows the body, from its skin on, and no noise of air: what a radiograph's camera is fitted to.
TransferFunction bodyFunction();

} // namespace tessera
