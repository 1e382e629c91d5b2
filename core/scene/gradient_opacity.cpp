// core/scene/gradient_opacity.cpp: see gradient_opacity.h.
#include "core/scene/gradient_opacity.h"

#include "core/base/error.h"
#include "core/base/magnitude.h"

#include <algorithm>
#include <cmath>

namespace tessera {

GradientOpacity GradientOpacity::fromPoints(std::vector<GradientPoint> points, Per per,
                                            const std::string& where) {
    if (points.size() > kMostPoints)
        throw InputError(where + ": expected at most " + std::to_string(kMostPoints) + " points, found " +
                         std::to_string(points.size()));
    for (GradientPoint& p : points) {
        checkValue(p.length, "a gradient's length", where);
        if (!(p.length >= 0))
            throw InputError(where + ": expected lengths of 0 or more, found " + shownNumber(p.length));
        if (!std::isfinite(p.factor))
            throw InputError(where + ": expected finite numbers, found factor " + std::to_string(p.factor));
        p.factor = std::clamp(p.factor, 0.0, 1.0);
    }
    std::stable_sort(points.begin(), points.end(),
                     [](const GradientPoint& a, const GradientPoint& b) { return a.length < b.length; });
    GradientOpacity out;
    if (std::all_of(points.begin(), points.end(), [](const GradientPoint& p) { return p.factor == 1; }))
        return out;
    out.points_ = std::move(points);
    out.per_ = per;
    return out;
}

double GradientOpacity::factor(double length) const {
    if (points_.empty())
        return 1;
    const auto right = std::upper_bound(points_.begin(), points_.end(), length,
                                        [](double x, const GradientPoint& p) { return x < p.length; });
    if (right == points_.begin())
        return right->factor;
    const auto left = right - 1;
    if (right == points_.end())
        return left->factor;
    return left->factor +
           (length - left->length) / (right->length - left->length) * (right->factor - left->factor);
}

GradientOpacity GradientOpacity::perMm(double spacingMm) const {
    GradientOpacity out = *this;
    if (per_ == Per::voxel)
        for (GradientPoint& p : out.points_)
            p.length /= spacingMm;
    out.per_ = Per::mm;
    return out;
}

} // namespace tessera
