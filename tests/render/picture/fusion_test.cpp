// tests/render/picture/fusion_test.cpp: several volumes in one picture (docs/sampling.md, "Several volumes").
#include "core/base/error.h"
#include "core/image/image_metrics.h"
#include "render/backends/engine_maker.h"
#include "tests/support/fused.h"
#include "tests/support/labelled.h"
#include "tests/support/lights.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/refusals.h"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(37, 29); // no packet's edges divide it

/// Labels on the first of fusedStores().
const std::filesystem::path& labelsOfFirst() {
    static const BallsOfLabels labels([] {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        return StoreReader(fusedStores()[0], ram).info();
    }());
    return labels.store;
}

enum class Lit { no, head, lights, shadows };
struct FusedCase {
    std::vector<int> volumes;
    Fusion rule;
    Lit lit = Lit::head;
    bool cuts = false, grades = false, labels = false, ownCuts = false;
    Scene scene(const glm::ivec2& size = kSize) const {
        Scene s = fusedScene(volumes, size);
        s.fusion = rule;
        s.shading.on = lit != Lit::no;
        if (lit == Lit::lights)
            s.lighting.lights =
                fourLights(gridAt({0, 0, 0}, {140, 132, 144}, {0.45, 0.5, 0.4}, 0, ValueType::i16));
        if (lit == Lit::shadows)
            s = shadowed(s);
        if (labels)
            for (std::size_t n = 0; n < volumes.size(); ++n)
                if (volumes[n] == 0)
                    s.volumes[n].labels.path = s.volumes[n].labels.store = labelsOfFirst();
        if (cuts)
            s.cuts.boxes.push_back({{-8, -20, -9}, {12, 9, 14}, CropBox::Space::patient, Keep::outside});
        if (ownCuts) {
            s.volumes[0].cuts.planes = {{{2, 3, 1}, {0.2, 1, 0.4}, Keep::inside}};
            s.volumes[1].cuts.boxes = {{{-30, -30, -30}, {3, 30, 30}, CropBox::Space::patient, Keep::inside},
                                       {{4, 5, 6}, {12, 14, 15}, CropBox::Space::voxels, Keep::outside}};
        }
        if (grades)
            for (SceneVolume& volume : s.volumes)
                std::get<TransferFunction>(volume.transferFunction)
                    .setGradientOpacity(GradientOpacity::fromPoints({{0.2, 0.1}, {3, 0.8}, {30, 1}}));
        return s;
    }
};
std::ostream& operator<<(std::ostream& out, const FusedCase& c) {
    return out << c.volumes.size() << " volumes, " << nameOf(c.rule) << ", light " << static_cast<int>(c.lit)
               << (c.cuts ? ", cut" : "") << (c.grades ? ", graded" : "") << (c.labels ? ", labels" : "")
               << (c.ownCuts ? ", own cuts" : "");
}
class Fused : public testing::TestWithParam<FusedCase> {};
class FusedMarch : public testing::TestWithParam<FusedCase> {};
INSTANTIATE_TEST_SUITE_P(
    Scenes, Fused,
    testing::Values(FusedCase{{0, 1}, Fusion::mix}, FusedCase{{1, 0}, Fusion::over, Lit::no},
                    FusedCase{{0, 1, 2}, Fusion::maximum, Lit::lights},
                    FusedCase{{2, 1, 0}, Fusion::over, Lit::lights, true},
                    FusedCase{{0, 2}, Fusion::mix, Lit::head, true, true},
                    FusedCase{{1, 0}, Fusion::over, Lit::head, true, false, false, true}));
/// What the mirror draws on the rays of others alone.
INSTANTIATE_TEST_SUITE_P(BesideTheVolumes, FusedMarch,
                         testing::Values(FusedCase{{0, 1}, Fusion::mix, Lit::shadows},
                                         FusedCase{{2, 0, 1}, Fusion::over, Lit::shadows, true, true},
                                         FusedCase{{0, 1}, Fusion::over, Lit::head, false, false, true},
                                         FusedCase{{1, 0}, Fusion::maximum, Lit::lights, false, true, true}));

TEST_P(Fused, NativeHasTheMirrorsBits) {
    PreparedFusion prepared(GetParam().scene());
    const Image mirror = mirrorPicture(prepared.p);
    EXPECT_FALSE(isBlank(mirror));
    for (const native::PacketTarget* target : nativeTargets())
        for (const bool ghostLayers : {true, false}) {
            NativeChoices choices;
            choices.target = target;
            choices.ghostLayers = ghostLayers;
            EXPECT_EQ(differing(nativePicture(prepared, choices), mirror), 0u) << target->name;
        }
    NativeChoices choices;
    choices.slicing.fixedIterations = 7;
    EXPECT_EQ(differing(nativePicture(prepared, choices), mirror), 0u) << "seven turns at a time";
    Scene scene = GetParam().scene();
    scene.quality.skipping = false;
    PreparedFusion all(scene);
    EXPECT_EQ(differing(nativePicture(all), mirror), 0u) << "without skipping";
}

TEST_P(Fused, NativeHasTheMirrorsBitsAcrossLevels) {
    PreparedFusion prepared(GetParam().scene());
    for (const unsigned seed : {1u, 2u}) {
        unsigned next = seed;
        for (Planner* plan : prepared.plans())
            plan->setSelection(randomShownLevels(plan->layer().selection, 7 * next++));
        EXPECT_EQ(differing(nativePicture(prepared), mirrorPicture(prepared.p)), 0u);
    }
}

/// @param prepared  with their levels
/// @param all  the same without skipping
void expectTheMirrorOnItsOwnRays(PreparedFusion& prepared, PreparedFusion& all) {
    Slicing shreds;
    shreds.fixedTile = 24;
    shreds.fixedIterations = 7;
    const std::vector<Image> pictures = gpuPictures(prepared, {Slicing{}, shreds});
    const Image& gpu = pictures[0];
    EXPECT_FALSE(isBlank(gpu));
    EXPECT_LE(compare(gpu, mirrorPicture(prepared, gpuRays(raysOf(prepared.p), prepared.budgets.gpu))).maxAbs,
              2e-5);
    EXPECT_TRUE(bitEqual(pictures[1], gpu)) << "seven turns at a time";
    EXPECT_TRUE(bitEqual(gpuPictures(all)[0], gpu)) << "without skipping";
}
void marchEqualsTheMirror(const FusedCase& given) {
    const GlContext context({"software"});
    Scene scene = given.scene({24, 18});
    PreparedFusion prepared(scene);
    scene.quality.skipping = false;
    PreparedFusion all(scene);
    for (PreparedFusion* both : {&prepared, &all})
        for (Planner* plan : both->plans())
            plan->view.shadowQuality.mapSize = 64; // made soon
    expectTheMirrorOnItsOwnRays(prepared, all);
    // Levels of some are mixed, of one they are not.
    for (std::size_t n = 1; n < prepared.plans().size(); ++n) {
        Planner &one = *prepared.plans()[n], &other = *all.plans()[n];
        one.setSelection(randomShownLevels(one.layer().selection, static_cast<unsigned>(7 * n)));
        other.setSelection(Selection(one.layer().selection));
    }
    expectTheMirrorOnItsOwnRays(prepared, all);
    EXPECT_TRUE(context.errors().empty());
}
TEST_P(Fused, MarchEqualsTheMirrorOnItsOwnRays) {
    marchEqualsTheMirror(GetParam());
}
TEST_P(FusedMarch, EqualsTheMirrorOnItsOwnRays) {
    marchEqualsTheMirror(GetParam());
}

TEST_P(Fused, ComesToTheReference) {
    const Scene scene = GetParam().scene({24, 20});
    const Image truth = fusedPicture(scene, EngineKind::reference).image;
    const auto rms = [&](double step) {
        Scene stepped = scene;
        stepped.quality.stepVoxels = step;
        constexpr std::size_t kAmple = std::size_t{1} << 30;
        return compare(
                   fusedPicture(stepped, EngineKind::native, kAmple, kAmple, LevelChoice::oneForAll).image,
                   truth)
            .rms;
    };
    const double coarse = rms(1), fine = rms(1.0 / 16);
    EXPECT_LT(fine, coarse / 5) << coarse;
    EXPECT_LT(fine, 1.5e-3);
}

TEST_P(Fused, PassesGiveTheSamePicture) {
    const Scene scene = GetParam().scene();
    constexpr std::size_t kAmple = std::size_t{1} << 30;
    const auto drawn = [&](EngineKind engine, std::size_t gpu) {
        return fusedPicture(scene, engine, gpu, kAmple, LevelChoice::finest);
    };
    const RenderResult ample = drawn(EngineKind::native, kAmple);
    EXPECT_EQ(ample.passes, 1);
    RenderResult tight;
    for (std::size_t mib = 4; tight.passes == 0 && mib < 32; ++mib)
        try { // the least budget
            tight = drawn(EngineKind::native, mib << 20);
        } catch (const InputError&) {
        }
    EXPECT_GT(tight.passes, 1);
    EXPECT_EQ(differing(tight.image, ample.image), 0u);
    EXPECT_EQ(differing(drawn(EngineKind::mirror, kAmple).image, ample.image), 0u);
}

TEST(FusedGpu, PassesGiveTheSamePicture) {
    Scene scene = FusedCase{{1, 2}, Fusion::over}.scene({16, 12});
    scene.quality.pixels.samples = 1;
    constexpr std::size_t kAmple = std::size_t{1} << 30;
    const auto drawn = [&](std::size_t gpu) {
        return fusedPicture(scene, EngineKind::gpu, gpu, kAmple, LevelChoice::finest);
    };
    const RenderResult ample = drawn(kAmple);
    EXPECT_FALSE(isBlank(ample.image));
    EXPECT_EQ(ample.engine, EngineKind::gpu);
    RenderResult tight;
    for (std::size_t halves = 4; tight.passes == 0 && halves < 32; ++halves)
        try { // the least budget
            tight = drawn(halves << 19);
        } catch (const InputError&) {
        }
    EXPECT_GT(tight.passes, 1);
    EXPECT_EQ(differing(tight.image, ample.image), 0u);
}

TEST(FusedGpu, AutomaticTakesAnEngineThatCanDraw) {
    const auto drawn = [](const std::vector<int>& volumes) {
        Scene scene = fusedScene(volumes, {4, 4});
        scene.quality.pixels.samples = 1;
        return fusedPicture(scene, EngineKind::automatic);
    };
    EXPECT_EQ(drawn({0, 1}).engine, EngineKind::gpu);
    const RenderResult many = drawn({0, 1, 2, 0, 1, 2, 0, 1});
    EXPECT_EQ(many.engine, EngineKind::native);
    EXPECT_NE(many.engineReason.find("8 volumes"), std::string::npos) << many.engineReason;
    EXPECT_NE(refusalOf([] {
                  fusedPicture(fusedScene({0, 1, 2, 0, 1, 2, 0, 1}, {4, 4}), EngineKind::gpu);
              }).find("--engine: expected native"),
              std::string::npos);
}

TEST(FusedForms, AVolumeThatShowsNothingChangesNoBit) {
    Scene scene = fusedScene({0, 2}, kSize);
    scene.quality.stepVoxels = 1.0 / 8;
    Scene alone = scene;
    alone.volumes.pop_back();
    scene.volumes[1].opacity = 0;
    const Image one = fusedPicture(alone, EngineKind::native).image;
    // The lattice's box is larger, so that rays begin elsewhere.
    EXPECT_LT(compare(fusedPicture(scene, EngineKind::native).image, one).rms, 2e-3);
    Scene within = scene; // a box within the first's
    FieldStores stores;
    within.volumes[1].path = stores.store(gridAt({0, 0, 0}, {10, 9, 8}, {3, 3, 3}, 10, ValueType::f32),
                                          [](const glm::dvec3&) { return 0.0; });
    for (const Fusion rule : {Fusion::mix, Fusion::over, Fusion::maximum}) {
        within.fusion = rule;
        EXPECT_EQ(differing(fusedPicture(within, EngineKind::native).image, one), 0u) << nameOf(rule);
    }
}

TEST(FusedForms, TwoEvenMedia) {
    TwoMedia media;
    const auto shown = [&](Fusion rule, EngineKind engine) {
        media.scene.fusion = rule;
        return fusedPicture(media.scene, engine).image.at(1, 2);
    };
    using T = TwoMedia;
    const glm::dvec3 one(1, 0.2, 0), two(0, 0.6, 1);
    const auto of = [](double extinction, const glm::dvec3& colour) {
        const double alpha = -std::expm1(-extinction * T::kMm);
        return glm::vec4(alpha * colour, alpha);
    };
    const double left = T::kFirst * std::exp(-T::kSecond * T::kUnit);
    for (const EngineKind engine :
         {EngineKind::gpu, EngineKind::native, EngineKind::mirror, EngineKind::reference}) {
        const float near = engine == EngineKind::reference ? 1e-7f : 2e-5f;
        const auto expect = [&](Fusion rule, const glm::vec4& wanted) {
            const glm::vec4 found = shown(rule, engine);
            for (int c = 0; c < 4; ++c)
                EXPECT_NEAR(found[c], wanted[c], near) << nameOf(rule) << ", " << name(engine) << ", " << c;
        };
        expect(Fusion::mix,
               of(T::kFirst + T::kSecond, (T::kFirst * one + T::kSecond * two) / (T::kFirst + T::kSecond)));
        expect(Fusion::over, of(left + T::kSecond, (left * one + T::kSecond * two) / (left + T::kSecond)));
        expect(Fusion::maximum, of(T::kSecond, glm::max(T::kFirst * one, T::kSecond * two) / T::kSecond));
    }
}

// A volume's own cuts are the scene's where it is alone; among others they lie where the scene's would.
TEST(FusedCuts, OfAVolumeAreThoseOfAScene) {
    Cuts cuts;
    cuts.planes = {{{1, 2, 3}, {0.5, 1, -0.3}, Keep::inside}};
    cuts.boxes = {{{-6, -30, -9}, {5, 30, 8}, CropBox::Space::patient, Keep::outside}};
    for (const Mode mode : {Mode::composite, Mode::maximum, Mode::slice}) {
        Scene scene = fusedScene({0}, kSize), own = scene;
        scene.mode = own.mode = mode;
        scene.cuts = own.volumes[0].cuts = cuts;
        const Image expected = fusedPicture(scene, EngineKind::native).image;
        EXPECT_FALSE(isBlank(expected));
        EXPECT_EQ(differing(fusedPicture(own, EngineKind::native).image, expected), 0u) << nameOf(mode);
    }
    Scene scene = fusedScene({0, 1}, kSize);
    scene.shading.on = false;
    scene.quality.stepVoxels = 1.0 / 16;
    scene.volumes[1].opacity = 0;
    const Image uncut = fusedPicture(scene, EngineKind::native).image;
    Scene own = scene;
    scene.cuts = own.volumes[0].cuts = cuts;
    const Image expected = fusedPicture(scene, EngineKind::native).image;
    EXPECT_LT(compare(fusedPicture(own, EngineKind::native).image, expected).rms, 4e-3);
    EXPECT_GT(compare(uncut, expected).rms, 0.05);
    // Along a face of an oblique plane, ray by ray.
    Camera& camera = std::get<Camera>(scene.camera);
    camera.projection = Projection::parallel;
    camera.parallelScale = 30;
    const glm::dvec3 along = glm::normalize(camera.focalPoint - camera.position);
    own = scene;
    own.cuts = {};
    own.volumes[0].cuts.planes = {
        {camera.focalPoint, glm::cross(along, glm::dvec3(0.3, 0.1, 1)), Keep::inside}};
    PreparedFusion prepared(own);
    EXPECT_EQ(differing(nativePicture(prepared), mirrorPicture(prepared.p)), 0u);
    // The other volume stays whole.
    scene.cuts = own.volumes[0].cuts = {};
    scene.volumes[0].opacity = own.volumes[0].opacity = 0;
    scene.volumes[1].opacity = own.volumes[1].opacity = 1;
    own.volumes[0].cuts = cuts;
    EXPECT_EQ(
        differing(fusedPicture(own, EngineKind::native).image, fusedPicture(scene, EngineKind::native).image),
        0u);
}

TEST(FusedForms, MixDoesNotDependOnTheOrder) {
    const Image forth = fusedPicture(fusedScene({0, 1, 2}, kSize), EngineKind::native).image,
                back = fusedPicture(fusedScene({2, 1, 0}, kSize), EngineKind::native).image;
    EXPECT_LT(compare(forth, back).maxAbs, 2e-5);
}

/// The middle of what is seen, pixels.
glm::dvec2 middleOf(const Image& image) {
    glm::dvec2 sum(0);
    double all = 0;
    for (int y = 0; y < image.size.y; ++y)
        for (int x = 0; x < image.size.x; ++x) {
            const double a = image.at(x, y).a;
            sum += a * (glm::dvec2(x, y) + 0.5), all += a;
        }
    return sum / all;
}

// Three landmarks in two volumes whose frames differ by rotation and spacing; one shown at a time.
TEST(FusedForms, LandmarksCoincide) {
    FieldStores stores;
    for (const glm::dvec3& spot : spots()) {
        const auto field = [&](const glm::dvec3& p) { return 100 * blob(p, spot, 6); };
        const auto fine = stores.store(gridAt({0, 0, 0}, {80, 76, 82}, {0.8, 0.8, 0.8}, 0, ValueType::f32),
                                       field),
                   turned = stores.store(
                       gridAt({2, 1, -3}, {30, 28, 26}, {2.4, 2.5, 2.6}, 33, ValueType::f32), field);
        for (const glm::dvec3& from : {glm::dvec3(0, -200, 0), glm::dvec3(140, 90, 80)}) {
            Scene scene = fusedScene({0, 1}, {96, 96});
            Camera camera = std::get<Camera>(scene.camera);
            camera.projection = Projection::parallel;
            camera.position = from, camera.focalPoint = {0, 0, 0}, camera.parallelScale = 48;
            scene.camera = camera;
            scene.shading.on = false;
            scene.volumes[0].path = fine, scene.volumes[1].path = turned;
            for (SceneVolume& volume : scene.volumes)
                volume.transferFunction = TransferFunction::fromExtinction({{0, 0}, {100, 0.001}}, {});
            const auto shows = [&](std::size_t n) {
                Scene one = scene;
                one.volumes[1 - n].opacity = 0;
                return middleOf(fusedPicture(one, EngineKind::native).image);
            };
            const double mmPerPixel = 1;
            EXPECT_LT(glm::length(shows(0) - shows(1)) * mmPerPixel, 0.1);
            // and where the camera has the place
            const glm::dmat3 axes = patientFromCamera(camera);
            const glm::dvec2 at(48 + glm::dot(axes[0], spot), 48 - glm::dot(axes[1], spot));
            EXPECT_LT(glm::length(shows(1) - at) * mmPerPixel, 0.1);
        }
    }
}

TEST(FusedForms, ATransformMovesAVolume) {
    const Scene scene = fusedScene({0, 1}, kSize);
    const glm::dmat4 by = glm::translate(glm::dmat4(1), glm::dvec3(9, -4, 6)) *
                          glm::rotate(glm::dmat4(1), 0.4, glm::dvec3(0, 1, 0.5));
    FieldStores stores;
    VolumeInfo info = gridAt({1, 2, -1}, {26, 22, 24}, {2.6, 3, 2.8}, 25, ValueType::f32);
    const glm::dmat4 back = glm::inverse(by);
    info.patientFromVoxel = by * info.patientFromVoxel;
    Scene stored = scene, moved = scene;
    stored.volumes[1].path =
        stores.store(info, [&](const glm::dvec3& p) { return hot(glm::dvec3(back * glm::dvec4(p, 1))); });
    moved.volumes[1].transform = by;
    const Image as = fusedPicture(stored, EngineKind::native).image;
    EXPECT_LT(compare(fusedPicture(moved, EngineKind::native).image, as).rms, 1e-4);
    EXPECT_GT(compare(fusedPicture(scene, EngineKind::native).image, as).rms, 0.01);
}

TEST(FusedForms, CamerasAreFittedToAll) {
    Scene scene = fusedScene({0, 2}, {64, 64});
    scene.camera = FittedView{};
    for (const bool parallel : {false, true}) {
        std::get<FittedView>(scene.camera).projection =
            parallel ? Projection::parallel : Projection::perspective;
        const Image image = fusedPicture(scene, EngineKind::native).image;
        int left = 64, right = 0, top = 64, bottom = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                if (image.at(x, y).a > 0.02f)
                    left = std::min(left, x), right = std::max(right, x), top = std::min(top, y),
                    bottom = std::max(bottom, y);
        EXPECT_GE(std::max(right - left, bottom - top), 52);
        EXPECT_GE(std::min({left, top, 63 - right, 63 - bottom}), 0);
        EXPECT_TRUE(left > 0 || top > 0);
    }
}

TEST(FusedLight, NativeHasTheMirrorsBitsAndComesToTheReference) {
    Scene scene = shadowed(fusedScene({0, 1, 2}, {24, 20}));
    constexpr std::size_t kAmple = std::size_t{1} << 30;
    const auto drawn = [&](EngineKind engine) {
        return fusedPicture(scene, engine, kAmple, kAmple, LevelChoice::oneForAll).image;
    };
    const Image native = drawn(EngineKind::native);
    EXPECT_EQ(differing(native, drawn(EngineKind::mirror)), 0u);
    scene.quality.stepVoxels = 1.0 / 8;
    EXPECT_LT(compare(drawn(EngineKind::native), drawn(EngineKind::reference)).rms, 0.012);
    scene.lighting.lights[0].shadow = false;
    EXPECT_GT(compare(drawn(EngineKind::native), native).rms, 0.03);
}

// A slab above a body, beside all rays of the picture.
TEST(FusedLight, AVolumeShadesAnother) {
    FieldStores stores;
    constexpr double kThick = 12, kExtinction = 0.08;
    Scene scene;
    SceneVolume body, slab;
    body.path = stores.store(gridAt({0, 0, 0}, {24, 24, 24}, {1, 1, 1}, 0, ValueType::f32),
                             [](const glm::dvec3& p) { return p.y; });
    slab.path = stores.store(gridAt({0, 0, 40}, {20, 20, 4}, {3, 3, kThick / 4}, 0, ValueType::f32),
                             [](const glm::dvec3&) { return 1.0; });
    body.transferFunction = TransferFunction::fromExtinction({{-20, 0.2}}, {});
    slab.transferFunction = TransferFunction::fromExtinction({{0, kExtinction}}, {});
    scene.volumes = {body, slab};
    scene.camera = frontCamera(6);
    scene.imageSize = {8, 8};
    scene.shading.ambient = 0, scene.shading.specular = 0, scene.shading.diffuse = 1;
    Light above;
    above.kind = LightKind::directional;
    above.frame = LightFrame::patient;
    above.direction = {0, -0.4, 1};
    above.shadow = true;
    scene.lighting.lights = {above};
    const auto brightness = [&](EngineKind engine, double opacity) {
        Scene here = scene;
        here.volumes[1].opacity = opacity;
        return double{fusedPicture(here, engine).image.at(4, 4).r};
    };
    const double way = kThick * std::sqrt(1 + 0.4 * 0.4);
    for (const EngineKind engine :
         {EngineKind::gpu, EngineKind::native, EngineKind::mirror, EngineKind::reference})
        EXPECT_NEAR(brightness(engine, 1) / brightness(engine, 0), std::exp(-kExtinction * way), 0.015)
            << name(engine);
}

} // namespace
} // namespace tessera
