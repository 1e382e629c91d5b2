// Pictures by paths of light: engines' bits, closed forms through stores and cameras, noise that is told, and
// what is refused.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/support/graded.h"
#include "tests/support/labelled.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;
using ::testing::HasSubstr;

Light sun(double softness = 8) {
    Light light;
    light.kind = LightKind::directional;
    light.direction = {0.5, 0.7, 0.6};
    light.softness = softness;
    return light;
}

Transport physical(int bounces, const Phase& phase = {}) {
    return {TransportResponse::physical, bounces, phase, {}};
}

Scene lit(Scene scene, int bounces = 4) {
    scene.lighting.lights = {sun()};
    scene.lighting.transport = physical(bounces, {PhaseKind::henyeyGreenstein, 0.3});
    scene.lighting.environment = Environment{Sky::twoTone, 0.5};
    scene.quality.pixels = {4, PixelFilter::box, 3};
    return scene;
}

/// Light from all around by a file, as if it had been read: a dim sky with a sun.
Scene underFile(Scene scene) {
    std::vector<glm::vec3> texels(128 * 64, glm::vec3(0.2f, 0.3f, 0.5f));
    texels[20 * 128 + 70] = glm::vec3(900, 800, 500);
    Environment& sky = scene.lighting.environment.emplace();
    sky.file = {"sky.exr", std::make_shared<const EnvironmentMap>(glm::ivec2(128, 64), std::move(texels))};
    sky.rotation = 20;
    return scene;
}

RenderResult drawn(const Scene& scene, const StoreReader& store, MemoryBudget& ram, EngineKind engine,
                   int threads = 2, std::size_t gpuBytes = std::size_t{256} << 20) {
    MemoryBudget gpu("GPU memory", "--gpu-memory", gpuBytes);
    RenderOptions options;
    options.engine = engine;
    options.threads = threads;
    RenderResult result = renderScene(scene, store, ram, gpu, options);
    EXPECT_LE(ram.peakBytes(), ram.limitBytes());
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    EXPECT_EQ(result.work.paths.exceeded, 0u);
    return result;
}

struct Torso {
    Torso() : reader(storePath("torso"), ram) {}
    Scene scene(const std::string& preset, int camera = 0, glm::ivec2 size = {32, 24}) const {
        return sceneOn(reader.info(), preset, camera, size);
    }
    RenderResult draw(const Scene& scene, EngineKind engine, int threads = 2,
                      std::size_t gpuBytes = std::size_t{256} << 20) {
        return drawn(scene, reader, ram, engine, threads, gpuBytes);
    }
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    StoreReader reader;
};

/// Labels of every look, some of them hidden, gradient opacity and media of labels.
Scene labelledScene(const Torso& torso, const BallsOfLabels& labels, LabelLook look, bool grades) {
    Scene scene = lit(torso.scene("soft-tissue", 1));
    if (grades)
        grade(scene);
    label(scene, labels.store, look);
    scene.volumes[0].labels.hide = {"two"};
    scene.volumes[0].labels.each = {{"40", LabelLook::plain, 0.5, {}},
                                    {"3", LabelLook::tint, {}, glm::dvec3(0, 1, 0)},
                                    {"7", LabelLook::solid, 0.05, {}}};
    return scene;
}

/// Cut by what rays are clipped to, and by what leaves several parts of them.
Scene cutScene(const Torso& torso, const BallsOfLabels& labels, bool parts) {
    Scene scene = labelledScene(torso, labels, LabelLook::solid, true);
    const glm::dvec3 extent(torso.reader.info().extentVoxels);
    scene.cuts.boxes = {{0.1 * extent, 0.8 * extent, CropBox::Space::voxels, Keep::inside}};
    const glm::dvec3 middle(torso.reader.info().patientFromVoxel * glm::dvec4(0.5 * extent, 1));
    scene.cuts.planes = {{middle, {0.2, 1, 0.3}, Keep::inside}};
    scene.lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    if (parts) {
        scene.cuts.boxes.push_back({0.4 * extent, 0.6 * extent, CropBox::Space::voxels, Keep::outside});
        scene.cuts.scissors = {
            {std::get<Camera>(scene.camera), 4.0 / 3, {{0.2, 0.2}, {0.7, 0.4}, {0.4, 0.9}}, Keep::outside}};
    }
    return scene;
}

/// Lamps in tissue and at the eye, tissue that glows, Rayleigh's function, and nothing around.
Scene lampsInTissue(const Torso& torso) {
    Scene scene = lit(torso.scene("bone-1"), 3);
    auto function = TransferFunction::fromExtinction({{-300, 0}, {200, 0.03}, {1500, 0.3}},
                                                     {{-300, {0.9, 0.3, 0.2}}, {800, {0.9, 0.9, 0.7}}});
    function.setMaterials({{250, 900, 0.3, 0.7, 0.2, 20, {0.2, 0.05, 0}}});
    function.setTissues({{200, 600, Phase{PhaseKind::schlick, 0.5}, SurfaceFinish{0.2, 0.2}}});
    scene.volumes[0].transferFunction = function;
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    const glm::dvec3 extent(torso.reader.info().extentVoxels);
    lamp.position =
        glm::dvec3(torso.reader.info().patientFromVoxel * glm::dvec4(extent * glm::dvec3(0.5, 0.3, 0.5), 1));
    lamp.attenuation = {1, 0.01, 0.001};
    scene.lighting.lights = {Light{}, lamp};
    scene.lighting.environment.reset();
    scene.lighting.transport->phase = {PhaseKind::rayleigh};
    scene.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
    scene.lighting.transport->colours = TransportColours::reflectance;
    return scene;
}

std::vector<Scene> manyScenes(const Torso& torso, const BallsOfLabels& labels) {
    std::vector<Scene> scenes;
    for (int camera = 0; camera < 3; ++camera)
        scenes.push_back(lit(torso.scene(camera == 1 ? "soft-tissue" : "bone-1", camera)));
    scenes.push_back(lit(torso.scene("lung")));
    grade(scenes.back());
    scenes.push_back(lit(torso.scene("bone-1")));
    label(scenes.back(), labels.store);
    scenes.push_back(labelledScene(torso, labels, LabelLook::tint, true));
    scenes.push_back(labelledScene(torso, labels, LabelLook::plain, false));
    scenes.back().volumes[0].labels.show = {"group:pair", "5", "6", "7"};
    scenes.push_back(cutScene(torso, labels, false));
    scenes.push_back(cutScene(torso, labels, true));
    scenes.push_back(lit(torso.scene("bone-1"), 1));
    scenes.back().quality.skipping = false;
    scenes.push_back(lit(torso.scene("soft-tissue")));
    scenes.back().lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    scenes.push_back(lit(torso.scene("soft-tissue", 1)));
    scenes.back().lighting.transport->surface = SurfaceScattering{{10, 60}, {0.1, 0.3, 0.6, 12}};
    scenes.push_back(lit(torso.scene("skin")));
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.position = {10, 20, 30};
    lamp.attenuation = {1, 0.01, 0.001};
    scenes.back().lighting.lights = {Light{}, lamp};
    scenes.back().lighting.transport->phase = {PhaseKind::rayleigh};
    scenes.push_back(underFile(lit(torso.scene("soft-tissue", 2))));
    scenes.back().lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    scenes.push_back(underFile(cutScene(torso, labels, true)));
    scenes.push_back(lit(torso.scene("bone-1")));
    scenes.back().lighting.environment->sky = Sky::softboxes;
    scenes.push_back(cutScene(torso, labels, false));
    scenes.back().lighting.transport->normals = ScatteringNormals::sobel;
    for (const PathPreview preview : {PathPreview::few, PathPreview::squared}) {
        scenes.push_back(cutScene(torso, labels, true));
        scenes.back().lighting.transport->preview = preview;
    }
    return scenes;
}

std::string refused(const Scene& scene, EngineKind engine = EngineKind::native) {
    Torso torso;
    try {
        torso.draw(scene, engine);
    } catch (const InputError& e) {
        return e.what();
    }
    return "drawn";
}

TEST(PathPicture, NativeHasTheMirrorsBits) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    int number = 0;
    for (const Scene& scene : manyScenes(torso, labels)) {
        SCOPED_TRACE("scene " + std::to_string(number++));
        const RenderResult mirror = torso.draw(scene, EngineKind::mirror);
        EXPECT_FALSE(isBlank(mirror.image));
        EXPECT_GT(mirror.work.paths.paths, 0u);
        for (const int threads : {1, 2}) {
            const RenderResult native = torso.draw(scene, EngineKind::native, threads);
            EXPECT_EQ(native.bricksOfLevel, mirror.bricksOfLevel);
            EXPECT_EQ(differing(native.image, mirror.image), 0u);
            EXPECT_EQ(native.work.paths.lookUps, mirror.work.paths.lookUps);
            EXPECT_EQ(native.work.paths.paths, mirror.work.paths.paths);
            EXPECT_EQ(native.work.paths.alone, 0u) << "slow";
        }
    }
}

/// By lanes of every set of instructions that the processor has.
TEST(PathPicture, HasTheSameBitsWithEveryInstructionSet) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    const Scene scene = labelledScene(torso, labels, LabelLook::solid, true);
    const Image mirror = torso.draw(scene, EngineKind::mirror).image;
    for (const native::PacketTarget* target : nativeTargets()) {
        ASSERT_EQ(setenv("TESSERA_INSTRUCTIONS", target->name, 1), 0);
        EXPECT_EQ(differing(torso.draw(scene, EngineKind::native).image, mirror), 0u) << target->name;
    }
    unsetenv("TESSERA_INSTRUCTIONS");
}

/// What lanes do not know goes one by one, and is told.
TEST(PathPicture, TellsWhatGoesOneByOne) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    Scene linear = lit(torso.scene("bone-1")), analytic = linear, response = linear;
    linear.quality.integrator = Integrator::linear;
    analytic.shading.gradient = Gradient::analytic;
    response.lighting.transport = Transport{TransportResponse::contract};
    response.lighting.environment.reset();
    Scene cut = response;
    cut.cuts = cutScene(torso, labels, true).cuts;
    for (const Scene& scene : {linear, analytic, response, cut}) {
        const RenderResult native = torso.draw(scene, EngineKind::native);
        EXPECT_GT(native.work.paths.paths, 0u);
        EXPECT_EQ(native.work.paths.alone, native.work.paths.paths);
        EXPECT_EQ(differing(native.image, torso.draw(scene, EngineKind::mirror).image), 0u);
    }
}

/// Smooth normals are those that Sobel's operator gives shading; opacity by gradient keeps that of shading.
TEST(PathPicture, ScattersBySmoothNormals) {
    Torso torso;
    Scene own = lit(torso.scene("bone-1", 1, {16, 12}), 2);
    own.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
    Scene smooth = own, graded = own;
    own.shading.gradient = Gradient::sobel;
    smooth.lighting.transport->normals = ScatteringNormals::sobel;
    grade(graded);
    Scene gradedSmooth = graded;
    gradedSmooth.lighting.transport->normals = ScatteringNormals::sobel;
    for (const EngineKind engine : {EngineKind::mirror, EngineKind::native, EngineKind::reference}) {
        SCOPED_TRACE(static_cast<int>(engine));
        EXPECT_EQ(differing(torso.draw(smooth, engine).image, torso.draw(own, engine).image), 0u);
        const Image other = torso.draw(gradedSmooth, engine).image, plain = torso.draw(graded, engine).image;
        EXPECT_GT(differing(other, plain), 0u) << "nothing is tested";
        for (std::size_t n = 0; n < other.pixels.size(); ++n)
            ASSERT_EQ(other.pixels[n].a, plain.pixels[n].a);
    }
}

/// Tissue of all values scatters as a scene whose own phase function and finish are the tissue's: from the
/// first scattering on, which rays begin, to the last.
TEST(PathPicture, TissueOfAllValuesIsTheScenesOwn) {
    Torso torso;
    const Phase phase{PhaseKind::henyeyGreenstein, 0.8};
    const SurfaceFinish finish{0.6, 0.4};
    for (const int bounces : {1, 3}) {
        auto function = TransferFunction::fromExtinction({{-300, 0}, {200, 0.03}, {1500, 0.3}},
                                                         {{-300, {0.9, 0.3, 0.2}}, {800, {0.9, 0.9, 0.7}}});
        Scene without = lit(torso.scene("bone-1", 1, {16, 12}), bounces);
        without.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
        without.lighting.transport->colours = TransportColours::reflectance;
        without.volumes[0].transferFunction = function;
        Scene own = without, other = without;
        own.lighting.transport->phase = phase;
        own.lighting.transport->surface->finish = finish;
        function.setTissues({{-5000, 50000, phase, finish}});
        other.volumes[0].transferFunction = function;
        for (const EngineKind engine : {EngineKind::mirror, EngineKind::native, EngineKind::reference}) {
            SCOPED_TRACE(static_cast<int>(engine));
            const Image image = torso.draw(own, engine).image;
            EXPECT_EQ(differing(torso.draw(other, engine).image, image), 0u);
            EXPECT_GT(differing(torso.draw(without, engine).image, image), 0u) << "nothing is tested";
        }
    }
}

/// Of themselves, they go side by side, whatever the transfer function.
TEST(PathPicture, TakesTheMidpointRuleWhereNoneIsNamed) {
    Torso torso;
    Scene scene = lit(torso.scene("bone-1"));
    scene.quality.integrator = Integrator::automatic;
    scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{199, 0}, {200, 0.5}, {201, 0}}, {{0, glm::dvec3(0.8)}}, 0.01);
    const RenderResult paths = torso.draw(scene, EngineKind::native);
    EXPECT_EQ(paths.integrator, Integrator::midpoint);
    EXPECT_EQ(paths.work.paths.alone, 0u);
    scene.lighting = {};
    EXPECT_NE(torso.draw(scene, EngineKind::native).integrator, Integrator::midpoint) << "nothing is tested";
}

/// Behind a shell, tissue whose gradient opacity is nothing adds segments of no opacity.
TEST(PathPicture, EndsWhereOpacityIsNothing) {
    Torso torso;
    Scene scene = lit(torso.scene("soft-tissue"));
    TransferFunction function =
        TransferFunction::fromOpacity({{-800, 0.5}, {2000, 0.9}}, {{0, glm::dvec3(0.8)}}, 1);
    function.setGradientOpacity(GradientOpacity::fromPoints({{0, 0}, {200, 0}, {200.5, 1}}));
    scene.volumes[0].transferFunction = function;
    const Image native = torso.draw(scene, EngineKind::native).image;
    for (const glm::vec4& pixel : native.pixels)
        for (int c = 0; c < 4; ++c)
            ASSERT_TRUE(std::isfinite(pixel[c]));
    EXPECT_EQ(differing(native, torso.draw(scene, EngineKind::mirror).image), 0u);
}

TEST(PathPicture, NativeHasTheMirrorsBitsWhereLevelsMix) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    const std::size_t small = std::size_t{3} << 20;
    Scene graded = lit(torso.scene("bone-1"));
    grade(graded);
    Scene smooth = graded;
    smooth.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
    smooth.lighting.transport->normals = ScatteringNormals::sobel;
    for (const Scene& scene : {lit(torso.scene("bone-1")), graded, cutScene(torso, labels, true), smooth}) {
        const RenderResult native = torso.draw(scene, EngineKind::native, 2, small);
        std::size_t levels = 0;
        for (const std::size_t bricks : native.bricksOfLevel)
            levels += bricks > 0;
        EXPECT_GT(levels, 2u) << "nothing is tested";
        EXPECT_EQ(native.work.paths.alone, 0u);
        EXPECT_EQ(differing(native.image, torso.draw(scene, EngineKind::mirror, 2, small).image), 0u);
    }
}

TEST(PathPicture, IsTheSameWithoutSkipping) {
    Torso torso;
    Scene scene = lit(torso.scene("bone-1"));
    const Image leaping = torso.draw(scene, EngineKind::native).image;
    scene.quality.skipping = false;
    EXPECT_EQ(differing(torso.draw(scene, EngineKind::native).image, leaping), 0u);
}

/// Rays see what they saw: alpha has no noise.
TEST(PathPicture, HasTheOpacityOfThePictureWithoutLight) {
    Torso torso;
    const Scene scene = lit(torso.scene("soft-tissue"));
    Scene plain = scene;
    plain.lighting = {};
    plain.shading.on = false;
    const Image paths = torso.draw(scene, EngineKind::native).image,
                unlit = torso.draw(plain, EngineKind::native).image;
    for (std::size_t n = 0; n < paths.pixels.size(); ++n)
        ASSERT_EQ(paths.pixels[n].a, unlit.pixels[n].a);
}

/// White tissue under a sky that is the same everywhere cannot be told from the sky, whatever its shape.
TEST(PathPicture, IsWhiteInAFurnace) {
    Torso torso;
    Scene scene = torso.scene("bone-1");
    scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{-500, 0}, {0, 0.002}, {300, 0.02}, {1500, 0.05}}, {}, 1);
    scene.lighting.lights = {sun()};
    scene.lighting.lights[0].intensity = 0;
    scene.lighting.transport = physical(256, {PhaseKind::henyeyGreenstein, -0.2});
    scene.lighting.environment = Environment{};
    scene.quality.pixels = {16, PixelFilter::box, 3};
    const Image image = torso.draw(scene, EngineKind::native).image;
    double light = 0, alpha = 0;
    for (const glm::vec4& pixel : image.pixels)
        light += static_cast<double>(pixel.g), alpha += static_cast<double>(pixel.a);
    EXPECT_GT(alpha, 0.2 * static_cast<double>(image.pixels.size()));
    EXPECT_NEAR(light / alpha, 1, 0.01);
}

/// Tissue of albedo a that sends e by itself, under a sky of e / (1 - a): light is the same everywhere.
TEST(PathPicture, GlowsInBalanceWithItsSky) {
    Torso torso;
    Scene scene = torso.scene("bone-1");
    TransferFunction function = TransferFunction::fromOpacity({{-500, 0}, {0, 0.01}, {300, 0.1}, {1500, 0.3}},
                                                              {{0, glm::dvec3(0.6)}}, 1);
    Material glow;
    glow.from = -3000, glow.to = 30000;
    glow.emission = {0.2, 0.1, 0};
    function.setMaterials({glow});
    scene.volumes[0].transferFunction = function;
    scene.lighting.transport = physical(256);
    scene.lighting.lights = {sun()};
    scene.lighting.lights[0].intensity = 0;
    scene.lighting.environment = Environment{Sky::uniform, 0.5, {1, 0.5, 0}};
    scene.quality.pixels = {16, PixelFilter::box, 3};
    const Image image = torso.draw(scene, EngineKind::native).image;
    glm::dvec4 sum(0);
    for (const glm::vec4& pixel : image.pixels)
        sum += glm::dvec4(pixel);
    EXPECT_GT(sum.a, 0.2 * static_cast<double>(image.pixels.size()));
    EXPECT_NEAR(sum.r / sum.a, 0.5, 0.005);
    EXPECT_NEAR(sum.g / sum.a, 0.25, 0.0025);
    EXPECT_EQ(sum.b, 0);
}

struct Mean {
    double mean = 0, error = 0; // and its standard error
};
/// Red, over all pixels.
Mean meanOf(const Image& image) {
    double sum = 0, squares = 0;
    for (const glm::vec4& pixel : image.pixels)
        sum += static_cast<double>(pixel.r), squares += std::pow(static_cast<double>(pixel.r), 2);
    const auto count = static_cast<double>(image.pixels.size());
    return {sum / count, std::sqrt((squares / count - std::pow(sum / count, 2)) / count)};
}

/// A slab of one extinction and sheared voxels, seen and lit along slanted ways, that scatters once.
struct Slab {
    static constexpr double kDensity = 0.08, kAlbedo = 0.6; // per mm
    Slab() : reader(stored.scene({}).volumes[0].path, ram), scene(stored.scene({})) {
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, kDensity}, {2, kDensity}}, {{0, glm::dvec3(kAlbedo)}});
        scene.imageSize = {16, 16};
        Camera camera;
        camera.projection = Projection::parallel;
        camera.focalPoint = glm::dvec3(stored.info.patientFromVoxel * glm::dvec4(48, 48, 12, 1));
        camera.position = camera.focalPoint + 200.0 * glm::normalize(glm::dvec3(0.3, -0.2, -1));
        camera.viewUp = {0, 1, 0};
        camera.parallelScale = 4;
        scene.camera = camera;
        Light light;
        light.kind = LightKind::directional;
        light.frame = LightFrame::patient;
        light.direction = {-0.4, 0.1, -1};
        light.intensity = 2;
        scene.lighting.lights = {light};
        scene.lighting.transport = physical(1, {PhaseKind::henyeyGreenstein, 0.5});
        scene.quality.pixels = {256, PixelFilter::box, 3};
    }
    Mean drawnMean(EngineKind engine = EngineKind::native) {
        return meanOf(drawn(scene, reader, ram, engine).image);
    }
    /// The closed form, of a thickness in voxels, in however many layers.
    double expected(double thickness) const {
        const Camera& camera = std::get<Camera>(scene.camera);
        const glm::dvec3 travel = glm::normalize(camera.focalPoint - camera.position);
        const double depth = thickness * 1.5 * kDensity, mu = travel.z;
        double sum = 0;
        for (const Light& light : scene.lighting.lights) {
            const glm::dvec3 towards = glm::normalize(light.direction);
            const double mu0 = -towards.z;
            const double phase = static_cast<double>(
                phaseOf(scene.lighting.transport->phase, static_cast<float>(glm::dot(travel, towards))));
            sum += kAlbedo * phase * M_PI * light.intensity * mu0 / (mu + mu0) *
                   -std::expm1(-depth * (1 / mu + 1 / mu0));
        }
        return sum;
    }

    Stored stored{[](const glm::dvec3&) { return 1.0; }, {96, 96, 24}, false};
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    StoreReader reader;
    Scene scene;
};

TEST(PathPicture, ScattersOnceInASlabAsTheClosedForm) {
    Slab slab;
    const Mean many = slab.drawnMean();
    const double expected = slab.expected(24);
    EXPECT_NEAR(many.mean, expected, 4 * many.error + 1e-3 * expected);
    EXPECT_LT(many.error, 5e-3 * expected);
    slab.scene.quality.pixels.samples = 16; // errors of strata fall faster than the root of their number
    const Mean few = slab.drawnMean();
    EXPECT_NEAR(few.mean, expected, 4 * few.error + 1e-3 * expected);
    EXPECT_GT(few.error / many.error, 5);
}

/// One of several lights is drawn for every scattering: all count as they are.
TEST(PathPicture, EveryLightCountsInASlab) {
    Slab slab;
    Light light = slab.scene.lighting.lights[0];
    for (const glm::dvec3& direction : {glm::dvec3(0.7, 0.3, -0.2), glm::dvec3(0.1, -0.6, -0.9)}) {
        light.direction = direction;
        light.intensity *= 0.4;
        light.softness = 3;
        slab.scene.lighting.lights.push_back(light);
    }
    slab.scene.lighting.transport->phase.g = 0.8; // much of one, little of another
    const Mean mean = slab.drawnMean();
    const double expected = slab.expected(24);
    EXPECT_NEAR(mean.mean, expected, 4 * mean.error + 4e-3 * expected);
    EXPECT_LT(mean.error, 0.01 * expected);
}

/// Tissue that cuts take away neither scatters nor casts a shadow: in one kept layer, in one that others are
/// taken from, and in two with a gap between them.
TEST(PathPicture, CutTissueIsNotThere) {
    const auto layer = [](double from, double to, Keep keep) {
        return CropBox{{-50, -50, from}, {200, 200, to}, CropBox::Space::voxels, keep};
    };
    const struct {
        std::vector<CropBox> boxes;
        double thickness;
    } cases[] = {{{layer(4, 9, Keep::inside)}, 5},
                 {{layer(-9, 4, Keep::outside), layer(9, 40, Keep::outside)}, 5},
                 {{layer(6.5, 20, Keep::outside)}, 10.5}};
    Slab slab;
    for (const auto& c : cases) {
        slab.scene.cuts.boxes = c.boxes;
        const double expected = slab.expected(c.thickness);
        EXPECT_GT(std::abs(expected / slab.expected(24) - 1), 0.02) << "nothing is tested";
        for (const EngineKind engine : {EngineKind::native, EngineKind::reference}) {
            const Mean mean = slab.drawnMean(engine);
            EXPECT_NEAR(mean.mean, expected, 4 * mean.error + 1e-3 * expected) << name(engine);
        }
    }
}

/// The contract's light by single ways, over many seeds, and the reference's own rays of light, one ray
/// through the middle of every pixel.
class PathsOfContract : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Gammas, PathsOfContract, testing::Values(1.0, 0.6));
TEST_P(PathsOfContract, ComeToTheReferencesLight) {
    Torso torso;
    Scene scene = torso.scene("bone-1", 0, {10, 8});
    // Smooth: what steps cost is no matter here.
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
        {{-300, 0}, {200, 0.03}, {1500, 0.3}}, {{-300, {0.9, 0.3, 0.2}}, {800, {0.9, 0.9, 0.7}}});
    Light lamp; // in tissue
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    const glm::dvec3 extent(torso.reader.info().extentVoxels);
    lamp.position =
        glm::dvec3(torso.reader.info().patientFromVoxel * glm::dvec4(extent * glm::dvec3(0.5, 0.3, 0.5), 1));
    scene.lighting.lights = {sun(0), Light{}, lamp};
    scene.lighting.lights[0].shadow = scene.lighting.lights[2].shadow = true;
    scene.lighting.lights[1].intensity = 0.3;
    Occlusion occlusion;
    occlusion.rays = 128;
    occlusion.radiusMm = 12;
    occlusion.offsetMm = 5;
    occlusion.bias = 0.1;
    occlusion.gamma = GetParam();
    scene.lighting.occlusion = occlusion;
    scene.shading.ambient = 0.5;
    scene.shading.gradientWeight = GradientWeight{1e6, 1e6}; // as a volume: normals are no matter here either
    scene.quality.stepVoxels = 0.25;
    const Image truth = torso.draw(scene, EngineKind::reference).image;
    scene.lighting.transport = Transport{TransportResponse::contract};
    constexpr int kSeeds = 100;
    std::vector<glm::dvec4> sum(truth.pixels.size()), squares(sum);
    for (int seed = 0; seed < kSeeds; ++seed) {
        scene.quality.pixels = {1, PixelFilter::box, static_cast<std::uint32_t>(seed)};
        const Image image = torso.draw(scene, EngineKind::native).image;
        for (std::size_t n = 0; n < sum.size(); ++n)
            sum[n] += glm::dvec4(image.pixels[n]),
                squares[n] += glm::dvec4(image.pixels[n] * image.pixels[n]);
    }
    double chi = 0, bias = 0, light = 0;
    int count = 0;
    for (std::size_t n = 0; n < sum.size(); ++n)
        for (int c = 0; c < 3; ++c) {
            const double mean = sum[n][c] / kSeeds,
                         variance = (squares[n][c] / kSeeds - mean * mean) / kSeeds;
            const double difference = mean - static_cast<double>(truth.pixels[n][c]);
            if (!(truth.pixels[n].a > 0.05f))
                continue;
            const double error = std::sqrt(variance) + 2e-3; // steps and the reference's own tolerance
            chi += std::pow(difference / error, 2);
            bias += difference, light += static_cast<double>(truth.pixels[n][c]);
            ++count;
        }
    ASSERT_GT(count, 60);
    EXPECT_LT(chi / count, 1.5);
    EXPECT_LT(std::abs(bias) / light, 0.01);
}

/// What --verify full tells of kept light is its difference to light by single ways in whole pictures.
TEST(PathPicture, LightsErrorIsMeasured) {
    Torso torso;
    Scene scene = torso.scene("soft-tissue", 1, {18, 14});
    scene.lighting.lights = {sun()};
    scene.lighting.lights[0].shadow = true;
    scene.lighting.occlusion = Occlusion{};
    scene.lighting.occlusion->gamma = 1;
    scene.shading.ambient = 0.5;
    scene.quality.pixels = {128, PixelFilter::box, 5};
    const auto measured = [&](const Scene& of, Verify verify) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.verify = verify;
        const RenderResult result = renderScene(of, torso.reader, torso.ram, gpu, options);
        EXPECT_LE(torso.ram.peakBytes(), torso.ram.limitBytes());
        return *result.measured;
    };
    double before = 0;
    for (const int level : {1, 3}) {
        scene.lighting.finestLevel = level;
        const Image kept = torso.draw(scene, EngineKind::native).image;
        Scene ways = scene;
        ways.lighting.transport = Transport{TransportResponse::contract};
        ways.quality.pixels.seed = 6;
        const Image first = torso.draw(ways, EngineKind::native).image;
        ways.quality.pixels.seed = 7;
        const Image second = torso.draw(ways, EngineKind::native).image;
        double squares = 0; // of independent noise the product has the mean 0
        int shown = 0;
        for (std::size_t n = 0; n < kept.pixels.size(); ++n)
            if (kept.pixels[n].a > 1.0f / 255) {
                squares += glm::dot(glm::dvec4(kept.pixels[n] - first.pixels[n]),
                                    glm::dvec4(kept.pixels[n] - second.pixels[n])) /
                           4;
                ++shown;
            }
        const PictureMeasurement m = measured(scene, Verify::full);
        ASSERT_TRUE(m.light && m.light->rms) << m.whyNoLight;
        const double rms = std::sqrt(squares / shown);
        EXPECT_LT(m.light->rms->low, 1.05 * rms) << level;
        EXPECT_GT(m.light->rms->high, 0.95 * rms) << level;
        EXPECT_GT(m.light->rms->value, 1.5 * before) << level;
        before = m.light->rms->value;
    }
    EXPECT_FALSE(measured(scene, Verify::quick).light);
    scene.lighting.occlusion->method = OcclusionMethod::positional;
    const PictureMeasurement other = measured(scene, Verify::full);
    EXPECT_FALSE(other.light);
    EXPECT_THAT(other.whyNoLight, HasSubstr("method local"));
    EXPECT_TRUE(other.all.rms);
}

/// A filter takes noise out, and pixels drawn again tell what is left and what it blurs.
TEST(PathPicture, DenoisedErrsLessAndTellsIt) {
    Torso torso;
    Scene scene = lit(torso.scene("skin", 0, {64, 48}), 2);
    scene.quality.pixels = {1024, PixelFilter::box, 9};
    const Image truth = torso.draw(scene, EngineKind::native).image;
    scene.quality.pixels = {8, PixelFilter::box, 3};
    const auto errorOf = [&](const Image& image) {
        double squares = 0;
        int shown = 0;
        for (std::size_t n = 0; n < truth.pixels.size(); ++n)
            if (truth.pixels[n].a > 1.0f / 255) {
                const glm::dvec4 d(image.pixels[n] - truth.pixels[n]);
                squares += glm::dot(d, d) / 4, ++shown;
            }
        return std::sqrt(squares / shown);
    };
    const RenderResult raw = torso.draw(scene, EngineKind::native);
    EXPECT_FALSE(raw.measured);
    scene.quality.pixels.denoise = true;
    MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.verify = Verify::full;
    const RenderResult denoised = renderScene(scene, torso.reader, torso.ram, gpu, options);
    EXPECT_LE(torso.ram.peakBytes(), torso.ram.limitBytes());
    const double error = errorOf(denoised.image);
    EXPECT_LT(error, 0.7 * errorOf(raw.image));
    ASSERT_TRUE(denoised.measured && denoised.measured->all.rms);
    EXPECT_TRUE(denoised.measured->keptRays);
    EXPECT_LT(denoised.measured->all.rms->low, 1.1 * error);
    EXPECT_GT(denoised.measured->all.rms->high, 0.9 * error);
    for (std::size_t n = 0; n < truth.pixels.size(); ++n)
        EXPECT_EQ(denoised.image.pixels[n].a, raw.image.pixels[n].a);
    scene.lighting.transport.reset();
    scene.lighting.environment.reset();
    EXPECT_THAT(refused(scene), HasSubstr("quality.denoise: expected paths of light"));
}

/// Sums over pictures of many seeds.
struct Seeds {
    Seeds(Torso& torso, Scene scene, EngineKind engine, int count) : count(count) {
        scene.quality.stepVoxels = 0.25;
        for (int seed = 0; seed < count; ++seed) {
            scene.quality.pixels.seed = static_cast<std::uint32_t>(seed);
            const RenderResult result = torso.draw(scene, engine);
            EXPECT_EQ(result.bricksOfLevel[0], result.residentBricks);
            sum.resize(result.image.pixels.size()), squares.resize(sum.size());
            for (std::size_t n = 0; n < sum.size(); ++n) {
                const glm::dvec4 pixel(result.image.pixels[n]);
                sum[n] += pixel, squares[n] += pixel * pixel;
            }
        }
    }
    double mean(std::size_t n, int c) const { return sum[n][c] / count; }
    /// Of the mean.
    double variance(std::size_t n, int c) const {
        const double m = mean(n, c);
        return std::max(0.0, squares[n][c] / count - m * m) / (count - 1);
    }
    int count;
    std::vector<glm::dvec4> sum, squares;
};

/// The reference's paths know no bounds and no null collisions: they invert optical depths.
TEST(PathPicture, ComesToTheReferencesPaths) {
    Torso torso;
    BallsOfLabels labels(torso.reader.info());
    std::vector<Scene> scenes = {
        lit(torso.scene("soft-tissue"), 8), labelledScene(torso, labels, LabelLook::tint, true),
        cutScene(torso, labels, true),      lampsInTissue(torso),
        lit(torso.scene("soft-tissue"), 8), lit(torso.scene("soft-tissue"), 8)};
    scenes[4].lighting.transport->preview = PathPreview::few;
    scenes[5].lighting.transport->preview = PathPreview::squared;
    scenes[0].lighting.transport->surface = SurfaceScattering{{20, 150}, {0.1, 0.3, 0.5, 6}};
    for (std::size_t n = 0; n < scenes.size(); ++n) {
        SCOPED_TRACE(n);
        Scene& scene = scenes[n];
        scene.imageSize = {9, 7};
        scene.quality.pixels = {16, PixelFilter::box, 0};
        const Seeds native(torso, scene, EngineKind::native, 24),
            truth(torso, scene, EngineKind::reference, 6);
        double chi = 0, difference = 0, variance = 0;
        int count = 0;
        for (std::size_t pixel = 0; pixel < truth.sum.size(); ++pixel) {
            if (truth.mean(pixel, 3) < 0.05)
                continue;
            double d = 0;
            for (int c = 0; c < 3; ++c)
                d += native.mean(pixel, c) - truth.mean(pixel, c);
            // Colours of a pixel's paths vary together: the worst case is taken.
            double error = 5e-4;
            for (int c = 0; c < 3; ++c)
                error += std::sqrt(native.variance(pixel, c) + truth.variance(pixel, c));
            chi += d * d / (error * error);
            difference += d, variance += error * error;
            ++count;
        }
        ASSERT_GT(count, 8);
        EXPECT_LT(chi / count, 1.0 + 5 * std::sqrt(2.0 / count));
        EXPECT_LT(std::abs(difference), 4 * std::sqrt(variance));
    }
}

/// The standard error that a picture tells is the one that it makes.
TEST(PathPicture, TellsTheErrorThatItMakes) {
    Torso torso;
    Scene scene = lit(torso.scene("bone-1", 0, {12, 10}));
    for (const int samples : {8, 64, 512}) {
        const int kSeeds = samples > 100 ? 40 : 60;
        scene.quality.pixels.samples = samples;
        std::vector<std::vector<double>> pixels;
        double told = 0;
        for (int seed = 0; seed < kSeeds; ++seed) {
            scene.quality.pixels.seed = static_cast<std::uint32_t>(seed);
            const RenderResult result = torso.draw(scene, EngineKind::native);
            ASSERT_TRUE(result.pixels.error);
            told += std::pow(result.pixels.error->rms, 2);
            std::vector<double> values;
            for (const glm::vec4& pixel : result.image.pixels)
                for (int c = 0; c < 4; ++c)
                    values.push_back(static_cast<double>(pixel[c]));
            pixels.push_back(values);
        }
        double variance = 0;
        std::size_t shown = 0;
        for (std::size_t n = 0; n < pixels[0].size(); n += 4) {
            double alpha = 0;
            for (const auto& picture : pixels)
                alpha += picture[n + 3];
            if (!(alpha > 0))
                continue;
            ++shown;
            for (std::size_t c = 0; c < 4; ++c) {
                double mean = 0, squares = 0;
                for (const auto& picture : pixels)
                    mean += picture[n + c] / kSeeds;
                for (const auto& picture : pixels)
                    squares += std::pow(picture[n + c] - mean, 2);
                variance += squares / (kSeeds - 1) / 4;
            }
        }
        const double made = std::sqrt(variance / static_cast<double>(shown));
        EXPECT_NEAR(std::sqrt(told / kSeeds) / made, 1, 0.1) << samples;
    }
}

TEST(PathPicture, StopsAtTheNoiseThatIsAskedFor) {
    Torso torso;
    Scene scene = lit(torso.scene("bone-1"));
    scene.quality.pixels.samples = PixelSampling::kMostForNoise;
    double before = 0;
    for (const double noise : {0.05, 0.02}) {
        scene.quality.pixels.noise = noise;
        const RenderResult result = torso.draw(scene, EngineKind::native);
        ASSERT_TRUE(result.pixels.error);
        EXPECT_LE(result.pixels.error->rms, noise);
        EXPECT_GT(result.pixels.error->rms, 0.2 * noise) << "no more samples than it needs";
        EXPECT_EQ(std::exp2(std::round(std::log2(result.pixels.taken))), result.pixels.taken);
        EXPECT_GT(result.pixels.taken, before);
        before = result.pixels.taken;
    }
    scene.quality.pixels.noise = 1e-6; // it is never reached
    scene.quality.pixels.samples = 300;
    EXPECT_EQ(torso.draw(scene, EngineKind::native).pixels.taken, 300);
}

/// No point has an extinction beyond its bounds, whatever levels meet there.
TEST(ExtinctionBoundsOfScenes, HoldEveryPoint) {
    for (const EdgeFunction edge : kEdgeFunctions)
        for (const std::string preset : {"bone-1", "soft-tissue"}) {
            MixedScene mixed("torso", preset, 0, edge);
            Planner& p = mixed.p();
            for (const bool mixes : {false, true}) {
                if (mixes)
                    mixed.choose(randomLevels(p.layer().selection, 7, true));
                const Layer& layer = p.layer();
                MemoryBudget& ram = mixed.prepared->budgets.ram;
                const OccupancyInput volume{layer.statistics, layer.table, p.info(), layer.selection, edge};
                ExtinctionBounds bounds(volume, layer.optics, 1e6f, ram);
                bounds.refine(volume, layer.optics, *layer.cache, ram);
                EXPECT_LE(bounds.usedBytes(),
                          ExtinctionBounds::bytes(p.info().extentVoxels, layer.optics.table.size()));
                std::mt19937 random(11);
                const MirrorInput input = mirrorInput(p, false);
                std::size_t outside = 0, positive = 0;
                withCacheField<float>(
                    *input.cache, *input.info, *input.selection, input.levels, Gradient::central,
                    [&](auto& field) {
                        for (int n = 0; n < 40000; ++n) {
                            glm::vec3 at;
                            for (int axis = 0; axis < 3; ++axis)
                                at[axis] = std::uniform_real_distribution<float>(
                                    0, static_cast<float>(p.info().extentVoxels[axis]))(random);
                            const float extinction = lookUp(layer.optics, field.value(at)).a;
                            const ExtinctionRange range = bounds.at(glm::ivec3(at)).range;
                            outside += extinction > range.most || extinction < range.least;
                            positive += extinction > 0;
                        }
                    });
                EXPECT_EQ(outside, 0u) << preset << " " << static_cast<int>(edge) << mixes;
                EXPECT_GT(positive, 100u);
            }
        }
}

/// White tissue that light hardly leaves, a lamp inside it, much forward scattering, a glow everywhere.
TEST(PathPicture, EndsInBadScenes) {
    Torso torso;
    const glm::dvec3 inside(torso.reader.info().patientFromVoxel *
                            glm::dvec4(0.5 * glm::dvec3(torso.reader.info().extentVoxels), 1));
    for (const double opacity : {1e-6, 0.5, 0.9999999}) {
        Scene scene = lit(torso.scene("bone-1", 0, {16, 12}), 256);
        TransferFunction function =
            TransferFunction::fromOpacity({{-2000, opacity}, {3000, opacity}}, {{0, glm::dvec3(1)}}, 1);
        Material glow;
        glow.from = -3000, glow.to = 30000;
        glow.emission = {1, 1, 1};
        function.setMaterials({glow});
        scene.volumes[0].transferFunction = function;
        Light lamp;
        lamp.kind = LightKind::point;
        lamp.frame = LightFrame::patient;
        lamp.position = inside;
        scene.lighting.lights = {lamp};
        scene.lighting.transport->phase.g = 0.99;
        scene.lighting.transport->surface = SurfaceScattering{{1, 2}, 1, 0.05};
        const RenderResult result = torso.draw(scene, EngineKind::native);
        EXPECT_GT(result.work.paths.paths, 0u);
        EXPECT_LT(result.work.paths.lookUps, 20000 * result.work.paths.paths);
        for (const glm::vec4& pixel : result.image.pixels)
            for (int c = 0; c < 4; ++c)
                ASSERT_TRUE(std::isfinite(pixel[c]) && pixel[c] >= 0);
    }
}

TEST(PathPicture, CostsNothingWithoutATransport) {
    Torso torso;
    const RenderResult plain = torso.draw(torso.scene("bone-1"), EngineKind::native);
    EXPECT_EQ(plain.work.paths.paths, 0u);
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    const Planner p = planScene(torso.scene("bone-1"), torso.reader, {}, {ram, gpu, 0});
    EXPECT_FALSE(p.layer().extinction.exists());
}

TEST(PathPicture, RefusesWhatIsNotThere) {
    Torso torso;
    const Scene scene = lit(torso.scene("bone-1"));
    Scene other = scene;
    other.mode = Mode::maximum; // has no light
    EXPECT_EQ(torso.draw(other, EngineKind::native).work.paths.paths, 0u);
    other = scene;
    other.quality.maxError = 3;
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected no error bound"));
    other = scene;
    other.quality.pixels.samples = PixelSampling::kAutomatic;
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected a number of samples"));
    other = scene;
    other.lighting.environment.reset();
    other.lighting.transport->response = TransportResponse::contract;
    other.lighting.occlusion = Occlusion{OcclusionMethod::rejecting};
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected occlusion of method local"));
    other.lighting.occlusion.reset();
    other.shading.on = false;
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected shading"));
    other = scene;
    other.lighting.environment->file.path = "unread.exr"; // as a path's keyframes have it
    EXPECT_THAT(refused(other), HasSubstr("unread.exr: expected a file of the scene's own lighting"));
}

} // namespace
} // namespace tessera
