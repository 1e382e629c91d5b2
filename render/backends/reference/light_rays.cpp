// render/backends/reference/light_rays.cpp: see light_rays.h. As for view rays, the field between two planes
// of sample centres is a cubic, cut where it crosses a point of the function. On a piece a four-point Gauss
// rule gives the optical depth, and the depth up to each of its points, from which the light left there
// follows. Pieces with a depth above a half are halved.
#include "render/backends/reference/light_rays.h"

#include "core/base/error.h"
#include "render/contract/ray.h"
#include "render/geometry/shape_shade.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tessera {
namespace {

/// Gauss-Legendre on [0,1]; inner[i][j]: the integral from 0 to node i of the j-th Lagrange polynomial.
struct Rule {
    static constexpr std::size_t kPoints = 4;
    std::array<double, kPoints> node, weight;
    std::array<std::array<double, kPoints>, kPoints> inner;
};
const Rule& gauss4() {
    static const Rule rule = [] {
        Rule r{};
        const double near = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(6.0 / 5)),
                     far = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(6.0 / 5));
        const double heavy = (18 + std::sqrt(30.0)) / 72, light = (18 - std::sqrt(30.0)) / 72;
        r.node = {(1 - far) / 2, (1 - near) / 2, (1 + near) / 2, (1 + far) / 2};
        r.weight = {light, heavy, heavy, light};
        for (std::size_t i = 0; i < Rule::kPoints; ++i)
            for (std::size_t j = 0; j < Rule::kPoints; ++j)
                for (std::size_t q = 0; q < Rule::kPoints; ++q) {
                    double lagrange = 1;
                    for (std::size_t m = 0; m < Rule::kPoints; ++m)
                        if (m != j)
                            lagrange *= (r.node[i] * r.node[q] - r.node[m]) / (r.node[j] - r.node[m]);
                    r.inner[i][j] += r.node[i] * r.weight[q] * lagrange;
                }
        return r;
    }();
    return rule;
}

/// Parts of a cell in which the extinction of labels is taken for monotone.
constexpr int kPartsOfLabels = 8;

/// Upper bound of light per voxel.
constexpr double kMostLight = 65535 / double{leaf::kLightOne};

/// (1 - exp(-depth)) / depth: the mean transmittance along a piece of constant extinction.
double meanLeft(double depth) {
    return depth > 1e-8 ? -std::expm1(-depth) / depth : 1 - 0.5 * depth;
}

} // namespace

Obstacles::Obstacles(const StoredFunction& function, const VolumeInfo& info)
    : function_(function), kinks_(function.kinks()) {
    const double voxelMm = std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
    for (const Isosurface& surface : function.surfaces()) {
        kinks_.push_back(surface.value);
        ofSurfaces_.push_back(-std::log1p(-std::min(surface.opacity, 1 - 0x1p-24)) / voxelMm);
    }
    std::sort(kinks_.begin(), kinks_.end());
}

bool Obstacles::emptyOver(double lo, double hi) const {
    const std::vector<Isosurface>& surfaces = function_.surfaces();
    return (surfaces.empty() || hi < surfaces.front().value) && function_.emptyOver(lo, hi);
}

double Obstacles::behindSurfaces(double stored) const {
    double sum = 0;
    for (std::size_t n = 0; n < ofSurfaces_.size() && stored >= function_.surfaces()[n].value; ++n)
        sum += ofSurfaces_[n];
    return sum;
}

LightRays::LightRays(const VolumeInfo& info, const Optics& optics, const Obstacles& obstacles,
                     const LightSources& sources, const EmptyCells& emptyCells, LatticeReader& samples,
                     LabelField* labels, int panels)
    : info_(info), optics_(optics), obstacles_(obstacles), sources_(sources), emptyCells_(emptyCells),
      samples_(samples), labels_(labels), panels_(panels),
      channels_(static_cast<int>(sources.casters.size()) + sources.ambientChannels),
      rejects_(sources.hasOcclusion && sources.occlusion.method == OcclusionMethod::rejecting),
      gathersEmission_(sources.ambientChannels > 1), toPatient_(info.patientFromVoxel),
      toVoxels_(glm::inverse(info.patientFromVoxel)) {
    if (labels || optics.grades())
        refuseHemisphere("labels or gradient opacity");
}

void LightRays::setOthers(std::vector<LightRays*> others) {
    others_ = std::move(others);
    if (!others_.empty())
        refuseHemisphere("several volumes");
}

/// Surfaces are known by the function of one volume alone.
void LightRays::refuseHemisphere(const char* beside) const {
    if (sources_.hasOcclusion && sources_.occlusion.directions == OcclusionDirections::hemisphere)
        throw InputError(std::string("lighting.occlusion.directions: expected sphere with ") + beside +
                         ", whose surfaces the reference does not know, found hemisphere");
}

LightShares LightRays::at(const glm::dvec3& voxel) {
    LightShares shares{};
    std::size_t channel = 0;
    const glm::dvec3 place(toPatient_ * glm::dvec4(voxel, 1));
    if (sources_.hasOcclusion) {
        const Occlusion& occlusion = sources_.occlusion;
        GatheredLight sum;
        double weights = 0;
        const bool hemisphere = occlusion.directions == OcclusionDirections::hemisphere;
        const SurfaceAround surface = hemisphere ? surfaceAt(voxel) : SurfaceAround{};
        for (const SphereDirection& direction : sources_.directions) {
            const double cosine = glm::dot(glm::dvec3(surface.normal), direction.towards);
            const double weight =
                direction.part * (1 - static_cast<double>(surface.share) * (1 - 4 * std::max(0.0, cosine)));
            weights += weight;
            if (!(weight > 0))
                continue;
            const GatheredLight light = gathered(place, direction.towards);
            sum.open += weight * light.open;
            sum.sent += weight * light.sent;
        }
        if (hemisphere)
            sum.open = weights > 0 ? sum.open / weights : 1;
        for (int c = 0; c < sources_.ambientChannels; ++c) {
            const double all = occlusion.bias + sum.open + occlusion.emission * sum.sent[c];
            shares[channel++] = std::min(kMostLight, std::pow(all, occlusion.gamma));
        }
    }
    for (const LightSources::Caster& light : sources_.casters)
        shares[channel++] = leftOf(light, place);
    return shares;
}

/// By the extinctions a voxel beside a place.
SurfaceAround LightRays::surfaceAt(const glm::dvec3& voxel) {
    const auto extinctionAt = [&](const glm::dvec3& p) {
        if (glm::any(glm::lessThan(p, glm::dvec3(0))) ||
            glm::any(glm::greaterThan(p, glm::dvec3(info_.extentVoxels))))
            return 0.0;
        const double stored = Cell(samples_, glm::ivec3(glm::floor(p - 0.5))).at(p);
        const FunctionPiece function = obstacles_.pieceAround(stored);
        return function.extinctionAt(function.value(stored)) + obstacles_.behindSurfaces(stored);
    };
    glm::dvec3 rise(0);
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 pitch(0);
        pitch[axis] = 1;
        const double before = extinctionAt(voxel - pitch), behind = extinctionAt(voxel + pitch);
        rise[axis] = 0.5 * (behind - before);
        sum += before + behind;
    }
    return surfaceAround(glm::vec3(rise), static_cast<float>(sum / 6),
                         glm::mat3(glm::transpose(glm::dmat3(toVoxels_))));
}

/// The share of a light that reaches a place, patient space.
double LightRays::leftOf(const LightSources::Caster& light, const glm::dvec3& place) {
    glm::dvec3 from = place;
    const glm::dvec3 towards = light.isPoint ? light.middle - place : light.middle;
    if (const double far = glm::length(towards); far > sources_.offsetMm || !light.isPoint)
        from += towards * (sources_.offsetMm / far);
    double sum = 0;
    for (const glm::dvec3& to : light.places) {
        const glm::dvec3 way = light.isPoint ? to - from : to;
        const double mm = light.isPoint ? glm::length(way) : std::numeric_limits<double>::infinity();
        sum += mm > 0 ? shadow(from, light.isPoint ? way / mm : way, mm) : 1;
    }
    return sum / static_cast<double>(light.places.size());
}

void LightRays::shade(const glm::dvec3& place, std::size_t channel, LightShares& shares) {
    for (const LightSources::Caster& light : sources_.casters)
        shares[channel++] *= leftOf(light, place);
}

double LightRays::shadow(const glm::dvec3& place, const glm::dvec3& direction, double mm) {
    const double past = shadeBetween(sources_.meshes, {place, direction}, 0, mm);
    return past > 0 ? past * walk<Ask::left>(place, direction, mm).left : 0;
}

GatheredLight LightRays::gathered(const glm::dvec3& place, const glm::dvec3& direction) {
    const double from = sources_.occlusion.offsetMm, mm = sources_.occlusion.radiusMm - from;
    if (!(mm > 0))
        return {1, {}}; // its limit as the ends meet
    const glm::dvec3 first = place + from * direction;
    std::optional<LeftByOthers> past;
    if (!others_.empty())
        past_ = &past.emplace(mm, [&](double a, double b) {
            double left = 1;
            for (LightRays* other : others_)
                left *= other->walk<Ask::left>(first + a * direction, direction, b - a).left;
            return left;
        });
    Walk light = pastMeshes(first, direction, mm);
    light.left *= past_ ? past_->at(mm) : 1;
    past_ = nullptr;
    if (sources_.occlusion.method == OcclusionMethod::local)
        return {light.seen / mm, light.sent / mm};
    return {light.left, {}};
}

/// Behind each surface of a mesh less is seen.
LightRays::Walk LightRays::pastMeshes(const glm::dvec3& first, const glm::dvec3& direction, double mm) {
    std::vector<ShadeStep> steps;
    shadeSteps(sources_.meshes, {first, direction}, 0, mm, steps);
    if (steps.empty())
        return walk<Ask::seen>(first, direction, mm);
    steps.push_back({mm, 0});
    Walk before, sum;
    double through = 1;
    for (const ShadeStep& step : steps) {
        if (!(through > 0))
            break;
        const Walk upTo = walk<Ask::seen>(first, direction, step.t);
        sum.seen += through * (upTo.seen - before.seen);
        sum.sent += through * (upTo.sent - before.sent);
        sum.left = through * upTo.left;
        before = upTo;
        through *= 1 - step.opacity;
    }
    sum.left = through > 0 ? sum.left : 0;
    return sum;
}

LightRays::Reached LightRays::reach(const glm::dvec3& from, const glm::dvec3& perMm, double mm,
                                    double share) {
    Walk walk;
    walk.until = share;
    along<Ask::place>({from, perMm, 0}, mm, walk);
    return {walk.reached, walk.left};
}

template <LightRays::Ask ask>
LightRays::Walk LightRays::walk(const glm::dvec3& place, const glm::dvec3& direction, double mm) {
    Walk walk;
    along<ask>({glm::dvec3(toVoxels_ * glm::dvec4(place, 1)), glm::dmat3(toVoxels_) * direction, 0}, mm,
               walk);
    return walk;
}

template <LightRays::Ask ask> void LightRays::along(const ReferenceRay& ray, double mm, Walk& walk) {
    double t0 = 0, t1 = 0;
    const RayLine<double> line{ray.base, ray.direction, 0, 1};
    if (!clipToBox(line, glm::dvec3(info_.extentVoxels), t0, t1) || !(t0 < mm)) {
        walk.seen = clear(0, mm);
        return;
    }
    t1 = std::min(t1, mm);
    walk.seen = clear(0, t0);
    const double planes = planesOf(optics_, optics_.grades());
    forEachInterval(ray, t0, t1, kCellExtent, 0, [&](double ta, double tb) {
        if (walk.ends())
            return;
        if (emptyCells_.hold(ray, ta, tb)) {
            walk.seen += walk.left * clear(ta, tb);
            return;
        }
        forEachInterval(ray, ta, tb, planes, 0.5, [&](double a, double b) {
            if (!walk.ends())
                throughCell<ask>(ray, a, b, walk);
        });
    });
    if (walk.ends())
        walk.left = 0;
    else if (t1 < mm)
        walk.seen += walk.left * clear(t1, mm);
}

template <LightRays::Ask ask>
void LightRays::throughCell(const ReferenceRay& ray, double ta, double tb, Walk& walk) {
    const auto position = [&](double t) { return ray.base + t * ray.direction; };
    const glm::ivec3 low(glm::floor(position(0.5 * (ta + tb)) - 0.5));
    const Cell cell(samples_, low);
    const double lo = cell.lowest(), hi = cell.highest(), length = tb - ta;
    std::optional<LabelsAlongRay> labels;
    if (labels_)
        labels.emplace(*labels_, position, ta, tb);
    const bool hasMedium = labels && labels->hasMedium();
    if (obstacles_.emptyOver(lo, hi) && !hasMedium) {
        walk.seen += walk.left * clear(ta, tb);
        return;
    }
    const auto stored = [&](double t) { return cell.at(position(t)); };
    const Cubic cubic(stored(ta), stored(ta + length / 3), stored(ta + 2 * length / 3), stored(tb));
    const auto& kinks = obstacles_.kinks();
    cuts_.clear();
    cuts_.push_back(0);
    const bool rejects = ask == Ask::seen && rejects_;
    if (auto k = std::lower_bound(kinks.begin(), kinks.end(), lo);
        rejects || (k != kinks.end() && *k <= hi)) {
        std::array<double, 4> ends{};
        const std::size_t count = cubic.monotonePieces(ends);
        for (std::size_t i = 1; rejects && i + 1 < count; ++i)
            cuts_.push_back(ends[i]);
        for (; k != kinks.end() && *k <= hi; ++k)
            for (std::size_t i = 0; i + 1 < count; ++i)
                if ((cubic(ends[i]) < *k) != (cubic(ends[i + 1]) < *k))
                    cuts_.push_back(crossing(cubic, *k, ends[i], ends[i + 1]));
    }
    std::optional<GradientAlongRay> gradient;
    if (optics_.grades()) {
        gradient.emplace(optics_,
                         gradientsInCell(samples_, low, optics_, optics_.gradient, position, ta, tb));
        gradient->forEachCorner([&](double u) { cuts_.push_back(u); });
        constexpr int kParts = 8; // in which the factor is monotone, or nearly so
        for (int n = 1; rejects && n < kParts; ++n)
            cuts_.push_back(static_cast<double>(n) / kParts);
    }
    std::sort(cuts_.begin(), cuts_.end());
    cuts_.push_back(1);
    if (labels)
        labels->forEachBorder([&](double u) { cuts_.insert(cuts_.end() - 1, u); });
    for (int n = 1; labels && rejects && n < kPartsOfLabels; ++n)
        cuts_.insert(cuts_.end() - 1, static_cast<double>(n) / kPartsOfLabels);
    std::sort(cuts_.begin(), cuts_.end());
    const CellOnWay onWay{cubic, ta, length, gradient ? &*gradient : nullptr, labels ? &*labels : nullptr};
    for (std::size_t i = 0; i + 1 < cuts_.size() && !walk.ends(); ++i) {
        const double from = cuts_[i], to = cuts_[i + 1];
        if (!(to > from))
            continue;
        const double inside = cubic(0.5 * (from + to)), behind = obstacles_.behindSurfaces(inside);
        const FunctionPiece function = obstacles_.pieceAround(inside);
        const auto extinctionAt = [&](double u) {
            return onWay.total(u, function.extinctionAt(function.value(cubic(u))));
        };
        const bool isEven = function.hasOneExtinction() && !gradient && !labels && !past_;
        const bool isNothing = function.isTransparent() && behind == 0 && !hasMedium;
        const double seenBefore = walk.seen;
        if (isNothing || (rejects && !isEven && extinctionAt(to) < extinctionAt(from))) {
            walk.seen += walk.left * clear(ta + length * from, ta + length * to);
        } else if (isEven) {
            const double depth = (function.extinction() + behind) * length * (to - from);
            if (ask == Ask::place && walk.left * std::exp(-depth) < walk.until)
                walk.reached =
                    ta + length * from + std::log(walk.left / walk.until) / (function.extinction() + behind);
            walk.seen += walk.left * length * (to - from) * meanLeft(depth);
            walk.left *= std::exp(-depth);
        } else {
            for (int n = 0; n < panels_; ++n)
                throughPiece<ask>(onWay, function, behind, from + (to - from) * n / panels_,
                                  from + (to - from) * (n + 1) / panels_, walk, 0);
        }
        if (gathersEmission_ && !isNothing)
            walk.sent += (walk.seen - seenBefore) * obstacles_.emission(inside);
    }
}

template <LightRays::Ask ask>
void LightRays::throughPiece(const CellOnWay& cell, const FunctionPiece& function, double behind, double u0,
                             double u1, Walk& walk, int halvings) {
    constexpr double kMostDepth = 0.5;
    constexpr double kMostGraded = 0.25; // of a cell: lengths of gradients are not polynomial
    constexpr int kMostHalvings = 12;
    const Rule& rule = gauss4();
    const double mm = (u1 - u0) * cell.length;
    std::array<double, Rule::kPoints> extinction{};
    double depth = 0;
    for (std::size_t i = 0; i < Rule::kPoints; ++i) {
        const double u = u0 + (u1 - u0) * rule.node[i];
        extinction[i] = cell.total(u, function.extinctionAt(function.value(cell.cubic(u)))) + behind;
        depth += rule.weight[i] * extinction[i];
    }
    depth *= mm;
    const auto placeOf = [&](double u) { return cell.begins + u * cell.length; };
    const double ofOthers = past_ ? past_->depth(placeOf(u1)) - past_->depth(placeOf(u0)) : 0;
    if ((depth + ofOthers > kMostDepth || ((cell.gradient || cell.labels) && u1 - u0 > kMostGraded)) &&
        halvings < kMostHalvings) {
        const double middle = 0.5 * (u0 + u1);
        throughPiece<ask>(cell, function, behind, u0, middle, walk, halvings + 1);
        if (!walk.ends())
            throughPiece<ask>(cell, function, behind, middle, u1, walk, halvings + 1);
        return;
    }
    if constexpr (ask == Ask::seen) {
        double mean = 0;
        for (std::size_t i = 0; i < Rule::kPoints; ++i) {
            double before = 0;
            for (std::size_t j = 0; j < Rule::kPoints; ++j)
                before += rule.inner[i][j] * extinction[j];
            const double past = past_ ? past_->at(placeOf(u0 + (u1 - u0) * rule.node[i])) : 1;
            mean += rule.weight[i] * past * std::exp(-mm * before);
        }
        walk.seen += walk.left * mm * mean;
    }
    if (ask == Ask::place && walk.left * std::exp(-depth) < walk.until) {
        // The rule's polynomial through the four extinctions, up to a share of the piece.
        const auto upTo = [&](double share) {
            double sum = 0;
            for (std::size_t i = 0; i < Rule::kPoints; ++i) {
                double at = 0; // by the same rule, over the part
                for (std::size_t j = 0; j < Rule::kPoints; ++j) {
                    double lagrange = 1;
                    for (std::size_t m = 0; m < Rule::kPoints; ++m)
                        if (m != j)
                            lagrange *= (share * rule.node[i] - rule.node[m]) / (rule.node[j] - rule.node[m]);
                    at += lagrange * extinction[j];
                }
                sum += rule.weight[i] * at;
            }
            return sum * share * mm;
        };
        const double sought = std::log(walk.left / walk.until);
        double low = 0, high = 1;
        for (int halving = 0; halving < 52; ++halving) {
            const double middle = 0.5 * (low + high);
            (upTo(middle) < sought ? low : high) = middle;
        }
        walk.reached = placeOf(u0 + (u1 - u0) * high);
    }
    walk.left *= std::exp(-depth);
}

} // namespace tessera
