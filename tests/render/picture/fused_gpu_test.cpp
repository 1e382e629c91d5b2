// tests/render/picture/fused_gpu_test.cpp: several volumes in one pass of the GPU ray caster: how texels are
// fetched, levels that differ, all light at once, meshes and cuts in the media, films, bytes on the device,
// and what it must allow.
#include "core/base/error.h"
#include "core/image/image_metrics.h"
#include "render/geometry/tube_shape.h"
#include "render/picture/frame_renderer.h"
#include "tests/support/fused.h"
#include "tests/support/lights.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/refusals.h"

#include <algorithm>
#include <epoxy/gl.h>
#include <gtest/gtest.h>
#include <set>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kFewPixels(24, 18);

/// Every brick that shows something at one level.
Selection allAt(int level, const Selection& like) {
    Selection s = like;
    s.counts = {};
    for (std::uint8_t& mine : s.levels) {
        if (mine != Selection::kEmpty)
            mine = static_cast<std::uint8_t>(level);
        ++s.counts[mine];
    }
    return s;
}
constexpr int kMixed = -1;
void setLevels(PreparedFusion& prepared, const std::vector<int>& levels) {
    unsigned seed = 3;
    for (std::size_t n = 0; n < levels.size(); ++n) {
        Planner& plan = *prepared.plans()[n];
        const Selection& now = plan.layer().selection;
        plan.setSelection(levels[n] == kMixed ? randomShownLevels(now, seed++) : allAt(levels[n], now));
    }
}

std::vector<SegmentedRay<float>> deviceRays(PreparedFusion& prepared) {
    return gpuRays(raysOf(prepared.p), prepared.budgets.gpu);
}
std::vector<SegmentedRay<float>> shifted(std::vector<SegmentedRay<float>> rays, int axis, float voxels) {
    for (SegmentedRay<float>& ray : rays)
        ray.entry[axis] += voxels;
    return rays;
}

/// OpenImageIO's gate, as pictures of one volume meet it (Gates.FilteredFetches...).
bool isWithinTheGate(const Image& image, const Image& truth) {
    const ImageDifference d = compare(image, truth);
    return d.nonFinite == 0 && d.valuesAbove012 == 0 &&
           static_cast<double>(d.valuesAbove004) <= 0.0002 * static_cast<double>(d.values);
}

TEST(FusedGpu, FilteredFetchesMeetTheMirrorAndAShiftDoesNot) {
    const GlContext context({"software"});
    for (const std::vector<int>& levels : {std::vector{0, 1, 0}, std::vector{kMixed, 0, kMixed}}) {
        Scene scene = fusedScene({0, 1, 2}, kFewPixels);
        scene.quality.fetch = Fetch::hardware;
        PreparedFusion prepared(scene);
        setLevels(prepared, levels);
        FusedOnDevice device(prepared);
        EXPECT_TRUE(device.caster->features() & kFeatureHardware);
        const Image filtered = device.picture();
        const auto rays = deviceRays(prepared);
        const Image mirror = mirrorPicture(prepared, rays);
        EXPECT_TRUE(isWithinTheGate(filtered, mirror)) << compare(filtered, mirror).maxAbs;
        EXPECT_GT(compare(filtered, mirror).maxAbs, 0);
        for (const int axis : {0, 1, 2})
            EXPECT_FALSE(isWithinTheGate(filtered, mirrorPicture(prepared, shifted(rays, axis, 1)))) << axis;
    }
    EXPECT_TRUE(context.errors().empty()) << testing::PrintToString(context.errors());
}

// Types of all sorts; no two have one level, and one is mixed or none is.
TEST(FusedGpu, EveryVolumeHasALevelAndATypeOfItsOwn) {
    const GlContext context({"software"});
    FieldStores stores;
    const auto bytes = stores.store(gridAt({-8, 6, 2}, {66, 40, 70}, {0.7, 1.1, 0.8}, 15, ValueType::u8),
                                    [](const glm::dvec3& p) { return 128 + 100 * std::sin(0.3 * p.y); });
    struct Row {
        std::vector<int> volumes, levels;
        bool withBytes;
    };
    for (const Row& row :
         {Row{{0, 1, 2}, {2, 0, 1}, true}, Row{{1, 0}, {1, kMixed}, false}, Row{{1, 1}, {0, 1}, false}}) {
        Scene scene = fusedScene(row.volumes, kFewPixels);
        if (row.withBytes) {
            scene.volumes[2].path = bytes;
            scene.volumes[2].transferFunction =
                TransferFunction::fromOpacity({{140, 0}, {220, 0.3}}, {{0, {0.2, 0.5, 1}}}, 1.5);
        }
        if (row.volumes[1] == row.volumes[0])
            scene.volumes[1].transform = glm::translate(glm::dmat4(1), glm::dvec3(7, -3, 5));
        PreparedFusion prepared(scene);
        setLevels(prepared, row.levels);
        const Image gpu = gpuPictures(prepared)[0];
        EXPECT_FALSE(isBlank(gpu));
        EXPECT_LE(compare(gpu, mirrorPicture(prepared, deviceRays(prepared))).maxAbs, 2e-5)
            << row.levels.front();
    }
    EXPECT_TRUE(context.errors().empty()) << testing::PrintToString(context.errors());
}

/// Bytes of all textures and buffers of the current context, as OpenGL says.
std::size_t bytesOnDevice() {
    constexpr GLuint kMostNames = 4096;
    std::size_t bytes = 0;
    for (GLuint name = 1; name < kMostNames; ++name) {
        if (glIsBuffer(name)) {
            GLint64 size = 0;
            glGetNamedBufferParameteri64v(name, GL_BUFFER_SIZE, &size);
            bytes += static_cast<std::size_t>(size);
        }
        if (!glIsTexture(name))
            continue;
        const auto value = [&](GLenum of) {
            GLint is = 0;
            glGetTextureLevelParameteriv(name, 0, of, &is);
            return static_cast<std::size_t>(is);
        };
        if (value(GL_TEXTURE_BUFFER_DATA_STORE_BINDING) != 0)
            continue; // its texels are a buffer's
        const std::size_t bits = value(GL_TEXTURE_RED_SIZE) + value(GL_TEXTURE_GREEN_SIZE) +
                                 value(GL_TEXTURE_BLUE_SIZE) + value(GL_TEXTURE_ALPHA_SIZE);
        bytes += value(GL_TEXTURE_WIDTH) * value(GL_TEXTURE_HEIGHT) * value(GL_TEXTURE_DEPTH) * bits / 8;
    }
    return bytes;
}

/// As the budgets of all volumes have them.
std::size_t bytesCounted(const PreparedFusion& prepared) {
    std::size_t bytes = prepared.budgets.gpu.usedBytes();
    for (const auto& volume : prepared.p.further)
        bytes += volume->gpu.usedBytes() - volume->heldGpu.bytes();
    return bytes;
}

/// Two volumes, of which one has materials and the other gradient opacity; occlusion, and the shadows of two
/// lights.
Scene withAllLight(const glm::ivec2& size) {
    Scene scene = fusedScene({1, 0}, size);
    scene.lighting.lights =
        fourLights(gridAt({0, 0, 0}, {140, 132, 144}, {0.45, 0.5, 0.4}, 0, ValueType::i16));
    scene.lighting.lights[1].shadow = scene.lighting.lights[3].shadow = true;
    scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
    scene.lighting.finestLevel = 1;
    std::get<TransferFunction>(scene.volumes[0].transferFunction)
        .setGradientOpacity(GradientOpacity::fromPoints({{0.2, 0.1}, {3, 0.8}}));
    std::get<TransferFunction>(scene.volumes[1].transferFunction)
        .setMaterials({{150, 280, 0.3, 0.5, 0.1, 5}, {280, 400, 0.1, 0.7, 0.5, 77}});
    return scene;
}
void makeMapsSoon(PreparedFusion& prepared) {
    for (Planner* plan : prepared.plans())
        plan->view.shadowQuality.mapSize = 64;
}

TEST(FusedGpu, AllLightAtOnceIsTheMirrorsAndItsBytesAreCounted) {
    const GlContext context({"software"});
    PreparedFusion prepared(withAllLight({16, 12}));
    makeMapsSoon(prepared);
    setLevels(prepared, {0, kMixed});
    FusedOnDevice device(prepared);
    constexpr std::uint32_t kAll =
        kFeatureVoxelLight | kFeatureMaterials | kFeatureGradientOpacity | kFeatureMixed | kFeatureNormalised;
    EXPECT_EQ(device.caster->features() & kAll, kAll);
    EXPECT_EQ(bytesOnDevice(), bytesCounted(prepared)) << "rays began";
    const Image gpu = device.picture();
    EXPECT_EQ(bytesOnDevice(), bytesCounted(prepared))
        << "then also of the level map of the volume at one level";
    const auto rays = deviceRays(prepared);
    EXPECT_LE(compare(gpu, mirrorPicture(prepared, rays)).maxAbs, 5e-5); // lights divide and take roots
    // Each part of it is to be seen.
    for (const auto& without : {+[](Scene& s) { s.lighting.occlusion.reset(); },
                                +[](Scene& s) { s.lighting.lights[1].shadow = false; },
                                +[](Scene& s) { s.lighting.lights[3].shadow = false; }}) {
        Scene less = withAllLight({16, 12});
        without(less);
        PreparedFusion other(less);
        makeMapsSoon(other);
        setLevels(other, {0, kMixed});
        EXPECT_GT(compare(mirrorPicture(other, rays), gpu).maxAbs, 0.02);
    }
    EXPECT_TRUE(context.errors().empty()) << testing::PrintToString(context.errors());
}

// A ball in two media, a part of which is cut away: the ray through its middle.
TEST(FusedGpu, MeshesAndCutsInTwoMediaAreClosedForms) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 24);
    TwoMedia media;
    using T = TwoMedia;
    const glm::dvec3 one(1, 0.2, 0), two(0, 0.6, 1), ofMesh(0.3, 0.9, 0.2);
    const double left = T::kFirst * std::exp(-T::kSecond * T::kUnit);
    media.scene.cuts.boxes = {{{-30, -8, -30}, {30, -6.5, 30}, CropBox::Space::patient, Keep::outside}};
    SceneMesh ball;
    ball.tube = Tube{{{0, 0, 0}}, 4};
    ball.colour = ofMesh;
    ball.shape = std::make_shared<const TubeShape>(*ball.tube, ram);
    std::get<Camera>(media.scene.camera).parallelScale = 1e-3;
    for (const Fusion rule : {Fusion::mix, Fusion::over, Fusion::maximum})
        for (const double opacity : {1.0, 0.4}) {
            if (opacity == 1 && rule != Fusion::over)
                continue;
            ball.opacity = opacity;
            media.scene.meshes = {ball};
            media.scene.fusion = rule;
            const double extinction = rule == Fusion::mix    ? T::kFirst + T::kSecond
                                      : rule == Fusion::over ? left + T::kSecond
                                                             : T::kSecond;
            const glm::dvec3 colour = rule == Fusion::mix ? (T::kFirst * one + T::kSecond * two) / extinction
                                      : rule == Fusion::over
                                          ? (left * one + T::kSecond * two) / extinction
                                          : glm::max(T::kFirst * one, T::kSecond * two) / extinction;
            glm::dvec3 sum(0);
            double through = 1;
            const auto add = [&](double alpha, const glm::dvec3& c) {
                sum += through * alpha * c;
                through *= 1 - alpha;
            };
            const auto medium = [&](double mm) { add(-std::expm1(-extinction * mm), colour); };
            medium(6 - 1.5); // from -10 mm to the ball, without what is cut away
            add(opacity, ofMesh);
            if (opacity < 1) {
                medium(8);
                add(opacity, ofMesh);
                medium(6);
            }
            const glm::vec4 seen = fusedPicture(media.scene, EngineKind::gpu).image.at(1, 2);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(seen[c], sum[c], 2e-5) << nameOf(rule) << ", " << opacity;
            EXPECT_NEAR(seen.a, 1 - through, 2e-5) << nameOf(rule) << ", " << opacity;
        }
}

TEST(FusedGpu, FramesEqualStills) {
    Scene scene = fusedScene({0, 1}, {12, 10});
    scene.quality.pixels.samples = 1;
    std::vector<Scene> scenes = {scene, scene};
    std::get<Camera>(scenes[1].camera).position = {-90, -120, 20};
    std::vector<Image> stills;
    for (const Scene& one : scenes)
        stills.push_back(fusedPicture(one, EngineKind::gpu).image);
    EXPECT_GT(compare(stills[0], stills[1]).rms, 0.02);
    OpenedVolumes opened(scene);
    RenderOptions options;
    options.engine = EngineKind::gpu;
    options.device.text = "software";
    FrameRenderer frames(opened.stores, opened.budgets.ram, opened.budgets.gpu, options);
    for (std::size_t n = 0; n < scenes.size(); ++n)
        EXPECT_EQ(differing(frames.draw(scenes[n]).image, stills[n]), 0u) << n;
}

// In little memory: the levels of each are mixed, or it is refused by name.
TEST(FusedGpu, SmallBudgetsAreKept) {
    struct Row {
        std::vector<int> volumes;
        std::size_t kib;
    };
    for (const Row& row : {Row{{1, 2}, 3584}, Row{{0, 1, 2}, 6000}}) {
        Scene scene = fusedScene(row.volumes, kFewPixels);
        scene.quality.pixels.samples = 1;
        const Image ample = fusedPicture(scene, EngineKind::native).image;
        const RenderResult result = fusedPicture(scene, EngineKind::gpu, row.kib << 10); // checks the peaks
        EXPECT_LT(compare(result.image, ample).rms, 0.2) << row.kib;
        std::set<std::size_t> used; // levels of further volumes
        for (const RenderResult::Further& further : result.further) {
            EXPECT_LE(further.gpuPeakBytes, further.gpuBytes);
            for (std::size_t level = 0; level < further.bricksOfLevel.size(); ++level)
                if (further.bricksOfLevel[level] > 0)
                    used.insert(level);
        }
        EXPECT_GT(used.size(), 1u) << row.kib;
    }
}

// The least memory: what is refused is told by the option that helps, and whose share is too small.
TEST(FusedBudgets, RefusalsNameTheShare) {
    const Scene scene = fusedScene({1, 2}, kFewPixels);
    OpenedVolumes opened(scene);
    int shares = 0;
    bool accepts = false;
    for (std::size_t kib = 50; kib <= 1000; kib += 50) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", kib << 10);
        const std::string refusal = refusalOf([&] {
            planScene(scene, opened.stores, TextureLimits{}, {opened.budgets.ram, gpu, 0},
                      LevelChoice::perBrick, kPictureBytesPerPixel);
        });
        const bool accepted = refusal == "no refusal";
        accepts = accepts || accepted;
        EXPECT_EQ(accepts, accepted) << kib << " KiB, which is more: " << refusal;
        if (accepts)
            continue;
        EXPECT_NE(refusal.find("--gpu-memory"), std::string::npos) << refusal;
        shares += refusal.find("in the share of volume") != std::string::npos;
    }
    EXPECT_TRUE(accepts);
    EXPECT_GT(shares, 0);
}

// A sample that needs many values takes many turns of loops, and rays go on all the same.
TEST(FusedGpu, PassesComeToAnEndWhateverTheGradient) {
    const GlContext context({"software"});
    for (const Gradient gradient : {Gradient::sobel, Gradient::cubic})
        for (const bool mixed : {false, true}) {
            Scene scene = fusedScene({0, 1}, {4, 2});
            scene.shading.gradient = gradient;
            scene.quality.stepVoxels = 2;
            PreparedFusion prepared(scene);
            setLevels(prepared, mixed ? std::vector{kMixed, kMixed} : std::vector{0, 0});
            FusedOnDevice device(prepared, 16);
            EXPECT_TRUE(device.caster->features() & kFeaturePasses);
            int calls = 0; // one dispatch each
            constexpr int kMost = 1500;
            while (!device.caster->draw({}, RayCaster::Clock::time_point::min(), device.work) &&
                   ++calls < kMost) {
            }
            ASSERT_LT(calls, kMost) << "rays neither go on nor wait";
            EXPECT_EQ(bytesOnDevice(), bytesCounted(prepared));
            EXPECT_GT(device.caster->waiting(), 0u);
            // What is taken is forgotten, of that volume alone.
            const auto wants = [&](std::size_t volume) {
                const std::vector<std::uint32_t> rays = device.caster->takeWanted(volume);
                return std::any_of(rays.begin(), rays.end(),
                                   [](std::uint32_t ray) { return ray != UINT32_MAX; });
            };
            const bool second = wants(1);
            EXPECT_FALSE(wants(1));
            EXPECT_TRUE(wants(0) || second);
            EXPECT_FALSE(wants(0));
            EXPECT_LE(compare(device.picture(), mirrorPicture(prepared, deviceRays(prepared))).maxAbs, 2e-5);
        }
}

/// What a program needs of the device, as its linker says.
FuseLimits needsOf(const GlProgram& program) {
    program.use();
    GLint name = 0, count = 0;
    glGetIntegerv(GL_CURRENT_PROGRAM, &name);
    const auto id = static_cast<GLuint>(name);
    glGetProgramiv(id, GL_ACTIVE_UNIFORMS, &count);
    FuseLimits needs;
    for (GLuint n = 0; n < static_cast<GLuint>(count); ++n) {
        char text[128];
        GLint size = 0;
        GLenum type = 0;
        glGetActiveUniform(id, n, sizeof(text), nullptr, &size, &type, text);
        switch (type) {
        case GL_SAMPLER_3D:
        case GL_UNSIGNED_INT_SAMPLER_3D:
        case GL_SAMPLER_BUFFER:
            needs.textures += size;
            break;
        case GL_FLOAT_MAT3:
            needs.components += 12 * size;
            break;
        case GL_FLOAT:
        case GL_INT:
            needs.components += size;
            break;
        default: // vectors
            needs.components += 4 * size;
        }
    }
    return needs;
}

TEST(FusedGpu, LimitsAreWhatItsProgramNeeds) {
    const GlContext context({"software"});
    const std::uint32_t all = kFeatureFused | kFeatureSkipping | kFeatureNormalised | kFeatureHardware |
                              kFeatureMixed | kFeaturePasses | kFeatureShading | kFeatureLights |
                              kFeatureMaterials | kFeatureVoxelLight | kFeatureEmission | kFeatureLabels |
                              kFeatureGradientOpacity | kFeatureTermination | kFeatureIntervals |
                              kFeaturePlaces | kFeatureSlabs;
    Scene scene = withAllLight({8, 8});
    scene.volumes[0].labels.path = "labels";
    const FuseLimits needs = needsOf(marchComposition(all, 2).program("march.comp"));
    EXPECT_EQ(cannotFuse(scene, {needs.textures, 64, 4096}), "");
    EXPECT_NE(cannotFuse(scene, {needs.textures - 1, 64, 4096}), "");
    EXPECT_NE(cannotFuse(scene, {64, 64, needs.components - 1}), "") << needs.components;
    EXPECT_EQ(cannotFuse(scene, {64, 64, needs.components + 256}), "") << needs.components;
}

} // namespace
} // namespace tessera
