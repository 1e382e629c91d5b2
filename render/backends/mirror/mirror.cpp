// render/backends/mirror/mirror.cpp: see mirror.h.
#include "render/backends/mirror/mirror.h"

#include "core/base/interrupt.h"
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/light/scene_light.h"
#include "render/plan/fusion.h"

#include <mutex>
#include <span>

namespace tessera {

MirrorInput mirrorInput(const FramePlan& scene, bool skipping) {
    MirrorInput input;
    if (scene.fused) {
        input.fused = &*scene.fused;
        input.fromLattice = scene.fused->fromLattice;
        input.ownCuts = scene.fused->cuts.slabs;
        for (const auto& volume : scene.further) {
            MirrorInput& further = input.further.emplace_back(mirrorInput(volume->plan, skipping));
            further.fromLattice = volume->fromLattice;
            further.ownCuts = volume->cuts.slabs;
        }
    }
    input.cache = scene.layer().cache.get();
    input.info = &scene.info();
    input.selection = &scene.layer().selection;
    input.levels = scene.layer().mixed() ? &scene.layer().levels : nullptr;
    input.unitMm = scene.layer().function.referenceLengthMm();
    input.optics = &scene.layer().optics;
    input.occupancy = skipping && scene.layer().occupancy.exists() ? &scene.layer().occupancy : nullptr;
    input.bounds = skipping && scene.layer().bounds.exists() ? &scene.layer().bounds : nullptr;
    input.surfaceOccupancy =
        skipping && scene.layer().mapsSurfaces ? &scene.layer().surfaceOccupancy : nullptr;
    input.strides = scene.strides();
    input.labels = scene.layer().labelBricks.get();
    return input;
}

namespace {

/// A field with its light.
template <typename Real, typename Values> struct LitField {
    Values& values;
    const StoredLight* light;
    LabelField* shares; // labels'; null: there are none
    Real value(const glm::vec<3, Real>& p) { return values.value(p); }
    Real pitch(const glm::vec<3, Real>& p) { return values.pitch(p); }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) { return values.gradient(p); }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p, Gradient by) { return values.gradient(p, by); }
    leaf::ReceivedLight<Real> received(const glm::vec<3, Real>& p, const leaf::LightingNumbers& lighting) {
        return light->at(p, lighting);
    }
    leaf::LabelShares<Real> labels(const glm::vec<3, Real>& p) { return shares->shares(p); }
    glm::vec<3, Real> mediumGradient(const glm::vec<3, Real>& p) { return shares->gradient(p); }
};

/// Calls visit(field) with the field of the input.
template <typename Real, typename Visit> void withField(const MirrorInput& input, const Visit& visit) {
    withCacheField<Real>(
        *input.cache, *input.info, *input.selection, input.levels, input.optics->gradient, [&](auto& values) {
            std::optional<LabelField> labels;
            if (input.labels)
                labels.emplace(*input.labels, *input.selection, input.levels, input.info->extentVoxels);
            LitField<Real, std::decay_t<decltype(values)>> field{values, input.light,
                                                                 labels ? &*labels : nullptr};
            visit(field);
        });
}

/// Calls visit(fields) with those of all volumes of the input.
/// @param known  of the first volumes
template <typename Real, typename Visit>
void withFields(const MirrorInput& input, std::vector<FusedField<Real>>& known, const Visit& visit) {
    const std::size_t number = known.size();
    if (number > input.further.size())
        return visit(known);
    const MirrorInput& here = number == 0 ? input : input.further[number - 1];
    withField<Real>(here, [&](auto& field) {
        FusedField<Real> fused;
        fused.linear = glm::mat<3, 3, Real>(glm::dmat3(here.fromLattice));
        fused.offset = glm::vec<3, Real>(glm::dvec3(here.fromLattice[3]));
        fused.unitMm = static_cast<Real>(here.unitMm);
        fused.cuts = here.ownCuts;
        fused.extent = glm::vec<3, Real>(here.info->extentVoxels);
        fused.see = [&](const FusedPlace<Real>& place, Work& work, SeenSegment<Real>& seen) {
            if (here.occupancy && emptyBoxAt(*here.occupancy, place.direction, place.middle))
                return false;
            ++work.samples;
            const SegmentEnd<Real> end = endOf(*here.optics, field.value(place.middle));
            return seeSegment(*here.optics, field, {}, end, place.middle, place.direction, place.lengthMm,
                              place.segments, work, seen);
        };
        known.push_back(std::move(fused));
        withFields(input, known, visit);
        known.pop_back();
    });
}

constexpr std::size_t kStrip = 64; // rays per task of a thread: neighbours share chunks

} // namespace

template <typename Real>
std::vector<glm::vec<4, Real>> mirrorRays(const MirrorInput& input, std::size_t rayCount,
                                          const RaySource<Real>& rays, int threads, Work& work) {
    std::vector<glm::vec<4, Real>> out(rayCount);
    std::mutex mutex;
    parallelFor(
        (rayCount + kStrip - 1) / kStrip, threads,
        [&](std::size_t strip) {
            Work mine;
            std::vector<SegmentedRay<Real>> parts;
            const auto draw = [&](const auto& ray) {
                for (std::size_t i = strip * kStrip; i < std::min(rayCount, (strip + 1) * kStrip); ++i)
                    out[i] = ray(partsOf(input, rays(i), i, parts));
            };
            std::vector<FusedField<Real>> known;
            if (input.fused)
                withFields(input, known, [&](const auto& fields) {
                    draw([&](const auto& ray) { return mirrorRayOf<Real>(ray, fields, input, mine); });
                });
            else
                withField<Real>(input, [&](auto& field) {
                    draw(
                        [&](const auto& ray) { return mirrorRayOf<Real>(ray, field, input, mine, nullptr); });
                });
            const std::lock_guard lock(mutex);
            work += mine;
        },
        input.progress);
    return out;
}

void mirrorPaths(const MirrorInput& input, const PathScene& scene, const RaySource<float>& rays,
                 const std::function<PathStart(std::size_t)>& starts, std::span<glm::vec4> colours,
                 std::span<PathBeginning> beginnings, int threads, Work& work) {
    std::mutex mutex;
    parallelFor((colours.size() + kStrip - 1) / kStrip, threads,
                [&](std::size_t strip) {
                    checkInterrupted();
                    Work mine;
                    std::vector<SegmentedRay<float>> parts;
                    withField<float>(input, [&](auto& field) {
                        for (std::size_t i = strip * kStrip;
                             i < std::min(colours.size(), (strip + 1) * kStrip); ++i)
                            if (colours[i].a > 0)
                                colours[i] = pathColour(partsOf(input, rays(i), i, parts), field, input,
                                                        scene, starts(i), colours[i].a, mine,
                                                        beginnings.empty() ? nullptr : &beginnings[i]);
                    });
                    const std::lock_guard lock(mutex);
                    work += mine;
                },
                input.progress);
}

template <typename Real>
std::vector<SurfaceHit> mirrorHits(const MirrorInput& input, std::size_t rayCount,
                                   const RaySource<Real>& rays, int threads) {
    std::vector<SurfaceHit> hits(rayCount);
    parallelFor((rayCount + kStrip - 1) / kStrip, threads, [&](std::size_t strip) {
        Work unused;
        std::vector<SegmentedRay<Real>> parts;
        withField<Real>(input, [&](auto& field) {
            for (std::size_t i = strip * kStrip; i < std::min(rayCount, (strip + 1) * kStrip); ++i)
                mirrorRayOf(partsOf(input, rays(i), i, parts), field, input, unused, &hits[i]);
        });
    });
    return hits;
}

std::vector<SeenBrick> mirrorSeen(const MirrorInput& input, std::size_t rayCount,
                                  const RaySource<float>& rays, int threads) {
    std::vector<SeenBrick> seen(input.selection->levels.size());
    parallelFor((rayCount + kStrip - 1) / kStrip, threads, [&](std::size_t strip) {
        withField<float>(input, [&](auto& field) {
            for (std::size_t i = strip * kStrip; i < std::min(rayCount, (strip + 1) * kStrip); ++i)
                seeAlong(rays(i), field, input, seen);
        });
    });
    return seen;
}

template std::vector<glm::vec4> mirrorRays<float>(const MirrorInput&, std::size_t, const RaySource<float>&,
                                                  int, Work&);
template std::vector<glm::dvec4> mirrorRays<double>(const MirrorInput&, std::size_t, const RaySource<double>&,
                                                    int, Work&);

template std::vector<SurfaceHit> mirrorHits<float>(const MirrorInput&, std::size_t, const RaySource<float>&,
                                                   int);
template std::vector<SurfaceHit> mirrorHits<double>(const MirrorInput&, std::size_t, const RaySource<double>&,
                                                    int);

} // namespace tessera
