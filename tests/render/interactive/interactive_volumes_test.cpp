// tests/render/interactive/interactive_volumes_test.cpp: interactive pictures of several volumes. They come
// to the still's, hold all volumes from the first on, and keep within both budgets, whatever changes.
#include "core/base/error.h"
#include "core/image/image_metrics.h"
#include "render/backends/gpu/gl/context.h"
#include "render/interactive/interactive_renderer.h"
#include "tests/support/fused.h"

#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;
using std::chrono::milliseconds;
using Clock = InteractiveRenderer::Clock;

constexpr glm::ivec2 kPixels(37, 29);
constexpr std::size_t kMuch = std::size_t{1} << 30;

/// A renderer of several volumes with all that it stands on, which checks itself after every step.
struct SeveralSession {
    SeveralSession(const Scene& scene, bool native, std::size_t gpuBytes = kMuch,
                   std::size_t ramBytes = kMuch, const InteractiveOptions& options = {})
        : ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", gpuBytes), opened(scene),
          context(native ? nullptr : std::make_unique<GlContext>(GlDeviceChoice{"software"})),
          engine(native ? std::unique_ptr<Engine>(std::make_unique<NativeEngine>(options.threads, gpu, ram))
                        : std::make_unique<GpuEngine>(*context, gpu, ram)),
          renderer(scene, opened.stores, *engine, ram, gpu, options) {}
    InteractiveRenderer::Progress step(milliseconds each = milliseconds(200)) {
        const InteractiveRenderer::Progress progress = renderer.advance(Clock::now() + each);
        EXPECT_LE(ram.peakBytes(), ram.limitBytes());
        EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
        for (std::size_t n = 0; n < renderer.drawnVolumes(); ++n) {
            const InteractiveVolume& volume = renderer.drawn(n);
            EXPECT_LE(pagesFor(volume.resident().counts), volume.pages()) << n;
            const MemoryBudget& own = *volume.plan().ram;
            EXPECT_LE(own.peakBytes(), own.limitBytes()) << n;
        }
        return progress;
    }
    Image converged() {
        for (int calls = 0; !step().converged; ++calls)
            if (calls > 500) {
                ADD_FAILURE() << "no end";
                break;
            }
        return renderer.picture();
    }
    MemoryBudget ram, gpu;
    OpenedVolumes opened;
    std::unique_ptr<GlContext> context;
    std::unique_ptr<Engine> engine;
    InteractiveRenderer renderer;
};

Camera otherCamera(const Scene& scene) {
    Camera camera = std::get<Camera>(scene.camera);
    camera.position = {-120, -90, 40};
    camera.focalPoint = {-3, 2, 4};
    return camera;
}
TransferFunction otherFunction() {
    return TransferFunction::fromOpacity({{1, 0}, {4, 0.4}, {9, 0.1}}, {{2, {0.1, 1, 0.3}}}, 2);
}

/// Shares of the picture that differ: of engines whose maps of levels are others than a still's.
double differing(const Image& a, const Image& b) {
    return compare(a, b).luvMean;
}

struct SeveralCase {
    const char* name;
    bool native = true;
    Fusion rule = Fusion::mix;
    Mode mode = Mode::composite;
    bool shadows = false, ofFunction = false;
    Scene scene() const {
        Scene s = fusedScene({0, 1}, kPixels);
        s.fusion = rule;
        s.mode = mode;
        if (ofFunction)
            s.volumes[1].valueColour = ValueColour::transferFunction;
        if (mode == Mode::slice) { // pixels that show the finest level, as interactive slices always do
            s.camera = FittedView{};
            s.imageSize = {170, 150};
        }
        return shadows ? shadowed(s) : s;
    }
    EngineKind engine() const { return native ? EngineKind::native : EngineKind::gpu; }
};
class SeveralInteractive : public testing::TestWithParam<SeveralCase> {};
INSTANTIATE_TEST_SUITE_P(Scenes, SeveralInteractive,
                         testing::Values(SeveralCase{"mix"}, SeveralCase{"over", true, Fusion::over},
                                         SeveralCase{"maximum", true, Fusion::maximum},
                                         SeveralCase{"shadows", true, Fusion::mix, Mode::composite, true},
                                         SeveralCase{"gpu", false, Fusion::over},
                                         SeveralCase{"greatest", true, Fusion::mix, Mode::maximum},
                                         SeveralCase{"overlay", true, Fusion::over, Mode::slice, false, true},
                                         SeveralCase{"gpuOverlay", false, Fusion::over, Mode::slice, false,
                                                     true}),
                         [](const auto& info) { return std::string(info.param.name); });

// After any change the picture is the still's of the scene as it is then: bit for bit by the native engine.
// The GPU's maps of levels are always mixed ones, as with one volume.
TEST_P(SeveralInteractive, ComesToTheStill) {
    Scene scene = GetParam().scene();
    const Image first = fusedPicture(scene, GetParam().engine()).image;
    const auto check = [&](const Image& picture, const char* what) {
        const Image still = fusedPicture(scene, GetParam().engine()).image;
        EXPECT_FALSE(isBlank(still));
        if (GetParam().native) {
            EXPECT_TRUE(bitEqual(picture, still)) << what;
        } else {
            EXPECT_LE(differing(picture, still), 1e-3) << what;
        }
    };
    std::vector<Image> pictures;
    {
        SeveralSession session(scene, GetParam().native); // its context goes before another comes
        pictures.push_back(session.converged());
        if (GetParam().mode != Mode::slice)
            session.renderer.setCamera(otherCamera(scene));
        pictures.push_back(session.converged());
        session.renderer.setFunction(otherFunction(), 1);
        pictures.push_back(session.converged());
        session.renderer.setOpacity(0.3, 1);
        pictures.push_back(session.converged());
    }
    check(pictures[0], "at first");
    if (GetParam().mode != Mode::slice)
        scene.camera = otherCamera(scene);
    check(pictures[1], "another camera");
    scene.volumes[1].transferFunction = otherFunction();
    check(pictures[2], "another function of the second volume");
    scene.volumes[1].opacity = 0.3;
    check(pictures[3], "another opacity of the second volume");
    EXPECT_GT(differing(pictures[2], pictures[3]), 0.1);
}

// The very first picture, drawn in haste with few pages, has both volumes: hiding either one changes it.
TEST_P(SeveralInteractive, TheFirstPictureHasAllVolumes) {
    const auto firstOf = [&](const Scene& scene) {
        SeveralSession session(scene, GetParam().native);
        session.renderer.setHaste(InteractiveRenderer::Haste{{30, 25}, 1});
        for (int calls = 0; calls < 500; ++calls)
            if (session.step(milliseconds(50)).newPicture)
                return session.renderer.picture();
        ADD_FAILURE() << "no picture";
        return Image();
    };
    const Scene both = GetParam().scene();
    const Image picture = firstOf(both);
    for (const std::size_t hidden : {0u, 1u}) {
        Scene without = both;
        without.volumes[hidden].opacity = 0;
        EXPECT_GT(differing(picture, firstOf(without)), 0.2) << "volume " << hidden + 1;
    }
}

// Random changes on few pages: after every step both budgets hold, and it comes to an end.
TEST_P(SeveralInteractive, AnyStepsKeepTheBudgets) {
    const Scene scene = GetParam().scene();
    const std::size_t gpuBytes = std::size_t{11} << 20,
                      ramBytes = std::size_t{GetParam().shadows ? 200u : 60u} << 20;
    SeveralSession session(scene, GetParam().native, gpuBytes, ramBytes);
    EXPECT_LT(session.renderer.atlasPages(), 100u) << "the budget must be short"; // of 125 bricks
    std::mt19937 random(7);
    for (int step = 0; step < 60; ++step) {
        switch (random() % 6) {
        case 0:
            if (GetParam().mode != Mode::slice)
                session.renderer.setCamera(random() % 2 ? otherCamera(scene)
                                                        : std::get<Camera>(scene.camera));
            break;
        case 1:
            session.renderer.setFunction(random() % 2
                                             ? otherFunction()
                                             : std::get<TransferFunction>(scene.volumes[1].transferFunction),
                                         1);
            break;
        case 2:
            session.renderer.setOpacity(random() % 2 ? 1 : 0.4, random() % 2);
            break;
        case 3:
            session.renderer.cancel();
            break;
        case 4:
            session.renderer.setHaste(random() % 2 ? std::optional(InteractiveRenderer::Haste{{20, 16}, 1})
                                                   : std::nullopt);
            break;
        default:
            break;
        }
        session.step(milliseconds(random() % 20));
        if (HasFailure())
            return;
    }
    session.renderer.setHaste(std::nullopt);
    EXPECT_EQ(session.converged().size, scene.imageSize);
}

// Engines stay while renderers come and go, and hold nothing of a renderer that is gone or never came.
TEST(SeveralInteractives, LeaveNothingInTheEngine) {
    const Scene scene = fusedScene({0, 1}, kPixels);
    MemoryBudget ram("RAM", "--ram", kMuch), gpu("GPU memory", "--gpu-memory", kMuch);
    const OpenedVolumes opened(scene);
    NativeEngine engine(1, gpu, ram);
    for (int n = 0; n < 2; ++n) {
        InteractiveRenderer renderer(scene, opened.stores, engine, ram, gpu, {});
        renderer.advance(Clock::now() + milliseconds(20));
    }
    EXPECT_EQ(gpu.usedBytes(), 0u);
    // Too little memory, at any place on the way.
    int refused = 0;
    for (std::size_t bytes = std::size_t{20} << 20; bytes > (std::size_t{1} << 18); bytes = bytes / 8 * 7) {
        MemoryBudget little("GPU memory", "--gpu-memory", bytes);
        NativeEngine own(1, little, ram);
        try {
            const InteractiveRenderer renderer(scene, opened.stores, own, ram, little, {});
        } catch (const InputError&) {
            ++refused;
        }
        EXPECT_EQ(little.usedBytes(), 0u) << bytes;
    }
    EXPECT_GT(refused, 3);
}

// The cuts of one volume stay while those of all change.
TEST(SeveralInteractives, AreCutAsTheStill) {
    for (const Mode mode : {Mode::composite, Mode::maximum}) {
        Scene scene = fusedScene({0, 1}, kPixels);
        scene.mode = mode;
        scene.volumes[0].cuts.planes = {{{2, 3, 1}, {0.2, 1, 0.4}, Keep::inside}};
        Scene other = scene;
        other.cuts.boxes = {{{-30, -30, -30}, {8, 30, 30}, CropBox::Space::patient, Keep::inside}};
        std::vector<Image> pictures;
        {
            SeveralSession session(scene, true);
            pictures.push_back(session.converged());
            session.renderer.setCuts(other.cuts);
            pictures.push_back(session.converged());
        }
        EXPECT_TRUE(bitEqual(pictures[0], fusedPicture(scene, EngineKind::native).image)) << nameOf(mode);
        EXPECT_TRUE(bitEqual(pictures[1], fusedPicture(other, EngineKind::native).image)) << nameOf(mode);
        EXPECT_GT(differing(pictures[0], pictures[1]), 0.1);
    }
}

// A volume's ambient light follows another's function.
TEST(SeveralInteractives, AmbientLightFollowsAllFunctions) {
    Scene scene = fusedScene({0, 1}, kPixels);
    scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 10};
    Image picture;
    {
        SeveralSession session(scene, true);
        session.converged();
        session.renderer.setFunction(otherFunction(), 1);
        picture = session.converged();
    }
    scene.volumes[1].transferFunction = otherFunction();
    EXPECT_TRUE(bitEqual(picture, fusedPicture(scene, EngineKind::native).image));
}

TEST(SeveralInteractives, ShareTheMemory) {
    const Scene scene = fusedScene({0, 1, 2}, kPixels);
    SeveralSession session(scene, true);
    ASSERT_EQ(session.renderer.drawnVolumes(), 3u);
    const MemoryBudget &second = *session.renderer.drawn(1).plan().ram,
                       &third = *session.renderer.drawn(2).plan().ram;
    EXPECT_NE(&second, &session.ram);
    EXPECT_LT(second.limitBytes() + third.limitBytes(), session.ram.limitBytes());
    EXPECT_GE(session.ram.usedBytes(), second.limitBytes() + third.limitBytes()) << "held as a whole";
}

// Cameras are fitted to all volumes, as a still's.
TEST(SeveralInteractives, FitAllVolumes) {
    Scene scene = fusedScene({1, 2}, kPixels);
    scene.camera = FittedView{};
    SeveralSession session(scene, true);
    const RenderResult still = fusedPicture(scene, EngineKind::native);
    EXPECT_EQ(session.renderer.camera(), still.camera);
    EXPECT_EQ(session.renderer.fitted(FittedView{}), still.camera);
    scene.volumes.pop_back();
    EXPECT_NE(fusedPicture(scene, EngineKind::native).camera, still.camera);
}

// What scenes of several volumes do not have is refused; the first alone has it.
TEST(SeveralInteractives, TheFirstAlone) {
    Scene scene = fusedScene({0, 1}, kPixels);
    scene.surfaces = {{300, {1, 1, 1}, 1}};
    EXPECT_THROW(SeveralSession(scene, true), InputError);
    InteractiveOptions options;
    options.firstAlone = true;
    SeveralSession session(scene, true, kMuch, kMuch, options);
    const Image picture = session.converged();
    EXPECT_EQ(session.renderer.sceneVolumes(), 1u);
    session.renderer.setFunction(otherFunction(), 1); // of a volume that is not drawn
    EXPECT_TRUE(bitEqual(session.converged(), picture));
}

} // namespace
} // namespace tessera
