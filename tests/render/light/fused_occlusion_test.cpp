// tests/render/light/fused_occlusion_test.cpp: the ambient light of several volumes (docs/sampling.md,
// "Several volumes"): the tissue of all takes it.
#include "core/image/image_metrics.h"
#include "render/light/light_memory.h"
#include "render/light/occlusion.h"
#include "tests/support/fused.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr std::size_t kAmple = std::size_t{1} << 30;

Image litPicture(const Scene& scene, EngineKind engine) {
    return fusedPicture(scene, engine, kAmple, kAmple, LevelChoice::oneForAll).image;
}

Scene occluded(Scene scene, OcclusionMethod method = OcclusionMethod::local) {
    scene.lighting.occlusion = Occlusion{.method = method, .rays = 16, .radiusMm = 12, .bias = 0, .gamma = 1};
    scene.shading.ambient = 0.8;
    return scene;
}

TransferFunction body(double extinction) {
    return TransferFunction::fromExtinction({{150, 0}, {260, extinction}, {330, 4 * extinction}},
                                            {{150, {0.9, 0.6, 0.4}}});
}

// One volume twice, each with half of the extinction, is the volume.
TEST(FusedOcclusion, TwoHalvesAreAWhole) {
    for (const OcclusionMethod method :
         {OcclusionMethod::local, OcclusionMethod::positional, OcclusionMethod::rejecting}) {
        Scene whole = occluded(fusedScene({0}, {32, 26}), method), halves = whole;
        whole.volumes[0].transferFunction = body(0.2);
        halves.volumes[0].transferFunction = body(0.1);
        halves.volumes.push_back(halves.volumes[0]);
        const Image expected = litPicture(whole, EngineKind::native);
        EXPECT_LT(compare(litPicture(halves, EngineKind::native), expected).maxAbs, 2e-3);
        whole.lighting.occlusion.reset();
        EXPECT_GT(compare(litPicture(whole, EngineKind::native), expected).rms, 0.05);
    }
}

TEST(FusedOcclusion, EveryEngineHasIt) {
    Scene scene = occluded(fusedScene({0, 1, 2}, {24, 20}));
    const Image native = litPicture(scene, EngineKind::native);
    EXPECT_EQ(differing(native, litPicture(scene, EngineKind::mirror)), 0u);
    EXPECT_LE(compare(native, litPicture(scene, EngineKind::gpu)).maxAbs, 1e-4);
}

TEST(FusedOcclusion, ComesToTheReference) {
    Scene scene = occluded(fusedScene({0, 2}, {12, 10}));
    scene.lighting.occlusion->rays = 8;
    scene.quality.stepVoxels = 1.0 / 8;
    EXPECT_LT(compare(litPicture(scene, EngineKind::native), litPicture(scene, EngineKind::reference)).rms,
              0.012);
    // The same voxels twice: by the reference alone, free of steps and samples of light.
    Scene halves = occluded(fusedScene({0}, {8, 8}));
    halves.lighting.occlusion->rays = 4;
    Scene whole = halves;
    whole.volumes[0].transferFunction = body(0.2);
    halves.volumes[0].transferFunction = body(0.1);
    halves.volumes.push_back(halves.volumes[0]);
    EXPECT_LT(
        compare(litPicture(halves, EngineKind::reference), litPicture(whole, EngineKind::reference)).maxAbs,
        2e-4);
}

// Channels of light differ from volume to volume where one alone sends light.
TEST(FusedOcclusion, OneVolumeMaySendLight) {
    Scene scene = shadowed(occluded(fusedScene({0, 1}, {12, 10})));
    scene.lighting.occlusion->rays = 4;
    scene.lighting.occlusion->emission = 1;
    scene.quality.stepVoxels = 1.0 / 8;
    for (const std::size_t sends : {0, 1}) {
        Scene one = scene;
        std::get<TransferFunction>(one.volumes[sends].transferFunction)
            .setMaterials({{-1e4, 1e4, 0.4, 0.6, 0.1, 10, {0.2, 0.9, 0.4}}});
        const Image native = litPicture(one, EngineKind::native);
        EXPECT_EQ(differing(native, litPicture(one, EngineKind::mirror)), 0u);
        EXPECT_LT(compare(native, litPicture(one, EngineKind::reference)).rms, 0.02) << sends;
    }
}

/// An occluder of a volume as planned, that is lit as such a scene's.
struct Tissue {
    Tissue(const std::filesystem::path& path, const TransferFunction& function,
           const std::optional<Occlusion>& occlusion)
        : scene(fusedScene({0}, {16, 16})) {
        scene.volumes[0].path = path;
        scene.volumes[0].transferFunction = function;
        prepared = std::make_unique<PreparedFusion>(scene);
        const FramePlan& p = prepared->p;
        occluder = std::make_unique<Occluder>(p.info(), p.layer().statistics, occlusion);
        occluder->setFunction(p.layer().table, p.layer().optics);
    }
    BrickCache& cache() { return *prepared->p.layer().cache; }
    Scene scene;
    std::unique_ptr<PreparedFusion> prepared;
    std::unique_ptr<Occluder> occluder;
};

TransferFunction evenMedium(double extinction) {
    return TransferFunction::fromExtinction({{0, extinction}}, {});
}
/// Values are extinctions; none below 0.
TransferFunction extinctionsThemselves() {
    return TransferFunction::fromExtinction({{0, 0}, {1, 1}}, {});
}

// A medium on a lattice of its own, turned and of other voxels, that ends within the volume.
TEST(FusedOcclusion, AMediumOnAnotherLatticeTakesWhatItTakes) {
    constexpr double kExtinction = 0.11, kRadius = 8;
    FieldStores stores;
    const auto one = [](const glm::dvec3&) { return 1.0; };
    const Occlusion occlusion{.rays = 32, .radiusMm = kRadius, .bias = 0, .gamma = 1};
    Tissue thin(stores.store(gridAt({0, 0, 0}, {80, 72, 64}, {1, 1, 1}, 0, ValueType::f32), one),
                evenMedium(1e-7), occlusion);
    const VolumeInfo there = gridAt({-18, 3, -2}, {20, 30, 33}, {1.9, 2.2, 1.7}, 31, ValueType::f32);
    Tissue medium(stores.store(there, one), evenMedium(kExtinction), {});
    thin.occluder->setOthers({{medium.occluder.get(), &medium.cache()}});
    OcclusionRoom room(thin.occluder->mostReach());
    const double inside = -std::expm1(-kExtinction * kRadius) / (kExtinction * kRadius);
    const VolumeInfo& own = thin.prepared->p.info();
    for (const int level : {0, 1}) {
        int within = 0, without = 0;
        const glm::ivec3 extent = levelExtent(own.extentVoxels, level),
                         chunks = chunkGrid(own.extentVoxels, level);
        for (std::size_t n = 0; n < cellCount(chunks); ++n) {
            const glm::ivec3 at = gridPosition(n, chunks);
            const ChunkKey key{level, at.x, at.y, at.z};
            thin.occluder->find(key, {}, true, thin.cache(), room);
            thin.occluder->occlude(key, room);
            const glm::ivec3 size = glm::min(extent - at * kChunkExtent, glm::ivec3(kChunkExtent));
            for (std::size_t s = 0; s < cellCount(size); s += 7) {
                const glm::ivec3 sample = gridPosition(s, size);
                const glm::dvec3 voxel =
                    std::ldexp(1.0, level) * (glm::dvec3(at * kChunkExtent + sample) + 0.5);
                const glm::dvec3 mm(own.patientFromVoxel * glm::dvec4(voxel, 1));
                const glm::dvec3 in(glm::inverse(there.patientFromVoxel) * glm::dvec4(mm, 1));
                // Millimetres to the nearest side of the medium; below 0 outside.
                const glm::dvec3 spacing = there.spacingMm();
                double depth = 1e9;
                for (int axis = 0; axis < 3; ++axis)
                    depth = std::min(depth,
                                     std::min(in[axis], there.extentVoxels[axis] - in[axis]) * spacing[axis]);
                const bool isNearBorder =
                    glm::any(glm::lessThan(voxel, glm::dvec3(kRadius + 3))) ||
                    glm::any(glm::greaterThan(voxel, glm::dvec3(own.extentVoxels) - (kRadius + 3)));
                const float light = room.light[linearIndex(sample, glm::ivec3(kChunkExtent))];
                if (depth > kRadius + 3 && !isNearBorder) {
                    ASSERT_NEAR(light, inside, 0.012) << level;
                    ++within;
                } else if (depth < -2 * kRadius) {
                    ASSERT_NEAR(light, 1, 1e-4) << level;
                    ++without;
                }
            }
        }
        EXPECT_GT(within, 20) << level;
        EXPECT_GT(without, 200) << level;
    }
}

// Two bodies side by side, on lattices of their own, shade one another as in one volume. Around the second
// the first has nothing at all.
TEST(FusedOcclusion, BodiesSideBySideAreThoseOfOneVolume) {
    FieldStores stores;
    const auto first = [](const glm::dvec3& p) { return p.x < -2 ? 0.2 * blob(p, {-4, 0, 0}, 3) : -1; };
    const auto second = [](const glm::dvec3& p) { return 0.8 * blob(p, {3.5, 1, -1}, 1.6); };
    const VolumeInfo here = gridAt({16, 0, 0}, {96, 32, 32}, {1, 1, 1}, 0, ValueType::f32),
                     there = gridAt({5, 0, 0}, {34, 30, 32}, {0.9, 0.8, 0.85}, 20, ValueType::f32);
    const Occlusion occlusion{.rays = 32, .radiusMm = 12, .bias = 0, .gamma = 1};
    Tissue one(stores.store(here, first), extinctionsThemselves(), occlusion),
        another(stores.store(there, second), extinctionsThemselves(), {}),
        both(stores.store(here, [&](const glm::dvec3&p) { return std::max(first(p), 0.0) + second(p); }),
             extinctionsThemselves(), occlusion);
    one.occluder->setOthers({{another.occluder.get(), &another.cache()}});
    OcclusionRoom room(one.occluder->mostReach()), expected(room);
    double shade = 0;
    const ChunkKey key{0, 0, 0, 0};
    one.occluder->find(key, {}, true, one.cache(), room);
    one.occluder->occlude(key, room);
    both.occluder->find(key, {}, true, both.cache(), expected);
    both.occluder->occlude(key, expected);
    ASSERT_FALSE(room.runs.empty());
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = run.to; n < run.to + native::kOcclusionRun; ++n)
            ASSERT_NEAR(room.light[n], expected.light[n], 0.01) << n;
    // Of the second alone.
    one.occluder->setOthers({});
    one.occluder->find(key, {}, true, one.cache(), room);
    one.occluder->occlude(key, room);
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = run.to; n < run.to + native::kOcclusionRun; ++n)
            shade = std::max(shade, static_cast<double>(room.light[n] - expected.light[n]));
    EXPECT_GT(shade, 0.04);
}

// What keeps the tissue of others is charged.
TEST(FusedOcclusion, ChargesForOthers) {
    const Scene scene = occluded(fusedScene({0}, {16, 16}));
    const PreparedFusion prepared(scene);
    const VolumeInfo& info = prepared.p.info();
    const auto bytes = [&](bool amongOthers) {
        return lightRamBytes(scene.lighting, info, {}, 2, false, amongOthers);
    };
    EXPECT_EQ(bytes(true) - bytes(false), ChunkExtinctions::bytes(info, 2));
    EXPECT_FALSE(prepared.p.view.amongOthers);
    const PreparedFusion two(occluded(fusedScene({0, 1}, {16, 16})));
    EXPECT_TRUE(two.p.view.amongOthers);
    EXPECT_TRUE(two.p.further[0].plan.view.amongOthers);
}

} // namespace
} // namespace tessera
