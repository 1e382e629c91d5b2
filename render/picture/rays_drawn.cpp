// render/picture/rays_drawn.cpp: see rays_drawn.h.
#include "render/picture/rays_drawn.h"

#include "render/picture/picture.h"
#include "render/pixels/kept_samples.h"
#include "render/plan/fusion.h"

#include <cstddef>
#include <cstdio>
#include <span>

namespace tessera {

Rays picturesRays(const FramePlan& p, bool layers) {
    Rays rays = raysOf(p);
    rays.paths = p.view.lighting.transport.has_value();
    rays.beginnings = rays.paths && layers;
    return rays;
}

RaysDrawn::RaysDrawn(const FramePlan& p)
    : levels(p.layer().selection.levels), stepVoxels(p.view.quality.stepVoxels), hulls(hullsOf(p.view.frame)),
      integrator(p.layer().optics.integrator) {
    for (const auto& volume : p.further) {
        const auto& more = volume->plan.layer().selection.levels;
        levels.insert(levels.end(), more.begin(), more.end());
    }
}

std::map<std::string, std::string> RaysDrawn::parts(const FramePlan& p, bool exact) const {
    const RayFrame<double>& frame = p.view.frame;
    const glm::dvec3 seen[] = {frame.centre, frame.right, frame.up, frame.toCentre};
    std::map<std::string, std::string> parts = {
        {"levels of bricks, which budgets choose:", fingerprint(std::as_bytes(std::span(levels)))},
        {"camera in the volume", fingerprint(std::as_bytes(std::span(seen)))},
        {"step in voxels", digitsOf(stepVoxels, 17)},
        {"integrator", integratorNames()[static_cast<std::size_t>(integrator)]},
        {"random numbers", exact ? "of the reference" : "of native and mirror"}};
    if (hulls.count > 0)
        parts["hulls and their samples"] =
            std::to_string(hulls.count) + " x " + std::to_string(hulls.samples);
    return parts;
}

std::string digitsOf(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

} // namespace tessera
