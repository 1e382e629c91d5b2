// tests/render/picture/symmetries_test.cpp: the same body, stored, placed or measured in another way, gives
// the same picture; its mirror image gives the picture's.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "core/image/image_metrics.h"
#include "render/picture/render_scene.h"
#include "tests/support/bricking_test_volumes.h"
#include "tests/support/scene_fixture.h"

#include <array>
#include <glm/gtc/matrix_transform.hpp>

namespace tessera::test {
namespace {

/// A body in a box of 40 x 36 x 44 voxels of 1.5 x 1 x 0.75 mm: whole values from 0 to 250, without a
/// symmetry.
constexpr glm::ivec3 kExtent{40, 36, 44};
double bodyAt(const glm::ivec3& p) {
    const glm::dvec3 x = glm::dvec3(p) / glm::dvec3(kExtent);
    const double shell = 1 - 2.4 * glm::length(x - glm::dvec3(0.42, 0.55, 0.47));
    const double ripples = 0.12 * std::sin(19 * x.x + 3) * std::cos(14 * x.y) * std::sin(11 * x.z + 1);
    const bool rod = std::abs(x.x - 0.7) < 0.06 && std::abs(x.z - 0.3) < 0.08 && x.y > 0.1;
    return std::floor(std::clamp(250 * (shell + ripples) + (rod ? 120 : 0), 0.0, 250.0));
}

/// The layout of the stored body: axis a of the store runs along axis `axis[a]` of the body, backwards where
/// `flipped`.
struct Stored {
    std::array<int, 3> axis{0, 1, 2};
    std::array<bool, 3> flipped{false, false, false};
    ValueType type = ValueType::i16;
    double slope = 1, intercept = 0; // physical = slope * stored + intercept = scale * body + offset
    double scale = 1, offset = 0;
    glm::dmat4 place{1}; // patient space from that of the body at rest

    glm::ivec3 inBody(const glm::ivec3& p) const {
        glm::ivec3 to;
        for (int a = 0; a < 3; ++a) {
            const int along = axis[static_cast<std::size_t>(a)];
            to[along] = flipped[static_cast<std::size_t>(a)] ? kExtent[along] - 1 - p[a] : p[a];
        }
        return to;
    }
    VolumeInfo info() const {
        constexpr glm::dvec3 spacing{1.5, 1, 0.75};
        VolumeInfo info;
        info.type = type;
        info.rescaleSlope = slope, info.rescaleIntercept = intercept;
        glm::dmat4 m(1);
        glm::dvec3 first{-32, 16, 64}; // start of the body's box
        for (int a = 0; a < 3; ++a) {
            const int along = axis[static_cast<std::size_t>(a)];
            info.extentVoxels[a] = kExtent[along];
            glm::dvec3 step(0);
            step[along] = spacing[along];
            if (flipped[static_cast<std::size_t>(a)]) {
                first[along] += spacing[along] * kExtent[along];
                step = -step;
            }
            m[a] = glm::dvec4(step, 0);
        }
        m[3] = glm::dvec4(first, 1);
        info.patientFromVoxel = place * m;
        return info;
    }
};

/// The scene of the body at rest.
Scene sceneOf(const VolumeInfo& info) {
    Scene scene = sceneOn(info, "auto", 0, {40, 32});
    scene.camera = cameraNumber(0, info, scene.imageSize);
    scene.volumes[0].transferFunction = TransferFunction::fromOpacity(
        {{40, 0}, {90, 0.06}, {150, 0.1}, {151, 0.5}, {250, 0.6}},
        {{40, {0.9, 0.3, 0.2}}, {150, {0.9, 0.8, 0.4}}, {250, {0.5, 0.7, 1}}}, 1);
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    lamp.position = {-80, -40, 140};
    lamp.attenuation = {0.5, 1.0 / 256, 0};
    lamp.colour = {1, 0.9, 0.8};
    scene.lighting.lights = {Light(), lamp};
    scene.lighting.lights[0].intensity = 0.5;
    scene.quality.stepVoxels = 0.5;
    return scene;
}

const Scene& atRest() {
    static const Scene scene = sceneOf(Stored().info());
    return scene;
}

/// Camera and lights move together with the body.
Scene moved(Scene scene, const glm::dmat4& by) {
    const auto point = [&by](const glm::dvec3& p) { return glm::dvec3(by * glm::dvec4(p, 1)); };
    Camera camera = std::get<Camera>(scene.camera);
    camera.viewUp = glm::dvec3(by * glm::dvec4(camera.viewUp, 0));
    camera.position = point(camera.position), camera.focalPoint = point(camera.focalPoint);
    scene.camera = camera;
    for (Light& light : scene.lighting.lights)
        light.position = point(light.position);
    return scene;
}

class Symmetries : public ::testing::TestWithParam<EngineKind> {
  protected:
    Image picture(const Stored& stored, const Scene& scene, std::size_t gpuBytes = std::size_t{256} << 20) {
        const auto path = folder_ / ("v" + std::to_string(number_++) + ".zarr");
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
        const VolumeInfo info = stored.info();
        HashSource source(info, [&stored](int x, int y, int z) {
            const double value = stored.scale * bodyAt(stored.inBody({x, y, z})) + stored.offset;
            return (value - stored.intercept) / stored.slope;
        });
        importToStore(source, path, ram, {});
        const StoreReader store(path, ram);
        RenderOptions options;
        options.engine = GetParam();
        options.device.text = "software";
        const RenderResult result = renderScene(scene, store, ram, gpu, options);
        fine_ = result.bricksOfLevel[0];
        coarse_ = result.residentBricks - fine_;
        return result.image;
    }
    Image picture(const Stored& stored) { return picture(stored, atRest()); }

    /// Equal but for how numbers round: a sample or two of a few rays may lie in another segment.
    static void expectAlike(const Image& image, const Image& as, const std::string& what) {
        const ImageDifference d = compare(image, as);
        EXPECT_GT(d.maskedPixels, 300u) << what;
        EXPECT_LT(d.rms, 2e-4) << what;
        EXPECT_LT(d.maxAbs, 4e-3) << what;
    }

    std::size_t fine_ = 0, coarse_ = 0; // bricks of the last picture at the finest level, and at others

  private:
    ScratchFolder folder_;
    int number_ = 0;
};

TEST_P(Symmetries, WhateverTheTypeOfTheStoredValues) {
    Stored stored;
    const Image is = picture(stored);
    for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f32}) {
        stored.type = type;
        EXPECT_TRUE(bitEqual(picture(stored), is)) << name(type);
    }
}

TEST_P(Symmetries, WhateverStandsForAValue) {
    const Image is = picture(Stored());
    Stored stored;
    stored.slope = -1; // stored values fall where the body's rise
    expectAlike(picture(stored), is, "negative slope");
    stored = Stored();
    stored.type = ValueType::u16, stored.intercept = -16334; // on both sides of 32768
    stored.slope = 0.5;
    expectAlike(picture(stored), is, "values around 32768");
}

// The same function, drawn over other values of the same things.
TEST_P(Symmetries, WhateverTheValuesAreMeasuredIn) {
    const Image is = picture(Stored());
    Stored stored;
    stored.scale = 4, stored.offset = -1000;
    Scene scene = atRest();
    const auto& f = std::get<TransferFunction>(scene.volumes[0].transferFunction);
    auto opacity = f.opacityPoints();
    auto colour = f.colourPoints();
    for (OpacityPoint& p : opacity)
        p.value = 4 * p.value - 1000;
    for (ColourPoint& p : colour)
        p.value = 4 * p.value - 1000;
    scene.volumes[0].transferFunction = TransferFunction::fromOpacity(opacity, colour, f.referenceLengthMm());
    expectAlike(picture(stored, scene), is, "4 v - 1000");
}

TEST_P(Symmetries, WhicheverWayTheAxesOfTheStoreRun) {
    const Image is = picture(Stored());
    for (const auto& [axis, flipped] : {std::pair(std::array{1, 2, 0}, std::array{false, false, false}),
                                        std::pair(std::array{0, 1, 2}, std::array{true, false, false}),
                                        std::pair(std::array{2, 1, 0}, std::array{false, true, true})}) {
        Stored stored;
        stored.axis = axis, stored.flipped = flipped;
        expectAlike(picture(stored), is, "axes " + std::to_string(axis[0]) + std::to_string(axis[1]));
    }
}

TEST_P(Symmetries, WhereverThePatientLies) {
    const Image is = picture(Stored());
    const glm::dmat4 shift = glm::translate(glm::dmat4(1), {96, -512, 40});
    const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 0.7, {0.3, -0.8, 0.5});
    for (const glm::dmat4& by : {shift, turn * shift}) {
        Stored stored;
        stored.place = by;
        expectAlike(picture(stored, moved(atRest(), by)), is, "moved");
    }
}

// All lengths are twice as long, and tissue half as dense.
TEST_P(Symmetries, HoweverLargeThePatientIs) {
    const Image is = picture(Stored());
    Stored stored;
    stored.place = glm::scale(glm::dmat4(1), glm::dvec3(2));
    Scene scene = moved(atRest(), stored.place);
    const auto& f = std::get<TransferFunction>(scene.volumes[0].transferFunction);
    scene.volumes[0].transferFunction = TransferFunction::fromOpacity(f.opacityPoints(), f.colourPoints(), 2);
    scene.lighting.lights[1].attenuation.y /= 2;
    expectAlike(picture(stored, scene), is, "twice as large");
}

TEST_P(Symmetries, AMirroredPatientHasAMirroredPicture) {
    const Image is = picture(Stored());
    Stored stored;
    stored.place = glm::scale(glm::dmat4(1), glm::dvec3(-1, 1, 1));
    Image image = picture(stored, moved(atRest(), stored.place));
    for (int y = 0; y < image.size.y; ++y)
        std::reverse(image.pixels.begin() + y * image.size.x, image.pixels.begin() + (y + 1) * image.size.x);
    expectAlike(image, is, "mirrored");
}

// Bricks and levels go by voxels, so places and types change nothing where levels mix, either.
TEST_P(Symmetries, AlsoWhereLevelsMix) {
    if (GetParam() == EngineKind::reference)
        GTEST_SKIP() << "the reference draws the finest level alone";
    const std::size_t few = std::size_t{300} << 10;
    const Image is = picture(Stored(), atRest(), few);
    EXPECT_GT(coarse_, 0u);
    EXPECT_GT(fine_, 0u);
    Stored stored;
    stored.type = ValueType::u16;
    EXPECT_TRUE(bitEqual(picture(stored, atRest(), few), is));
    stored = Stored();
    stored.place = glm::translate(glm::dmat4(1), {64, -128, 32});
    expectAlike(picture(stored, moved(atRest(), stored.place), few), is, "shifted");
}

INSTANTIATE_TEST_SUITE_P(Engines, Symmetries,
                         ::testing::Values(EngineKind::native, EngineKind::reference, EngineKind::gpu),
                         [](const auto& row) { return name(row.param); });

} // namespace
} // namespace tessera::test
