// render/engines/reference/reference.cpp: see reference.h. Between two planes of sample centres the field
// along a ray is a cubic; it is cut where it crosses a point of the transfer function or the value of an
// isosurface, and each smooth piece goes to the integrator (NUMERICS C2). Shading adds the planes where the
// values that the gradient is made of change their cell, and cuts where that gradient turns away from the
// ray.
#include "render/engines/reference/reference.h"

#include "core/image.h"
#include "core/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/leaves.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/sampler.h"
#include "render/engines/reference/cubic.h"
#include "render/engines/reference/piece_of_ray.h"
#include "render/engines/reference/reference_integrator.h"
#include "render/engines/reference/stored_function.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace tessera {
namespace {

/// Calls visit(ta, tb) for each interval of [t0,t1] between crossings of the planes offset + k * spacing.
template <typename Visit>
void forEachInterval(const ReferenceRay& ray, double t0, double t1, double spacing, double offset,
                     const Visit& visit) {
    std::array<double, 3> plane{}, advance{}, next{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double d = ray.direction[axis];
        next[a] = std::numeric_limits<double>::infinity();
        if (d == 0)
            continue;
        const double at = (ray.base[axis] + t0 * d - offset) / spacing;
        plane[a] = d > 0 ? std::floor(at) + 1 : std::ceil(at) - 1;
        advance[a] = d > 0 ? 1 : -1;
        next[a] = (offset + plane[a] * spacing - ray.base[axis]) / d;
    }
    for (double t = t0; t < t1;) {
        const std::size_t a =
            static_cast<std::size_t>(std::min_element(next.begin(), next.end()) - next.begin());
        const double end = std::min(next[a], t1);
        if (end > t) {
            visit(t, end);
            t = end;
        }
        if (!(next[a] < t1))
            break;
        plane[a] += advance[a];
        next[a] = (offset + plane[a] * spacing - ray.base[static_cast<int>(a)]) /
                  ray.direction[static_cast<int>(a)];
    }
}

/// The eight samples of a cell of the field. Beyond the outermost sample centres both samples of an axis are
/// the same one.
class Cell {
  public:
    Cell(LatticeReader& reader, const glm::ivec3& low) : low_(low) { reader.cube<2>(low, values_.data()); }
    double lowest() const { return *std::min_element(values_.begin(), values_.end()); }
    double highest() const { return *std::max_element(values_.begin(), values_.end()); }
    /// Trilinear also a rounding error outside of the cell, so that the cubic is exact.
    double at(const glm::dvec3& p) const {
        const glm::dvec3 f = p - 0.5 - glm::dvec3(low_);
        return leaf::trilinear(values_[0], values_[1], values_[2], values_[3], values_[4], values_[5],
                               values_[6], values_[7], f.x, f.y, f.z);
    }

  private:
    glm::ivec3 low_;
    std::array<double, 8> values_;
};

/// The 4x4x4 samples around a cell: all that gradients in it can reach.
class Neighbourhood {
  public:
    Neighbourhood(LatticeReader& reader, const glm::ivec3& low) : extent_(reader.extent()), first_(low - 1) {
        reader.cube<4>(first_, values_.data());
    }
    const glm::ivec3& extent() const { return extent_; }
    double at(const glm::ivec3& i) const {
        const glm::ivec3 local = glm::clamp(i - first_, glm::ivec3(0), glm::ivec3(3));
        return values_[static_cast<std::size_t>((local.z * 4 + local.y) * 4 + local.x)];
    }

  private:
    glm::ivec3 extent_, first_;
    std::array<double, 64> values_;
};

/// Planes of sample centres bound the cells of the field. Differences over half a pitch take values half a
/// voxel off, which change their cells at the planes between; all others change theirs where the field does.
bool cutsHalfwayBetweenSamples(Gradient gradient) {
    return gradient == Gradient::forward || gradient == Gradient::centralHalf;
}

class RayIntegral {
  public:
    RayIntegral(const ReferenceInput& input, const StoredFunction& function, const Optics& optics,
                LatticeReader& samples, const std::vector<bool>& emptyCells)
        : info_(*input.info), function_(function), optics_(optics), samples_(samples),
          emptyCells_(emptyCells), cells_(cellGrid(info_.extentVoxels)), panels_(input.panels),
          toGradient_(optics.voxelFromPatientTransposed), toPatient_(optics.patientFromVoxel) {}

    glm::dvec4 operator()(const ReferenceRay& ray) {
        RayLine<double> line{ray.base, ray.direction, ray.tMin, 1};
        double t0 = 0, t1 = 0;
        if (!clipToBox(line, glm::dvec3(info_.extentVoxels), t0, t1))
            return glm::dvec4(0);
        ReferenceIntegrator integral;
        lastEnd_ = std::numeric_limits<double>::quiet_NaN();
        const bool halves = optics_.shading && cutsHalfwayBetweenSamples(optics_.gradient);
        forEachInterval(ray, t0, t1, kCellExtent, 0, [&](double ta, double tb) {
            if (integral.opaque())
                return;
            const glm::dvec3 middle = ray.base + 0.5 * (ta + tb) * ray.direction;
            const glm::ivec3 cell =
                glm::clamp(glm::ivec3(glm::floor(middle)) / kCellExtent, glm::ivec3(0), cells_ - 1);
            if (!emptyCells_.empty() && emptyCells_[linearIndex(cell, cells_)])
                return;
            forEachInterval(ray, ta, tb, halves ? 0.5 : 1.0, 0.5,
                            [&](double a, double b) { addInterval(ray, a, b, integral); });
        });
        return glm::dvec4(integral.colour(), integral.alpha());
    }

  private:
    void addInterval(const ReferenceRay& ray, double ta, double tb, ReferenceIntegrator& integral) {
        if (integral.opaque())
            return;
        const auto position = [&](double t) { return ray.base + t * ray.direction; };
        const glm::ivec3 low(glm::floor(position(0.5 * (ta + tb)) - 0.5));
        // The cell decides whether anything shows; only then are its neighbours worth reading.
        const Cell cell(samples_, low);
        const double lo = cell.lowest(), hi = cell.highest();
        if (function_.emptyOver(lo, hi))
            return;
        const auto stored = [&](double t) { return cell.at(position(t)); };
        const double length = tb - ta;
        // Where intervals meet the field has one value, or a surface there would be met twice or never.
        const double first = ta == lastEnd_ ? lastValue_ : stored(ta), last = stored(tb);
        lastEnd_ = tb;
        lastValue_ = last;
        const Cubic cubic(first, stored(ta + length / 3), stored(ta + 2 * length / 3), last);
        std::vector<double>& cuts = cuts_;
        cuts.clear();
        std::array<double, 4> ends{};
        const std::size_t count = cubic.monotonePieces(ends);
        for (std::size_t i = 0; i < count; ++i)
            cuts.push_back(ends[i]);
        const auto& kinks = function_.kinks();
        for (auto k = std::lower_bound(kinks.begin(), kinks.end(), lo); k != kinks.end() && *k <= hi; ++k)
            for (std::size_t i = 0; i + 1 < count; ++i)
                if ((cubic(ends[i]) < *k) != (cubic(ends[i + 1]) < *k))
                    cuts.push_back(crossing(cubic, *k, ends[i], ends[i + 1]));
        findSurfaces(cubic, std::span(ends).first(count), first, last);
        std::sort(cuts.begin(), cuts.end());
        if (!optics_.shading)
            return addPieces(cubic, length, nullptr, integral);
        const Neighbourhood around(samples_, low);
        const auto gradient = [&](double t) { return toGradient_ * cellGradient(around, low, position(t)); };
        const LightAlongRay light(
            optics_, toPatient_ * ray.direction,
            {gradient(ta), gradient(ta + length / 3), gradient(ta + 2 * length / 3), gradient(tb)},
            position(ta), position(tb));
        light.forEachTurn([&](double u) { cuts.push_back(u); });
        std::sort(cuts.begin(), cuts.end());
        addPieces(cubic, length, &light, integral);
    }

    /// What lies between the cuts, and the surfaces that are met at some of them.
    /// @param light  none: colours stay as they are
    void addPieces(const Cubic& cubic, double length, const LightAlongRay* light,
                   ReferenceIntegrator& integral) {
        auto met = met_.begin();
        for (std::size_t i = 0; i < cuts_.size(); ++i) {
            for (; met != met_.end() && met->at <= cuts_[i]; ++met) {
                const glm::dvec3& colour = met->surface->colour;
                integral.addSurface(
                    light ? light->lit(colour, met->at, function_.materialAt(met->surface->value, optics_))
                          : colour,
                    met->surface->opacity);
            }
            if (i + 1 == cuts_.size())
                return;
            const double from = cuts_[i], to = cuts_[i + 1];
            const double inside = cubic(0.5 * (from + to));
            const FunctionPiece function = function_.pieceAround(inside);
            if (function.isTransparent())
                continue;
            const PieceOfRay piece{cubic, function, light, length, function_.materialAt(inside, optics_)};
            for (int k = 0; k < panels_; ++k) {
                const auto at = [&](int panel) {
                    return from + (to - from) * (static_cast<double>(panel) / panels_);
                };
                integral.add(at(k), at(k + 1), piece);
            }
        }
    }

    /// The crossings of surfaces, in the order in which the ray meets them, into met_ and cuts_. Below a
    /// value is one side of its surface, the rest the other.
    /// @param ends  of the pieces on which the cubic is monotone
    void findSurfaces(const Cubic& cubic, std::span<const double> ends, double first, double last) {
        met_.clear();
        const std::vector<Isosurface>& surfaces = function_.surfaces();
        for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
            const double a = i == 0 ? first : cubic(ends[i]);
            const double b = i + 2 == ends.size() ? last : cubic(ends[i + 1]);
            for (std::size_t n = 0; n < surfaces.size(); ++n) {
                const Isosurface& surface = surfaces[a < b ? n : surfaces.size() - 1 - n];
                if ((a < surface.value) == (b < surface.value))
                    continue;
                met_.push_back({crossing(cubic, surface.value, ends[i], ends[i + 1]), &surface});
                cuts_.push_back(met_.back().at);
            }
        }
    }

    /// The gradient that the scene shades by, at a place in a given cell. The analytic one jumps between
    /// cells, so there the cell decides, not the rounding of the place.
    glm::dvec3 cellGradient(const Neighbourhood& block, const glm::ivec3& low, const glm::dvec3& p) const {
        if (optics_.gradient != Gradient::analytic)
            return fieldGradient(block, p, 1.0, optics_.gradient);
        return trilinearSlope(block, low, low + 1, p - 0.5 - glm::dvec3(low)).slope;
    }

    const VolumeInfo& info_;
    const StoredFunction& function_;
    const Optics& optics_;
    LatticeReader& samples_;
    const std::vector<bool>& emptyCells_;
    glm::ivec3 cells_;
    int panels_;
    glm::dmat3 toGradient_, toPatient_; // of gradients and of directions
    std::vector<double> cuts_;
    struct Met {
        double at; // of the interval, 0 to 1
        const Isosurface* surface;
    };
    std::vector<Met> met_;
    double lastEnd_ = 0, lastValue_ = 0; // where the interval before ended, and the field there
};

} // namespace

namespace {

/// A camera's rays by their places on the picture, in pixels.
class RayMaker {
  public:
    RayMaker(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size)
        : plane_(rayPlane(camera, info, size)), size_(size),
          voxelFromPatient_(glm::inverse(info.patientFromVoxel)) {}
    ReferenceRay operator()(const glm::dvec2& place) const {
        const PatientRay ray = pixelRay(plane_, place, size_);
        return {glm::dvec3(voxelFromPatient_ * glm::dvec4(ray.base, 1)),
                glm::dmat3(voxelFromPatient_) * ray.direction,
                std::max(ray.minT, -std::numeric_limits<double>::max())};
    }

  private:
    RayPlane plane_;
    glm::ivec2 size_;
    glm::dmat4 voxelFromPatient_;
};

} // namespace

std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        int stride, const glm::dvec2& shift) {
    const RayMaker ray(camera, info, size);
    std::vector<ReferenceRay> rays;
    const glm::ivec2 kept = thinnedSize(size, stride);
    rays.reserve(static_cast<std::size_t>(kept.x) * static_cast<std::size_t>(kept.y));
    for (int y = 0; y < kept.y; ++y)
        for (int x = 0; x < kept.x; ++x) {
            const glm::dvec2 pixel(thinnedPixel({x, y}, size, stride));
            rays.push_back(ray(pixel + 0.5 + shift));
        }
    return rays;
}

std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        std::span<const glm::vec2> places) {
    const RayMaker ray(camera, info, size);
    std::vector<ReferenceRay> rays;
    rays.reserve(places.size());
    for (const glm::vec2& place : places)
        rays.push_back(ray(glm::dvec2(place)));
    return rays;
}

Optics shadingOf(const ReferenceInput& input) {
    Optics optics = makeOptics(TransferTable{}, *input.info, input.shading, 0);
    setLighting(optics, input.shading, input.lighting, input.function->materials(), input.camera,
                *input.info);
    return optics;
}

std::vector<glm::dvec4> renderReference(const ReferenceInput& input, const std::vector<ReferenceRay>& rays,
                                        int threads) {
    const StoredFunction function(*input.function, input.surfaces, *input.info);
    const Optics optics = shadingOf(input);
    std::vector<bool> emptyCells;
    if (const Statistics* s = input.statistics) {
        emptyCells.resize(s->cellMin.size());
        for (std::size_t i = 0; i < emptyCells.size(); ++i)
            emptyCells[i] =
                function.emptyOver(static_cast<double>(s->cellMin[i]), static_cast<double>(s->cellMax[i]));
    }
    constexpr std::size_t kStrip = 16;
    std::vector<glm::dvec4> out(rays.size());
    parallelFor((rays.size() + kStrip - 1) / kStrip, threads,
                [&](std::size_t strip) {
                    LatticeReader samples(*input.cache, *input.info, 0, nullptr);
                    RayIntegral integral(input, function, optics, samples, emptyCells);
                    for (std::size_t i = strip * kStrip; i < std::min(rays.size(), (strip + 1) * kStrip); ++i)
                        out[i] = integral(rays[i]);
                },
                input.progress);
    return out;
}

} // namespace tessera
