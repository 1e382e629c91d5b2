// render/backends/reference/simpson_ray.h: the second integrator of the verification (reference_proof.h): one
// ray through the field by adaptive Simpson quadrature, from panels of 1/64 voxel on. Rays are cut where the
// field crosses a point of the function or an isosurface. Samples and function are read like the reference's
// (LatticeReader, TransferFunction). Gradients and light are pointwise, like the mirror's (sampler.h,
// optics.h). Interpolation, cuts, crossings and quadrature are its own. Kinks of the light are found by
// halving.
#pragma once

#include "core/base/volume.h"
#include "render/backends/reference/reference.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/contract/sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

namespace tessera {

class SimpsonRay {
  public:
    /// @param optics  for their shading alone
    SimpsonRay(const ReferenceInput& input, const Optics& optics, LatticeReader& samples)
        : function_(*input.function), surfaces_(input.surfaces), info_(*input.info), optics_(optics),
          samples_(samples) {
        const auto stored = [&](double value) {
            return (value - info_.rescaleIntercept) / info_.rescaleSlope;
        };
        for (const double kink : function_.kinks())
            kinks_.push_back(stored(kink));
        for (const Material& m : function_.materials())
            kinks_.insert(kinks_.end(), {stored(m.from), stored(m.to)});
        std::sort(kinks_.begin(), kinks_.end());
        for (Isosurface& surface : surfaces_)
            surface.value = static_cast<float>(stored(surface.value)); // as all engines have it
        std::stable_sort(surfaces_.begin(), surfaces_.end(),
                         [](const Isosurface& a, const Isosurface& b) { return a.value < b.value; });
    }

    glm::dvec4 operator()(const ReferenceRay& ray) {
        depth_ = 0;
        colour_ = glm::dvec3(0);
        before_ = std::numeric_limits<double>::quiet_NaN();
        const std::vector<double> ends = cellEnds(ray);
        for (std::size_t i = 0; i + 1 < ends.size() && depth_ < 45; ++i)
            addCell(ray, ends[i], ends[i + 1]);
        return {colour_, -std::expm1(-depth_)};
    }

  private:
    struct Point {
        double extinction;
        glm::dvec3 colour;
    };
    struct Panel {
        double depth;
        glm::dvec3 colour;
    };

    /// The ray's entry, crossings of planes of sample centres, and exit.
    std::vector<double> cellEnds(const ReferenceRay& ray) const {
        double first = ray.tMin, last = std::numeric_limits<double>::max();
        for (int axis = 0; axis < 3; ++axis) {
            const double from = ray.base[axis], along = ray.direction[axis],
                         extent = info_.extentVoxels[axis];
            if (along == 0 && (from < 0 || from > extent))
                return {};
            if (along == 0)
                continue;
            first = std::max(first, std::min(-from / along, (extent - from) / along));
            last = std::min(last, std::max(-from / along, (extent - from) / along));
        }
        if (!(first < last))
            return {};
        std::vector<double> ends = {first, last};
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < info_.extentVoxels[axis] && ray.direction[axis] != 0; ++i) {
                const double t = (i + 0.5 - ray.base[axis]) / ray.direction[axis];
                if (t > first && t < last)
                    ends.push_back(t);
            }
        std::sort(ends.begin(), ends.end());
        return ends;
    }

    void addCell(const ReferenceRay& ray, double from, double to) {
        if (!(to > from))
            return;
        const glm::dvec3 middle = ray.base + 0.5 * (from + to) * ray.direction;
        for (int axis = 0; axis < 3; ++axis)
            low_[axis] = std::floor(middle[axis] - 0.5);
        double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 at = glm::ivec3(low_) + glm::ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
            const double value = samples_.at(glm::max(glm::ivec3(0), glm::min(at, info_.extentVoxels - 1)));
            corners_[static_cast<std::size_t>(corner)] = value;
            lowest = std::min(lowest, value);
            highest = std::max(highest, value);
        }
        // Opacity is linear between points: without one inside, the ends of the range tell.
        const auto kink = std::lower_bound(kinks_.begin(), kinks_.end(), lowest);
        const bool hasKink = kink != kinks_.end() && *kink <= highest;
        const bool hasSurface = std::any_of(surfaces_.begin(), surfaces_.end(), [&](const Isosurface& s) {
            return lowest <= s.value && s.value <= highest;
        });
        if (!hasSurface && !hasKink && extinction(lowest) == 0 && extinction(highest) == 0) {
            before_ = std::numeric_limits<double>::quiet_NaN();
            return;
        }
        const double voxels = (to - from) * glm::length(ray.direction);
        const int panels = std::max(1, static_cast<int>(std::ceil(64 * voxels)));
        for (int i = 0; i < panels; ++i)
            addPanel(ray, from + (to - from) * i / panels, from + (to - from) * (i + 1) / panels);
    }

    double physical(double stored) const { return info_.rescaleSlope * stored + info_.rescaleIntercept; }
    double extinction(double stored) const { return function_.extinction(physical(stored)); }

    /// Stored units. From differences, so that a constant cell is constant.
    double value(const ReferenceRay& ray, double t) const {
        const glm::dvec3 w = ray.base + t * ray.direction - 0.5 - low_;
        const auto mixed = [](double a, double b, double share) { return a + share * (b - a); };
        const auto plane = [&](std::size_t first) {
            return mixed(mixed(corners_[first], corners_[first + 1], w.x),
                         mixed(corners_[first + 2], corners_[first + 3], w.x), w.y);
        };
        return mixed(plane(0), plane(4), w.z);
    }

    /// A cut of a panel, and the surface there, if any.
    struct Cut {
        double at;
        const Isosurface* surface = nullptr;
    };

    /// Cuts [a,b] where the field crosses a point of the function or a surface. It searches quarters of the
    /// panel, each split at the extremum of the parabola through three of its values.
    void addPanel(const ReferenceRay& ray, double a, double b) {
        std::vector<Cut> cuts = {{a}, {b}};
        double from = a;
        for (int part = 1; part <= 4; ++part) {
            const double end = a + (b - a) * part / 4;
            const double v0 = value(ray, from), v1 = value(ray, 0.5 * (from + end)), v2 = value(ray, end);
            const double bend = v0 - 2 * v1 + v2, turn = bend != 0 ? 0.25 * (3 * v0 - 4 * v1 + v2) / bend : 0;
            if (turn > 0 && turn < 1) {
                const double top = from + turn * (end - from);
                cutBetween(ray, from, top, cuts);
                from = top;
            }
            cutBetween(ray, from, end, cuts);
            from = end;
        }
        std::stable_sort(cuts.begin(), cuts.end(), [](const Cut& x, const Cut& y) { return x.at < y.at; });
        for (std::size_t i = 0; i < cuts.size(); ++i) {
            if (const Isosurface* surface = cuts[i].surface) {
                colour_ += std::exp(-depth_) * surface->opacity *
                           lit(ray, cuts[i].at, surface->colour, surface->value);
                depth_ -= std::log1p(-surface->opacity);
            }
            if (i + 1 < cuts.size() && cuts[i + 1].at > cuts[i].at && depth_ < 45)
                addPiece(ray, cuts[i].at, cuts[i + 1].at);
        }
    }

    void cutBetween(const ReferenceRay& ray, double from, double to, std::vector<Cut>& cuts) {
        const double v0 = std::isnan(before_) ? value(ray, from) : before_, v1 = value(ray, to);
        before_ = v1;
        for (auto k = std::lower_bound(kinks_.begin(), kinks_.end(), std::min(v0, v1));
             k != kinks_.end() && *k <= std::max(v0, v1); ++k)
            cuts.push_back({meeting(ray, *k, from, to)});
        // Surfaces are crossed in the order of the ray's values.
        const auto add = [&](const Isosurface& surface) {
            if ((v0 < surface.value) != (v1 < surface.value) && surface.drawnOpacity() > 0)
                cuts.push_back({meeting(ray, surface.value, from, to), &surface});
        };
        if (v1 > v0)
            std::for_each(surfaces_.begin(), surfaces_.end(), add);
        else
            std::for_each(surfaces_.rbegin(), surfaces_.rend(), add);
    }

    double meeting(const ReferenceRay& ray, double value0, double a, double b) const {
        const bool below = value(ray, a) < value0;
        for (int turn = 0; turn < 55; ++turn) {
            const double t = a + 0.5 * (b - a);
            ((value(ray, t) < value0) == below ? a : b) = t;
        }
        return b;
    }

    void addPiece(const ReferenceRay& ray, double a, double b) {
        const double inset = 1e-9 * (b - a); // a step is read from the side that the piece is on
        const auto at = [&](double place) {
            const double t = std::clamp(place, a + inset, b - inset), v = value(ray, t);
            const double tau = extinction(v) * factor(ray, t);
            const glm::dvec3 colour = function_.colour(physical(v));
            return Point{tau, tau > 0 ? lit(ray, t, colour, v) : colour};
        };
        const Point pa = at(a), pm = at(0.5 * (a + b)), pb = at(b);
        halve(at, a, b, pa, pm, pb, simpson(b - a, pa, pm, pb), 0);
    }

    /// Gradient opacity, by the scene's own points.
    double factor(const ReferenceRay& ray, double t) const {
        if (function_.gradientOpacity().isOne())
            return 1;
        const glm::dvec3 stored =
            fieldGradient(samples_, ray.base + t * ray.direction, 1.0, optics_.gradient);
        const glm::dmat3 toPatient = glm::transpose(glm::inverse(glm::dmat3(info_.patientFromVoxel)));
        return function_.gradientOpacity()
            .perMm(meanSpacingMm(info_))
            .factor(glm::length(info_.rescaleSlope * (toPatient * stored)));
    }

    glm::dvec3 lit(const ReferenceRay& ray, double t, const glm::dvec3& colour, double stored) const {
        if (!optics_.shading)
            return colour;
        const glm::dvec3 gradient =
            fieldGradient(samples_, ray.base + t * ray.direction, 1.0, optics_.normals);
        if (!optics_.hasLights)
            return shade(optics_, colour, gradient, ray.direction);
        leaf::Material<double> material{double{optics_.phong.x}, double{optics_.phong.y},
                                        double{optics_.phong.z}, optics_.specularPower};
        for (const Material& m : function_.materials())
            if (m.from <= physical(stored) && physical(stored) < m.to)
                material = {m.ambient,
                            m.diffuse,
                            m.specular,
                            m.specularPower,
                            {m.emission.r, m.emission.g, m.emission.b}};
        return shade(optics_, colour, gradient, ray.direction, ray.base + t * ray.direction, material);
    }

    static Panel simpson(double h, const Point& a, const Point& m, const Point& b) {
        const double half = h * (5 * a.extinction + 8 * m.extinction - b.extinction) / 24,
                     whole = h * (a.extinction + 4 * m.extinction + b.extinction) / 6;
        return {whole, h / 6 *
                           (a.extinction * a.colour + 4 * m.extinction * std::exp(-half) * m.colour +
                            b.extinction * std::exp(-whole) * b.colour)};
    }

    template <typename At>
    void halve(const At& at, double a, double b, const Point& pa, const Point& pm, const Point& pb,
               const Panel& whole, int halvings) {
        constexpr double kTolerance = 1e-12; // of a panel of 1/64 voxel or less
        constexpr int kMaxHalvings = 30;
        const double m = 0.5 * (a + b);
        const Point left = at(0.5 * (a + m)), right = at(0.5 * (m + b));
        const Panel first = simpson(m - a, pa, left, pm), second = simpson(b - m, pm, right, pb);
        const glm::dvec3 both = first.colour + std::exp(-first.depth) * second.colour;
        const glm::dvec3 gap = glm::abs(both - whole.colour);
        const double difference =
            std::max({std::abs(first.depth + second.depth - whole.depth), gap.x, gap.y, gap.z}) /
            std::max(1.0, std::max({pm.colour.x, pm.colour.y, pm.colour.z}) / 4); // of strong lights
        if (halvings < kMaxHalvings && difference > kTolerance && depth_ < 45) {
            halve(at, a, m, pa, left, pm, first, halvings + 1);
            halve(at, m, b, pm, right, pb, second, halvings + 1);
            return;
        }
        colour_ += std::exp(-depth_) * both;
        depth_ += first.depth + second.depth;
    }

    const TransferFunction& function_;
    std::vector<Isosurface> surfaces_; // by value, in stored units
    std::vector<double> kinks_;        // stored units, ascending
    const VolumeInfo& info_;
    const Optics& optics_;
    LatticeReader& samples_;
    glm::dvec3 low_{0};
    std::array<double, 8> corners_{};
    double depth_ = 0;
    glm::dvec3 colour_{0};
    double before_ = 0; // the field at the end of the part before; NaN if it was not evaluated
};

} // namespace tessera
