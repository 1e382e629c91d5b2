// render/engines/reference/reference.cpp: see reference.h. Between two planes of sample centres the field
// along a ray is a cubic; it is cut where it crosses a point of the transfer function or the value of an
// isosurface, and each smooth piece goes to the integrator (NUMERICS C2). Shading adds the planes where the
// values that the gradient is made of change their cell, and cuts where that gradient turns away from the
// ray.
#include "render/engines/reference/reference.h"

#include "core/image.h"
#include "core/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/sampler.h"
#include "render/engines/reference/reference_integrator.h"

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

/// The 4x4x4 samples around a cell: all that values and gradients in it can reach.
class Neighbourhood {
  public:
    Neighbourhood(LatticeReader& reader, const glm::ivec3& low, bool wide)
        : extent_(reader.extent()), first_(wide ? low - 1 : low), edge_(wide ? 4 : 2) {
        std::size_t n = 0;
        for (int z = 0; z < edge_; ++z)
            for (int y = 0; y < edge_; ++y)
                for (int x = 0; x < edge_; ++x)
                    values_[n++] =
                        reader.at(glm::clamp(first_ + glm::ivec3(x, y, z), glm::ivec3(0), extent_ - 1));
    }
    const glm::ivec3& extent() const { return extent_; }
    double at(const glm::ivec3& i) const {
        const glm::ivec3 local = glm::clamp(i - first_, glm::ivec3(0), glm::ivec3(edge_ - 1));
        return values_[static_cast<std::size_t>((local.z * edge_ + local.y) * edge_ + local.x)];
    }
    /// Range of the cell's own eight samples.
    void range(const glm::ivec3& low, double& lo, double& hi) const {
        lo = std::numeric_limits<double>::infinity();
        hi = -lo;
        for (int corner = 0; corner < 8; ++corner) {
            const double v = at(low + glm::ivec3(corner & 1, (corner >> 1) & 1, corner >> 2));
            lo = std::min(lo, v);
            hi = std::max(hi, v);
        }
    }

  private:
    glm::ivec3 extent_, first_;
    int edge_;
    std::array<double, 64> values_{};
};

/// A cubic in u in [0,1] through its values at 0, 1/3, 2/3, 1.
struct Cubic {
    double c0, c1, c2, c3;
    /// From differences, so that equal values give a constant.
    Cubic(double f0, double f1, double f2, double f3) : c0(f0) {
        const double d1 = f1 - f0, d2 = f2 - f0, d3 = f3 - f0;
        c1 = 9 * d1 - 4.5 * d2 + d3;
        c2 = -22.5 * d1 + 18 * d2 - 4.5 * d3;
        c3 = 13.5 * d1 - 13.5 * d2 + 4.5 * d3;
    }
    double operator()(double u) const { return c0 + u * (c1 + u * (c2 + u * c3)); }

    /// Ends of the pieces on which it is monotone, 0 and 1 included, ascending.
    std::size_t monotonePieces(std::array<double, 4>& ends) const {
        std::size_t n = 0;
        ends[n++] = 0;
        const double a = 3 * c3, b = 2 * c2, d = b * b - 4 * a * c1;
        if (d > 0 || a == 0) {
            std::array<double, 2> roots = {-1, -1};
            if (a == 0) {
                if (b != 0)
                    roots[0] = -c1 / b;
            } else {
                const double q = -0.5 * (b + std::copysign(std::sqrt(d), b));
                roots = {q / a, q != 0 ? c1 / q : -1};
            }
            std::sort(roots.begin(), roots.end());
            for (const double r : roots)
                if (r > ends[n - 1] && r < 1)
                    ends[n++] = r;
        }
        ends[n++] = 1;
        return n;
    }
};

/// The transfer function and the isosurfaces over stored values, with what the reference asks of them.
class StoredFunction {
  public:
    StoredFunction(const TransferFunction& function, std::vector<Isosurface> surfaces, const VolumeInfo& info)
        : function_(function), slope_(info.rescaleSlope), intercept_(info.rescaleIntercept),
          surfaces_(std::move(surfaces)) {
        for (const double kink : function.kinks())
            kinks_.push_back((kink - intercept_) / slope_);
        std::sort(kinks_.begin(), kinks_.end());
        std::erase_if(surfaces_, [](const Isosurface& surface) { return !(surface.opacity > 0); });
        for (Isosurface& surface : surfaces_)
            surface.value =
                static_cast<float>((surface.value - intercept_) / slope_); // as all engines have it
        std::stable_sort(surfaces_.begin(), surfaces_.end(),
                         [](const Isosurface& a, const Isosurface& b) { return a.value < b.value; });
    }
    double extinction(double stored) const { return function_.extinction(slope_ * stored + intercept_); }
    glm::dvec3 colour(double stored) const { return function_.colour(slope_ * stored + intercept_); }
    const std::vector<double>& kinks() const { return kinks_; }
    /// Those with an opacity, by value, ascending.
    const std::vector<Isosurface>& surfaces() const { return surfaces_; }
    /// Extinction is 0 on all of [lo,hi] and no isosurface there: extinction is piecewise monotone, so ends
    /// and kinks (both limits) decide.
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

  private:
    const TransferFunction& function_;
    double slope_, intercept_;
    std::vector<double> kinks_;        // stored values
    std::vector<Isosurface> surfaces_; // their values stored ones
};

/// Where monotone f crosses value between a and b; f(a) and f(b) lie on different sides.
double crossing(const Cubic& f, double value, double a, double b) {
    const bool rising = f(a) < value;
    for (int turn = 0; turn < 60; ++turn) {
        const double middle = 0.5 * (a + b);
        if ((f(middle) < value) == rising)
            a = middle;
        else
            b = middle;
    }
    return 0.5 * (a + b);
}

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
          emptyCells_(emptyCells), cells_(cellGrid(info_.extentVoxels)), panels_(input.panels) {}

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
        // The narrow block decides whether anything shows; only then is the wide one worth reading.
        const Neighbourhood narrow(samples_, low, false);
        double lo = 0, hi = 0;
        narrow.range(low, lo, hi);
        if (function_.emptyOver(lo, hi))
            return;
        const auto stored = [&](double t) { return cellValue(narrow, low, position(t)); };
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
        // lit: (colour, t) of a surface
        const auto addPieces = [&](const auto& radiant, const auto& lit) {
            auto met = met_.begin();
            for (std::size_t i = 0; i < cuts.size(); ++i) {
                for (; met != met_.end() && met->at <= cuts[i]; ++met)
                    integral.addSurface(lit(met->surface->colour, ta + met->at * length),
                                        met->surface->opacity);
                for (int k = 0; k < panels_ && i + 1 < cuts.size(); ++k) {
                    const auto at = [&](int panel) {
                        const double share = static_cast<double>(panel) / panels_;
                        return ta + (cuts[i] + (cuts[i + 1] - cuts[i]) * share) * length;
                    };
                    integral.add(at(k), at(k + 1), radiant);
                }
            }
        };
        const auto plain = [&](double t) {
            const double s = cubic((t - ta) / length);
            return RadiantPoint{function_.extinction(s), function_.colour(s)};
        };
        if (!optics_.shading)
            return addPieces(plain, [](const glm::dvec3& colour, double) { return colour; });
        const Neighbourhood wide(samples_, low, true);
        const glm::dvec3 direction = glm::normalize(ray.direction);
        const auto gradient = [&](double t) { return cellGradient(wide, low, position(t)); };
        cutWhereLightTurns([&](double u) { return gradient(ta + u * length); }, direction);
        const auto lit = [&](const glm::dvec3& colour, double t) {
            return shade(optics_, colour, gradient(t), direction);
        };
        addPieces(
            [&](double t) {
                RadiantPoint point = plain(t);
                if (point.extinction > 0)
                    point.colour = lit(point.colour, t);
                return point;
            },
            lit);
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

    /// Light is two-sided, so it has a corner where the gradient that is shaded turns away from the ray.
    /// Every kind of gradient is made of cubics between the planes that rays are cut at, and so is its
    /// product with a direction.
    template <typename GradientAt>
    void cutWhereLightTurns(const GradientAt& gradient, const glm::dvec3& direction) {
        const glm::dmat3 toGradient(optics_.voxelFromPatientTransposed), toPatient(optics_.patientFromVoxel);
        const glm::dvec3 along = glm::transpose(toGradient) * (toPatient * direction);
        const auto facing = [&](double u) { return glm::dot(gradient(u), along); };
        const Cubic cubic(facing(0), facing(1.0 / 3), facing(2.0 / 3), facing(1));
        std::array<double, 4> ends{};
        const std::size_t count = cubic.monotonePieces(ends);
        for (std::size_t i = 0; i + 1 < count; ++i)
            if ((cubic(ends[i]) < 0) != (cubic(ends[i + 1]) < 0))
                cuts_.push_back(crossing(cubic, 0, ends[i], ends[i + 1]));
        std::sort(cuts_.begin(), cuts_.end());
    }

    /// Trilinear in a given cell, also a rounding error outside of it, so that the cubic is exact.
    /// Beyond the outermost sample centres both samples of an axis are the same one.
    static double cellValue(const Neighbourhood& block, const glm::ivec3& low, const glm::dvec3& p) {
        return trilinear(block, low, low + 1, p - 0.5 - glm::dvec3(low));
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
    std::vector<double> cuts_;
    struct Met {
        double at; // of the interval, 0 to 1
        const Isosurface* surface;
    };
    std::vector<Met> met_;
    double lastEnd_ = 0, lastValue_ = 0; // where the interval before ended, and the field there
};

} // namespace

std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        int stride, const glm::dvec2& shift) {
    const RayPlane plane = rayPlane(camera, info, size);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    std::vector<ReferenceRay> rays;
    const glm::ivec2 kept = thinnedSize(size, stride);
    rays.reserve(static_cast<std::size_t>(kept.x) * static_cast<std::size_t>(kept.y));
    for (int y = 0; y < kept.y; ++y)
        for (int x = 0; x < kept.x; ++x) {
            const glm::dvec2 pixel(thinnedPixel({x, y}, size, stride));
            const PatientRay ray = pixelRay(plane, pixel + 0.5 + shift, size);
            rays.push_back({glm::dvec3(voxelFromPatient * glm::dvec4(ray.base, 1)),
                            glm::dmat3(voxelFromPatient) * ray.direction,
                            std::max(ray.minT, -std::numeric_limits<double>::max())});
        }
    return rays;
}

std::vector<glm::dvec4> renderReference(const ReferenceInput& input, const std::vector<ReferenceRay>& rays,
                                        int threads) {
    const StoredFunction function(*input.function, input.surfaces, *input.info);
    const Optics optics = makeOptics(TransferTable{}, *input.info, input.shading, 0); // for its shading alone
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
