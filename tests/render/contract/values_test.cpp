// tests/render/contract/values_test.cpp: rays that keep one value: maximum, minimum, average, slices and
// slabs (docs/sampling.md, "Modes"). They are compared with a few lines of independent code and with the
// reference, and every engine and division of the work with every other.
#include "render/backends/reference/reference.h"
#include "render/picture/render_scene.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/value_scenes.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kValuesSize(39, 43); // no packet's edges divide it

class Values : public testing::TestWithParam<ValueCase> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(storePath(GetParam().store)))
            GTEST_SKIP() << GetParam().store << " is absent: the real scans are not on this machine";
    }
    Scene scene(const glm::ivec2& size = kValuesSize) const {
        return valueScene(GetParam(), infoOf(GetParam().store), size);
    }
    bool plane() const { return GetParam().mode == Mode::slice && GetParam().thicknessMm == 0; }
};
const auto kCases = testing::Values(
    ValueCase{"torso", Mode::maximum, 0}, ValueCase{"torso", Mode::minimum, 2},
    ValueCase{"torso", Mode::average, 2}, ValueCase{"torso", Mode::slice, 0},
    ValueCase{"torso", Mode::slice, 1, 17}, ValueCase{"torso", Mode::slice, 2, 25, Reduction::minimum},
    ValueCase{"torso", Mode::maximum, 2, 0, Reduction::average, ValueColour::transferFunction},
    ValueCase{"head", Mode::maximum, 1}, ValueCase{"head", Mode::minimum, 2},
    ValueCase{"abdomen", Mode::average, 0}, ValueCase{"abdomen", Mode::slice, 0, 9, Reduction::maximum},
    ValueCase{"abdomen", Mode::slice, 1});
INSTANTIATE_TEST_SUITE_P(Scenes, Values, kCases);

std::vector<ReferenceRay> raysOfCamera(const FramePlan& p) {
    return referenceRays(p.view.camera, p.info(), p.view.imageSize);
}

std::vector<glm::dvec4> referenceOf(const Prepared& prepared) {
    const FramePlan& p = prepared.p;
    ReferenceInput input;
    input.cache = p.layer().cache.get();
    input.info = &p.info();
    input.function = &p.layer().function;
    input.reduction = p.layer().optics.reduction;
    input.look = p.layer().look;
    input.slabs = p.view.part.slabs;
    input.flat = p.view.part.flat;
    return renderReference(input, raysOfCamera(p), 0);
}

// The field read 100 times a voxel along rays of the camera's own definition, in patient space.
TEST_P(Values, ReferenceIsWhatAFewLinesSay) {
    const Scene scene = this->scene({9, 9});
    Prepared prepared(GetParam().store, scene);
    const PlainVolume volume(GetParam().store);
    const VolumeInfo& info = volume.info();
    const std::vector<glm::dvec4> reference = referenceOf(prepared);
    const Camera& camera = std::get<Camera>(scene.camera);
    const RayPlane plane = rayPlane(camera, info, scene.imageSize);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const glm::dvec3 normal = glm::normalize(scene.slice.normal);
    const Reduction reduction = reductionOf(scene);
    int met = 0;
    for (int n = 0; n < 81; ++n) {
        const PatientRay ray = pixelRay(plane, glm::dvec2(n % 9, n / 9) + 0.5, scene.imageSize);
        const double step = 0.01 * info.spacingMm().x;
        double low = 1e30, high = -1e30, sum = 0, count = 0;
        const auto take = [&](double t) {
            const glm::dvec3 at = ray.base + t * ray.direction;
            const glm::dvec3 p(voxelFromPatient * glm::dvec4(at, 1));
            if (glm::any(glm::lessThan(p, glm::dvec3(0))) ||
                glm::any(glm::greaterThan(p, glm::dvec3(info.extentVoxels))))
                return;
            if (GetParam().mode == Mode::slice && !this->plane() &&
                std::abs(glm::dot(at - scene.slice.point, normal)) > 0.5 * scene.slice.thicknessMm)
                return;
            const double value = volume.at(p);
            low = std::min(low, value), high = std::max(high, value), sum += value, ++count;
        };
        if (this->plane()) {
            const double t = glm::dot(scene.slice.point - ray.base, normal) / glm::dot(ray.direction, normal);
            if (t >= ray.minT)
                take(t);
        } else {
            const double far = 2 * glm::length(info.spacingMm() * glm::dvec3(info.extentVoxels));
            for (double t = std::max(ray.minT, -far); t < far; t += step)
                take(t);
        }
        const glm::dvec4& pixel = reference[static_cast<std::size_t>(n)];
        if (count < 3 && !this->plane())
            continue; // it all but misses
        ASSERT_EQ(pixel.a, count > 0 ? 1 : 0) << n;
        if (count == 0)
            continue;
        ++met;
        const double value = reduction == Reduction::average   ? sum / count
                             : reduction == Reduction::minimum ? low
                                                               : high;
        if (scene.valueColour == ValueColour::window) {
            const double grey = std::clamp((value - (20 - 450)) / 900, 0.0, 1.0);
            EXPECT_NEAR(greyOf(pixel.r), grey, this->plane() ? 1e-9 : 2e-3) << n;
        } else {
            const glm::dvec3 colour = prepared.p.layer().function.colour(value);
            EXPECT_NEAR(pixel.r, colour.r, 2e-2) << n;
        }
    }
    EXPECT_GT(met, 12);
}

double rmsBetween(const std::vector<glm::dvec4>& a, const std::vector<glm::dvec4>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += glm::dot(a[i] - b[i], a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST_P(Values, TheMirrorComesToTheReference) {
    Prepared prepared(GetParam().store, scene());
    Planner& p = prepared.p;
    const std::vector<glm::dvec4> truth = referenceOf(prepared);
    std::vector<double> errors;
    for (const double step : {1.0, 0.5, 0.25, 0.125}) {
        p.setStep(step);
        Work work;
        const auto mirror =
            mirrorRays<double>(mirrorInput(p, true), truth.size(), frameRays(p.view.frame), 0, work);
        errors.push_back(rmsBetween(mirror, truth));
    }
    if (plane()) {
        for (const double error : errors)
            EXPECT_LT(error, 1e-6); // the table's float entries
        return;
    }
    if (errors[1] == 0)
        return; // all rays have what lies beyond the window
    EXPECT_LT(errors.back(), 0.4 * errors[1]) << errors[0] << " " << errors[1] << " " << errors[2];
    EXPECT_LT(errors.back(), 0.01);
}

TEST_P(Values, NativeHasTheMirrorsBits) {
    Prepared prepared(GetParam().store, scene());
    const Image mirror = mirrorPicture(prepared);
    EXPECT_FALSE(isBlank(mirror));
    for (const native::PacketTarget* target : nativeTargets())
        for (const bool ghostLayers : {true, false}) {
            NativeChoices choices;
            choices.target = target;
            choices.ghostLayers = ghostLayers;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u)
                << target->name << (ghostLayers ? ", ghost layers" : ", no ghost layers");
        }
}

TEST_P(Values, NativeHasTheMirrorsBitsOfMixedLevels) {
    for (const EdgeFunction edge : {EdgeFunction::nearest, EdgeFunction::split}) {
        Scene scene = this->scene();
        scene.quality.edgeFunction = edge;
        Prepared prepared(GetParam().store, scene);
        prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 5));
        prepared.p.view.quality.skipping = false;
        const Image every = mirrorPicture(prepared);
        prepared.p.view.quality.skipping = true;
        const Image mirror = mirrorPicture(prepared);
        EXPECT_EQ(differing(mirror, every), 0u) << "leaping changed the picture";
        for (const native::PacketTarget* target : nativeTargets()) {
            NativeChoices choices;
            choices.target = target;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u) << target->name;
        }
    }
}

TEST_P(Values, CuttingTheWorkAndLeapingChangeNoBit) {
    Prepared prepared(GetParam().store, scene());
    const NativePicture whole = nativePicture(prepared);
    for (const int turns : {1, 7}) {
        NativeChoices choices;
        choices.slicing.fixedIterations = turns;
        choices.shreds = turns == 1;
        choices.threads = 3;
        EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole.image), 0u) << turns;
    }
    prepared.p.view.quality.skipping = false;
    const NativePicture every = nativePicture(prepared);
    EXPECT_EQ(differing(every.image, whole.image), 0u) << "leaping changed the picture";
    const Reduction reduction = prepared.p.layer().optics.reduction;
    if (reduction == Reduction::maximum && !plane()) {
        EXPECT_LT(whole.work.segments, every.work.segments) << "nothing was leapt over";
    }
}

// Bricks that no sample reads may be missing.
TEST_P(Values, LeavingOutBricksChangesNoBit) {
    Prepared some(GetParam().store, scene()), all(GetParam().store, scene(), false);
    const auto shown = [](const Prepared& p) { return p.p.layer().selection.shownBricks(); };
    if (GetParam().mode == Mode::slice) {
        EXPECT_LT(shown(some), cellCount(some.p.layer().selection.bricks));
    }
    EXPECT_EQ(differing(mirrorPicture(some), mirrorPicture(all)), 0u);
}

TEST_P(Values, MarchEqualsTheMirrorOnItsOwnRays) {
    const GlContext context({"software"});
    for (const bool mixed : {false, true}) {
        Prepared prepared(GetParam().store, scene());
        if (mixed)
            prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 9));
        Planner& p = prepared.p;
        const std::uint32_t features = marchFeatures(p, false);
        EXPECT_TRUE(features & kFeatureValues);
        const Image march = marchOn(prepared, features).image;
        const auto rays = gpuRays(raysOf(p), prepared.budgets.gpu);
        Image mirror(p.view.imageSize);
        Work work;
        mirror.pixels = mirrorRays<float>(
            mirrorInput(p, true), rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
        double largest = 0;
        for (std::size_t i = 0; i < march.pixels.size(); ++i)
            for (int c = 0; c < 4; ++c)
                largest = std::max(largest, double{std::abs(march.pixels[i][c] - mirror.pixels[i][c])});
        EXPECT_LE(largest, 1e-5) << (mixed ? "mixed" : "one level");
        EXPECT_FALSE(isBlank(march));
        Slicing shreds;
        shreds.fixedTile = 24;
        shreds.fixedIterations = 7;
        EXPECT_TRUE(bitEqual(marchOn(prepared, features, shreds).image, march));
        if (features & kFeatureSkipping) {
            EXPECT_TRUE(bitEqual(marchOn(prepared, features & ~std::uint32_t{kFeatureSkipping}).image, march))
                << "leaping changed the picture";
        }
        const Image filtered = marchOn(prepared, features | kFeatureHardware).image;
        std::size_t off = 0;
        for (std::size_t i = 0; i < march.pixels.size(); ++i)
            off += std::abs(march.pixels[i].r - filtered.pixels[i].r) > 0.012f;
        EXPECT_EQ(off, 0u) << "filtered fetches";
    }
}

// Whole pictures: each engine draws each mode, in several passes too, and says what it knows of its errors.
TEST_P(Values, PicturesOfEveryEngineAndBudget) {
    const auto draw = [&](EngineKind engine, std::size_t gpuBytes, std::optional<double> maxError) {
        Scene scene = this->scene({48, 40});
        scene.quality.stepVoxels = 0.5;
        scene.quality.maxError = maxError;
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
        const StoreReader reader(storePath(GetParam().store), ram);
        RenderOptions options;
        options.engine = engine;
        options.device.text = "software";
        options.verify = maxError ? Verify::none : Verify::quick;
        options.checking = !maxError;
        return renderScene(scene, reader, ram, gpu, options);
    };
    const std::size_t ample = std::size_t{1} << 30;
    const RenderResult native = draw(EngineKind::native, ample, {});
    EXPECT_FALSE(isBlank(native.image));
    EXPECT_FALSE(native.predictedError);
    ASSERT_TRUE(native.measured);
    EXPECT_TRUE(native.measured->whyNot.empty()) << native.measured->whyNot;
    EXPECT_EQ(differing(draw(EngineKind::mirror, ample, {}).image, native.image), 0u);
    EXPECT_LT(rmsBetween(std::vector<glm::dvec4>(native.image.pixels.begin(), native.image.pixels.end()),
                         [&] {
                             const Image r = draw(EngineKind::reference, ample, {}).image;
                             return std::vector<glm::dvec4>(r.pixels.begin(), r.pixels.end());
                         }()),
              native.level == 0 ? 0.02 : 0.1);
    const RenderResult gpu = draw(EngineKind::gpu, ample, {});
    EXPECT_EQ(gpu.image.size, native.image.size);
    const RenderResult whole = draw(EngineKind::native, ample, 0.0);
    const RenderResult parts = draw(EngineKind::native, std::size_t{5} << 20, 0.0);
    EXPECT_EQ(differing(whole.image, parts.image), 0u);
    if (whole.selectionPages > 60) {
        EXPECT_GT(parts.passes, 1);
    }
}

TEST(ValueWindow, GreysAreThoseOfDicomsLinearWindow) {
    // PS3.3 C.11.2.1.3.2: y = (x - c) / w + 0.5, shown as it is by an sRGB display.
    const ValueLook look{ValueColour::window, {40, 400}};
    const TransferFunction none;
    EXPECT_EQ(greyOf(colourOfValue(look, none, -160).r), 0);
    EXPECT_NEAR(greyOf(colourOfValue(look, none, 40).r), 0.5, 1e-12);
    EXPECT_NEAR(greyOf(colourOfValue(look, none, 140).r), 0.75, 1e-12);
    EXPECT_NEAR(greyOf(colourOfValue(look, none, 240).r), 1, 1e-12);
    EXPECT_EQ(colourOfValue(look, none, -3000).r, 0);
    EXPECT_EQ(colourOfValue(look, none, 3000).r, 1);
    const TransferTable table = valueTable(look, none, Reduction::average);
    VolumeInfo info;
    info.extentVoxels = {8, 8, 8};
    info.rescaleSlope = -2; // the stored number falls as the value rises
    info.rescaleIntercept = 100;
    Shading unlit;
    unlit.on = false;
    const Optics optics = makeOptics(table, info, unlit, 0);
    for (double value = -200; value <= 300; value += 0.37)
        EXPECT_NEAR(static_cast<double>(lookUp(optics, static_cast<float>((value - 100) / -2)).r),
                    colourOfValue(look, none, value).r, 1e-6)
            << value;
}

TEST(ValueWindow, InverseGreysFallFromWhiteToBlack) {
    const ValueLook look{ValueColour::inverse, {40, 400}}, plain{ValueColour::window, {40, 400}};
    const TransferFunction none;
    for (const double value : {-3000.0, -160.0, -60.0, 40.0, 140.0, 240.0, 3000.0})
        EXPECT_NEAR(greyOf(colourOfValue(look, none, value).r),
                    1 - greyOf(colourOfValue(plain, none, value).r), 1e-12)
            << value;
    for (const Reduction reduction : {Reduction::maximum, Reduction::minimum, Reduction::average}) {
        const TransferTable table = valueTable(look, none, reduction);
        EXPECT_EQ(table.entries.front().r, 1);
        EXPECT_EQ(table.entries.back().r, 0);
    }
}

// A PET: few voxels of the bladder hold a hundred times what the rest does.
TEST(ValueWindow, AutoIsNotStretchedByAThousandthOfTheVoxels) {
    ValueSummary pet{0, 100, false, 1, std::vector<double>(64, 0)};
    pet.histogram[0] = 900000, pet.histogram[2] = 99500, pet.histogram[3] = 200, pet.histogram[63] = 300;
    const GreyWindow window = windowOf(std::string("auto"), pet, Mode::slice);
    EXPECT_EQ(window.low(), 0);
    EXPECT_GT(window.high(), 4);
    EXPECT_LT(window.high(), 7);
    pet.histogram[63] = 3000; // more than a thousandth: tissue
    EXPECT_EQ(windowOf(std::string("auto"), pet, Mode::slice).high(), 100);
    ValueSummary even{0, 64, false, 1, std::vector<double>(64, 10)};
    EXPECT_EQ(windowOf(std::string("auto"), even, Mode::slice).high(), 64);
}

TEST(ValueWindow, Names) {
    ValueSummary hu{-1000, 3000, true, 1, {}}, other{0, 255, false, 1, {}};
    EXPECT_EQ(windowOf(std::string("auto"), hu, Mode::slice), (GreyWindow{50, 400}));
    EXPECT_EQ(windowOf(std::string("auto"), other, Mode::slice), (GreyWindow{127.5, 255}));
    EXPECT_EQ(windowOf(std::string("lung"), other, Mode::slice), (GreyWindow{-600, 1500}));
    EXPECT_EQ(windowOf(GreyWindow{1, 2}, hu, Mode::slice), (GreyWindow{1, 2}));
    EXPECT_EQ(std::get<GreyWindow>(parseWindow("40,80", "--window")), (GreyWindow{40, 80}));
    for (const char* wrong : {"40", "40,", ",80", "40,0", "40,-3", "nan,3", "1,2,3", "lungs", ""})
        EXPECT_THROW(parseWindow(wrong, "--window"), InputError) << wrong;
}

TEST(SlicePoses, AreThoseOfRadiology) {
    // LPS: +x left, +y back, +z head.
    const glm::dvec3 left{1, 0, 0}, back{0, 1, 0}, head{0, 0, 1};
    const auto pose = [](Orientation o) { return poseOf({o, 7.0}, {1, 2, 3}); };
    EXPECT_EQ(pose(Orientation::axial).right, left); // the patient's right at the picture's left
    EXPECT_EQ(pose(Orientation::axial).up, -back);
    EXPECT_EQ(pose(Orientation::axial).point, glm::dvec3(1, 2, 7));
    EXPECT_EQ(pose(Orientation::coronal).right, left);
    EXPECT_EQ(pose(Orientation::coronal).up, head);
    EXPECT_EQ(pose(Orientation::coronal).point, glm::dvec3(1, 7, 3));
    EXPECT_EQ(pose(Orientation::sagittal).right, back); // the face at the picture's left
    EXPECT_EQ(pose(Orientation::sagittal).up, head);
    EXPECT_EQ(pose(Orientation::sagittal).point, glm::dvec3(7, 2, 3));
}

} // namespace
} // namespace tessera
