// tests/render/labels/labels_test.cpp: labels in pictures (docs/sampling.md, "Labels"): closed forms on every
// engine and in the light of voxels. The native engine has the mirror's bits, the GPU ray caster its own
// tolerance, and skipping changes nothing.
#include "core/image/image_metrics.h"
#include "render/picture/frame_renderer.h"
#include "render/picture/render_scene.h"
#include "tests/support/graded.h"
#include "tests/support/labelled.h"
#include "tests/support/lights.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/reference_light.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(39, 43); // no packet's edges divide it

const std::filesystem::path& torsoLabels() {
    static const BallsOfLabels labels(infoOf("torso"));
    return labels.store;
}

enum class Lit { no, head, lights, shadows };
struct LabelCase {
    const char* preset;
    int camera;
    Lit lit;
    LabelLook look;
    bool isolates = false, grades = false;
    Gradient gradient = Gradient::central;
    LabelBorders borders = LabelBorders::smooth;
    Scene scene(const glm::ivec2& size, const char* store = "torso") const {
        Scene s = sceneOn(infoOf(store), preset, camera, size);
        s.shading.on = lit != Lit::no;
        s.shading.gradient = gradient;
        if (lit == Lit::lights)
            lightWithAll(s, infoOf(store), ShadingModel::phong, true);
        if (lit == Lit::shadows) {
            s.lighting.lights = {keyLight()};
            s.lighting.occlusion = Occlusion{.rays = 16, .radiusMm = 12};
        }
        if (grades)
            grade(s);
        label(s, torsoLabels(), look);
        Labels& labels = s.volumes[0].labels;
        labels.hide = {"two"};
        labels.borders = borders;
        labels.each = {{"40", LabelLook::plain, 0.5, {}},
                       {"3", LabelLook::tint, {}, glm::dvec3(0, 1, 0)},
                       {"7", {}, 0.05, {}}};
        if (isolates)
            labels.show = {"group:pair", "5", "6", "7"};
        return s;
    }
};
std::ostream& operator<<(std::ostream& out, const LabelCase& c) {
    return out << c.preset << ", camera " << c.camera << ", light " << static_cast<int>(c.lit) << ", "
               << nameOf(c.look) << (c.isolates ? ", isolated" : "") << (c.grades ? ", graded" : "") << ", "
               << nameOf(c.borders);
}
class Labelled : public testing::TestWithParam<LabelCase> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Labelled,
                         testing::Values(LabelCase{"bone-1", 0, Lit::head, LabelLook::solid},
                                         LabelCase{"soft-tissue", 1, Lit::no, LabelLook::tint},
                                         LabelCase{"soft-tissue", 2, Lit::head, LabelLook::plain},
                                         LabelCase{"bone-1", 0, Lit::lights, LabelLook::solid, true},
                                         LabelCase{"soft-tissue", 0, Lit::head, LabelLook::tint, false, true},
                                         LabelCase{"soft-tissue", 0, Lit::shadows, LabelLook::solid},
                                         LabelCase{"bone-1", 1, Lit::head, LabelLook::solid, true, true,
                                                   Gradient::sobel},
                                         LabelCase{"soft-tissue", 0, Lit::head, LabelLook::solid, true, false,
                                                   Gradient::central, LabelBorders::nearest},
                                         LabelCase{"soft-tissue", 2, Lit::shadows, LabelLook::tint, false,
                                                   false, Gradient::central, LabelBorders::nearest}));

TEST_P(Labelled, NativeHasTheMirrorsBits) {
    Prepared prepared("torso", GetParam().scene(kSize));
    if (GetParam().lit != Lit::shadows)
        expectTheMirrorsBits(prepared);
    const Image whole = nativePicture(prepared).image;
    NativeChoices choices;
    choices.slicing.fixedIterations = 7;
    EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole), 0u) << "seven turns at a time";
    choices = {};
    choices.blocks = true;
    EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole), 0u) << "blocks";
    Scene scene = GetParam().scene(kSize);
    scene.quality.skipping = false;
    Prepared all("torso", scene);
    EXPECT_EQ(differing(nativePicture(all).image, whole), 0u) << "without skipping";
    scene.volumes[0].labels = {};
    Prepared without("torso", scene);
    EXPECT_GT(compare(nativePicture(without).image, whole).maxAbs, 0.01);
}

/// Their shadows, too, which packets cast and the mirror ray by ray.
TEST_P(Labelled, NativeHasTheMirrorsLight) {
    if (GetParam().lit != Lit::shadows)
        GTEST_SKIP() << "without shadows";
    Scene scene = GetParam().scene({26, 22});
    const auto drawn = [&](EngineKind engine) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
            gpu("GPU memory", "--gpu-memory", std::size_t{512} << 20);
        const StoreReader reader(storePath("torso"), ram);
        RenderOptions options;
        options.engine = engine;
        return renderScene(scene, reader, ram, gpu, options).image;
    };
    const Image native = drawn(EngineKind::native);
    EXPECT_FALSE(isBlank(native));
    EXPECT_EQ(differing(native, drawn(EngineKind::mirror)), 0u);
}

TEST_P(Labelled, NativeHasTheMirrorsBitsAcrossLevels) {
    if (GetParam().lit == Lit::shadows)
        GTEST_SKIP() << "the mirror's light is compared in whole pictures";
    Prepared prepared("torso", GetParam().scene(kSize));
    Planner& p = prepared.p;
    for (const unsigned seed : {1u, 2u}) {
        p.setSelection(randomShownLevels(p.layer().selection, seed));
        ASSERT_TRUE(p.layer().mixed());
        expectTheMirrorsBits(prepared);
        const Image whole = nativePicture(prepared).image;
        Scene scene = GetParam().scene(kSize);
        scene.quality.skipping = false;
        Prepared all("torso", scene);
        all.p.setSelection(Selection(p.layer().selection));
        EXPECT_EQ(differing(nativePicture(all).image, whole), 0u) << "without skipping";
    }
}

TEST_P(Labelled, MarchEqualsTheMirrorOnItsOwnRays) {
    if (GetParam().lit == Lit::shadows)
        GTEST_SKIP() << "the mirror's light is compared in whole pictures";
    const GlContext context({"software"});
    for (const bool isMixed : {false, true}) {
        Prepared prepared("torso", GetParam().scene({32, 32}));
        Planner& p = prepared.p;
        if (isMixed)
            p.setSelection(randomShownLevels(p.layer().selection, 5));
        const auto rays = gpuRays(p.view.frame, prepared.budgets.gpu);
        Work work;
        Image mirror(p.view.imageSize);
        mirror.pixels = mirrorRays<float>(
            mirrorInput(p, true), rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
        const std::uint32_t features = marchFeatures(p, true);
        EXPECT_NE(features & kFeatureLabels, 0u);
        const GpuPicture gpu = marchOn(prepared, features);
        EXPECT_LE(compare(gpu.image, mirror).maxAbs, 2e-5);
        Slicing shreds;
        shreds.fixedTile = 24;
        shreds.fixedIterations = 7;
        EXPECT_TRUE(bitEqual(marchOn(prepared, features, shreds).image, gpu.image));
        EXPECT_TRUE(bitEqual(marchOn(prepared, features & ~kFeatureSkipping).image, gpu.image));
    }
}

Image drawnBy(const Scene& scene, EngineKind kind, std::size_t gpuBytes = std::size_t{1} << 30,
              LevelChoice levels = LevelChoice::perBrick) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader store(storePath("torso"), ram);
    RenderOptions options;
    options.engine = kind;
    options.device.text = "software";
    options.levels = levels;
    const Image image = renderScene(scene, store, ram, gpu, options).image;
    EXPECT_LE(gpu.peakBytes(), gpuBytes);
    return image;
}

// Whole pictures of every engine, with the light of voxels.
TEST(LabelLight, EveryEngineHasTheSame) {
    const LabelCase shadowed{"soft-tissue", 0, Lit::shadows, LabelLook::solid};
    Scene scene = shadowed.scene({40, 40});
    const auto draw = [&](EngineKind kind) { return drawnBy(scene, kind); };
    const Image native = draw(EngineKind::native), mirror = draw(EngineKind::mirror);
    EXPECT_EQ(differing(native, mirror), 0u);
    EXPECT_LE(compare(draw(EngineKind::gpu), mirror).maxAbs, 5e-5);
    scene.imageSize = {12, 12};
    scene.lighting.occlusion->rays = 4;
    // The reference has no levels, which matter in so small a picture; light adds little to that.
    const auto difference = [&] {
        return compare(draw(EngineKind::reference), draw(EngineKind::native)).rms;
    };
    const double lit = difference();
    scene.lighting = {};
    EXPECT_LE(lit, difference() + 0.01);
}

/// A box of one label through the whole volume.
struct OneLabel {
    OneLabel(const VolumeInfo& scan, bool half) : store(folder / "l.zarr") {
        HeldLayer layer(scan, Values(cellCount(scan.extentVoxels), 1));
        for (std::size_t i = 0; half && i < layer.values.size(); ++i)
            layer.values[i] = gridPosition(i, scan.extentVoxels).x < scan.extentVoxels.x / 2 ? 1 : 0;
        LabelFile file = fileOf({layer});
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        importLabels(file, scan, store, ram, quickly());
    }
    const ScratchFolder folder;
    const std::filesystem::path store;
};

/// The volume's own picture, by every engine.
std::vector<Image> byEveryEngine(Prepared& prepared, const Scene& scene) {
    ReferenceInput input = referenceInput(prepared, scene);
    input.labels = prepared.p.layer().labelBricks.get();
    return {nativePicture(prepared).image, mirrorPicture(prepared),
            marchOn(prepared, marchFeatures(prepared.p, true)).image, referencePicture(input, prepared)};
}

// A label that changes nothing leaves every bit; one of half the opacity is a function of half the
// extinction.
TEST(LabelForms, AreThoseOfTheFunction) {
    const GlContext context({"software"});
    const OneLabel one(infoOf("torso"), false);
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {24, 24});
    ValueSummary values;
    values.isHu = true;
    const TransferFunction whole = presetFunction("soft-tissue", values);
    scene.volumes[0].transferFunction = whole;
    Prepared bare("torso", scene);
    label(scene, one.store, LabelLook::plain);
    Prepared plain("torso", scene);
    const std::vector<Image> expected = byEveryEngine(bare, scene), found = byEveryEngine(plain, scene);
    for (std::size_t n = 0; n + 1 < expected.size(); ++n)
        EXPECT_EQ(differing(expected[n], found[n]), 0u) << n;
    EXPECT_LE(compare(expected.back(), found.back()).maxAbs, 1e-6);

    scene.volumes[0].labels.opacity = 0.5;
    Prepared half("torso", scene);
    scene.volumes[0].labels = {};
    scene.volumes[0].transferFunction = whole;
    Prepared table("torso", scene);
    for (glm::vec4& entry : table.p.layer().optics.table)
        entry.a *= 0.5f;
    EXPECT_LE(compare(nativePicture(half).image, nativePicture(table).image).maxAbs, 2e-6);
    EXPECT_LE(compare(mirrorPicture(half), mirrorPicture(table)).maxAbs, 2e-6);
}

// The light of a medium is that of a function with its extinction: occlusion and shadows.
TEST(LabelForms, AMediumTakesLight) {
    const OneLabel half(infoOf("torso"), true);
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {32, 32});
    scene.shading.gradientWeight = GradientWeight{1e8, 2e8}; // no surface
    scene.lighting.lights = {keyLight()};
    scene.lighting.occlusion = Occlusion{.rays = 16, .radiusMm = 30};
    label(scene, half.store);
    Labels& labels = scene.volumes[0].labels;
    labels.show = {"1"};
    labels.opacity = 0.05;
    labels.each = {{"1", {}, {}, glm::dvec3(1)}};
    const auto atLevel0 = [&] { // bricks of one value have light of one
        return drawnBy(scene, EngineKind::native, std::size_t{1} << 30, LevelChoice::oneForAll);
    };
    const Image medium = atLevel0();
    // The same half, as tissue of one extinction.
    labels.look = LabelLook::plain;
    labels.opacity = {};
    const double extinction = -std::log1p(-0.05);
    scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{-5000, extinction}, {5000, extinction}}, {{0, {1, 1, 1}}});
    const Image function = atLevel0();
    // Without the occlusion of the medium: 0.047.
    EXPECT_LE(compare(medium, function).rms, 0.01);
    scene.lighting = {};
    EXPECT_GT(compare(medium, atLevel0()).rms, 0.05) << "light without shade";
}

// A medium: the opacity of a ray is that of its length.
TEST(LabelForms, AMediumIsEven) {
    const GlContext context({"software"});
    const Stored volume([](const glm::dvec3& p) { return 3 * p.x; }, glm::ivec3(44, 40, 48));
    const OneLabel one(volume.info, false);
    Scene scene = volume.scene({}, 1, 24);
    scene.shading.on = false;
    label(scene, one.store);
    scene.volumes[0].labels.opacity = 0.02;
    scene.volumes[0].labels.each = {{"*", {}, {}, glm::dvec3(0.2, 0.5, 0.9)}};
    const auto prepared = volume.prepare(scene);
    for (const Image& image : byEveryEngine(*prepared, scene)) {
        EXPECT_FALSE(isBlank(image));
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const auto ray =
                segmentedRay(prepared->p.view.frame, glm::dvec2(static_cast<double>(i % 24) + 0.5,
                                                                static_cast<double>(i / 24) + 0.5));
            const double mm = ray.count == 0 ? 0 : (ray.count - 1 + ray.tail) * ray.segmentMm;
            const double alpha = 1 - std::pow(1 - 0.02, mm);
            ASSERT_NEAR(image.pixels[i].a, alpha, 2e-5);
            ASSERT_NEAR(image.pixels[i].b, 0.9 * alpha, 2e-5);
        }
    }
}

// Two media of unlike density: depths add up, and so do colours.
TEST(LabelForms, MediaHaveTheirOwnDensities) {
    const GlContext context({"software"});
    const Stored volume([](const glm::dvec3& p) { return 3 * p.x; }, glm::ivec3(44, 40, 48), true);
    const ScratchFolder folder;
    HeldLayer layer(volume.info, Values(cellCount(volume.info.extentVoxels)));
    for (std::size_t i = 0; i < layer.values.size(); ++i)
        layer.values[i] = gridPosition(i, volume.info.extentVoxels).x < 22 ? 1 : 2;
    LabelFile file = fileOf({layer});
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    importLabels(file, volume.info, folder / "l.zarr", ram, quickly());
    Scene scene = volume.scene({}, 1, 24);
    scene.shading.on = false;
    label(scene, folder / "l.zarr");
    scene.volumes[0].labels.each = {{"1", {}, 0.04, glm::dvec3(1, 0, 0)},
                                    {"2", {}, 0.01, glm::dvec3(0, 0, 1)}};
    const auto prepared = volume.prepare(scene);
    EXPECT_GE(prepared->p.layer().labels->numbers().dense, 0);
    // Along x, 22 mm of each.
    const double first = -22 * std::log1p(-0.04), second = -22 * std::log1p(-0.01);
    for (const Image& image : byEveryEngine(*prepared, scene)) {
        const glm::vec4 middle = image.pixels[12 * 24 + 12];
        EXPECT_NEAR(middle.a, -std::expm1(-first - second), 1e-4);
        // Whichever is in front: both shares of light lie between those of either order.
        const double least = -std::expm1(-first) * std::exp(-second), most = -std::expm1(-first);
        EXPECT_GT(middle.r, least - 0.01);
        EXPECT_LT(middle.r, most + 0.01);
        EXPECT_NEAR(middle.r + middle.b, middle.a, 1e-4);
    }
}

TEST(LabelForms, WhatIsHiddenIsNotThere) {
    const OneLabel half(infoOf("torso"), true);
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {32, 32});
    label(scene, half.store);
    scene.volumes[0].labels.hide = {"*"};
    scene.volumes[0].labels.unlabelled = false;
    Prepared nothing("torso", scene);
    EXPECT_TRUE(isBlank(nativePicture(nothing).image));
    EXPECT_EQ(nothing.p.layer().selection.shownBricks(), 0u);
    scene.volumes[0].labels.unlabelled = true;
    Prepared rest("torso", scene);
    EXPECT_LT(rest.p.layer().selection.shownBricks(), [&] {
        Scene all = scene;
        all.volumes[0].labels = {};
        return Prepared("torso", all).p.layer().selection.shownBricks();
    }());
    // Culled or not: the same picture.
    Prepared kept("torso", scene, false);
    EXPECT_EQ(differing(nativePicture(rest).image, nativePicture(kept).image), 0u);
}

// Halved steps come nearer to the true integral.
TEST(LabelConvergence, TheMirrorComesToTheReference) {
    const auto difference = [](LabelLook look, double step, bool shading, LabelBorders borders) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {24, 24});
        scene.shading.on = shading;
        scene.quality.stepVoxels = step;
        label(scene, torsoLabels(), look);
        scene.volumes[0].labels.borders = borders;
        Prepared prepared("torso", scene);
        ReferenceInput input = referenceInput(prepared, scene);
        input.labels = prepared.p.layer().labelBricks.get();
        return compare(mirrorPicture(prepared), referencePicture(input, prepared)).rms;
    };
    constexpr LabelBorders smooth = LabelBorders::smooth, nearest = LabelBorders::nearest;
    for (const LabelLook look : {LabelLook::solid, LabelLook::tint, LabelLook::plain}) {
        const double coarse = difference(look, 1, false, smooth),
                     fine = difference(look, 0.125, false, smooth);
        EXPECT_LT(fine, 0.2 * coarse) << nameOf(look);
        EXPECT_LT(fine, 2e-3) << nameOf(look);
        // A segment across a face has the labels of one side: the error falls as the step, not its square.
        const double steps = difference(look, 0.5, false, nearest),
                     faces = difference(look, 0.0625, false, nearest);
        EXPECT_LT(faces, 0.3 * steps) << nameOf(look);
    }
    EXPECT_LT(difference(LabelLook::solid, 0.125, true, smooth),
              0.6 * difference(LabelLook::solid, 1, true, smooth));
}

// What statistics say is empty has no factor anywhere that a sample can reach.
TEST(LabelCells, AreEmptyOnlyWhereNothingShows) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16});
    label(scene, torsoLabels());
    scene.volumes[0].labels.show = {"6", "7"};
    Prepared prepared("torso", scene);
    const Layer& layer = prepared.p.layer();
    const glm::ivec3 e = prepared.p.info().extentVoxels;
    const Selection finest = atLevel0(layer.selection);
    LabelField field(*layer.labelBricks, finest, nullptr, e);
    std::mt19937 random(3);
    int shown = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
        const glm::dvec3 p = glm::dvec3(unit(), unit(), unit()) * glm::dvec3(e);
        const std::size_t cell = linearIndex(glm::ivec3(p) / kCellExtent, layer.statistics.cells);
        const auto shares = field.shares(p);
        EXPECT_EQ(shares.plain, 0);
        if (shares.solid > 0) {
            ++shown;
            EXPECT_NE(layer.statistics.cellShows[cell] & kShowsMedium, 0);
        }
    }
    EXPECT_GT(shown, 50);
}

// The factors of coarse samples are means, of a medium above its border: no structure is lost at any level.
TEST(LabelLevels, CoarseSamplesAreMeans) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16});
    label(scene, torsoLabels());
    scene.volumes[0].labels.show = {"5", "6"};
    Prepared prepared("torso", scene);
    const DrawnLabels& labels = *prepared.p.layer().labels;
    const glm::ivec3 e = prepared.p.info().extentVoxels, bricks = brickGrid(e);
    const auto channels = static_cast<std::size_t>(labels.numbers().count);
    const std::size_t texels = cellCount(glm::ivec3(kBrickExtent));
    std::vector<std::uint16_t> fine(channels * texels), coarse(channels * texels);
    const auto solid = static_cast<std::size_t>(labels.numbers().solid) * texels;
    const double density{labels.numbers().density}, voxelMm = typicalVoxelMm(prepared.p.info());
    for (std::size_t b = 0; b < cellCount(bricks); ++b) {
        labels.fill(b, 0, fine);
        const glm::ivec3 inside = e - gridPosition(b, bricks) * kBrickExtent;
        for (int level = 1; level + 1 < kLevelCount; ++level) {
            labels.fill(b, level, coarse);
            const int along = 1 << level;
            // All of those that cells tell of; of finer levels some.
            const int edge = kBrickExtent >> level, count = level < 3 ? edge : edge * edge * edge;
            for (int n = 0; n < count; ++n) {
                const glm::ivec3 at = level < 3 ? glm::ivec3(n, 3 * n % edge, 5 * n % edge)
                                                : gridPosition(static_cast<std::size_t>(n), glm::ivec3(edge));
                const glm::ivec3 low = at * along, high = glm::min(low + along, inside);
                if (glm::any(glm::greaterThanEqual(low, high)))
                    continue;
                double sum = 0;
                for (int z = low.z; z < high.z; ++z)
                    for (int y = low.y; y < high.y; ++y)
                        for (int x = low.x; x < high.x; ++x)
                            sum += fine[solid + linearIndex({x, y, z}, glm::ivec3(kBrickExtent))];
                const double mean =
                    sum / static_cast<double>(cellCount(high - low)) / double{leaf::kLightOne};
                const double border{leaf::kLabelBorder}, depth = density * std::ldexp(voxelMm, level);
                const double part = 1 - (1 - border / (1 - border)) * -std::expm1(-depth);
                const double expected = mean > 0 ? border + (1 - border) * part * mean : 0;
                EXPECT_NEAR(coarse[solid + linearIndex(at, glm::ivec3(kBrickExtent))],
                            expected * double{leaf::kLightOne}, 1);
            }
        }
    }
}

// Budgets of a few bricks, in passes: the same bits.
TEST(LabelBudgets, PassesChangeNothing) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {32, 32});
    scene.quality.maxError = 0;
    label(scene, torsoLabels());
    const Image ample = drawnBy(scene, EngineKind::native);
    EXPECT_FALSE(isBlank(ample));
    for (const std::size_t mib : {24u, 40u})
        EXPECT_EQ(differing(drawnBy(scene, EngineKind::native, std::size_t{mib} << 20), ample), 0u) << mib;
}

// A camera by side is fitted to what labels leave, solid or of the function: half of the torso is in the
// middle.
TEST(LabelCamera, IsFittedToWhatShows) {
    const OneLabel half(infoOf("torso"), true);
    constexpr int kEdge = 96;
    for (const LabelLook look : {LabelLook::solid, LabelLook::plain}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {kEdge, kEdge});
        FittedView view;
        view.projection = Projection::parallel;
        scene.camera = view;
        scene.shading.on = false;
        label(scene, half.store, look);
        scene.volumes[0].labels.show = {"1"};
        const Image image = drawnBy(scene, EngineKind::native);
        int low = kEdge, high = -1;
        for (int i = 0; i < kEdge * kEdge; ++i)
            if (image.pixels[static_cast<std::size_t>(i)].a > 0.02f)
                low = std::min(low, i % kEdge), high = std::max(high, i % kEdge);
        EXPECT_NEAR(low + high, kEdge - 1, 6) << nameOf(look);
        EXPECT_LT(high - low, kEdge - 20) << nameOf(look) << ": half of it";
    }
}

// Where memory is short, bricks with borders of labels keep finer levels than those without.
TEST(LabelLevels, BordersTakeTheMemory) {
    Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, {256, 256});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    label(scene, torsoLabels());
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
        gpu("GPU memory", "--gpu-memory", std::size_t{12} << 20);
    const StoreReader store(storePath("torso"), ram);
    const Planner p = planScene(scene, store, TextureLimits{}, {ram, gpu, 0});
    EXPECT_GT(p.chosen.error.mean, 0);
    double with = 0, without = 0;
    std::size_t ofBorders = 0, others = 0;
    for (std::size_t b = 0; b < p.layer().selection.levels.size(); ++b) {
        const int level = p.layer().selection.levels[b];
        if (level == Selection::kEmpty)
            continue;
        const bool isBorder = p.layer().statistics.labelledBricks[b].borders > 0.2f;
        (isBorder ? with : without) += level;
        ++(isBorder ? ofBorders : others);
    }
    ASSERT_GT(ofBorders, 3u);
    ASSERT_GT(others, 3u);
    EXPECT_LT(with / static_cast<double>(ofBorders) + 0.5, without / static_cast<double>(others));
}

// Frames keep bricks and labels from one to the next, and are stills bit by bit; other looks too.
TEST(LabelFrames, EqualStills) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
        gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader store(storePath("torso"), ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.verify = Verify::none;
    FrameRenderer frames(store, ram, gpu, options);
    const LabelCase looks[] = {{"soft-tissue", 0, Lit::shadows, LabelLook::solid},
                               {"soft-tissue", 0, Lit::shadows, LabelLook::tint}};
    int number = 0;
    for (const int look : {0, 0, 0, 1, 1, 0}) {
        Scene scene = looks[look].scene({32, 32});
        Camera camera = std::get<Camera>(scene.camera);
        camera.position += glm::dvec3(7.0 * number++, 0, 3);
        scene.camera = camera;
        const Image frame = frames.draw(scene).image;
        EXPECT_FALSE(isBlank(frame));
        MemoryBudget otherRam("RAM", "--ram", std::size_t{1} << 30),
            otherGpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        EXPECT_EQ(differing(renderScene(scene, store, otherRam, otherGpu, options).image, frame), 0u)
            << number;
    }
    EXPECT_GT(frames.kept().goneOn, 1u);
}

TEST(LabelRefusals, NameWhatIsMeant) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16});
    label(scene, torsoLabels());
    const auto refusal = [&](const Scene& s) -> std::string {
        try {
            Prepared prepared("torso", s);
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    };
    scene.volumes[0].labels.show = {"on"};
    EXPECT_NE(refusal(scene).find("one"), std::string::npos) << refusal(scene);
    scene.volumes[0].labels.show = {};
    scene.surfaces = {{200, {1, 1, 1}, 1}};
    EXPECT_NE(refusal(scene).find("plain"), std::string::npos) << refusal(scene);
    scene.volumes[0].labels.look = LabelLook::plain;
    EXPECT_EQ(refusal(scene), "");
    scene.volumes[0].labels.opacity = 0.5;
    EXPECT_NE(refusal(scene).find("plain"), std::string::npos) << refusal(scene);
    scene.surfaces = {};
    scene.quality.integrator = Integrator::linear;
    EXPECT_NE(refusal(scene).find("midpoint"), std::string::npos) << refusal(scene);
    scene.quality.integrator = Integrator::midpoint;
    // Labels of the same extent half a voxel away, and of another extent.
    VolumeInfo moved = infoOf("torso");
    moved.patientFromVoxel[3] += 0.5 * moved.patientFromVoxel[1];
    VolumeInfo larger = infoOf("torso");
    larger.extentVoxels.z += 1;
    for (const VolumeInfo& other : {moved, larger}) {
        const BallsOfLabels elsewhere(other);
        label(scene, elsewhere.store);
        EXPECT_NE(refusal(scene).find("grid"), std::string::npos) << refusal(scene);
    }
    scene.volumes[0].labels.path = scene.volumes[0].labels.store = storePath("torso");
    EXPECT_NE(refusal(scene), "") << "a store without labels";
}

} // namespace
} // namespace tessera
