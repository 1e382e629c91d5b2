// render/backends/reference/ray_integral.h: the integral along one ray of one volume. Between two planes of
// sample centres the field along a ray is a cubic. It is cut where it crosses a point of the transfer
// function or the value of an isosurface, and each smooth piece goes to the integrator. Shading adds the
// planes where the values that the gradient is made of change their cell, and cuts where that gradient turns
// away from the ray. Occlusion and shadows have rays of their own (light_rays.h), at visible points.
#pragma once

#include "render/backends/reference/cell_gradients.h"
#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/light_rays.h"
#include "render/backends/reference/piece_of_ray.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/reference_integrator.h"
#include "render/backends/reference/stored_function.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {

/// Shared inputs of light rays, for all threads.
struct LightForRays {
    LightSources sources;
    Obstacles obstacles;
    EmptyCells emptyCells;
};
/// What all threads share of a volume. The input outlives it.
struct IntegralInput {
    const ReferenceInput& given;
    StoredFunction function;
    Optics optics;
    EmptyCells emptyCells;
    std::optional<LightForRays> light; // none: no occlusion or shadows
    std::optional<LightForRays> paths; // none: no paths of light

    explicit IntegralInput(const ReferenceInput& input)
        : given(input), function(*input.function, input.surfaces, *input.info), optics(shadingOf(input)),
          emptyCells(input, function) {
        const auto make = [&](std::optional<LightForRays>& rays) {
            rays.emplace(LightForRays{LightSources(input), Obstacles(function, *input.info), {}});
            rays->emptyCells = EmptyCells(input, rays->obstacles);
        };
        if (optics.lighting.channels > 0)
            make(light);
        if (input.paths)
            make(paths);
    }
    IntegralInput(const IntegralInput&) = delete;
    IntegralInput& operator=(const IntegralInput&) = delete;
};

/// All bricks at level 0.
inline Selection finestOf(const VolumeInfo& info) {
    Selection finest;
    finest.bricks = brickGrid(info.extentVoxels);
    finest.levels.assign(cellCount(finest.bricks), 0);
    finest.counts[0] = finest.levels.size();
    return finest;
}

class RayIntegral {
  public:
    /// For one thread; all outlive it.
    RayIntegral(const IntegralInput& of, LatticeReader& samples)
        : input_(of.given), info_(*input_.info), function_(of.function), optics_(of.optics),
          samples_(samples), emptyCells_(of.emptyCells), panels_(input_.panels),
          toPatient_(optics_.patientFromVoxel), lightTolerance_(input_.lightTolerance) {
        if (input_.labels)
            labels_.emplace(*input_.labels, finest_ = finestOf(info_), nullptr, info_.extentVoxels);
        if (of.light)
            lightRays_.emplace(info_, optics_, of.light->obstacles, of.light->sources, of.light->emptyCells,
                               samples_, labels_ ? &*labels_ : nullptr, panels_);
    }

    glm::dvec4 operator()(const ReferenceRay& ray) {
        RayLine<double> line{ray.base, ray.direction, ray.tMin, 1};
        double t0 = 0, t1 = 0;
        if (!drawnPart(line, t0, t1) || !((t1 = std::min(t1, ray.tMax)) >= t0))
            return glm::dvec4(0);
        parts_.assign(1, {t0, t1});
        if (input_.cuts)
            input_.cuts->parts(ray.base, ray.direction, t0, t1, parts_);
        if (input_.reduction != Reduction::composite)
            return keptValue(ray);
        ReferenceIntegrator integral(input_.thinness);
        lastLit_ = std::numeric_limits<double>::quiet_NaN();
        wayMm_ = t1 - t0;
        for (const RayCuts::Part& part : parts_)
            addPart(ray, part.from, part.to, planes(), integral);
        return glm::dvec4(integral.colour(), integral.alpha());
    }

    /// Drawn parts of the last ray, mm.
    const std::vector<RayPart>& parts() const { return parts_; }

    // For intervals that several volumes share (fused_integral.h).

    /// An interval between two planes of samples: the field, and what its colours depend on.
    struct Interval {
        std::optional<CellStretch> stretch;
        double length = 0; // mm
        std::optional<LabelsAlongRay> labels;
        std::optional<LightAlongRay> light, onMedium;
        std::optional<GradientAlongRay> graded; // of gradient opacity, where light has another
        std::vector<double> cuts;               // ascending, from 0 to 1: between them all is smooth
    };
    bool holdsNothing(const ReferenceRay& ray, double ta, double tb) const {
        return emptyCells_.hold(ray, ta, tb);
    }
    /// Begins the intervals of another ray.
    /// @param wayMm  of what is drawn of it
    void begin(double wayMm) {
        stretches_.begin();
        wayMm_ = wayMm;
        lastLit_ = std::numeric_limits<double>::quiet_NaN();
    }
    double planes() const { return planesOf(optics_, optics_.takesGradients()); }
    /// Shadows of others: multiplies shares of light at a place, patient space.
    void setOthers(std::function<void(const glm::dvec3& place, LightShares& shares)> others) {
        others_ = std::move(others);
    }
    /// Of the scene's light of voxels; null: it has none.
    LightRays* lightRays() { return lightRays_ ? &*lightRays_ : nullptr; }
    /// False where nothing shows. The light in `out` refers to this until the next one is prepared.
    bool prepare(const ReferenceRay& ray, double ta, double tb, const ReferenceIntegrator& integral,
                 Interval& out);
    /// The part of an interval between two of its cuts, or of others.
    struct Piece {
        FunctionPiece function;
        PieceOfRay radiant;
        bool shows = true;
        Piece(const RayIntegral& of, const Interval& interval, double from, double to);
        Piece(const Piece&) = delete;
        Piece& operator=(const Piece&) = delete;
    };

  private:
    LightShares lightAt(const glm::dvec3& voxel) {
        LightShares shares = lightRays_->at(voxel);
        if (others_)
            others_(glm::dvec3(info_.patientFromVoxel * glm::dvec4(voxel, 1)), shares);
        return shares;
    }
    void addPart(const ReferenceRay& ray, double t0, double t1, double planes,
                 ReferenceIntegrator& integral) {
        stretches_.begin();
        forEachInterval(ray, t0, t1, kCellExtent, 0, [&](double ta, double tb) {
            if (integral.opaque())
                return;
            if (emptyCells_.hold(ray, ta, tb))
                return;
            forEachInterval(ray, ta, tb, planes, 0.5,
                            [&](double a, double b) { addInterval(ray, a, b, integral); });
        });
    }

    bool drawnPart(const RayLine<double>& line, double& t0, double& t1) const {
        if (!clipToBox(line, glm::dvec3(info_.extentVoxels), t0, t1))
            return false;
        for (const RaySlab<double>& slab : input_.slabs)
            if (!clipToSlab(line, slab, t0, t1))
                return false;
        return t1 > t0 || (input_.flat && t1 == t0);
    }

    /// For rays that keep one value. Between planes of sample centres the field is a cubic: its extrema are
    /// at its ends or turning points, and its mean follows from the three-eighths rule.
    glm::dvec4 keptValue(const ReferenceRay& ray) {
        if (parts_.empty())
            return glm::dvec4(0);
        const auto position = [&](double t) { return ray.base + t * ray.direction; };
        double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0, way = 0;
        const auto add = [&](double ta, double tb) {
            const glm::ivec3 lowest(glm::floor(position(0.5 * (ta + tb)) - 0.5));
            const Cell cell(samples_, lowest);
            const auto stored = [&](double t) { return cell.at(position(t)); };
            const double length = tb - ta;
            const std::array<double, 4> f = {stored(ta), stored(ta + length / 3), stored(ta + 2 * length / 3),
                                             stored(tb)};
            const Cubic cubic(f[0], f[1], f[2], f[3]);
            std::array<double, 4> ends{};
            const std::size_t count = cubic.monotonePieces(ends);
            for (std::size_t i = 0; i < count; ++i) {
                const double value = i + 1 == count ? f[3] : cubic(ends[i]);
                low = std::min(low, value);
                high = std::max(high, value);
            }
            way += length;
            sum += length * (f[0] + 3 * f[1] + 3 * f[2] + f[3]) / 8;
        };
        for (const RayCuts::Part& part : parts_)
            if (part.to > part.from)
                forEachInterval(ray, part.from, part.to, 1.0, 0.5, add);
            else
                add(part.from, part.to);
        const bool greatest = (input_.reduction == Reduction::maximum) == (info_.rescaleSlope > 0);
        const double kept = input_.reduction == Reduction::average ? sum / way : greatest ? high : low;
        return glm::dvec4(
            colourOfValue(input_.look, *input_.function, info_.rescaleSlope * kept + info_.rescaleIntercept),
            1);
    }

    void addInterval(const ReferenceRay& ray, double ta, double tb, ReferenceIntegrator& integral) {
        if (!integral.opaque() && prepare(ray, ta, tb, integral, interval_))
            addPieces(interval_, integral);
    }

    struct CellLabels {
        const LabelsAlongRay* labels; // none: the scene has no labels
    };
    /// Cuts where the labels' medium begins to prevail over the function, because gradients change there.
    /// Changes closer together than 1/kParts of a piece may be missed.
    void cutWhereMediumPrevails(const Cubic& cubic, const CellLabels& cell, const GradientAlongRay* graded) {
        if (!cell.labels || !cell.labels->hasMedium())
            return;
        constexpr int kParts = 8;
        const std::vector<double> before = cuts_;
        for (std::size_t i = 0; i + 1 < before.size(); ++i) {
            const double from = before[i], to = before[i + 1];
            const FunctionPiece function = function_.pieceAround(cubic(0.5 * (from + to)));
            const auto prevails = [&](double u) {
                const double extinction =
                    function.extinctionAt(function.value(cubic(u))) * (graded ? graded->factor(u) : 1.0);
                return cell.labels->medium(u) > cell.labels->function(u, extinction);
            };
            for (int n = 0; to > from && n < kParts; ++n) {
                double a = from + (to - from) * n / kParts, b = from + (to - from) * (n + 1) / kParts;
                const bool first = prevails(a);
                if (first == prevails(b))
                    continue;
                for (int halving = 0; halving < 52; ++halving) {
                    const double middle = 0.5 * (a + b);
                    (prevails(middle) == first ? a : b) = middle;
                }
                cuts_.push_back(b);
            }
        }
        std::sort(cuts_.begin(), cuts_.end());
    }

    /// Computes received light into received_: from the first to the last visible position between cuts.
    void receive(const ReferenceRay& ray, double ta, double tb, const Cubic& cubic, double mostExtinction,
                 const CellLabels& cell, const ReferenceIntegrator& integral) {
        received_.clear();
        double first = 2, last = -1;
        for (std::size_t i = 0; i + 1 < cuts_.size(); ++i)
            if (cuts_[i] < cuts_[i + 1] &&
                ((cell.labels && cell.labels->hasMedium()) ||
                 !function_.pieceAround(cubic(0.5 * (cuts_[i] + cuts_[i + 1]))).isTransparent())) {
                first = std::min(first, cuts_[i]);
                last = cuts_[i + 1];
            }
        for (const Met& met : met_) {
            first = std::min(first, met.at);
            last = std::max(last, met.at);
        }
        if (first > last)
            return received_.add(0, 1, lastShares_);
        const auto placeOf = [&](double u) { return u == 1 ? tb : ta + u * (tb - ta); };
        const auto light = [&](double u) {
            const double t = placeOf(u);
            return t == lastLit_ ? lastShares_ : lightAt(ray.base + t * ray.direction);
        };
        const double length = (tb - ta) * (last - first);
        if (cell.labels && cell.labels->hasMedium())
            mostExtinction += double{optics_.labels.density};
        const double adds = met_.empty() ? -std::expm1(-mostExtinction * length) : 1;
        const LightBetween::Need need{lightTolerance_, std::exp(-integral.depth()) * adds, length / wayMm_};
        if (need.weight <= need.tolerance * need.part) // for any light
            received_.add(first, last, std::isnan(lastLit_) ? light(first) : lastShares_);
        else if (first < last)
            received_.add(first, last, lightRays_->channels(), need, light);
        else
            received_.add(first, last, light(first));
        if (need.weight > need.tolerance * need.part || std::isnan(lastLit_)) {
            lastLit_ = placeOf(last);
            lastShares_ = received_.last();
        }
    }

    /// Adds the pieces between the cuts, and the surfaces at some of them.
    void addPieces(const Interval& interval, ReferenceIntegrator& integral) {
        const LightAlongRay* const light = optics_.shading ? &*interval.light : nullptr;
        const std::vector<double>& cuts = interval.cuts;
        auto met = met_.begin();
        for (std::size_t i = 0; i < cuts.size(); ++i) {
            for (; met != met_.end() && met->at <= cuts[i]; ++met) {
                const glm::dvec3 colour = met->surface->drawnColour();
                integral.addSurface(
                    light ? light->lit(colour, met->at, function_.materialAt(met->surface->value, optics_))
                          : colour,
                    met->surface->drawnOpacity());
            }
            if (i + 1 == cuts.size())
                return;
            const double from = cuts[i], to = cuts[i + 1];
            const Piece piece(*this, interval, from, to);
            if (!piece.shows)
                continue;
            for (int k = 0; k < panels_; ++k) {
                const auto at = [&](int panel) {
                    return from + (to - from) * (static_cast<double>(panel) / panels_);
                };
                integral.add(at(k), at(k + 1), piece.radiant);
            }
        }
    }

    /// Appends the crossings of surfaces, in order along the ray, to met_ and cuts_.
    void findSurfaces(const CellStretch& stretch) {
        met_.clear();
        crossSurfaces(stretch, function_.surfaces(), [&](double u, std::size_t number) {
            met_.push_back({u, &function_.surfaces()[number]});
            cuts_.push_back(u);
            return false;
        });
    }

    const ReferenceInput& input_;
    const VolumeInfo& info_;
    const StoredFunction& function_;
    const Optics& optics_;
    LatticeReader& samples_;
    const EmptyCells& emptyCells_;
    int panels_;
    glm::dmat3 toPatient_;             // of directions
    std::vector<RayCuts::Part> parts_; // drawn parts of the ray
    Interval interval_;
    std::vector<double> cuts_;
    struct Met {
        double at; // of the interval, 0 to 1
        const Isosurface* surface;
    };
    std::vector<Met> met_;
    StretchesOfRay stretches_;
    Selection finest_; // for labels
    std::optional<LabelField> labels_;
    double wayMm_ = 0; // through the volume
    std::optional<LightRays> lightRays_;
    std::function<void(const glm::dvec3&, LightShares&)> others_;
    double lightTolerance_;
    LightBetween received_;
    double lastLit_ = 0; // last position with computed light
    LightShares lastShares_{};
};

inline bool RayIntegral::prepare(const ReferenceRay& ray, double ta, double tb,
                                 const ReferenceIntegrator& integral, Interval& out) {
    const auto position = [&](double t) { return ray.base + t * ray.direction; };
    const glm::ivec3 low(glm::floor(position(0.5 * (ta + tb)) - 0.5));
    // Neighbours are read only if something is visible in the cell.
    const Cell cell(samples_, low);
    const double lo = cell.lowest(), hi = cell.highest();
    out.labels.reset();
    if (labels_)
        out.labels.emplace(*labels_, position, ta, tb);
    if (function_.emptyOver(lo, hi) && !(out.labels && out.labels->hasMedium()))
        return false;
    out.stretch.emplace(stretches_.through(cell, position, ta, tb));
    const CellStretch& stretch = *out.stretch;
    const Cubic& cubic = stretch.cubic;
    out.length = tb - ta;
    out.light.reset();
    out.graded.reset();
    out.onMedium.reset();
    std::vector<double>& cuts = cuts_;
    cuts.assign(stretch.ends.begin(), stretch.ends.begin() + static_cast<std::ptrdiff_t>(stretch.count));
    const auto& kinks = function_.kinks();
    for (auto k = std::lower_bound(kinks.begin(), kinks.end(), lo); k != kinks.end() && *k <= hi; ++k)
        for (std::size_t i = 0; i + 1 < stretch.count; ++i)
            if ((cubic(stretch.ends[i]) < *k) != (cubic(stretch.ends[i + 1]) < *k))
                cuts.push_back(crossing(cubic, *k, stretch.ends[i], stretch.ends[i + 1]));
    findSurfaces(stretch);
    std::sort(cuts.begin(), cuts.end());
    if (out.labels)
        out.labels->forEachBorder([&](double u) { cuts.push_back(u); });
    std::sort(cuts.begin(), cuts.end());
    const CellLabels ofCell{out.labels ? &*out.labels : nullptr};
    if (!optics_.takesGradients()) {
        cutWhereMediumPrevails(cubic, ofCell, nullptr);
        out.cuts = cuts;
        return true;
    }
    const LightAlongRay& light = out.light.emplace(
        optics_, toPatient_ * ray.direction,
        gradientsInCell(samples_, low, optics_, optics_.shading ? optics_.normals : optics_.gradient,
                        position, ta, tb),
        position(ta), position(tb), lightRays_ ? &received_ : nullptr);
    if (optics_.grades() && optics_.shading && optics_.smooths())
        out.graded.emplace(optics_,
                           gradientsInCell(samples_, low, optics_, optics_.gradient, position, ta, tb));
    const GradientAlongRay& graded = out.graded ? *out.graded : static_cast<const GradientAlongRay&>(light);
    if (optics_.shading)
        light.forEachTurn([&](double u) { cuts.push_back(u); });
    if (optics_.grades())
        graded.forEachCorner([&](double u) { cuts.push_back(u); });
    std::sort(cuts.begin(), cuts.end());
    if (optics_.shading && out.labels && out.labels->hasMedium()) {
        out.onMedium.emplace(optics_, toPatient_ * ray.direction,
                             LabelsAlongRay::gradients(*labels_, optics_, position, ta, tb), position(ta),
                             position(tb), lightRays_ ? &received_ : nullptr);
        out.onMedium->forEachTurn([&](double u) { cuts.push_back(u); });
        std::sort(cuts.begin(), cuts.end());
    }
    cutWhereMediumPrevails(cubic, ofCell, optics_.grades() ? &graded : nullptr);
    if (lightRays_) {
        receive(ray, ta, tb, cubic, function_.mostExtinction(lo, hi), ofCell, integral);
        received_.forEachJoint([&](double u) { cuts.push_back(u); });
        std::sort(cuts.begin(), cuts.end());
    }
    out.cuts = cuts;
    return true;
}

inline RayIntegral::Piece::Piece(const RayIntegral& of, const Interval& interval, double from, double to)
    : function(of.function_.pieceAround(interval.stretch->cubic(0.5 * (from + to)))),
      radiant{interval.stretch->cubic,
              function,
              of.optics_.shading ? &*interval.light : nullptr,
              interval.length,
              of.function_.materialAt(interval.stretch->cubic(0.5 * (from + to)), of.optics_),
              !of.optics_.grades() ? nullptr
              : interval.graded    ? &*interval.graded
                                   : &*interval.light,
              interval.labels ? &*interval.labels : nullptr,
              of.optics_.shading && interval.onMedium ? &*interval.onMedium : nullptr},
      shows(!function.isTransparent() || (interval.labels && interval.labels->hasMedium())) {}

} // namespace tessera
