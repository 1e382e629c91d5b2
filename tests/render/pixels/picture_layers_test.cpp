// tests/render/pixels/picture_layers_test.cpp: layers of pictures by paths of light: closed forms, engines'
// bits, what is not asked for, and pictures that go on from kept samples.
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "render/picture/render_scene.h"
#include "render/pixels/kept_samples.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr double kStep = 1.0 / 16; // voxels
const glm::vec3 kAlbedo(0.8f, 0.3f, 0.1f);

Scene lit(Scene scene, int samples = 4) {
    Light sun;
    sun.kind = LightKind::directional;
    sun.direction = {0.5, 0.7, 0.6};
    scene.lighting.lights = {sun};
    scene.lighting.transport = Transport{TransportResponse::physical, 3, {}, {}};
    scene.lighting.environment = Environment{Sky::uniform, 0.5};
    scene.quality.pixels = {samples, PixelFilter::box, 3};
    return scene;
}

RenderResult drawn(const Scene& scene, const StoreReader& store, EngineKind engine, LayersAsked layers,
                   KeptSamples* kept = nullptr, MemoryBudget* most = nullptr,
                   LevelChoice levels = LevelChoice::perBrick) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", ram.limitBytes());
    RenderOptions options;
    options.engine = engine;
    options.threads = 2;
    options.layers = layers;
    options.kept = kept;
    options.levels = levels;
    return renderScene(scene, store, most ? *most : ram, gpu, options);
}

/// Of one colour, and as good as opaque from the plane z = 20 voxels on, of a sheared volume.
struct HalfSpace {
    static constexpr double kPlane = 20;
    HalfSpace() : reader(stored.scene({}).volumes[0].path, ram) {}
    Scene scene(int camera, int samples) const {
        Scene scene = stored.scene({}, camera, 12);
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
            {{kPlane - 0.001, 0}, {kPlane, 1000}, {100, 1000}}, {{0, glm::dvec3(kAlbedo)}});
        scene.quality.stepVoxels = kStep;
        if (camera == 0) {
            Camera& eye = std::get<Camera>(scene.camera);
            eye.focalPoint = glm::dvec3(stored.info.patientFromVoxel * glm::dvec4(24, 24, kPlane, 1));
            eye.position = eye.focalPoint - glm::dvec3(20, 10, 120);
            eye.viewAngle = 6;
        }
        return lit(scene, samples);
    }
    glm::dvec3 normal() const {
        const glm::dmat3 linear(stored.info.patientFromVoxel);
        return glm::normalize(glm::transpose(glm::inverse(linear)) * glm::dvec3(0, 0, 1));
    }

    // Voxel i has its centre at i + 1/2.
    Stored stored{[](const glm::dvec3& v) { return v.z; }, {48, 48, 40}, false};
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    StoreReader reader;
};

TEST(PictureLayers, AreThoseOfAPlane) {
    HalfSpace half;
    const Scene scene = half.scene(0, 16);
    const Camera& eye = std::get<Camera>(scene.camera);
    const RenderResult result =
        drawn(scene, half.reader, EngineKind::native, {true, true}, nullptr, nullptr,
              LevelChoice::finest); // coarse ones have this field, too, by longer steps
    ASSERT_TRUE(result.layers);
    const glm::dvec3 normal = half.normal();
    const glm::dvec3 on(half.stored.info.patientFromVoxel * glm::dvec4(24, 24, HalfSpace::kPlane, 1));
    const RayPlane plane = rayPlane(eye, half.stored.info, scene.imageSize);
    std::size_t whole = 0;
    for (int y = 0; y < scene.imageSize.y; ++y)
        for (int x = 0; x < scene.imageSize.x; ++x) {
            const glm::vec4 colour = result.image.at(x, y), albedo = result.layers->albedo.at(x, y),
                            found = result.layers->normal.at(x, y);
            EXPECT_EQ(albedo.a, colour.a) << "alpha of the layers is the colour's";
            if (!(colour.a > 0.999f))
                continue;
            ++whole;
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(albedo[c], kAlbedo[c] * colour.a, 1e-3f);
                EXPECT_NEAR(found[c],
                            static_cast<double>(colour.a) *
                                (glm::dot(normal, eye.position - on) > 0 ? normal[c] : -normal[c]),
                            2e-3);
            }
            const PatientRay ray = pixelRay(plane, {x + 0.5, y + 0.5}, scene.imageSize);
            const double along =
                glm::dot(normal, on - eye.position) / glm::dot(normal, glm::normalize(ray.direction));
            EXPECT_NEAR(found.a, along, 0.1) << "mm";
        }
    EXPECT_GT(whole, 50u) << "nothing is tested";
}

/// An opaque plane is where it is to an eighth of a segment, wherever the segments' middles are.
TEST(PictureLayers, DepthIsFinerThanSteps) {
    HalfSpace half;
    for (const EngineKind engine : {EngineKind::native, EngineKind::mirror}) {
        Scene scene = half.scene(0, 1);
        scene.quality.stepVoxels = 2;
        const Camera& eye = std::get<Camera>(scene.camera);
        const RenderResult result =
            drawn(scene, half.reader, engine, {true, false}, nullptr, nullptr, LevelChoice::finest);
        const glm::dmat4& patientFromVoxel = half.stored.info.patientFromVoxel;
        const glm::dvec3 normal = half.normal(),
                         on(patientFromVoxel * glm::dvec4(24, 24, HalfSpace::kPlane, 1));
        const RayPlane plane = rayPlane(eye, half.stored.info, scene.imageSize);
        std::size_t whole = 0;
        double least = 1e9, most = -1e9;
        for (int y = 0; y < scene.imageSize.y; ++y)
            for (int x = 0; x < scene.imageSize.x; ++x) {
                const glm::vec4 found = result.layers->normal.at(x, y);
                if (!(result.image.at(x, y).a > 0.999f))
                    continue;
                ++whole;
                // A sample's place within its pixel is not known: planes of depth are told by the pixel's
                // middle.
                const PatientRay ray = pixelRay(plane, {x + 0.5, y + 0.5}, scene.imageSize);
                const glm::dvec3 way = glm::normalize(ray.direction);
                const double behind =
                    double{found.a} - glm::dot(normal, on - eye.position) / glm::dot(normal, way);
                const double stepMm = 2 / glm::length(glm::inverse(glm::dmat3(patientFromVoxel)) * way);
                least = std::min(least, behind / stepMm), most = std::max(most, behind / stepMm);
            }
        EXPECT_GT(whole, 50u) << "nothing is tested";
        EXPECT_LT(most, 0.2) << "steps";
        EXPECT_GT(least, -0.2) << "steps";
    }
}

/// Along the view, from the camera's position.
TEST(PictureLayers, DepthOfAParallelPictureIsAlongItsView) {
    VolumeInfo info;
    info.patientFromVoxel = glm::dmat4(2);
    info.patientFromVoxel[3][3] = 1;
    Camera camera;
    camera.projection = Projection::parallel;
    camera.position = {0, 0, -10};
    camera.focalPoint = {0, 0, 5};
    EXPECT_DOUBLE_EQ(depthMm(camera, info, {7, 9, 3}), 16);
    camera.projection = Projection::perspective;
    EXPECT_DOUBLE_EQ(depthMm(camera, info, {4, 6, 3}), std::sqrt(8.0 * 8 + 12 * 12 + 16 * 16));
}

/// Of two samples, one of which sees half of a place and the other nothing, albedo and normal are like the
/// colour, and depth is that of what is seen.
TEST(PictureLayers, AreMeansOverSamplesAndDepthOfWhatIsSeen) {
    PictureLayers::OfRays means = {Image({2, 1}), Image({2, 1})};
    means[0].pixels[0] = {0.25f * kAlbedo, 0.25f};
    means[1].pixels[0] = {0, 0, 0.25f, 0.25f * 300};
    const PictureLayers layers(std::move(means));
    EXPECT_EQ(layers.albedo.pixels[0], glm::vec4(0.25f * kAlbedo, 0.25f));
    EXPECT_EQ(layers.normal.pixels[0], glm::vec4(0, 0, 0.25f, 300));
    EXPECT_EQ(layers.normal.pixels[1], glm::vec4(0)) << "nothing is seen";
}

std::vector<Scene> torsoScenes(const VolumeInfo& info) {
    std::vector<Scene> scenes;
    for (const int camera : {0, 1, 2})
        scenes.push_back(lit(sceneOn(info, camera == 1 ? "soft-tissue" : "bone-1", camera, {24, 18})));
    scenes.push_back(scenes[0]);
    scenes.back().quality.pixels.samples = 1;
    scenes.push_back(scenes[0]);
    scenes.back().lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    const glm::dvec3 extent(info.extentVoxels);
    scenes.back().cuts.boxes = {{0.1 * extent, 0.8 * extent, CropBox::Space::voxels, Keep::inside},
                                {0.4 * extent, 0.6 * extent, CropBox::Space::voxels, Keep::outside}};
    scenes.push_back(scenes[0]);
    scenes.back().lighting.transport = Transport{TransportResponse::contract};
    scenes.back().lighting.environment.reset();
    scenes.push_back(scenes[0]);
    scenes.back().shading.gradient = Gradient::cubic;
    return scenes;
}

void expectSameLayers(const RenderResult& a, const RenderResult& b) {
    ASSERT_TRUE(a.layers && b.layers);
    EXPECT_EQ(differing(a.layers->albedo, b.layers->albedo), 0u);
    EXPECT_EQ(differing(a.layers->normal, b.layers->normal), 0u);
    ASSERT_EQ(a.pixelErrors.has_value(), b.pixelErrors.has_value());
    if (a.pixelErrors) {
        EXPECT_EQ(differing(*a.pixelErrors, *b.pixelErrors), 0u);
    }
}

/// And the picture with layers is that without.
TEST(PictureLayers, NativeHasTheMirrorsBits) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader reader(storePath("torso"), ram);
    int number = 0;
    for (const Scene& scene : torsoScenes(reader.info())) {
        SCOPED_TRACE("scene " + std::to_string(number++));
        const RenderResult mirror = drawn(scene, reader, EngineKind::mirror, {true, true});
        const RenderResult native = drawn(scene, reader, EngineKind::native, {true, true});
        EXPECT_FALSE(isBlank(native.layers->albedo));
        expectSameLayers(native, mirror);
        const RenderResult plain = drawn(scene, reader, EngineKind::native, {});
        EXPECT_FALSE(plain.layers || plain.pixelErrors);
        EXPECT_EQ(differing(native.image, plain.image), 0u);
        EXPECT_EQ(native.work.paths.lookUps, plain.work.paths.lookUps);
    }
}

TEST(PictureLayers, ErrorsAreThoseThatTheReportTells) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader reader(storePath("torso"), ram);
    Scene scene = lit(sceneOn(reader.info(), "soft-tissue", 0, {24, 18}), 16);
    for (const bool transport : {true, false}) {
        if (!transport)
            scene.lighting.transport.reset();
        const RenderResult result = drawn(scene, reader, EngineKind::native, {false, true});
        EXPECT_FALSE(result.layers);
        ASSERT_TRUE(result.pixelErrors && result.pixels.error);
        double squares = 0;
        std::size_t shown = 0;
        for (std::size_t i = 0; i < result.image.pixels.size(); ++i)
            if (result.image.pixels[i].a > 1.0f / 255) {
                for (int c = 0; c < 4; ++c)
                    squares += std::pow(static_cast<double>(result.pixelErrors->pixels[i][c]), 2);
                ++shown;
            }
        EXPECT_GT(result.pixels.error->rms, 1e-4);
        EXPECT_NEAR(std::sqrt(squares / 4 / static_cast<double>(shown)), result.pixels.error->rms, 1e-6);
    }
}

/// Memory is counted, and where no layers are asked for none is taken for them.
TEST(PictureLayers, TakeTheMemoryThatIsCounted) {
    MemoryBudget own("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader reader(storePath("torso"), own);
    const Scene scene = lit(sceneOn(reader.info(), "bone-1", 0, {64, 48}));
    std::size_t peaks[2] = {};
    for (const bool layers : {false, true}) {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        drawn(scene, reader, EngineKind::native, {layers, layers}, nullptr, &ram);
        peaks[layers] = ram.peakBytes();
    }
    EXPECT_EQ(peaks[1] - peaks[0], 64 * 48 * (PictureLayers::bytesPerPixel(4) + sizeof(glm::vec4)));
}

/// With its layers, by either engine, from a state that either kept.
TEST(PictureLayers, GoOnFromKeptSamplesToTheSameBits) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader reader(storePath("torso"), ram);
    Scene scene = lit(sceneOn(reader.info(), "bone-1", 0, {24, 18}), 40);
    const RenderResult whole = drawn(scene, reader, EngineKind::native, {true, true});
    const ScratchFolder folder;
    for (const int before : {2, 8, 20, 40}) {
        const std::filesystem::path path = folder / ("kept" + std::to_string(before));
        scene.quality.pixels.samples = before;
        KeptSamples first(path, {{"scene", "1"}});
        drawn(scene, reader, EngineKind::mirror, {true, true}, &first);
        scene.quality.pixels.samples = 40;
        KeptSamples second(path, {{"scene", "1"}});
        const RenderResult rest = drawn(scene, reader, EngineKind::native, {true, true}, &second);
        EXPECT_EQ(rest.pixels.ofEarlierRuns, 1 << static_cast<int>(std::log2(before)));
        EXPECT_EQ(rest.pixels.taken, 40);
        EXPECT_LT(rest.work.paths.paths, whole.work.paths.paths);
        EXPECT_EQ(differing(rest.image, whole.image), 0u) << before;
        expectSameLayers(rest, whole);
        scene.quality.stepVoxels = 0.25; // of what the plan decides
        KeptSamples third(path, {{"scene", "1"}});
        EXPECT_THROW(drawn(scene, reader, EngineKind::native, {true, true}, &third), InputError);
        scene.quality.stepVoxels = 0.5;
    }
}

} // namespace
} // namespace tessera
