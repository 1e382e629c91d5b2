// render/backends/reference/fused_integral.cpp: see fused_integral.h.
#include "render/backends/reference/fused_integral.h"

#include "core/base/threads.h"
#include "render/backends/reference/ray_integral.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <glm/mat3x3.hpp>
#include <memory>

namespace tessera {
namespace {

/// One of the volumes, for one thread.
struct FusedVolume {
    const ReferenceInput& input;
    LatticeReader samples;
    RayIntegral integral;
    // Of the ray at hand:
    ReferenceRay ray;
    double enters = 0, leaves = 0;
    std::vector<RayCuts::Part> parts; // that its own cuts leave of it
    // Of the interval at hand:
    bool shows = false;
    RayIntegral::Interval interval;

    explicit FusedVolume(const IntegralInput& of)
        : input(of.given), samples(*input.cache, *input.info, 0, nullptr), integral(of, samples) {}

    void begin(const ReferenceRay& lattice, double t0, double t1) {
        ray = {glm::dvec3(input.fromLattice * glm::dvec4(lattice.base, 1)),
               glm::dmat3(input.fromLattice) * lattice.direction, lattice.tMin};
        integral.begin(t1 - t0);
        const RayLine<double> line{ray.base, ray.direction, t0, 1};
        if (!clipToBox(line, glm::dvec3(input.info->extentVoxels), enters, leaves))
            enters = leaves = t1;
        enters = std::max(enters, t0), leaves = std::min(leaves, t1);
        parts.assign(1, {enters, leaves});
        if (leaves > enters && input.ownCuts && input.ownCuts->any())
            input.ownCuts->parts(ray.base, ray.direction, enters, leaves, parts);
    }
    void addCuts(std::vector<double>& cuts) const {
        if (!(leaves > enters))
            return;
        const auto add = [&](double, double end) { cuts.push_back(end); };
        cuts.push_back(enters);
        for (const RayCuts::Part& part : parts) {
            cuts.push_back(part.from);
            cuts.push_back(part.to);
        }
        forEachInterval(ray, enters, leaves, integral.planes(), 0.5, add);
        forEachInterval(ray, enters, leaves, kCellExtent, 0, add);
    }
    void prepare(double ta, double tb, const ReferenceIntegrator& sum) {
        const double middle = 0.5 * (ta + tb);
        const bool isKept = std::any_of(parts.begin(), parts.end(), [&](const RayCuts::Part& part) {
            return part.from < middle && middle < part.to;
        });
        shows = isKept && !integral.holdsNothing(ray, ta, tb) && integral.prepare(ray, ta, tb, sum, interval);
    }
};

class FusedIntegral {
  public:
    FusedIntegral(const ReferenceInput& input, const std::vector<std::unique_ptr<IntegralInput>>& all)
        : input_(input) {
        for (const auto& of : all)
            volumes_.push_back(std::make_unique<FusedVolume>(*of));
        for (const auto& volume : volumes_) {
            LightRays* const rays = volume->integral.lightRays();
            if (!rays)
                continue;
            std::vector<LightRays*> others;
            for (const auto& other : volumes_)
                if (other != volume && other->integral.lightRays())
                    others.push_back(other->integral.lightRays());
            rays->setOthers(others);
            volume->integral.setOthers(
                [others, channel = rays->firstShadowChannel()](const glm::dvec3& place, LightShares& shares) {
                    for (LightRays* other : others)
                        other->shade(place, channel, shares);
                });
        }
    }
    FusedIntegral(const FusedIntegral&) = delete;
    FusedIntegral& operator=(const FusedIntegral&) = delete;

    glm::dvec4 operator()(const ReferenceRay& ray) {
        const RayLine<double> line{ray.base, ray.direction, ray.tMin, 1};
        double t0 = 0, t1 = 0;
        if (!clipToBox(line, glm::dvec3(input_.fused->voxels.extentVoxels), t0, t1))
            return glm::dvec4(0);
        for (const RaySlab<double>& slab : input_.slabs)
            if (!clipToSlab(line, slab, t0, t1))
                return glm::dvec4(0);
        if (!((t1 = std::min(t1, ray.tMax)) >= t0))
            return glm::dvec4(0);
        std::vector<RayCuts::Part> parts{{t0, t1}};
        if (input_.cuts)
            input_.cuts->parts(ray.base, ray.direction, t0, t1, parts);
        ReferenceIntegrator sum;
        for (const RayCuts::Part& part : parts)
            addPart(ray, part.from, part.to, sum);
        return glm::dvec4(sum.colour(), sum.alpha());
    }

  private:
    void addPart(const ReferenceRay& ray, double t0, double t1, ReferenceIntegrator& sum) {
        planes_.assign(1, t0);
        for (const auto& volume : volumes_) {
            volume->begin(ray, t0, t1);
            volume->addCuts(planes_);
        }
        planes_.push_back(t1);
        std::sort(planes_.begin(), planes_.end());
        for (std::size_t i = 0; i + 1 < planes_.size() && !sum.opaque(); ++i)
            if (planes_[i] < planes_[i + 1])
                addInterval(planes_[i], planes_[i + 1], sum);
    }

    void addInterval(double ta, double tb, ReferenceIntegrator& sum) {
        cuts_.clear();
        for (const auto& volume : volumes_) {
            volume->prepare(ta, tb, sum);
            if (volume->shows)
                cuts_.insert(cuts_.end(), volume->interval.cuts.begin(), volume->interval.cuts.end());
        }
        std::sort(cuts_.begin(), cuts_.end());
        for (std::size_t i = 0; i + 1 < cuts_.size(); ++i)
            if (cuts_[i] < cuts_[i + 1])
                addPiece(cuts_[i], cuts_[i + 1], tb - ta, sum);
    }

    void addPiece(double from, double to, double length, ReferenceIntegrator& sum) {
        struct Part {
            RayIntegral::Piece piece;
            double unitMm;
            Part(const FusedVolume& of, double from, double to)
                : piece(of.integral, of.interval, from, to), unitMm(of.input.function->referenceLengthMm()) {}
        };
        std::vector<std::unique_ptr<Part>> parts; // pieces stay where they are
        for (const auto& volume : volumes_) {
            if (!volume->shows)
                continue;
            auto part = std::make_unique<Part>(*volume, from, to);
            if (part->piece.shows)
                parts.push_back(std::move(part));
        }
        if (parts.empty())
            return;
        const int rule = static_cast<int>(input_.fused->rule);
        sum.add(from, to, [&](const ReferenceIntegrator::Places& u, RadiantNodes& at) {
            std::array<leaf::Fused<double>, 8> fused{};
            for (const auto& part : parts) {
                RadiantNodes own;
                part->piece.radiant(u, own);
                for (std::size_t n = 0; n < u.size(); ++n) {
                    const double extinction = own.extinction[n] / length;
                    if (extinction > 0)
                        fused[n] = leaf::fusedWith<double>(fused[n], rule, extinction,
                                                           -std::expm1(-extinction * part->unitMm),
                                                           own.red[n], own.green[n], own.blue[n]);
                }
            }
            for (std::size_t n = 0; n < u.size(); ++n) {
                at.extinction[n] = fused[n].extinction * length;
                at.red[n] = fused[n].red, at.green[n] = fused[n].green, at.blue[n] = fused[n].blue;
            }
        });
    }

    const ReferenceInput& input_;
    std::vector<std::unique_ptr<FusedVolume>> volumes_;
    std::vector<double> planes_, cuts_;
};

} // namespace

std::vector<glm::dvec4> renderFused(const ReferenceInput& input, const std::vector<ReferenceRay>& rays,
                                    int threads) {
    std::vector<std::unique_ptr<IntegralInput>> all;
    all.push_back(std::make_unique<IntegralInput>(input));
    for (const ReferenceInput& further : input.further)
        all.push_back(std::make_unique<IntegralInput>(further));
    constexpr std::size_t kStrip = 16;
    std::vector<glm::dvec4> out(rays.size());
    parallelFor((rays.size() + kStrip - 1) / kStrip, threads,
                [&](std::size_t strip) {
                    FusedIntegral integral(input, all);
                    for (std::size_t i = strip * kStrip; i < std::min(rays.size(), (strip + 1) * kStrip); ++i)
                        out[i] = integral(rays[i]);
                },
                input.progress);
    return out;
}

} // namespace tessera
