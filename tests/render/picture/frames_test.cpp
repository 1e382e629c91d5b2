// tests/render/picture/frames_test.cpp: pictures that follow one another in a film equal stills bit by bit,
// whatever stays from one to the next.
#include "render/picture/frame_renderer.h"
#include "tests/support/scene_fixture.h"

namespace tessera::test {
namespace {

/// Through the volume and back, wide angled.
Camera along(const VolumeInfo& info, double t) {
    Camera camera = cameraNumber(2, info, {32, 24});
    const glm::dvec3 centre(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    camera.position += (0.7 * t) * (centre - camera.position);
    camera.focalPoint += 60.0 * glm::dvec3(std::sin(2 * t), std::cos(3 * t), std::sin(t));
    camera.viewAngle = 90 + 40 * t;
    return camera;
}

struct Row {
    const char* name;
    EngineKind engine;
    std::size_t gpuBytes;
    std::size_t leastKept; // of the pictures
    void (*change)(Scene&);
    std::size_t pictures = 6;
};

class FramesOf : public ::testing::TestWithParam<Row> {};

TEST_P(FramesOf, EqualStills) {
    const Row& row = GetParam();
    RenderOptions options;
    options.engine = row.engine;
    options.device.text = "software";
    options.searching = true;
    const auto still = [&](const Scene& scene) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
            gpu("GPU memory", "--gpu-memory", row.gpuBytes);
        const StoreReader store(storePath("torso"), ram);
        return renderScene(scene, store, ram, gpu, options).image;
    };
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", row.gpuBytes);
    const StoreReader store(storePath("torso"), ram);
    Scene scene = sceneOn(store.info(), "bone-1", 2, {24, 16});
    scene.quality.automaticStep = true;
    row.change(scene);
    // Stills first: one context of OpenGL is current at a time.
    std::vector<Scene> scenes;
    for (const double t : {0.0, 0.1, 0.5, 0.55, 1.0, 0.05}) {
        if (scenes.size() == row.pictures)
            break;
        scene.camera = along(store.info(), t);
        scenes.push_back(scene);
    }
    std::vector<Image> stills;
    for (const Scene& one : scenes)
        stills.push_back(still(one));
    EXPECT_FALSE(bitEqual(stills[0], stills[2]));
    scene.volumes[0].transferFunction = "skin-1"; // another function on the way, and back
    const Image skin = still(scene);

    FrameRenderer frames(store, ram, gpu, options);
    for (std::size_t n = 0; n < scenes.size(); ++n)
        EXPECT_TRUE(bitEqual(frames.draw(scenes[n]).image, stills[n])) << row.name << " " << n;
    EXPECT_GE(frames.kept().goneOn, row.leastKept) << row.name;
    EXPECT_TRUE(bitEqual(frames.draw(scene).image, skin)) << row.name;
    EXPECT_TRUE(bitEqual(frames.draw(scenes[1]).image, stills[1])) << row.name;
    frames.forget();
    EXPECT_TRUE(bitEqual(frames.draw(scenes[2]).image, stills[2])) << row.name;
    EXPECT_LE(ram.peakBytes(), ram.limitBytes());
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
}

// Renderers refer to a layer's statistics and tables as long as they keep light.
TEST(Frames, APlanThatTakesAnothersPlaceKeepsItsLayersPlace) {
    FramePlan plan, next;
    const Layer* const place = &plan.layer();
    next.layers.front().pageEdge = 7;
    plan = std::move(next);
    EXPECT_EQ(&plan.layer(), place);
    EXPECT_EQ(plan.layer().pageEdge, 7);
    plan = FramePlan();
    EXPECT_EQ(&plan.layer(), place);
    EXPECT_EQ(plan.layer().pageEdge, kBrickExtent);
}

TEST(Frames, KeepLightAndEqualStills) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", ram.limitBytes());
    const StoreReader store(storePath("torso"), ram);
    Scene scene = sceneOn(store.info(), "bone-1", 0, {24, 16});
    scene.lighting.occlusion = Occlusion();
    scene.lighting.occlusion->rays = 4;
    scene.lighting.lights = {{LightKind::directional, LightFrame::camera, {1, 1, 1}}, {}};
    scene.lighting.lights[0].shadow = true;
    RenderOptions options;
    options.engine = EngineKind::native;
    FrameRenderer frames(store, ram, gpu, options);
    const Camera first = fitCamera(store.info(), View::anterior, Projection::perspective, scene.imageSize);
    for (int n = 0; n < 4; ++n) {
        Camera camera = first;
        camera.position.x += 4.0 * n;
        scene.camera = camera;
        MemoryBudget ownRam("RAM", "--ram", ram.limitBytes()),
            ownGpu("GPU memory", "--gpu-memory", gpu.limitBytes());
        const StoreReader own(storePath("torso"), ownRam);
        EXPECT_TRUE(
            bitEqual(frames.draw(scene).image, renderScene(scene, own, ownRam, ownGpu, options).image))
            << n;
    }
    EXPECT_GE(frames.kept().goneOn, 2u);
}

constexpr std::size_t kMiB = std::size_t{1} << 20;
const Row kRows[] = {
    {"native", EngineKind::native, 512 * kMiB, 5, [](Scene&) {}},
    {"nativeSamples", EngineKind::native, 512 * kMiB, 5,
     [](Scene& s) { s.quality.pixels.samples = PixelSampling::kAutomatic; }},
    {"nativeShort", EngineKind::native, 6 * kMiB, 0, [](Scene&) {}},
    {"nativePasses", EngineKind::native, 12 * kMiB, 0, [](Scene& s) { s.quality.maxError = 0; }},
    {"nativeLight", EngineKind::native, 512 * kMiB, 0,
     [](Scene& s) {
         s.lighting.occlusion = Occlusion();
         s.lighting.occlusion->rays = 4;
         s.lighting.finestLevel = 2;
         s.lighting.lights = {{LightKind::directional, LightFrame::camera, {1, 1, 1}}, {}};
         s.lighting.lights[0].shadow = true;
     },
     3},
    {"nativeSurface", EngineKind::native, 512 * kMiB, 4,
     [](Scene& s) {
         s.surfaces = {{-400, glm::dvec3(1), 1}};
         s.mode = Mode::isosurface;
     }},
    {"nativePaths", EngineKind::native, 512 * kMiB, 2,
     [](Scene& s) {
         s.lighting.transport = Transport{};
         s.quality.pixels.samples = 2;
     },
     3},
    {"nativeGreatest", EngineKind::native, 512 * kMiB, 3, [](Scene& s) { s.mode = Mode::maximum; }},
    {"mirror", EngineKind::mirror, 512 * kMiB, 0,
     [](Scene& s) {
         s.quality.stepVoxels = 2;
         s.quality.automaticStep = false;
     }},
    {"march", EngineKind::gpu, 512 * kMiB, 2, [](Scene&) {}, 3},
};

INSTANTIATE_TEST_SUITE_P(Frames, FramesOf, ::testing::ValuesIn(kRows),
                         [](const auto& row) { return std::string(row.param.name); });

} // namespace
} // namespace tessera::test
