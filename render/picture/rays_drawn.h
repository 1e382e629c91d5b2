// render/picture/rays_drawn.h: the rays of a picture, and what their results depend on.
#pragma once

#include "render/engine.h"
#include "render/plan/planner.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tessera {

/// Those of the picture itself, and not of what is tried or estimated.
Rays picturesRays(const FramePlan& plan, bool layers);

/// Everything that a ray's result depends on, for a fixed scene and engine.
struct RaysDrawn {
    std::vector<std::uint8_t> levels;
    double stepVoxels;
    Hulls hulls;
    Integrator integrator;

    explicit RaysDrawn(const FramePlan& plan);
    friend bool operator==(const RaysDrawn&, const RaysDrawn&) = default;

    /// By name, in words.
    /// @param exact  the engine draws the true integral
    std::map<std::string, std::string> parts(const FramePlan& plan, bool exact) const;
};

/// A number by so many significant digits.
std::string digitsOf(double value, int digits);

} // namespace tessera
