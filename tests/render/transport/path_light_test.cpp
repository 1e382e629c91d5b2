// The light of pictures by paths: closed forms through stores and cameras, the reference's, and noise that is
// told.
#include "tests/support/path_scenes.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;
using namespace tessera::test::path_scenes;
using ::testing::HasSubstr;

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

} // namespace
} // namespace tessera
