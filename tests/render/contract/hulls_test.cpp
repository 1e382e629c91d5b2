// tests/render/contract/hulls_test.cpp: sampling hulls take as many samples of every ray in each hull, and
// end where boxes, cuts and meshes do (docs/sampling.md, "Sampling hulls").
#include "render/picture/render_scene.h"
#include "render/plan/scene_rules.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/value_scenes.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

Scene hullScene(const std::string& store, int camera, int count, int samples,
                const glm::ivec2& size = {37, 41}) {
    Scene scene = sceneOn(infoOf(store), "soft-tissue", camera, size);
    scene.quality.sampling = Sampling::hulls;
    scene.quality.hulls = {count, samples};
    scene.quality.fetch = Fetch::exact;
    scene.quality.terminationTransmittance = 0;
    return scene;
}

RenderResult drawn(const Scene& scene, const std::string& store, EngineKind engine,
                   Verify verify = Verify::none) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
    const StoreReader reader(storePath(store), ram);
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    options.verify = verify;
    options.searching = options.checking = verify != Verify::none;
    return renderScene(scene, reader, ram, gpu, options);
}

double depthOf(const RayHulls& hulls, const glm::dvec3& voxel) {
    return glm::dot(hulls.normal, voxel) + hulls.offset;
}

class HullRays : public testing::TestWithParam<int> {}; // cameras
INSTANTIATE_TEST_SUITE_P(Cameras, HullRays, testing::Values(0, 1, 2));

TEST_P(HullRays, HaveTheirSamplesInEveryHullAndLeaveNoGap) {
    for (const auto& [count, samples] : {std::pair(1, 5), std::pair(4, 8), std::pair(7, 1)}) {
        Prepared prepared("sphere", hullScene("sphere", GetParam(), count, samples));
        const RayFrame<double>& frame = prepared.p.view.frame;
        ASSERT_EQ(frame.hulls.count, count);
        const CutRays cuts = cutRays(frame, {}, 0);
        EXPECT_EQ(cuts.most, static_cast<std::size_t>(count));
        const auto rays = frameRays(cast<float>(frame));
        double thickest = 0;
        for (std::size_t n = 0; n + 1 < cuts.first.size(); ++n) {
            const SegmentedRay<float> ray = rays(n);
            for (std::size_t k = 0; k < cuts.count(n); ++k) {
                const RayInterval& in = cuts.at(n, k);
                EXPECT_EQ(in.from, k > 0 ? cuts.at(n, k - 1).to : 0);
                const SegmentedRay<float> part =
                    partOf(ray, in, static_cast<float>(frame.segmentVoxels), frame.hullSamples());
                EXPECT_EQ(part.count, samples);
                EXPECT_EQ(part.tail, 1.0f);
                const glm::dvec3 begin(part.entry), end = begin + double(samples) * glm::dvec3(part.step);
                EXPECT_NEAR(glm::length(end - begin), in.to - in.from, 1e-3);
                // Both ends of a part are within one hull.
                const double size = (frame.hulls.farthest - frame.hulls.nearest) / count;
                const double at = (depthOf(frame.hulls, 0.5 * (begin + end)) - frame.hulls.nearest) / size;
                const double low = frame.hulls.plane(static_cast<int>(std::floor(at)));
                EXPECT_GE(depthOf(frame.hulls, begin), low - 1e-3);
                EXPECT_LE(depthOf(frame.hulls, end), low + size + 1e-3);
                thickest =
                    std::max(thickest, (depthOf(frame.hulls, end) - depthOf(frame.hulls, begin)) / size);
                // The part's length in mm is that of its segments.
                EXPECT_NEAR(double(part.segmentMm) * samples,
                            glm::length(frame.patientFromVoxel * (end - begin)), 1e-3 * samples);
            }
            if (cuts.count(n) > 0) {
                const double all = (ray.count - 1 + double{ray.tail}) * frame.segmentVoxels;
                EXPECT_NEAR(cuts.at(n, cuts.count(n) - 1).to, all, 1e-3);
                EXPECT_EQ(cuts.at(n, 0).from, 0);
            }
        }
        EXPECT_GT(thickest, count > 1 ? 0.99 : 0.5) << "no ray crosses a whole hull";
    }
}

// Slices show steps at borders of boxes; hulls are exact whatever the angle and their number of samples.
TEST_P(HullRays, OfEvenFogAreItsClosedForm) {
    constexpr double kPerMm = 0.013;
    for (const auto& [count, samples] : {std::pair(1, 1), std::pair(3, 2), std::pair(8, 5)}) {
        Scene scene = hullScene("sphere", GetParam(), count, samples);
        scene.shading.on = false;
        scene.volumes.front().transferFunction = fog(kPerMm);
        scene.cuts.planes.push_back({middleOf(infoOf("sphere")), {0.3, 1, -0.4}, Keep::inside});
        const RenderResult result = drawn(scene, "sphere", EngineKind::native);
        Prepared prepared("sphere", scene);
        const auto rays = frameRays(prepared.p.view.frame);
        int met = 0;
        for (std::size_t n = 0; n < result.image.pixels.size(); ++n) {
            const SegmentedRay<double> ray = rays(n);
            const double mm = ray.count == 0 ? 0 : (ray.count - 1 + ray.tail) * ray.segmentMm;
            EXPECT_NEAR(result.image.pixels[n].a, -std::expm1(-kPerMm * mm), 1e-5);
            met += mm > 0;
        }
        EXPECT_GT(met, 300);
    }
}

TEST(Hulls, EnginesAgree) {
    for (const auto& [store, camera, count, samples] :
         {std::tuple("torso", 0, 4, 8), std::tuple("torso", 1, 1, 60), std::tuple("sphere", 2, 7, 9)}) {
        for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated}) {
            Scene scene = hullScene(store, camera, count, samples);
            scene.quality.integrator = integrator;
            const Image native = drawn(scene, store, EngineKind::native).image;
            EXPECT_EQ(differing(native, drawn(scene, store, EngineKind::mirror).image), 0u)
                << store << camera;
            scene.quality.skipping = false;
            EXPECT_EQ(differing(native, drawn(scene, store, EngineKind::native).image), 0u)
                << "skipping changed the picture";
            scene.quality.skipping = true;
            const Image march = drawn(scene, store, EngineKind::gpu).image;
            EXPECT_LE(compare(march, native).maxAbs, 2e-5) << store << camera;
        }
    }
}

// The middle of segments: an order of 2 where the field is smooth.
TEST(Hulls, AreOfSecondOrder) {
    const auto picture = [](int samples) {
        Scene scene = hullScene("sphere", 0, 1, samples, {48, 48});
        scene.shading.on = false;
        scene.volumes.front().transferFunction =
            TransferFunction::fromExtinction({{-2000, 0}, {3000, 0.02}}, {{0, {1, 1, 1}}});
        return drawn(scene, "sphere", EngineKind::native).image;
    };
    const Image truth = picture(1024);
    const double coarse = compare(picture(32), truth).rms, fine = compare(picture(128), truth).rms;
    EXPECT_GT(std::log2(coarse / fine) / 2, 1.6) << coarse << " " << fine;
}

TEST(Hulls, ChooseTheirNumbers) {
    Scene scene = hullScene("torso", 0, Hulls::kAutomatic, Hulls::kAutomatic, {96, 96});
    const RenderResult result = drawn(scene, "torso", EngineKind::native, Verify::quick);
    EXPECT_EQ(result.hulls.count, 1);
    EXPECT_GT(result.hulls.samples, 16);
    EXPECT_LE(result.hulls.samples, Hulls::kMostSamples);
    ASSERT_TRUE(result.errors && result.errors->step);
    EXPECT_LE(result.errors->step->error.rms, 1.0 / 255);
    scene.lighting.lights = {Light{}};
    scene.lighting.lights.front().shadow = true;
    EXPECT_EQ(drawn(scene, "torso", EngineKind::native).hulls.count, 4);
    // What few samples err by is measured, against rays that have no hulls.
    scene = hullScene("torso", 0, 1, 8, {96, 96});
    const RenderResult few = drawn(scene, "torso", EngineKind::native, Verify::full);
    ASSERT_TRUE(few.measured && few.measured->all.rms);
    scene.quality.hulls.samples = 512;
    const RenderResult many = drawn(scene, "torso", EngineKind::native, Verify::full);
    ASSERT_TRUE(many.measured && many.measured->all.rms);
    EXPECT_GT(few.measured->all.rms->value, 3 * many.measured->all.rms->value);
}

TEST(Hulls, CostNothingWhereTheyAreNotAskedFor) {
    Scene scene = hullScene("sphere", 0, 4, 8);
    scene.quality.sampling = Sampling::limited;
    Prepared prepared("sphere", scene);
    EXPECT_EQ(prepared.p.view.frame.cuts, nullptr);
    EXPECT_EQ(prepared.p.view.frame.hullSamples(), 0);
}

TEST(Hulls, RefuseWhatTheyDoNotDraw) {
    const auto refusedFor = [](const char* word, const std::function<void(Scene&)>& change) {
        Scene scene = hullScene("sphere", 0, 4, 8);
        change(scene);
        try {
            checkScene(scene);
            ADD_FAILURE() << word << " was taken";
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
        }
    };
    refusedFor("one volume", [](Scene& s) { s.volumes.push_back(s.volumes.front()); });
    refusedFor("mode composite", [](Scene& s) { s.mode = Mode::maximum; });
    refusedFor("isosurfaces", [](Scene& s) { s.surfaces = {{300, {1, 1, 1}, 1}}; });
    refusedFor("labels", [](Scene& s) { s.volumes.front().labels.path = "labels.nii"; });
    refusedFor("paths of light", [](Scene& s) { s.lighting.transport = Transport{}; });
    refusedFor("error bound", [](Scene& s) { s.quality.maxError = 1; });
    refusedFor("pre-integrated-2d", [](Scene& s) { s.quality.integrator = Integrator::preintegrated2d; });
}

} // namespace
} // namespace tessera
