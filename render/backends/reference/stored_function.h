// render/backends/reference/stored_function.h: the transfer function and the isosurfaces over stored values,
// with the queries of the reference.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"
#include "render/contract/optics.h"

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace tessera {

/// The function between two neighbouring points. It ignores the function outside them, so values that
/// rounding moves beyond them are on the right side of a step.
class FunctionPiece {
  public:
    /// @param inside  a stored value between the points
    FunctionPiece(const TransferFunction& function, double slope, double intercept, double inside)
        : function_(&function), slope_(slope), intercept_(intercept) {
        const double value = slope * inside + intercept;
        const auto around = [value](const auto& points, auto& from, auto& rise, const auto& get) {
            const auto right = std::upper_bound(points.begin(), points.end(), value,
                                                [](double v, const auto& p) { return v < p.value; });
            const auto left = right == points.begin() ? right : right - 1;
            from = get(*left);
            if (right != points.begin() && right != points.end())
                rise = (get(*right) - from) / (right->value - left->value);
            return left->value;
        };
        if (!function.opacityPoints().empty())
            opacityFrom_ = around(function.opacityPoints(), opacity_, opacityRise_,
                                  [](const OpacityPoint& p) { return p.opacity; });
        if (!function.colourPoints().empty())
            colourFrom_ = around(function.colourPoints(), colour_, colourRise_,
                                 [](const ColourPoint& p) { return p.colour; });
        if (opacityRise_ == 0)
            extinction_ = function.extinctionOf(opacity_);
    }
    bool isTransparent() const { return opacityRise_ == 0 && extinction_ == 0; }
    bool hasOneExtinction() const { return opacityRise_ == 0; }
    /// 1/mm, of visible values.
    double extinction() const { return extinction_; }

    /// Physical units.
    template <typename V> V value(V stored) const { return V(slope_) * stored + V(intercept_); }
    double extinctionAt(double value) const {
        return function_->extinctionOf(std::max(0.0, opacity_ + (value - opacityFrom_) * opacityRise_));
    }
    /// @param channel  0 to 2
    template <typename V> V colourAt(V value, int channel) const {
        return V(colour_[channel]) + (value - V(colourFrom_)) * V(colourRise_[channel]);
    }

  private:
    const TransferFunction* function_;
    double slope_, intercept_;
    double opacityFrom_ = 0, colourFrom_ = 0; // physical units, as is the next
    double opacity_ = 0, opacityRise_ = 0, extinction_ = 0;
    glm::dvec3 colour_{1}, colourRise_{0};
};

class StoredFunction {
  public:
    StoredFunction(const TransferFunction& function, std::vector<Isosurface> surfaces, const VolumeInfo& info)
        : function_(function), slope_(info.rescaleSlope), intercept_(info.rescaleIntercept),
          surfaces_(std::move(surfaces)) {
        const auto cutAt = [&](double value) { kinks_.push_back((value - intercept_) / slope_); };
        for (const double kink : function.kinks())
            cutAt(kink);
        for (const Material& m : function.materials())
            cutAt(m.from), cutAt(m.to);
        std::sort(kinks_.begin(), kinks_.end());
        std::erase_if(surfaces_, [](const Isosurface& surface) { return !(surface.drawnOpacity() > 0); });
        for (Isosurface& surface : surfaces_)
            surface.value =
                static_cast<float>((surface.value - intercept_) / slope_); // as all engines have it
        std::stable_sort(surfaces_.begin(), surfaces_.end(),
                         [](const Isosurface& a, const Isosurface& b) { return a.value < b.value; });
    }
    double extinction(double stored) const { return function_.extinction(slope_ * stored + intercept_); }
    FunctionPiece pieceAround(double stored) const { return {function_, slope_, intercept_, stored}; }
    const std::vector<double>& kinks() const { return kinks_; }
    /// Light emitted by tissue.
    glm::dvec3 emission(double stored) const {
        const double value = slope_ * stored + intercept_;
        for (const Material& m : function_.materials())
            if (m.from <= value && value < m.to)
                return m.emission;
        return glm::dvec3(0);
    }
    /// The default material: that of optics.
    leaf::Material<double> materialAt(double stored, const Optics& optics) const {
        const double value = slope_ * stored + intercept_;
        for (const Material& m : function_.materials())
            if (m.from <= value && value < m.to)
                return {m.ambient,
                        m.diffuse,
                        m.specular,
                        m.specularPower,
                        {m.emission.r, m.emission.g, m.emission.b}};
        return {double{optics.phong.x}, double{optics.phong.y}, double{optics.phong.z}, optics.specularPower};
    }
    /// Surfaces with an opacity above 0, by ascending value.
    const std::vector<Isosurface>& surfaces() const { return surfaces_; }
    /// True if extinction is 0 on all of [lo,hi], without an isosurface: extinction is piecewise monotone, so
    /// ends and kinks (both limits) decide.
    bool emptyOver(double lo, double hi) const {
        for (const Isosurface& surface : surfaces_)
            if (lo <= surface.value && surface.value <= hi)
                return false;
        if (extinction(lo) != 0 || extinction(hi) != 0)
            return false;
        for (auto k = std::lower_bound(kinks_.begin(), kinks_.end(), lo); k != kinks_.end() && *k <= hi;
             ++k) {
            const double inside = std::nextafter(*k, -std::numeric_limits<double>::infinity());
            if (extinction(*k) != 0 || extinction(std::max(lo, inside)) != 0)
                return false;
        }
        return true;
    }

    /// The largest extinction on [lo,hi]: at its ends, or a limit at a kink. The function itself has the
    /// limit from above in physical units; that from below is beside the kink.
    double mostExtinction(double lo, double hi) const {
        double most = std::max(extinction(lo), extinction(hi));
        const double below = std::copysign(std::numeric_limits<double>::infinity(), -slope_);
        for (auto k = std::lower_bound(kinks_.begin(), kinks_.end(), lo); k != kinks_.end() && *k <= hi; ++k)
            most =
                std::max({most, extinction(*k), extinction(std::clamp(std::nextafter(*k, below), lo, hi))});
        return most;
    }

  private:
    const TransferFunction& function_;
    double slope_, intercept_;
    std::vector<double> kinks_;        // stored values
    std::vector<Isosurface> surfaces_; // their values stored ones
};

} // namespace tessera
