// tests/render/labels/label_optics_test.cpp: labels with transfer functions and materials of their own
// (docs/sampling.md, "Labels").
#include "core/image/image_metrics.h"
#include "core/scene/scene_presets.h"
#include "render/picture/frame_renderer.h"
#include "render/plan/label_optics.h"
#include "tests/support/fused.h"
#include "tests/support/label_tools.h"
#include "tests/support/labelled.h"
#include "tests/support/refusals.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kHalvesSize(37, 29);

/// Two halves of a volume, labels 1 and 2, cut at x = 20 of 40 voxels of 1 mm; tissue without one at z >= 30.
struct Halves {
    FieldStores stores;
    ScratchFolder folder;
    Scene scene;
    explicit Halves(const FieldMm& field, bool withRest = false) {
        const VolumeInfo info = gridAt({0, 0, 0}, {40, 36, 38}, {1, 1, 1}, 0, ValueType::f32);
        HeldLayer layer(info, Values(cellCount(info.extentVoxels)));
        for (std::size_t i = 0; i < layer.values.size(); ++i) {
            const glm::ivec3 at = gridPosition(i, info.extentVoxels);
            layer.values[i] = withRest && at.z >= 30 ? 0 : at.x < 20 ? 1 : 2;
        }
        LabelFile file = fileOf({layer}, {{1, "one"}, {2, "two"}});
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        importLabels(file, info, folder / "l.zarr", ram, quickly());
        scene = fusedScene({0}, kHalvesSize);
        scene.volumes[0].path = stores.store(info, field);
        label(scene, folder / "l.zarr", LabelLook::plain);
    }
    Labels& labels() { return scene.volumes[0].labels; }
};

/// At level 0.
RenderResult drawn(const Scene& scene, EngineKind engine) {
    constexpr std::size_t kAmple = std::size_t{1} << 30;
    return fusedPicture(scene, engine, kAmple, kAmple, LevelChoice::oneForAll);
}

TransferFunction even(double extinction, const glm::dvec3& colour) {
    return TransferFunction::fromOpacity({{0, -std::expm1(-extinction)}}, {{0, colour}}, 1);
}
double wave(const glm::dvec3& p) {
    return 200 + 150 * std::sin(0.3 * p.x) * std::cos(0.25 * p.y + 1) * std::cos(0.2 * p.z);
}
/// A scene in which all has its own: label 1 a function, label 2 a function and a material.
Scene ofWaves() {
    static Halves halves(wave, true);
    Labels& labels = halves.labels();
    labels.each.resize(2);
    labels.each[0].of = "one";
    labels.each[0].transferFunction =
        TransferFunction::fromOpacity({{150, 0}, {300, 0.3}}, {{150, {1, 0.2, 0.1}}, {300, {1, 1, 0}}}, 1);
    labels.each[1].of = "2";
    labels.each[1].look = LabelLook::tint;
    labels.each[1].colour = glm::dvec3(0.1, 0.4, 1);
    labels.each[1].transferFunction = TransferFunction::fromOpacity({{100, 0.2}, {260, 0}}, {}, 1);
    labels.each[1].material = MaterialResponse{0.1, 0.9, 0.4, 8};
    return halves.scene;
}

// Along x each half has the depth of its own function, whatever the order; along the border it is the mean.
TEST(LabelOptics, OfEvenMediaAreClosedForms) {
    Halves halves([](const glm::dvec3&) { return 1.0; });
    Scene& scene = halves.scene;
    scene.shading.on = false;
    constexpr double kOne = 0.03, kTwo = 0.08;
    scene.volumes[0].transferFunction = even(kOne, {1, 0, 0});
    halves.labels().each = {{.of = "two", .transferFunction = even(kTwo, {0, 0, 1})}};
    Camera camera;
    camera.projection = Projection::parallel;
    camera.position = {-100, 0, 0}, camera.focalPoint = {0, 0, 0}, camera.viewUp = {0, 0, 1};
    camera.parallelScale = 2;
    scene.camera = camera;
    scene.imageSize = {4, 4};
    for (const EngineKind engine : {EngineKind::native, EngineKind::mirror, EngineKind::reference}) {
        const glm::vec4 seen = drawn(scene, engine).image.at(1, 2);
        const double first = 20 * kOne, second = 20 * kTwo;
        EXPECT_NEAR(seen.a, -std::expm1(-first - second), 1e-4) << name(engine);
        EXPECT_NEAR(seen.r, -std::expm1(-first), 2e-3) << name(engine); // half a voxel of the border
        EXPECT_NEAR(seen.r + seen.b, seen.a, 1e-5) << name(engine);
    }
    std::get<Camera>(scene.camera).position = {0, -100, 0};
    std::get<Camera>(scene.camera).parallelScale = 1e-3;
    for (const EngineKind engine : {EngineKind::native, EngineKind::reference}) {
        const glm::vec4 seen = drawn(scene, engine).image.at(2, 2);
        EXPECT_NEAR(seen.a, -std::expm1(-36 * 0.5 * (kOne + kTwo)), 1e-3) << name(engine);
        EXPECT_NEAR(seen.r / seen.b, kOne / kTwo, 1e-2) << name(engine);
    }
}

// The cuts of a volume with such labels are those of the scene, and exact.
TEST(LabelOptics, TheirVolumeIsCutExactly) {
    Scene scene = ofWaves(), own = scene;
    scene.cuts.planes = {{{1, 2, 3}, {0.5, 1, -0.3}, Keep::inside}};
    scene.cuts.boxes = {{{-6, -30, -9}, {5, 30, 8}, CropBox::Space::patient, Keep::outside}};
    own.volumes[0].cuts = scene.cuts;
    const Image expected = drawn(scene, EngineKind::native).image;
    EXPECT_FALSE(isBlank(expected));
    EXPECT_EQ(differing(drawn(own, EngineKind::native).image, expected), 0u);
    own.volumes[0].cuts.boxes = {{{0, 0, 0}, {20, 36, 38}, CropBox::Space::voxels, Keep::inside}};
    EXPECT_FALSE(isBlank(drawn(own, EngineKind::native).image));
}

TEST(LabelOptics, NativeHasTheMirrorsBits) {
    Scene scene = ofWaves();
    const Image native = drawn(scene, EngineKind::native).image;
    EXPECT_FALSE(isBlank(native));
    EXPECT_EQ(differing(native, drawn(scene, EngineKind::mirror).image), 0u);
    scene.quality.skipping = false;
    EXPECT_EQ(differing(native, drawn(scene, EngineKind::native).image), 0u) << "without skipping";
    scene.volumes[0].labels.each.clear();
    EXPECT_GT(compare(native, drawn(scene, EngineKind::native).image).rms, 0.05);
}

TEST(LabelOptics, ComeToTheReference) {
    Scene scene = ofWaves();
    scene.imageSize = {24, 20};
    const Image truth = drawn(scene, EngineKind::reference).image;
    const auto rms = [&](double step) {
        scene.quality.stepVoxels = step;
        return compare(drawn(scene, EngineKind::native).image, truth).rms;
    };
    const double coarse = rms(1), fine = rms(1.0 / 16);
    EXPECT_LT(fine, coarse / 5) << coarse;
    EXPECT_LT(fine, 1.5e-3);
}

// A function that is the volume's own changes nothing but rounding; so does a material that is the scene's.
TEST(LabelOptics, ThatAreTheVolumesChangeNothing) {
    Halves halves(wave, true); // some tissue has no label
    Scene& scene = halves.scene;
    const Image plain = drawn(scene, EngineKind::native).image;
    halves.labels().each = {{.of = "two", .transferFunction = scene.volumes[0].transferFunction}};
    EXPECT_LT(compare(drawn(scene, EngineKind::native).image, plain).maxAbs, 2e-5);
    const Shading& s = scene.shading;
    halves.labels().each = {
        {.of = "two",
         .material = MaterialResponse{s.ambient, s.diffuse, s.specular, static_cast<int>(s.specularPower)}}};
    EXPECT_LT(compare(drawn(scene, EngineKind::native).image, plain).maxAbs, 2e-5);
    // One that shows colours as they are is a picture without shading.
    halves.labels().show = {"two"};
    halves.labels().each = {{.of = "one", .material = MaterialResponse{0, 0.1, 1, 2}},
                            {.of = "two", .material = MaterialResponse{1, 0, 0, 1}}};
    const Image flat = drawn(scene, EngineKind::native).image;
    halves.labels().each.clear();
    EXPECT_GT(compare(flat, drawn(scene, EngineKind::native).image).rms, 0.02);
    scene.shading.on = false;
    EXPECT_LT(compare(flat, drawn(scene, EngineKind::native).image).maxAbs, 2e-5);
}

// A solid label keeps its medium beside a material; the last rule decides, as for looks.
TEST(LabelOptics, LooksAndRulesAreAsOfOtherLabels) {
    Halves halves(wave);
    Labels& labels = halves.labels();
    labels.look = LabelLook::solid;
    const Image solid = drawn(halves.scene, EngineKind::native).image;
    const Shading& s = halves.scene.shading;
    const MaterialResponse own{s.ambient, s.diffuse, s.specular, static_cast<int>(s.specularPower)};
    labels.each = {{.of = "*", .material = own}};
    const RenderResult both = drawn(halves.scene, EngineKind::native);
    EXPECT_EQ(differing(both.image, solid), 0u);
    EXPECT_EQ(both.labels->shown, 2u);
    labels.each = {{.of = "two", .material = own}}; // each has a border of its own
    const std::size_t grooved = differing(drawn(halves.scene, EngineKind::native).image, solid);
    EXPECT_GT(grooved, 0u);
    EXPECT_LT(grooved, solid.pixels.size() / 25);
    labels.each = {{.of = "*", .transferFunction = std::string("auto")},
                   {.of = "one", .transferFunction = even(0.2, {1, 0, 0})},
                   {.of = "two", .transferFunction = even(0.2, {1, 0, 0})}};
    const Image last = drawn(halves.scene, EngineKind::native).image;
    labels.each.erase(labels.each.begin());
    EXPECT_LT(compare(drawn(halves.scene, EngineKind::native).image, last).maxAbs, 1e-6);
    // Both have one function: one further volume.
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 28);
    const StoreReader store(halves.scene.volumes[0].path, ram);
    const StoreReader* const stores[] = {&store};
    EXPECT_EQ(withLabelOptics(halves.scene, stores).scene.volumes.size(), 2u);
}

TEST(LabelOptics, HaveTheirFramesAndErrors) {
    Scene scene = ofWaves();
    scene.quality.maxError = 3;
    scene.quality.automaticStep = true;
    OpenedVolumes opened(scene);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.verify = Verify::full;
    options.searching = options.checking = true;
    const RenderResult result =
        renderScene(scene, opened.stores, opened.budgets.ram, opened.budgets.gpu, options);
    ASSERT_TRUE(result.measured);
    EXPECT_LE(result.measured->rays.luvP99->value, 3) << result.measured->whyNot;
    const Image truth = drawn(ofWaves(), EngineKind::reference).image;
    EXPECT_LE(errorBetween(result.image, truth).luvP99, 3);
    options.verify = Verify::none;
    options.searching = options.checking = false;
    scene = ofWaves();
    options.levels = LevelChoice::oneForAll;
    FrameRenderer frames(opened.stores, opened.budgets.ram, opened.budgets.gpu, options);
    EXPECT_EQ(differing(frames.draw(scene).image, drawn(scene, EngineKind::native).image), 0u);
}

TEST(LabelOptics, RefusalsNameWhatIsMeant) {
    const auto refused = [](const char* words, const auto& change) {
        Scene scene = ofWaves();
        change(scene);
        const std::string refusal = refusalOf([&] { drawn(scene, EngineKind::native); });
        EXPECT_NE(refusal.find(words), std::string::npos) << refusal;
    };
    refused("fusion", [](Scene& s) { s.fusion = Fusion::over; });
    refused("at most 8", [](Scene& s) {
        for (int n = 0; n < 8; ++n)
            s.volumes[0].labels.each.push_back(
                {.of = "one", .transferFunction = even(0.1 * (n + 1), {1, 1, 1})});
    });
    refused("no-such",
            [](Scene& s) { s.volumes[0].labels.each[0].transferFunction = std::string("no-such"); });
}

} // namespace
} // namespace tessera
