// render/reference_proof.cpp: see reference_proof.h.
#include "render/reference_proof.h"

#include "core/threads.h"
#include "render/lattice.h"
#include "render/reference_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tessera {
namespace {

template <typename F> ReferenceIntegrator over(double a, double b, const F& radiant) {
    ReferenceIntegrator integral;
    integral.add(a, b, radiant);
    return integral;
}
double relative(double computed, double exact) {
    return std::abs(computed - exact) / std::abs(exact);
}
constexpr double kTight = 1e-12, kLoose = 1e-10; // NUMERICS C2

ClosedFormError constantSlab() {
    ClosedFormError e{"T1", "constant slab, optical depth 1e-6 to 1e6", 0, kTight};
    for (int decade = -6; decade <= 6; ++decade) {
        const double x = std::pow(10, decade), exact = -std::expm1(-x);
        const auto r = over(0, 1, [x](double) { return RadiantPoint{x, glm::dvec3(1)}; });
        e.relativeError =
            std::max({e.relativeError, relative(r.alpha(), exact), relative(r.colour().r, exact)});
    }
    return e;
}

ClosedFormError exponentialSlab() {
    ClosedFormError e{"T3", "exponential slab", 0, kTight};
    for (const double scale : {0.05, 0.2, 5.0}) {
        const double exact = 3 * scale * -std::expm1(-2 / scale);
        const auto r = over(0, 2, [scale](double t) {
            return RadiantPoint{3 * std::exp(-t / scale), glm::dvec3(1)};
        });
        e.relativeError = std::max(e.relativeError, relative(r.depth(), exact));
    }
    return e;
}

ClosedFormError sphereChords() {
    ClosedFormError e{"T4", "chords of a uniform sphere", 0, kTight};
    for (const double b : {0.0, 0.5, 1.0, 1.9, 1.999, 1.999999}) {
        const double half = std::sqrt(4 - b * b);
        const auto r = over(-half, half, [](double) { return RadiantPoint{0.7, glm::dvec3(0.5)}; });
        e.relativeError = std::max(e.relativeError, relative(r.alpha(), -std::expm1(-1.4 * half)));
    }
    return e;
}

ClosedFormError gaussianBlob() {
    ClosedFormError e{"T5", "Gaussian blob", 0, kTight};
    const double s = 0.3, h = 2;
    for (const double b : {0.0, 0.4, 1.0}) {
        const auto r = over(-h, h, [b, s](double t) {
            return RadiantPoint{5 * std::exp(-(t * t + b * b) / (2 * s * s)), glm::dvec3(1)};
        });
        const double exact = 5 * s * std::sqrt(2 * std::numbers::pi) * std::exp(-b * b / (2 * s * s)) *
                             std::erf(h / (s * std::numbers::sqrt2));
        e.relativeError = std::max(e.relativeError, relative(r.depth(), exact));
    }
    return e;
}

ClosedFormError colourRamp() {
    ClosedFormError e{"T6", "colour ramp, optical depth 1e-6 to 1e6", 0, kTight};
    for (int decade = -6; decade <= 6; ++decade) {
        const double x = std::pow(10, decade), c0 = 0.2, c1 = 0.9;
        const auto r = over(0, 1, [=](double t) { return RadiantPoint{x, glm::dvec3(c0 + (c1 - c0) * t)}; });
        double ramp = -std::expm1(-x) / x - std::exp(-x);
        if (x < 0.5) { // by its series, which does not cancel: sum of -(-x)^k k/(k+1)!
            ramp = 0;
            double term = 1;
            for (int k = 1; k < 24; ++k) {
                term *= -x / (k + 1);
                ramp -= term * k;
            }
        }
        e.relativeError =
            std::max(e.relativeError, relative(r.colour().r, c0 * -std::expm1(-x) + (c1 - c0) * ramp));
    }
    return e;
}

ClosedFormError stepFunction() {
    ClosedFormError e{"T7", "step function across a ramp, cut at the step", 0, kTight};
    const double s0 = 0.3721;
    for (const double sigma : {1e-3, 4.0, 1e3}) {
        const auto f = [=](double t) { return RadiantPoint{t < s0 ? 0 : sigma, glm::dvec3(1)}; };
        ReferenceIntegrator r;
        r.add(0, s0, f);
        r.add(s0, 1, f);
        e.relativeError = std::max(e.relativeError, relative(r.alpha(), -std::expm1(-sigma * (1 - s0))));
    }
    return e;
}

ClosedFormError linearTimesLinear() {
    ClosedFormError e{"T8", "extinction and colour linear across a ramp", 0, kLoose};
    for (const double kappa : {0.01, 1.0, 10.0, 1000.0}) {
        const auto r = over(0, 1, [kappa](double u) { return RadiantPoint{kappa * u, glm::dvec3(u)}; });
        const double exact =
            std::sqrt(std::numbers::pi / (2 * kappa)) * std::erf(std::sqrt(kappa / 2)) - std::exp(-kappa / 2);
        e.relativeError = std::max(e.relativeError, relative(r.colour().b, exact));
    }
    return e;
}

/// Of the transmittance, where the depth stays below what the integrator calls opaque.
ClosedFormError boundaryLayer() {
    ClosedFormError e{"T11", "boundary layer k/(t+eps), eps 1e-2 to 1e-8", 0, kLoose};
    for (const double eps : {1e-2, 1e-4, 1e-6, 1e-8})
        for (const double k : {0.1, 0.5, 1.0, 2.0}) {
            const auto r = over(0, 1, [=](double t) { return RadiantPoint{k / (t + eps), glm::dvec3(1)}; });
            const double depth = k * (std::log1p(eps) - std::log(eps));
            e.relativeError = std::max({e.relativeError, std::abs(std::expm1(depth - r.depth())),
                                        relative(r.alpha(), -std::expm1(-depth))});
        }
    return e;
}

ClosedFormError surfaceInMedium() {
    ClosedFormError e{"surface", "a surface inside a constant medium, optical depth 1e-6 to 1e3", 0, kTight};
    const double at = 0.37, opacity = 0.4, medium = 0.8, surface = 0.3;
    for (int decade = -6; decade <= 3; ++decade) {
        const double x = std::pow(10, decade);
        const auto radiant = [&](double) { return RadiantPoint{x, glm::dvec3(medium)}; };
        ReferenceIntegrator r;
        r.add(0, at, radiant);
        r.addSurface(glm::dvec3(surface), opacity);
        r.add(at, 1, radiant);
        const double before = std::exp(-x * at);
        const double colour =
            medium * -std::expm1(-x * at) +
            before * (opacity * surface - (1 - opacity) * medium * std::expm1(-x * (1 - at)));
        const double alpha = opacity - (1 - opacity) * std::expm1(-x);
        e.relativeError =
            std::max({e.relativeError, relative(r.colour().g, colour), relative(r.alpha(), alpha)});
    }
    return e;
}

/// The second integrator: one ray through the field, by adaptive Simpson.
class SimpsonRay {
  public:
    SimpsonRay(const ReferenceInput& input, LatticeReader& samples)
        : function_(*input.function), surfaces_(input.surfaces), info_(*input.info), samples_(samples) {}

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

    /// Where the ray enters, crosses planes of sample centres, and leaves.
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
            const double stored = samples_.at(glm::max(glm::ivec3(0), glm::min(at, info_.extentVoxels - 1)));
            const double value = info_.rescaleSlope * stored + info_.rescaleIntercept;
            corners_[static_cast<std::size_t>(corner)] = value;
            lowest = std::min(lowest, value);
            highest = std::max(highest, value);
        }
        // Opacity is linear between points: without one inside, the ends of the range tell.
        const auto& kinks = function_.kinks();
        const auto kink = std::lower_bound(kinks.begin(), kinks.end(), lowest);
        const bool hasSurface = std::any_of(surfaces_.begin(), surfaces_.end(), [&](const Isosurface& s) {
            return lowest <= s.value && s.value <= highest;
        });
        if (!hasSurface && (kink == kinks.end() || *kink > highest) && function_.extinction(lowest) == 0 &&
            function_.extinction(highest) == 0) {
            before_ = std::numeric_limits<double>::quiet_NaN();
            return;
        }
        const double voxels = (to - from) * glm::length(ray.direction);
        const int panels = std::max(1, static_cast<int>(std::ceil(64 * voxels)));
        for (int i = 0; i < panels; ++i)
            addPanel(ray, from + (to - from) * i / panels, from + (to - from) * (i + 1) / panels);
    }

    double value(const ReferenceRay& ray, double t) const {
        const glm::dvec3 w = ray.base + t * ray.direction - 0.5 - low_;
        double sum = 0;
        for (std::size_t corner = 0; corner < 8; ++corner)
            sum += corners_[corner] * ((corner & 1) ? w.x : 1 - w.x) * ((corner & 2) ? w.y : 1 - w.y) *
                   ((corner & 4) ? w.z : 1 - w.z);
        return sum;
    }

    /// A place where a panel is cut, and the surface that is met there, if any.
    struct Cut {
        double at;
        const Isosurface* surface = nullptr;
    };

    /// Cuts [a,b] where the field meets a point of the function or a surface: sides that quarters of the
    /// panel can tell, each cut once more where the parabola through three of its values turns.
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
                colour_ += std::exp(-depth_) * surface->opacity * surface->colour;
                depth_ -= std::log1p(-surface->opacity);
            }
            if (i + 1 < cuts.size() && cuts[i + 1].at > cuts[i].at && depth_ < 45)
                addPiece(ray, cuts[i].at, cuts[i + 1].at);
        }
    }

    void cutBetween(const ReferenceRay& ray, double from, double to, std::vector<Cut>& cuts) {
        const double v0 = std::isnan(before_) ? value(ray, from) : before_, v1 = value(ray, to);
        before_ = v1;
        const auto& kinks = function_.kinks();
        for (auto k = std::lower_bound(kinks.begin(), kinks.end(), std::min(v0, v1));
             k != kinks.end() && *k <= std::max(v0, v1); ++k)
            cuts.push_back({meeting(ray, *k, from, to)});
        for (const Isosurface& surface : surfaces_)
            if ((v0 < surface.value) != (v1 < surface.value) && surface.opacity > 0)
                cuts.push_back({meeting(ray, surface.value, from, to), &surface});
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
        const auto at = [&](double t) {
            const double v = value(ray, std::clamp(t, a + inset, b - inset));
            return Point{function_.extinction(v), function_.colour(v)};
        };
        const Point pa = at(a), pm = at(0.5 * (a + b)), pb = at(b);
        halve(at, a, b, pa, pm, pb, simpson(b - a, pa, pm, pb), 0);
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
            std::max({std::abs(first.depth + second.depth - whole.depth), gap.x, gap.y, gap.z});
        if (halvings < kMaxHalvings && difference > kTolerance && depth_ < 45) {
            halve(at, a, m, pa, left, pm, first, halvings + 1);
            halve(at, m, b, pm, right, pb, second, halvings + 1);
            return;
        }
        colour_ += std::exp(-depth_) * both;
        depth_ += first.depth + second.depth;
    }

    const TransferFunction& function_;
    const std::vector<Isosurface>& surfaces_;
    const VolumeInfo& info_;
    LatticeReader& samples_;
    glm::dvec3 low_{0};
    std::array<double, 8> corners_{};
    double depth_ = 0;
    glm::dvec3 colour_{0};
    double before_ = 0; // the field where the part before ended; none where it was not looked at
};

double largestDifference(const std::vector<glm::dvec4>& a, const std::vector<glm::dvec4>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            const double d = std::abs(a[i][c] - b[i][c]);
            largest = std::isfinite(d) ? std::max(largest, d) : std::numeric_limits<double>::infinity();
        }
    return largest;
}

} // namespace

std::vector<ClosedFormError> closedFormErrors() {
    return {constantSlab(), exponentialSlab(),   sphereChords(),  gaussianBlob(),   colourRamp(),
            stepFunction(), linearTimesLinear(), boundaryLayer(), surfaceInMedium()};
}

RayProof proveOnRays(const ReferenceInput& input, const std::vector<ReferenceRay>& rays, int threads) {
    RayProof proof;
    proof.rays = rays.size();
    const std::vector<glm::dvec4> once = renderReference(input, rays, threads);
    ReferenceInput finer = input;
    finer.panels = 2 * input.panels;
    proof.halving = largestDifference(once, renderReference(finer, rays, threads));
    std::vector<glm::dvec4> simpson(rays.size());
    parallelFor(rays.size(), threads, [&](std::size_t i) {
        LatticeReader samples(*input.cache, *input.info, 0, nullptr);
        simpson[i] = SimpsonRay(input, samples)(rays[i]);
    });
    ReferenceInput unlit = input;
    unlit.shading.on = false;
    proof.independent =
        largestDifference(input.shading.on ? renderReference(unlit, rays, threads) : once, simpson);
    return proof;
}

std::vector<ReferenceRay> sampledRays(const std::vector<ReferenceRay>& rays, std::size_t count) {
    std::vector<ReferenceRay> sampled;
    for (std::size_t i = 0; i < std::min(count, rays.size()); ++i)
        sampled.push_back(rays[(2 * i + 1) * rays.size() / (2 * std::min(count, rays.size()))]);
    return sampled;
}

} // namespace tessera
