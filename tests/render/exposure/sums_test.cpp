// tests/render/exposure/sums_test.cpp: emission, absorption and radiographs (docs/sampling.md, "Sums along
// rays"), beside sums along the same rays by code of its own, closed forms, and every engine beside another.
#include "core/image/colour.h"
#include "render/exposure/exposed_caster.h"
#include "render/picture/render_scene.h"
#include "render/picture/unfolded.h"
#include "tests/support/interactive_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/refusals.h"
#include "tests/support/surface_fixture.h"
#include "tests/support/value_scenes.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tessera::test {
namespace {

using testing::HasSubstr;

const std::vector<EngineKind> kAllEngines{EngineKind::native, EngineKind::mirror, EngineKind::reference,
                                          EngineKind::gpu};

RenderResult drawn(const Scene& scene, EngineKind engine, const std::filesystem::path& store,
                   Verify verify = Verify::none) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader reader(store, ram);
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    options.verify = verify;
    options.checking = verify != Verify::none;
    return renderScene(scene, reader, ram, gpu, options);
}

/// Sums along the ray through a pixel's middle: light by component, and extinction; 400 places a voxel.
struct Sums {
    glm::dvec3 light{0};
    double depth = 0;
    bool meets = false;
};
Sums sumsAlong(const Scene& scene, const PlainVolume& volume, const TransferFunction& function, int n) {
    const VolumeInfo& info = volume.info();
    const glm::ivec2 size = scene.imageSize;
    const RayPlane plane = rayPlane(std::get<Camera>(scene.camera), info, size);
    const PatientRay ray = pixelRay(plane, glm::dvec2(n % size.x, n / size.x) + 0.5, size);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const double step = 0.0025 * info.spacingMm().x,
                 far = 2 * glm::length(info.spacingMm() * glm::dvec3(info.extentVoxels));
    Sums sums;
    for (double t = std::max(ray.minT, -far); t < far; t += step) {
        const glm::dvec3 p(voxelFromPatient * glm::dvec4(ray.base + t * ray.direction, 1));
        if (glm::any(glm::lessThan(p, glm::dvec3(0))) ||
            glm::any(glm::greaterThan(p, glm::dvec3(info.extentVoxels))))
            continue;
        const double value = volume.at(p), extinction = function.extinction(value);
        sums.light += step * extinction * function.colour(value);
        sums.depth += step * extinction;
        sums.meets = true;
    }
    return sums;
}

Scene torsoSums(Mode mode, const glm::ivec2& size = {11, 9}, int camera = 2) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", camera, size);
    scene.mode = mode;
    scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{-200, 0}, {-100, 0.1}, {40, 0.02}, {300, 0.9}},
                                      {{-100, {0.9, 0.5, 0.3}}, {200, {0.4, 0.8, 1}}}, 10);
    scene.window = GreyWindow{60, 150};
    if (mode == Mode::radiograph)
        scene.window = GreyWindow{180, 320};
    scene.quality.stepVoxels = 0.125;
    return scene;
}

TEST(Sums, OfTheReferenceAreWhatAFewLinesSay) {
    const PlainVolume volume("torso");
    for (const Mode mode : {Mode::emission, Mode::absorption, Mode::radiograph})
        for (const ValueColour colour :
             {ValueColour::window, ValueColour::inverse, ValueColour::transferFunction}) {
            if (mode == Mode::radiograph && colour == ValueColour::transferFunction)
                continue;
            Scene scene = torsoSums(mode);
            scene.valueColour = colour;
            const auto& own = std::get<TransferFunction>(scene.volumes[0].transferFunction);
            const GreyWindow window = std::get<GreyWindow>(scene.window);
            const Image picture = drawn(scene, EngineKind::reference, storePath("torso")).image;
            int between = 0;
            for (int n = 0; n < 99; ++n) {
                const glm::dvec4 pixel(picture.pixels[static_cast<std::size_t>(n)]);
                const std::string where = nameOf(mode) + " " + std::to_string(n);
                const TransferFunction water = TransferFunction::fromExtinction({{-1000, 0}, {9000, 10}}, {});
                const Sums sums = sumsAlong(scene, volume, mode == Mode::radiograph ? water : own, n);
                const auto part = [&](double sum) {
                    return std::clamp((sum - window.low()) / window.width, 0.0, 1.0);
                };
                if (mode == Mode::emission) {
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(pixel[c], part(sums.light[c]), 2e-3) << where;
                    EXPECT_EQ(pixel.a, std::max({pixel.r, pixel.g, pixel.b})) << where;
                    between += pixel.a > 0 && pixel.a < 1;
                } else if (mode == Mode::absorption) {
                    const double alpha = 1 - std::exp(-sums.depth);
                    const glm::dvec3 shows = colour == ValueColour::window    ? glm::dvec3(1)
                                             : colour == ValueColour::inverse ? glm::dvec3(0)
                                             : sums.depth > 0                 ? sums.light / sums.depth
                                                                              : glm::dvec3(0);
                    EXPECT_NEAR(pixel.a, alpha, 2e-3) << where;
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(pixel[c], alpha * shows[c], 2e-3) << where;
                    between += pixel.a > 0.01 && pixel.a < 0.99;
                } else {
                    const double grey = part(sums.depth);
                    EXPECT_EQ(pixel.a, sums.meets ? 1 : 0) << where;
                    if (sums.meets) {
                        EXPECT_NEAR(greyOf(pixel.r), colour == ValueColour::inverse ? 1 - grey : grey, 2e-3)
                            << where;
                    }
                    between += grey > 0 && grey < 1;
                }
            }
            EXPECT_GT(between, 20) << nameOf(mode);
        }
}

TEST(Sums, OfEveryEngineAreThoseOfTheReference) {
    for (const Mode mode : {Mode::emission, Mode::absorption, Mode::radiograph}) {
        Scene scene = torsoSums(mode, {33, 29});
        const Image truth = drawn(scene, EngineKind::reference, storePath("torso")).image;
        const Image native = drawn(scene, EngineKind::native, storePath("torso")).image;
        EXPECT_EQ(differing(drawn(scene, EngineKind::mirror, storePath("torso")).image, native), 0u);
        EXPECT_LT(compare(native, truth).rms, 2e-3) << nameOf(mode);
        EXPECT_LT(compare(drawn(scene, EngineKind::gpu, storePath("torso")).image, truth).rms, 4e-3)
            << nameOf(mode);
        scene.quality.skipping = false;
        EXPECT_EQ(differing(drawn(scene, EngineKind::native, storePath("torso")).image, native), 0u)
            << nameOf(mode) << ": leaping changed the picture";
        scene.quality.stepVoxels = 1;
        EXPECT_GT(compare(drawn(scene, EngineKind::native, storePath("torso")).image, truth).rms,
                  4 * compare(native, truth).rms)
            << "the step has an effect";
    }
}

// Nothing hides anything: a medium that is opaque in a composite adds up all the same.
TEST(Sums, OfAnEvenMediumAreItsClosedForm) {
    for (const double extinction : {1e-5, 0.02, 3.0, 16.0}) {
        const Stored stored([](const glm::dvec3&) { return 500.0; }, {40, 32, 48}, true);
        Scene scene = stored.scene({}, 0, 8);
        scene.camera = Camera{.projection = Projection::parallel,
                              .position = {20, 16, -300},
                              .focalPoint = {20, 16, 24},
                              .viewUp = {0, 1, 0},
                              .parallelScale = 8};
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, extinction}, {1000, extinction}}, {{0, {0.25, 0.5, 1}}});
        scene.mode = Mode::emission;
        const double depth = 48 * extinction;
        for (const EngineKind engine : kAllEngines) {
            const RenderResult automatic = drawn(scene, engine, stored.folder / "v.zarr");
            EXPECT_NEAR(automatic.window.width, depth, 1e-5 * depth) << extinction;
            EXPECT_EQ(automatic.window.low(), 0);
            for (const glm::vec4& pixel : automatic.image.pixels) {
                EXPECT_NEAR(pixel.r, 0.25, 2e-6) << extinction;
                EXPECT_NEAR(pixel.g, 0.5, 2e-6) << extinction;
                EXPECT_NEAR(pixel.b, 1, 2e-6) << extinction;
            }
        }
        scene.mode = Mode::absorption;
        for (const EngineKind engine : kAllEngines)
            EXPECT_NEAR(drawn(scene, engine, stored.folder / "v.zarr").image.pixels[27].a,
                        1 - std::exp(-depth), 2e-5)
                << extinction;
        scene.mode = Mode::radiograph;
        scene.volumes[0].unit = "HU"; // 500 HU: one and a half times water
        EXPECT_NEAR(drawn(scene, EngineKind::native, stored.folder / "v.zarr").window.width, 72, 1e-4);
    }
}

TEST(Sums, AreThoseOfAThinMediumsComposite) {
    Scene scene = torsoSums(Mode::absorption, {24, 24});
    const Image sums = drawn(scene, EngineKind::native, storePath("torso")).image;
    scene.mode = Mode::composite;
    scene.shading.on = false;
    scene.quality.integrator = Integrator::midpoint;
    scene.quality.terminationTransmittance = 0;
    const Image composite = drawn(scene, EngineKind::native, storePath("torso")).image;
    for (std::size_t i = 0; i < sums.pixels.size(); ++i)
        EXPECT_NEAR(sums.pixels[i].a, composite.pixels[i].a, 1e-5) << i;
}

// What is told of an open window draws the same picture, with samples, measured errors and all.
TEST(Sums, AWindowThatIsToldGivesTheSameBits) {
    for (const Mode mode : {Mode::emission, Mode::radiograph})
        for (const bool automatic : {true, false}) {
            Scene scene = torsoSums(mode, {48, 40}, 0);
            scene.quality.automaticStep = automatic;
            scene.quality.pixels.samples = automatic ? PixelSampling::kAutomatic : 1;
            scene.window = std::string("auto");
            const RenderResult open = drawn(scene, EngineKind::native, storePath("torso"), Verify::quick);
            ASSERT_TRUE(open.measured);
            EXPECT_LT(open.measured->all.luvMean.value_or(Estimate{99}).value, 3) << nameOf(mode);
            scene.window = open.window;
            EXPECT_EQ(differing(drawn(scene, EngineKind::native, storePath("torso"), Verify::quick).image,
                                open.image),
                      0u);
            EXPECT_FALSE(isBlank(open.image));
            scene.window = GreyWindow{open.window.centre / 2, open.window.width / 2};
            EXPECT_GT(compare(drawn(scene, EngineKind::native, storePath("torso")).image, open.image).rms,
                      0.05);
        }
}

TEST(Sums, InWindowsAreThoseOfAStill) {
    for (const Mode mode : {Mode::emission, Mode::absorption, Mode::radiograph}) {
        Scene scene = torsoSums(mode, {40, 40}, 0);
        scene.quality.stepVoxels = 0.5;
        const auto expectStill = [&](const Image& shown) {
            const Image still = drawn(scene, EngineKind::native, storePath("torso")).image;
            if (mode == Mode::radiograph) // a still's levels are no finer than its pixels show
                EXPECT_LT(compare(shown, still).rms, 0.01);
            else
                EXPECT_EQ(differing(shown, still), 0u) << nameOf(mode);
        };
        Session session(scene, std::size_t{256} << 20, {}, storePath("torso"), true);
        session.converge();
        expectStill(session.renderer.picture());
        if (mode == Mode::absorption)
            continue;
        scene.window = GreyWindow{40, 100};
        session.renderer.setWindow(scene.window);
        session.converge();
        expectStill(session.renderer.picture());
        session.renderer.setWindow(std::string("auto"));
        session.converge();
        float most = 0;
        for (const glm::vec4& pixel : session.renderer.picture().pixels)
            most = std::max({most, pixel.r, pixel.g, pixel.b});
        EXPECT_EQ(most, 1) << nameOf(mode) << ", an open window";
    }
}

// A radiograph is white where rays pass the volume, however little is there; cuts and their gaps are not.
TEST(Sums, OfARadiographAreOpaqueWhereRaysMeetWhatIsDrawn) {
    const Stored stored([](const glm::dvec3&) { return -1000.0; }, {40, 40, 40}, true);
    Scene scene = stored.scene({}, 0, 16);
    scene.camera = Camera{.projection = Projection::parallel,
                          .position = {20, 20, -300},
                          .focalPoint = {20, 20, 20},
                          .viewUp = {0, 1, 0},
                          .parallelScale = 32};
    scene.mode = Mode::radiograph;
    scene.volumes[0].unit = "HU";
    scene.valueColour = ValueColour::inverse;
    const auto opaque = [&] {
        int count = 0;
        for (const glm::vec4& pixel :
             drawn(scene, EngineKind::native, stored.folder / "v.zarr").image.pixels) {
            count += pixel.a == 1;
            EXPECT_TRUE(pixel.a == 0 || pixel == glm::vec4(1)) << "air is white";
        }
        return count;
    };
    EXPECT_EQ(opaque(), 100); // 10 x 10 pixels of 4 mm
    CropBox box;
    box.low = {8, 8, -100};
    box.high = {32, 32, 100};
    box.keep = Keep::outside;
    scene.cuts.boxes = {box};
    EXPECT_EQ(opaque(), 64);
    scene.cuts.boxes[0].keep = Keep::inside;
    EXPECT_EQ(opaque(), 36);
}

TEST(Sums, RefuseWhatTheyHaveNot) {
    Scene scene = torsoSums(Mode::radiograph);
    scene.window = std::string("lung");
    const auto draw = [&] { drawn(scene, EngineKind::native, storePath("torso")); };
    EXPECT_THAT(refusalOf(draw), HasSubstr("window: expected auto or CENTRE,WIDTH of mm of water in mode "
                                           "radiograph, found \"lung\""));
    scene.window = std::string("auto");
    scene.valueColour = ValueColour::transferFunction;
    EXPECT_THAT(refusalOf(draw), HasSubstr("valueColour: expected window or inverse in mode radiograph"));
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader reader(storePath("torso"), ram);
    scene.valueColour = ValueColour::window;
    scene.imageSize = {8, 1};
    const UnfoldedRow row{middleOf(reader.info()), {0, 0, 1}, {0, 1, 0}};
    EXPECT_THAT(refusalOf([&] { renderUnfolded(scene, std::span(&row, 1), reader, ram, gpu, {}); }),
                HasSubstr("window: expected CENTRE,WIDTH of mode radiograph in an unfolded picture"));
    scene.window = GreyWindow{100, 200};
    EXPECT_EQ(renderUnfolded(scene, std::span(&row, 1), reader, ram, gpu, {}).image.size, glm::ivec2(8, 1));
    const Stored small([](const glm::dvec3& p) { return 0.01 * p.x; }, {20, 20, 20}, true);
    Scene other = small.scene({}, 0, 8);
    other.mode = Mode::radiograph;
    EXPECT_THAT(refusalOf([&] { drawn(other, EngineKind::native, small.folder / "v.zarr"); }),
                HasSubstr("mode radiograph: expected a volume in HU"));
}

// Opacity by gradient counts, cut bricks and mixed budgets or not.
TEST(Sums, TakeOpacityByGradient) {
    for (const bool cut : {false, true}) {
        Scene scene = torsoSums(Mode::absorption, {33, 29});
        auto& function = std::get<TransferFunction>(scene.volumes[0].transferFunction);
        function.setGradientOpacity(GradientOpacity::fromPoints({{5, 0}, {60, 1}}));
        if (cut)
            scene.cuts.boxes = {{{20, 15, 20}, {70, 60, 90}, CropBox::Space::voxels, Keep::inside}};
        const Image truth = drawn(scene, EngineKind::reference, storePath("torso")).image;
        const Image native = drawn(scene, EngineKind::native, storePath("torso")).image;
        EXPECT_EQ(differing(drawn(scene, EngineKind::mirror, storePath("torso")).image, native), 0u);
        EXPECT_LT(compare(native, truth).rms, 3e-3);
        function.setGradientOpacity({});
        EXPECT_GT(compare(drawn(scene, EngineKind::native, storePath("torso")).image, native).rms, 0.05);
    }
}

// Each alone, one over the other: two halves of an even medium let through what one does of both.
TEST(Sums, OfSeveralVolumesLieOverOneAnother) {
    const Stored stored([](const glm::dvec3&) { return 500.0; }, {32, 32, 32}, true);
    for (const ValueColour colour : {ValueColour::window, ValueColour::transferFunction}) {
        Scene scene = stored.scene({}, 0, 8);
        scene.camera = Camera{.projection = Projection::parallel,
                              .position = {16, 16, -300},
                              .focalPoint = {16, 16, 16},
                              .viewUp = {0, 1, 0},
                              .parallelScale = 8};
        scene.volumes[0].transferFunction =
            TransferFunction::fromOpacity({{0, 0.01}, {1000, 0.01}}, {{0, {1, 1, 1}}}, 1);
        scene.volumes.push_back(scene.volumes[0]);
        scene.mode = Mode::absorption;
        scene.valueColour = colour;
        scene.fusion = Fusion::over;
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
            gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        const StoreReader reader(stored.folder / "v.zarr", ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        const Image picture = renderScene(scene, std::array{&reader, &reader}, ram, gpu, options).image;
        EXPECT_NEAR(picture.pixels[27].a, 1 - std::pow(0.99, 64), 1e-4);
    }
}

// Noise of air shows in a radiograph; a camera is fitted to the body all the same.
TEST(Sums, OfARadiographAreFittedToTheBody) {
    const Stored stored(
        [](const glm::dvec3& p) {
            return glm::length(p - glm::dvec3(40, 40, 30)) < 12 ? 40.0
                                                                : -960 - 10 * std::sin(30 * p.x + 7 * p.y);
        },
        {80, 80, 60}, true);
    Scene scene = stored.scene({}, 0, 64);
    scene.camera = FittedView{.view = View::anterior, .named = true};
    scene.volumes[0].unit = "HU";
    scene.mode = Mode::radiograph;
    const Camera fitted = drawn(scene, EngineKind::native, stored.folder / "v.zarr").camera;
    scene.mode = Mode::composite;
    scene.volumes[0].transferFunction = bodyFunction();
    EXPECT_EQ(fitted, drawn(scene, EngineKind::native, stored.folder / "v.zarr").camera);
    EXPECT_NEAR(glm::length(fitted.focalPoint - glm::dvec3(40, 40, 30)), 0, 1.5);
    EXPECT_LT(glm::length(fitted.position - fitted.focalPoint) * std::tan(glm::radians(fitted.viewAngle / 2)),
              16);
}

// Extinctions from 1e-6 to those of metal; the sums of floats stay true.
TEST(Sums, AreTrueFromThinAirToMetal) {
    for (const double value : {-999.9, -900.0, 3000.0, 30000.0}) {
        const Stored stored([&](const glm::dvec3&) { return value; }, {32, 32, 96}, true);
        Scene scene = stored.scene({}, 0, 4);
        scene.camera = Camera{.projection = Projection::parallel,
                              .position = {16, 16, -300},
                              .focalPoint = {16, 16, 48},
                              .viewUp = {0, 1, 0},
                              .parallelScale = 4};
        scene.mode = Mode::radiograph;
        scene.volumes[0].unit = "HU";
        const double water = 96 * (1 + value / 1000);
        for (const EngineKind engine : kAllEngines)
            EXPECT_NEAR(drawn(scene, engine, stored.folder / "v.zarr").window.width, water,
                        value < -999 ? 1e-3 * water : 1e-5 * water)
                << value;
    }
}

} // namespace
} // namespace tessera::test
