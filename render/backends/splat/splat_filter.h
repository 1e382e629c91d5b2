// render/backends/splat/splat_filter.h: which of three filters a patch of splats takes, and a footprint as
// it is drawn (docs/sampling.md, "Splats").
#pragma once

#include "render/backends/splat/splat_projection.h"
#include "render/backends/splat/splat_settings.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace tessera {

/// A splat as tiles draw it: q(x) = depth exp(-d^2 / 2), d^2 = xx dx^2 + 2 xy dx dy + yy dy^2 below the
/// cut-off's square, else 0.
struct DrawnSplat {
    float x = 0, y = 0;           // pixels
    float xx = 0, xy = 0, yy = 0; // the inverse variance
    float depth = 0;              // optical depth in the middle
    float halfWidth = 0, halfHeight = 0;
    float red = 0, green = 0, blue = 0; // not premultiplied
};

/// The depths at which patches of a level change their filter, mm.
struct FilterDepths {
    static constexpr double kLeast = 0.3, kMost = 2; // c_min, c_max of the paper
    double nearest = 0;                              // nearer: the kernel alone
    double farthest = 0;                             // farther: the pixel's filter alone

    /// @param level  of the samples
    static FilterDepths of(const SplatView& view, const SplatSettings& settings, int level) {
        const double voxels = settings.sigma * (1 << level) / settings.lowPass;
        return {kLeast * voxels * view.deviations.x * view.scale,
                kMost * view.widening * voxels * view.deviations.z * view.scale};
    }
    /// Of a patch, by the depths of its corners; a parallel camera's are all 1.
    SplatFilter choose(std::span<const double> corners) const {
        const auto [low, high] = std::minmax_element(corners.begin(), corners.end());
        if (*high < nearest)
            return SplatFilter::reconstruction;
        return *low > farthest ? SplatFilter::lowPass : SplatFilter::full;
    }
};

/// Numbers of footprints that are the same for all.
struct FilterNumbers {
    float filter; // variance of the pixel's filter
    float cutOff; // deviations
    float whole;  // 1 / (2 pi (1 - e^(-r^2 / 2)))

    explicit FilterNumbers(const SplatSettings& s)
        : filter(static_cast<float>(s.lowPass * s.lowPass)), cutOff(static_cast<float>(s.cutOff)),
          whole(static_cast<float>(-0.5 / (std::numbers::pi * std::expm1(-0.5 * s.cutOff * s.cutOff)))) {}
};

/// False where the footprint has no area.
/// @param filter  one of the first three
/// @param mass  optical depth times mm^2: extinction times volume
inline bool filtered(const Footprint& f, SplatFilter filter, const FilterNumbers& n, float mass,
                     DrawnSplat& out) {
    constexpr float kThinnest = 1e-12f; // pixels^4
    float xx = f.xx, xy = f.xy, yy = f.yy;
    if (filter == SplatFilter::lowPass)
        xx = yy = n.filter, xy = 0;
    else if (filter == SplatFilter::full)
        xx += n.filter, yy += n.filter;
    const float determinant = xx * yy - xy * xy;
    if (!(determinant > kThinnest))
        return false;
    const float inverse = 1 / determinant;
    out.x = f.at.x;
    out.y = f.at.y;
    out.xx = yy * inverse;
    out.xy = -xy * inverse;
    out.yy = xx * inverse;
    out.depth = mass * f.area * n.whole * std::sqrt(inverse);
    out.halfWidth = n.cutOff * std::sqrt(xx);
    out.halfHeight = n.cutOff * std::sqrt(yy);
    return true;
}

} // namespace tessera
