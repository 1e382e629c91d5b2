// tests/bench/accuracy/setting.h: a setting, one way to draw a scene, and the list of settings that a sweep
// measures. It is not the full product: a base setting, a sweep along each axis from it, and the product of
// step, integrator and fetch. That product is the work-precision figure.
#pragma once

#include "core/scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace tessera::accuracy {

/// Which bricks a picture is drawn from: settings of one of these share what is on the device.
struct Detail {
    bool finest = true;  // every brick that shows something at level 0, where that fits; else as chosen
    int memoryShare = 1; // the scene's bricks get 1/memoryShare of the GPU memory that they ask for
    std::optional<double> maxError; // predicted error that levels may have, L*u*v*; none: the best that fits
    EdgeFunction edgeFunction = Quality{}.edgeFunction;
    bool operator==(const Detail&) const = default;
};

struct Setting {
    double stepVoxels = Quality{}.stepVoxels;
    Integrator integrator = Integrator::automatic;
    Fetch fetch = Quality{}.fetch;
    double termination = Quality{}.terminationTransmittance; // 0: off
    std::optional<Gradient> gradient;                        // none: the scene is not lit
    Detail detail;
    bool operator==(const Setting&) const = default;
};

/// One setting and why it is there; a setting that several axes share is listed once, under the first.
struct Planned {
    Setting setting;
    std::string axis; // "product", "termination", "memory", "levels", "edges", "gradient", "default"
};

/// As the scene itself says.
Setting settingOf(const Scene& scene);
/// The scene with a setting's quality; the camera, the function and what it shows stay.
Scene withSetting(const Scene& scene, const Setting& setting);

/// Coarse steps of all methods come before finer ones.
/// @param quick  fewer steps and axes
/// @param integrators  of the product; empty: all
std::vector<Planned> plannedSettings(const Scene& scene, bool quick,
                                     const std::vector<Integrator>& integrators = {});

/// "preintegrated, exact": integrator and fetch: what is one curve of a figure.
std::string methodName(const Setting& setting);
/// "midpoint, hardware, step 1/2, termination 1/510, memory 1/4": all that differs from setting to setting.
std::string settingName(const Setting& setting);
/// 0.25 as "1/4", 2 as "2", 1/510 as "1/510"; 0 as "off".
std::string fractionText(double number);

} // namespace tessera::accuracy
