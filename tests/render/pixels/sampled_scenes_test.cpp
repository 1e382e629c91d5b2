// Scenes that renderers with adaptive samples leave black, or stop too early at: volumes that clip the corner
// of a tile of pixels, and scenes that few rays hit. Drawn by the native engine with --samples auto, against
// 256 samples of every pixel.
#include "core/base/error.h"
#include "core/image/colour.h"
#include "render/picture/render_scene.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(64, 48);

RenderResult drawn(const Scene& scene, Verify verify = Verify::none, int threads = 2,
                   std::size_t gpuBytes = std::size_t{64} << 20) {
    MemoryBudget ram("RAM", "--ram", std::size_t{128} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(scene.volumes[0].path, ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.threads = threads;
    options.verify = verify;
    const RenderResult result = renderScene(scene, reader, ram, gpu, options);
    EXPECT_LE(ram.peakBytes(), ram.limitBytes());
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    return result;
}

/// Seen along z, the volume's middle at a place of the picture, in pixels.
Scene sceneAt(const Stored& stored, const glm::dvec2& middle, double voxelsPerPixel, double turned,
              const std::vector<OpacityPoint>& extinction) {
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction(extinction, {{0, {0.9, 0.7, 0.5}}});
    scene.imageSize = kSize;
    const glm::dvec3 up(std::sin(turned), -std::cos(turned), 0);
    const glm::dvec2 off = (glm::dvec2(kSize) / 2.0 - middle) * voxelsPerPixel;
    Camera camera = fitCamera(stored.info, View::superior, Projection::parallel, kSize);
    camera.viewUp = up;
    const glm::dvec3 centre =
        glm::dvec3(stored.info.patientFromVoxel * glm::dvec4(glm::dvec3(stored.info.extentVoxels) / 2.0, 1));
    const glm::dvec3 away = camera.position - camera.focalPoint;
    const glm::dvec3 rightOfView = glm::normalize(glm::cross(-away, up));
    camera.focalPoint = centre + off.x * rightOfView - off.y * up;
    camera.position = camera.focalPoint + away;
    camera.parallelScale = 0.5 * kSize.y * voxelsPerPixel;
    scene.camera = camera;
    scene.shading.on = false;
    scene.quality.pixels = {PixelSampling::kAutomatic, PixelFilter::box, 3};
    return scene;
}

Image truthOf(Scene scene) {
    scene.quality.pixels = {256, PixelFilter::box, 77};
    return drawn(scene).image;
}

constexpr float kShown = 0.06f; // 8 samples find it; of less 64 may find nothing

double distance(const glm::vec4& a, const glm::vec4& b) {
    return glm::distance(luvFromLinear(glm::dvec3(a)), luvFromLinear(glm::dvec3(b)));
}

/// Nothing that the truth shows is black, and what is there errs as little as the picture says of itself.
void expectSampled(const Scene& scene, float shown = kShown) {
    const Image truth = truthOf(scene);
    const RenderResult r = drawn(scene, Verify::full);
    ASSERT_TRUE(r.measured);
    ASSERT_TRUE(r.measured->all.luvP99Bound) << r.measured->whyNot;
    std::vector<double> distances;
    for (std::size_t i = 0; i < truth.pixels.size(); ++i)
        if (truth.pixels[i].a > shown) {
            EXPECT_GT(r.image.pixels[i].a, 0) << "pixel " << i << ", truth " << truth.pixels[i].a;
            distances.push_back(distance(r.image.pixels[i], truth.pixels[i]));
        }
    ASSERT_FALSE(distances.empty());
    std::sort(distances.begin(), distances.end());
    const double p99 = distances[static_cast<std::size_t>(0.99 * static_cast<double>(distances.size() - 1))];
    EXPECT_LE(p99, *r.measured->all.luvP99Bound + 0.8) << "this truth has noise of its own";
    for (const int threads : {1, 4})
        EXPECT_TRUE(bitEqual(drawn(scene, Verify::none, threads).image, r.image)) << threads;
}

// The corners of the picture and of tiles of 4 to 32 pixels in it, straight and rotated. If the middles of
// the clipped tile miss the volume (31.53 is beyond the middle of pixel 31), its neighbours decide.
TEST(SampledScenes, AVolumeThatClipsATilesCornerIsSampledLikeAnyOther) {
    const Stored cube([](const glm::dvec3&) { return 1000.0; }, glm::ivec3(16), true); // 5.33 pixels wide
    struct Case {
        glm::dvec2 corner, off;
    };
    for (const double turned : {0.0, 0.4})
        for (const Case& c :
             {Case{{0, 0}, {-1.3, -1.3}}, Case{{64, 0}, {1.3, -1.3}}, Case{{0, 48}, {-1.3, 1.3}},
              Case{{64, 48}, {1.3, 1.3}}, Case{{32, 32}, {2.2, -1.1}}, Case{{16, 8}, {2.2, 2.2}},
              Case{{40, 36}, {-2.2, -2.3}}}) {
            SCOPED_TRACE(testing::Message()
                         << "turned " << turned << ", corner " << c.corner.x << " " << c.corner.y);
            expectSampled(sceneAt(cube, c.corner + c.off, 3, turned, {{0, 2}, {2000, 2}}));
        }
}

// A part that reaches into the picture by less than half a pixel meets no middle.
TEST(SampledScenes, AVolumeThatClipsThePicturesEdgeIsSampledLikeAnyOther) {
    const Stored cube([](const glm::dvec3&) { return 1000.0; }, glm::ivec3(16), true); // 5.33 pixels wide
    {
        // Its last cell is a voxel of eight, and its pixels are small: the cell is large, but not what is
        // there.
        const Stored odd([](const glm::dvec3&) { return 1000.0; }, glm::ivec3(33), true);
        const Scene scene =
            sceneAt(odd, {0.3 - 16.5 * 2, 24.2}, 0.5, 0, {{0, 2}, {2000, 2}}); // 66 pixels wide
        const Image truth = truthOf(scene), image = drawn(scene).image;
        ASSERT_GT(truth.at(0, 24).a, 0.1f);
        EXPECT_NEAR(image.at(0, 24).a, truth.at(0, 24).a, 0.5f * truth.at(0, 24).a);
    }
    for (const double inside : {0.15, 0.3, 0.45})
        for (const glm::dvec2& middle :
             {glm::dvec2(inside - 8.0 / 3, 24.2), glm::dvec2(31.7, inside - 8.0 / 3),
              glm::dvec2(64 - inside + 8.0 / 3, 20.1)}) {
            SCOPED_TRACE(testing::Message() << inside << " inside, " << middle.x << " " << middle.y);
            const Scene scene = sceneAt(cube, middle, 3, 0, {{0, 2}, {2000, 2}});
            const Image truth = truthOf(scene), image = drawn(scene).image;
            std::size_t shown = 0;
            for (std::size_t i = 0; i < truth.pixels.size(); ++i)
                if (truth.pixels[i].a > kShown) {
                    ++shown;
                    EXPECT_NEAR(image.pixels[i].a, truth.pixels[i].a, 0.5f * truth.pixels[i].a);
                }
            EXPECT_GE(shown, 5u);
        }
}

// A picture that shows nothing is not taken at its word: other pixels are drawn again, and told of.
TEST(SampledScenes, APictureOfNothingIsMeasuredToo) {
    const Stored cube([](const glm::dvec3&) { return 1000.0; }, glm::ivec3(16), true);
    Scene scene = sceneAt(cube, {0.3 - 8.0 / 3, 24.2}, 3, 0, {{0, 2}, {2000, 2}});
    scene.quality.pixels.samples = 1; // middles alone: the truth shows a part of the border's pixels
    const RenderResult missed = drawn(scene, Verify::full);
    ASSERT_TRUE(isBlank(missed.image) && missed.measured);
    EXPECT_GT(missed.measured->all.shown, 0u);
    scene = sceneAt(cube, {-9, 24.2}, 3, 0, {{0, 2}, {2000, 2}}); // beside the picture
    const RenderResult empty = drawn(scene, Verify::full);
    ASSERT_TRUE(empty.measured);
    EXPECT_NE(empty.measured->whyNot.find("nor do the"), std::string::npos) << empty.measured->whyNot;
}

/// A voxel or two thick, in several depths, crossing one another.
double wires(const glm::dvec3& p) {
    double v = 0;
    for (int wire = 0; wire < 4; ++wire) {
        const double angle = 0.3 + 0.8 * wire;
        const double off = (p.x - 45) * std::sin(angle) + (p.y - 34) * std::cos(angle) - 3.0 * wire;
        v = std::max(v, 1000 * (1 - std::hypot(off, p.z - 3.5 - 2 * wire)));
    }
    return v;
}
/// Single voxels of unlike opacity.
double dots(const glm::dvec3& p) {
    const glm::ivec3 at(p);
    return at.x % 11 == 5 && at.y % 13 == 6 && at.z == 4 ? 300.0 + 70 * ((at.x + at.y) % 11) : 0.0;
}
const std::vector<OpacityPoint> kScarce = {{0, 0}, {1000, 0.8}};
constexpr glm::ivec3 kScarceExtent(90, 68, 12);

// A wire is a half to a quarter as wide as a pixel, and dots are as small. If neither a pixel's middle nor a
// neighbour's hits them, the distance map shows that something lies there.
TEST(SampledScenes, WhatFewRaysHitIsSampledLikeAnyOther) {
    const Stored thin(wires, kScarceExtent, true), single(dots, kScarceExtent, true);
    struct Case {
        const Stored& stored;
        double voxelsPerPixel;
        float shown = kShown;
    };
    for (const Case& c : {Case{single, 1.5}, Case{single, 2}, Case{single, 3}, Case{single, 4, 0.03f},
                          Case{thin, 2}, Case{thin, 4}}) {
        SCOPED_TRACE(c.voxelsPerPixel);
        expectSampled(sceneAt(c.stored, {31.7, 24.2}, c.voxelsPerPixel, 0.1, kScarce), c.shown);
    }
}

// With the least memory that it says it needs an error that was asked for is reached, or what was.
TEST(SampledScenes, MaxErrorEndsWithTheFloorsMemory) {
    const Stored thin(wires, kScarceExtent, true);
    Scene scene = sceneAt(thin, {31.7, 24.2}, 4, 0.1, kScarce);
    scene.quality.maxError = 5;
    const RenderResult ample = drawn(scene, Verify::full);
    std::optional<RenderResult> least;
    std::size_t floor = std::size_t{128} << 10;
    for (; !least && floor < std::size_t{8} << 20; floor += std::size_t{64} << 10)
        try {
            least = drawn(scene, Verify::full, 2, floor);
        } catch (const InputError&) { // it needs more
        }
    ASSERT_TRUE(least);
    EXPECT_GT(least->passes, 1);
    EXPECT_TRUE(bitEqual(least->image, ample.image));
    EXPECT_EQ(least->shortfall, ample.shortfall);
    ASSERT_TRUE(least->measured && least->measured->all.luvP99Bound);
    EXPECT_EQ(least->shortfall.empty(), *least->measured->all.luvP99Bound <= 5) << least->shortfall;
}

} // namespace
} // namespace tessera
