// tests/render/transport/path_surfaces_test.cpp: paths of light among isosurfaces: closed forms, what they
// are beside a dense medium, and engines' bits.
#include "render/picture/render_scene.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;
using ::testing::HasSubstr;

/// The value is the place along z: isosurfaces are planes at right angles to it. They are seen along z, from
/// below.
struct Planes {
    explicit Planes(const Formula& value = [](const glm::dvec3& p) { return p.z; })
        : stored(value, {44, 40, 48}, true), reader(stored.scene({}).volumes[0].path, ram),
          scene(stored.scene({})) {
        scene.imageSize = {12, 12};
        Camera camera;
        camera.projection = Projection::parallel;
        camera.focalPoint = {22, 20, 24};
        camera.position = {22, 20, -100};
        camera.viewUp = {0, 1, 0};
        camera.parallelScale = 4;
        scene.camera = camera;
        scene.lighting.lights = {from({0, 0, -1})};
        Transport transport;
        transport.bounces = 1;
        transport.surface = SurfaceScattering{{1e6, 2e6}, {0, 1}}; // no coat
        scene.lighting.transport = transport;
        scene.quality.pixels = {16, PixelFilter::box, 3};
    }
    static Light from(const glm::dvec3& direction) {
        Light light;
        light.kind = LightKind::directional;
        light.frame = LightFrame::patient;
        light.direction = direction;
        light.intensity = 1;
        return light;
    }
    Image draw(EngineKind engine = EngineKind::native) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
        RenderOptions options;
        options.engine = engine;
        RenderResult result = renderScene(scene, reader, ram, gpu, options);
        EXPECT_LE(ram.peakBytes(), ram.limitBytes());
        EXPECT_EQ(result.work.paths.exceeded, 0u);
        return std::move(result.image);
    }
    glm::dvec4 mean(EngineKind engine = EngineKind::native) {
        const Image image = draw(engine);
        glm::dvec4 sum(0), squares(0);
        const auto count = static_cast<double>(image.pixels.size());
        for (const glm::vec4& pixel : image.pixels)
            sum += glm::dvec4(pixel) / count, squares += glm::dvec4(pixel) * glm::dvec4(pixel) / count;
        error = std::sqrt(std::max(squares.r - sum.r * sum.r, 0.0) / count);
        return sum;
    }
    double error = 0; // standard error of the last mean's red
    Stored stored;
    MemoryBudget ram{"RAM", "--ram", std::size_t{128} << 20};
    StoreReader reader;
    Scene scene;
};

/// A white even surface that faces a light of intensity I shows I, in slanted light its cosine.
TEST(PathSurfaces, ShowTheLightThatFallsOnThem) {
    Planes planes;
    planes.scene.surfaces = {{20, {0.8, 0.5, 0.2}, 1}};
    const glm::dvec4 straight = planes.mean();
    EXPECT_NEAR(straight.r, 0.8, 2e-3);
    EXPECT_NEAR(straight.g, 0.5, 2e-3);
    EXPECT_NEAR(straight.a, 1, 1e-6);
    planes.scene.lighting.lights = {Planes::from({std::sin(0.5), 0, -std::cos(0.5)})};
    EXPECT_NEAR(planes.mean().r, 0.8 * std::cos(0.5), 1e-3);
    planes.scene.lighting.lights = {Planes::from({0, 0, 1})}; // from behind
    EXPECT_NEAR(planes.mean().r, 0, 1e-6);
}

/// A translucent one before an opaque one: light passes it on its way there and back.
TEST(PathSurfaces, LetLightThroughByTheirOpacity) {
    Planes planes;
    planes.scene.quality.pixels.samples = 256;
    planes.scene.surfaces = {{12, {1, 0, 0}, 0.3}, {30, {0, 1, 0}, 1}};
    const glm::dvec4 once = planes.mean();
    EXPECT_NEAR(once.a, 1, 1e-6);
    EXPECT_NEAR(once.r, 0.3, 0.01);
    EXPECT_NEAR(once.g, 0.7 * 0.7, 0.01);
    planes.scene.surfaces = {{12, {1, 0, 0}, 0.3}};
    const glm::dvec4 alone = planes.mean();
    EXPECT_NEAR(alone.a, 0.3, 1e-6);
    EXPECT_NEAR(alone.r, 0.3, 0.01);
}

/// Between two surfaces light goes to and fro: a white room has the light of its sky, and no more.
TEST(PathSurfaces, MakeNoLight) {
    Planes planes;
    planes.scene.surfaces = {{12, glm::dvec3(1), 0.3}, {20, glm::dvec3(1), 0.5}, {30, glm::dvec3(1), 1}};
    planes.scene.lighting.lights[0].intensity = 0;
    planes.scene.lighting.environment = Environment{Sky::uniform};
    planes.scene.lighting.transport->bounces = 256;
    planes.scene.quality.pixels.samples = 256;
    const double mean = planes.mean().r;
    EXPECT_NEAR(mean, 1, 4 * planes.error + 1e-3);
}

/// The same where surfaces let light through; all of it, where they take none.
TEST(PathSurfaces, MakeNoLightWhereTheyAreTranslucent) {
    Planes planes;
    planes.scene.surfaces = {{12, glm::dvec3(1), 0.7}, {20, glm::dvec3(1), 1}, {30, glm::dvec3(1), 1}};
    planes.scene.lighting.lights[0].intensity = 0;
    planes.scene.lighting.environment = Environment{Sky::uniform};
    planes.scene.lighting.transport->bounces = 256;
    planes.scene.quality.pixels.samples = 256;
    SurfaceFinish& finish = planes.scene.lighting.transport->surface->finish;
    finish = {0, 1, 0.6, 0};
    const double even = planes.mean().r;
    EXPECT_NEAR(even, 1, 4 * planes.error + 1e-3);
    EXPECT_LT(planes.error, 0.01);
    finish = {0.1, 0.4, 0.6, 30};
    const double lobe = planes.mean().r;
    EXPECT_LT(lobe, 1 + 4 * planes.error);
    EXPECT_GT(lobe, 0.6);
}

/// Of light from behind a plane shows its share, by the lobe around the straight way; nothing of what an
/// opaque one has behind it.
TEST(PathSurfaces, LetLightThroughInALobe) {
    Planes planes;
    planes.scene.surfaces = {{20, {0.8, 0.5, 0.2}, 1}};
    planes.scene.lighting.transport->surface->finish = {0, 1, 0.5, 12};
    const double cosine = std::cos(0.3);
    planes.scene.lighting.lights = {Planes::from({0, std::sin(0.3), cosine})};
    const double expected = 0.8 * 0.5 * 14 / 2 * std::pow(cosine, 12) * cosine;
    const glm::dvec4 through = planes.mean();
    EXPECT_NEAR(through.r, expected, 2e-3 * expected);
    EXPECT_NEAR(through.g, expected * 0.5 / 0.8, 2e-3 * expected);
    planes.scene.lighting.lights = {Planes::from({0, 0, -1})};
    EXPECT_NEAR(planes.mean().r, 0.8 * 0.5, 1e-3); // the other half
    // A finish of its own stands for the transport's.
    planes.scene.surfaces[0].finish = SurfaceFinish{0, 1, 1, 0};
    EXPECT_NEAR(planes.mean().r, 0, 1e-6);
    planes.scene.lighting.lights = {Planes::from({0, 0, 1})};
    EXPECT_NEAR(planes.mean().r, 0.8, 1e-3);
}

/// A white even plane in the light, seen through one that spreads light evenly, and through one that lets it
/// on as it comes.
TEST(PathSurfaces, ShowWhatIsBehindThem) {
    Planes planes;
    planes.scene.surfaces = {{20, glm::dvec3(1), 1}, {20.5, glm::dvec3(0.6), 1}};
    planes.scene.surfaces[0].finish = SurfaceFinish{0, 1, 1, 0};
    planes.scene.surfaces[1].finish = SurfaceFinish{0, 1, 1, 0};
    planes.scene.lighting.lights = {Planes::from({0, 0, 1})};
    planes.scene.lighting.transport->bounces = 2;
    planes.scene.quality.pixels.samples = 256;
    EXPECT_NEAR(planes.mean().r, 0.6, 4 * planes.error + 3e-3); // few ways pass between them to the sides
    planes.scene.surfaces[0].finish->translucentPower = 1000;
    EXPECT_NEAR(planes.mean().r, 0.6, 4 * planes.error + 3e-3);
    EXPECT_LT(planes.error, 3e-3);
}

/// A medium before a surface takes light twice, and scatters none.
TEST(PathSurfaces, LieInTheMedium) {
    Planes planes;
    planes.scene.surfaces = {{30, {0, 1, 0}, 1}};
    planes.scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{9.999, 0}, {10, 0.03}, {29, 0.03}}, {{0, {0, 0, 0}}});
    planes.scene.quality.stepVoxels = 0.25;
    planes.scene.quality.pixels.samples = 256;
    const glm::dvec4 mean = planes.mean();
    EXPECT_NEAR(mean.a, 1, 1e-5);
    EXPECT_NEAR(mean.g, std::exp(-2 * 0.03 * 20), 0.01); // from place 10.5 to 30.5 along z, half a voxel each
    EXPECT_NEAR(mean.r, 0, 1e-9);
}

/// Thin plates with nothing between them: ways leap to the next one, and not over it.
TEST(PathSurfaces, AreNotLeaptOver) {
    Planes plates([](const glm::dvec3& p) {
        double value = 0;
        for (const double at : {6.7, 41.9}) // near to what is empty: 8 to 40
            value = std::max(value, 1 - std::abs(p.z - at + 0.02 * p.x) / 1.5);
        return value;
    });
    plates.scene.surfaces = {{0.5, {0.9, 0.6, 0.3}, 0.3}};
    plates.scene.lighting.lights = {Planes::from({0.3, 0.2, -1}), Planes::from({-0.3, 0.4, 1})};
    plates.scene.lighting.transport->bounces = 4;
    const Image leaping = plates.draw();
    plates.scene.quality.skipping = false;
    const Image whole = plates.draw();
    std::size_t far = 0;
    for (std::size_t n = 0; n < whole.pixels.size(); ++n)
        far += glm::length(whole.pixels[n] - leaping.pixels[n]) > 1e-3f; // a root's last bits turn few paths
    EXPECT_LE(far, whole.pixels.size() / 100);
    EXPECT_GT(whole.pixels[0].g, 0.1f);
}

/// A preview's last way passes what would stop it: a white room is white after few scatterings. Others end in
/// it.
TEST(PathSurfaces, AreNoObstacleToAPreviewsLastWay) {
    Planes planes;
    planes.scene.surfaces = {{12, glm::dvec3(1), 0.3}, {20, glm::dvec3(1), 0.5}, {30, glm::dvec3(1), 1}};
    planes.scene.lighting.lights[0].intensity = 0;
    planes.scene.lighting.environment = Environment{Sky::uniform};
    planes.scene.lighting.transport->bounces = 3;
    EXPECT_LT(planes.mean().r, 0.95);
    for (const PathPreview preview : {PathPreview::few, PathPreview::squared}) {
        planes.scene.lighting.transport->preview = preview;
        EXPECT_NEAR(planes.mean().r, 1, 1e-4);
    }
}

TEST(PathSurfaces, NativeHasTheMirrorsBits) {
    for (const bool volume : {false, true})
        for (int camera = 0; camera < 2; ++camera) {
            SCOPED_TRACE(testing::Message() << volume << " " << camera);
            MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
            const StoreReader reader(storePath("torso"), ram);
            Scene scene = torsoScene(camera, volume, Integrator::midpoint, {20, 16});
            scene.lighting.lights = {Planes::from({0.5, -0.7, 0.6})};
            scene.lighting.lights[0].softness = 8;
            scene.lighting.environment = Environment{Sky::twoTone, 0.5};
            scene.lighting.transport = Transport{TransportResponse::physical, 6, {}, {}};
            scene.lighting.transport->surface = SurfaceScattering{{20, 150}, {0.1, 0.3, 0.3, 4}};
            scene.surfaces[0].finish = SurfaceFinish{0.05, 0.4, 0.8, 20};
            if (camera == 1)
                scene.lighting.transport->preview = PathPreview::squared;
            scene.quality.pixels = {4, PixelFilter::box, 3};
            const glm::dvec3 extent(reader.info().extentVoxels);
            if (camera == 1)
                scene.cuts.boxes = {{0.4 * extent, 0.6 * extent, CropBox::Space::voxels, Keep::outside}};
            const auto drawn = [&](EngineKind engine, int threads, bool skipping = true) {
                MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
                RenderOptions options;
                options.engine = engine;
                options.threads = threads;
                scene.quality.skipping = skipping;
                return renderScene(scene, reader, ram, gpu, options);
            };
            const RenderResult native = drawn(EngineKind::native, 2);
            EXPECT_GT(native.work.paths.paths, 100u);
            EXPECT_EQ(differing(native.image, drawn(EngineKind::mirror, 1).image), 0u);
            EXPECT_EQ(differing(native.image, drawn(EngineKind::native, 1).image), 0u);
            // Leaps begin pieces elsewhere: the same but for the last bits of a root.
            const Image whole = drawn(EngineKind::native, 2, false).image;
            double most = 0;
            std::size_t far = 0;
            for (std::size_t n = 0; n < whole.pixels.size(); ++n) {
                const double d = static_cast<double>(glm::length(whole.pixels[n] - native.image.pixels[n]));
                most = std::max(most, d), far += d > 1e-3;
            }
            EXPECT_LT(far, whole.pixels.size() / 50) << most;
        }
}

TEST(PathSurfaces, AreRefusedWhereTheyAreNotDrawn) {
    Planes planes;
    planes.scene.surfaces = {{20, glm::dvec3(1), 1}};
    const auto refused = [&](EngineKind engine) -> std::string {
        try {
            planes.draw(engine);
        } catch (const InputError& e) {
            return e.what();
        }
        return "drawn";
    };
    EXPECT_THAT(refused(EngineKind::reference),
                HasSubstr("native or mirror for paths of light among isosurfaces"));
    planes.scene.lighting.transport->response = TransportResponse::contract;
    planes.scene.lighting.transport->surface.reset();
    EXPECT_THAT(refused(EngineKind::native), HasSubstr("no isosurfaces beside response \"contract\""));
}

} // namespace
} // namespace tessera
