// tests/render/contract/gradient_opacity_test.cpp: gradient opacity: closed forms, on every engine and in the
// light of voxels. The native engine has the mirror's bits, the GPU ray caster its own tolerance, and both
// converge to the reference. Scenes without gradient opacity have no cost.
#include "core/image/image_metrics.h"
#include "render/plan/visibility_rays.h"
#include "tests/support/graded.h"
#include "tests/support/interactive_fixture.h"
#include "tests/support/lights.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/reference_light.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(39, 43); // no packet's edges divide it

double largestDifference(const Image& a, const Image& b) {
    return compare(a, b).maxAbs;
}

enum class Lit { no, head, lights };
struct GradedCase {
    const char* preset;
    int camera;
    Lit lit;
    Gradient gradient = Gradient::central;
    Integrator integrator = Integrator::midpoint;
    bool surfaces = false;
    Scene scene(const glm::ivec2& size) const {
        Scene s = sceneOn(infoOf("torso"), preset, camera, size);
        s.shading.on = lit != Lit::no;
        s.shading.gradient = gradient;
        s.quality.integrator = integrator;
        if (lit == Lit::lights)
            lightWithAll(s, infoOf("torso"), ShadingModel::phong, true);
        if (surfaces)
            s.surfaces = {{-300, {0.9, 0.6, 0.5}, 0.3}, {250, {0.95, 0.9, 0.8}, 0.6}};
        grade(s);
        return s;
    }
};
std::ostream& operator<<(std::ostream& out, const GradedCase& c) {
    return out << c.preset << ", camera " << c.camera << ", light " << static_cast<int>(c.lit) << ", "
               << gradientNames()[static_cast<std::size_t>(c.gradient)] << ", "
               << integratorNames()[static_cast<std::size_t>(c.integrator)]
               << (c.surfaces ? ", surfaces" : "");
}
class Graded : public testing::TestWithParam<GradedCase> {};
INSTANTIATE_TEST_SUITE_P(
    Scenes, Graded,
    testing::Values(GradedCase{"soft-tissue", 0, Lit::no}, GradedCase{"soft-tissue", 2, Lit::head},
                    GradedCase{"bone-1", 1, Lit::lights},
                    GradedCase{"soft-tissue", 0, Lit::no, Gradient::centralHalf},
                    GradedCase{"soft-tissue", 1, Lit::head, Gradient::forward},
                    GradedCase{"soft-tissue", 2, Lit::no, Gradient::sobel},
                    GradedCase{"soft-tissue", 0, Lit::lights, Gradient::sobel2},
                    GradedCase{"bone-1", 1, Lit::head, Gradient::sobel4, Integrator::linear},
                    GradedCase{"soft-tissue", 1, Lit::head, Gradient::sobel2, Integrator::midpoint, true},
                    GradedCase{"bone-1", 0, Lit::lights, Gradient::analytic, Integrator::preintegrated},
                    GradedCase{"soft-tissue", 1, Lit::no, Gradient::central, Integrator::linear},
                    GradedCase{"soft-tissue", 0, Lit::head, Gradient::central, Integrator::preintegrated2d},
                    GradedCase{"soft-tissue", 2, Lit::no, Gradient::central, Integrator::midpoint, true},
                    GradedCase{"soft-tissue", 0, Lit::lights, Gradient::central, Integrator::preintegrated,
                               true}));

TEST_P(Graded, NativeHasTheMirrorsBits) {
    Prepared prepared("torso", GetParam().scene(kSize));
    expectTheMirrorsBits(prepared);
    const Image whole = nativePicture(prepared).image;
    NativeChoices choices;
    choices.slicing.fixedIterations = 7;
    EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole), 0u) << "seven turns at a time";
    choices = {};
    choices.blocks = true;
    EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole), 0u) << "blocks";
    // It is there: without it the picture is another.
    Scene plain = GetParam().scene(kSize);
    std::get<TransferFunction>(plain.volumes[0].transferFunction).setGradientOpacity({});
    Prepared without("torso", plain);
    EXPECT_GT(largestDifference(nativePicture(without).image, whole), 0.05);
}

TEST_P(Graded, NativeHasTheMirrorsBitsAcrossLevels) {
    Prepared prepared("torso", GetParam().scene(kSize));
    Planner& p = prepared.p;
    for (const unsigned seed : {1u, 2u}) {
        p.setSelection(seed == 1 ? randomShownLevels(p.layer().selection, seed)
                                 : randomLevels(p.layer().selection, seed, true));
        ASSERT_TRUE(p.layer().mixed());
        expectTheMirrorsBits(prepared);
    }
}

// As Contract.MarchEqualsTheMirrorOnItsOwnRays; cut and without skipping, bit-equal.
TEST_P(Graded, MarchEqualsTheMirrorOnItsOwnRays) {
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
        EXPECT_NE(features & kFeatureGradientOpacity, 0u);
        const GpuPicture gpu = marchOn(prepared, features);
        // Lights of the scene's own divide and take roots.
        EXPECT_LE(largestDifference(gpu.image, mirror), GetParam().lit == Lit::lights ? 2e-5 : 1e-5);
        EXPECT_EQ(gpu.work.segments, work.segments);
        if (!GetParam().surfaces && !needsEnds(GetParam().integrator)) { // else it takes more fronts anew
            EXPECT_EQ(gpu.work.samples, work.samples);
        }
        Slicing shreds;
        shreds.fixedTile = 24;
        shreds.fixedIterations = 7;
        EXPECT_TRUE(bitEqual(marchOn(prepared, features, shreds).image, gpu.image));
        EXPECT_TRUE(bitEqual(marchOn(prepared, features & ~kFeatureSkipping).image, gpu.image));
    }
}

TEST(GradedVisibility, EveryEngineCountsTheSame) {
    const GlContext context({"software"});
    for (const bool isMixed : {false, true}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {64, 64});
        scene.shading.on = false;
        const auto countsOf = [&](const Scene& s) {
            Prepared prepared("torso", s);
            Planner& p = prepared.p;
            if (isMixed)
                p.setSelection(randomShownLevels(p.layer().selection, 3));
            NativeEngine engine(0, prepared.budgets.gpu, prepared.budgets.ram);
            p.chosen.chooser.reset();
            p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
            Work work;
            loadBricks(engine, p, prepared.budgets.gpu, work);
            const auto count = [&](Engine& by) {
                const auto counter = by.counter(prepared.budgets.gpu);
                counter->begin();
                while (!counter->count(Slicing{}, RayCaster::Clock::time_point::max())) {
                }
                return counter->seen();
            };
            const std::vector<SeenBrick> mine = count(engine);
            const VisibilityRays rays =
                visibilityRays(p.view.camera, p.info(), p.view.imageSize, p.strides());
            MirrorInput input = mirrorInput(p, false);
            input.strides = rays.strides;
            const auto seen = mirrorSeen(input, rayCount(glm::ivec2(rays.frame.imageSize)),
                                         frameRays(cast<float>(rays.frame)), 0);
            OnDevice device(prepared);
            const std::vector<SeenBrick> byGpu = count(device.engine);
            std::uint64_t light = 0, gpuLight = 0;
            for (std::size_t b = 0; b < seen.size(); ++b) {
                EXPECT_EQ(mine[b].light, seen[b].light);
                EXPECT_EQ(mine[b].rays, seen[b].rays);
                light += seen[b].light;
                gpuLight += byGpu[b].light;
            }
            // It filters, and its rays are its own.
            EXPECT_NEAR(static_cast<double>(gpuLight), static_cast<double>(light),
                        0.01 * static_cast<double>(light));
            return light;
        };
        const std::uint64_t plain = countsOf(scene);
        grade(scene);
        EXPECT_GT(countsOf(scene), plain + plain / 20) << "more is seen through what shows less";
    }
}

/// A ramp whose gradient is the same everywhere but half a voxel from the faces that it runs to; sheared, of
/// unlike spacings. Stored values; the function shows those in the middle alone.
struct Ramp {
    static constexpr double kPerVoxel = 8; // along x
    Stored stored;
    explicit Ramp(double slope = 1, ValueType type = ValueType::f32)
        : stored([](const glm::dvec3& p) { return kPerVoxel * p.x; }, glm::ivec3(44, 40, 48), false, slope,
                 type) {}
    /// Of physical values.
    double lengthPerMm() const {
        const glm::dmat3 toPatient = glm::transpose(glm::inverse(glm::dmat3(stored.info.patientFromVoxel)));
        return std::abs(stored.info.rescaleSlope) * glm::length(toPatient * glm::dvec3(kPerVoxel, 0, 0));
    }
    double meanSpacing() const {
        const glm::dvec3 s = stored.info.spacingMm();
        return (s.x + s.y + s.z) / 3;
    }
    TransferFunction function(double factor) const {
        const double slope = stored.info.rescaleSlope;
        std::vector<OpacityPoint> points;
        std::vector<ColourPoint> colours;
        for (const auto& [voxel, extinction] :
             {std::pair(8.0, 0.0), std::pair(14.0, 0.09), std::pair(30.0, 0.05), std::pair(36.0, 0.0)})
            points.push_back({slope * kPerVoxel * voxel, factor * extinction});
        colours = {{slope * kPerVoxel * 10, {1, 0.3, 0.1}}, {slope * kPerVoxel * 30, {0.2, 0.5, 1}}};
        return TransferFunction::fromExtinction(points, colours);
    }
};

/// Factors at that length: on a rise, at a step, between two points, beyond the last, before the first.
std::vector<std::pair<GradientOpacity, double>> factorsAt(double length, GradientOpacity::Per per) {
    using P = GradientPoint;
    const auto of = [per](std::vector<P> points) { return GradientOpacity::fromPoints(points, per); };
    return {{of({{0, 0}, {4 * length, 1}}), 0.25},
            {of({{0, 1}, {0.99 * length, 1}, {0.99 * length, 0.125}, {3 * length, 0.125}}), 0.125},
            {of({{0, 1}, {0.5 * length, 0.2}, {1.5 * length, 0.8}, {9 * length, 0}}), 0.5},
            {of({{0, 1}, {0.5 * length, 0.375}}), 0.375},
            {of({{2 * length, 0.75}, {3 * length, 1}}), 0.75},
            {of({{0, 1}, {0.5 * length, 0}}), 0}};
}

// The picture of a ramp is that of a function whose extinctions are scaled.
TEST(GradedRamp, IsTheScaledFunction) {
    const GlContext context({"software"});
    for (const double slope : {1.0, -2.5})
        for (const auto per : {GradientOpacity::Per::mm, GradientOpacity::Per::voxel}) {
            const Ramp ramp(slope);
            const double length =
                ramp.lengthPerMm() * (per == GradientOpacity::Per::voxel ? ramp.meanSpacing() : 1);
            int number = 0;
            for (const auto& [factor, expected] : factorsAt(length, per)) {
                SCOPED_TRACE(testing::Message() << "slope " << slope << ", factor " << expected);
                Scene scene = ramp.stored.scene({}, number % 3, 24);
                scene.shading.on = number % 2 == 0;
                scene.quality.integrator = number % 3 == 1 ? Integrator::preintegrated : Integrator::midpoint;
                scene.volumes[0].transferFunction = ramp.function(expected);
                const auto scaled = ramp.stored.prepare(scene);
                scene.volumes[0].transferFunction = graded(ramp.function(1), factor);
                const auto prepared = ramp.stored.prepare(scene);
                ++number;
                const Image picture = nativePicture(*prepared).image;
                EXPECT_EQ(isBlank(picture), expected == 0);
                EXPECT_LE(largestDifference(picture, nativePicture(*scaled).image), 2e-6);
                EXPECT_LE(largestDifference(marchOn(*prepared, marchFeatures(prepared->p, true)).image,
                                            marchOn(*scaled, marchFeatures(scaled->p, true)).image),
                          2e-5);
                const ReferenceInput input = referenceInput(*prepared, scene);
                ReferenceInput other = input;
                const TransferFunction less = ramp.function(expected);
                other.function = &less;
                const auto rays = referenceRays(prepared->p.view.camera, prepared->p.info(), {24, 24});
                const auto truth = renderReference(input, rays, 0), same = renderReference(other, rays, 0);
                for (std::size_t i = 0; i < rays.size(); ++i)
                    for (int c = 0; c < 4; ++c)
                        ASSERT_NEAR(truth[i][c], same[i][c], 1e-9);
            }
        }
}

// The light of voxels too, and the reference's own rays of light.
TEST(GradedRamp, ItsLightIsThatOfTheScaledFunction) {
    for (const ValueType type : {ValueType::f32, ValueType::i16}) {
        const Ramp ramp(1, type);
        const auto [factor, expected] = factorsAt(ramp.lengthPerMm(), GradientOpacity::Per::mm)[0];
        Scene scene = ramp.stored.scene({}, 0, 24);
        Light key = keyLight(); // from where the ramp's gradients answer to it
        key.direction = {1, -1, 1};
        scene.lighting.lights = {Light(), key};
        scene.lighting.occlusion = Occlusion();
        scene.lighting.occlusion->radiusMm = 12;
        scene.volumes[0].transferFunction = ramp.function(expected);
        const auto scaled = ramp.stored.prepare(scene);
        scene.volumes[0].transferFunction = graded(ramp.function(1), factor);
        const auto prepared = ramp.stored.prepare(scene);
        const Image picture = nativePicture(*prepared).image;
        EXPECT_FALSE(isBlank(picture));
        EXPECT_LE(largestDifference(picture, nativePicture(*scaled).image), 3e-4); // light has 14 bits
        Scene unshadowed = scene;
        unshadowed.lighting.lights[1].shadow = false;
        EXPECT_GT(largestDifference(picture, nativePicture(*ramp.stored.prepare(unshadowed)).image), 0.01);
        Scene plain = scene;
        plain.volumes[0].transferFunction = ramp.function(1);
        const auto dense = ramp.stored.prepare(plain);
        EXPECT_GT(largestDifference(picture, nativePicture(*dense).image), 0.02);

        for (const auto method :
             {OcclusionMethod::local, OcclusionMethod::positional, OcclusionMethod::rejecting}) {
            Scene by = scene;
            by.lighting.occlusion->method = method;
            const auto one = ramp.stored.prepare(by);
            by.volumes[0].transferFunction = ramp.function(expected);
            const auto other = ramp.stored.prepare(by);
            by.volumes[0].transferFunction = ramp.function(1);
            const auto thick = ramp.stored.prepare(by);
            RaysOfLight mine(*one, by), theirs(*other, by), thicker(*thick, by);
            for (const glm::dvec3& place : {glm::dvec3(20.2, 20, 24), glm::dvec3(33, 7.7, 40.1)}) {
                const LightShares a = mine.light.at(place), b = theirs.light.at(place),
                                  c = thicker.light.at(place);
                for (int channel = 0; channel < 2; ++channel) {
                    EXPECT_NEAR(a[static_cast<std::size_t>(channel)], b[static_cast<std::size_t>(channel)],
                                1e-6);
                    EXPECT_GE(a[static_cast<std::size_t>(channel)], c[static_cast<std::size_t>(channel)]);
                }
                EXPECT_GT(a[0] + a[1], c[0] + c[1] + 1e-3);
            }
        }
    }
}

/// Rms over pixels of what the double mirror is off.
double mirrorError(const Stored& stored, Scene scene, double stepVoxels) {
    scene.quality.stepVoxels = stepVoxels;
    const auto prepared = stored.prepare(scene);
    const FramePlan& p = prepared->p;
    Work work;
    const auto mirror = mirrorRays<double>(mirrorInput(p, true), rayCount(p.view.imageSize),
                                           frameRays(p.view.frame), 0, work);
    const auto truth = renderReference(referenceInput(*prepared, scene),
                                       referenceRays(p.view.camera, p.info(), p.view.imageSize), 0);
    double squares = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
        squares += glm::dot(mirror[i] - truth[i], mirror[i] - truth[i]);
    return std::sqrt(squares / static_cast<double>(truth.size()));
}

// A gradient at a segment's middle is of second order too, where the factor has no corner; with corners the
// error falls all the same.
TEST(GradedConvergence, TheMirrorComesToTheReference) {
    const Stored stored([](const glm::dvec3& p) {
        return 300 * std::sin(0.23 * p.x) * std::cos(0.19 * p.y) + 200 * std::sin(0.21 * p.z + 0.1 * p.x);
    });
    const auto smooth = TransferFunction::fromExtinction({{-600, 0.01}, {600, 0.08}},
                                                         {{-400, {1, 0.2, 0}}, {400, {0, 0.6, 1}}});
    const auto rise = GradientOpacity::fromPoints({{0, 0}, {1000, 1}}),
               corners = GradientOpacity::fromPoints({{20, 0}, {60, 1}, {60, 0.3}, {90, 0.8}});
    for (const bool isLit : {false, true})
        for (const Integrator integrator :
             {Integrator::midpoint, Integrator::linear, Integrator::preintegrated}) {
            Scene scene = stored.scene({}, 0, 16);
            scene.shading.on = isLit;
            scene.quality.integrator = integrator;
            scene.volumes[0].transferFunction = graded(smooth, rise);
            const double half = mirrorError(stored, scene, 0.5), eighth = mirrorError(stored, scene, 0.125);
            EXPECT_GT(half / eighth, 8) << half << ", " << eighth; // 16; kinks of the gradient take some
            scene.volumes[0].transferFunction = graded(smooth, corners);
            EXPECT_LT(mirrorError(stored, scene, 0.125), 0.5 * mirrorError(stored, scene, 0.5));
        }
}

TEST(GradedNothing, AFactorOfOneIsNone) {
    for (const bool isLit : {false, true}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, kSize);
        scene.shading.on = isLit;
        ValueSummary values;
        values.isHu = true;
        const TransferFunction function = presetFunction("soft-tissue", values);
        scene.volumes[0].transferFunction = function;
        Prepared plain("torso", scene);
        scene.volumes[0].transferFunction =
            graded(function, GradientOpacity::fromPoints({{0, 1}, {50, 1}, {90, 2}}));
        Prepared ones("torso", scene);
        EXPECT_FALSE(ones.p.layer().optics.grades());
        EXPECT_EQ(marchFeatures(ones.p, true), marchFeatures(plain.p, true));
        EXPECT_EQ(marchFeatures(plain.p, true) & kFeatureGradientOpacity, 0u);
        EXPECT_EQ(ones.p.layer().selection.counts, plain.p.layer().selection.counts);
        const NativePicture a = nativePicture(plain), b = nativePicture(ones);
        EXPECT_TRUE(bitEqual(a.image, b.image));
        EXPECT_EQ(a.work.samples, b.work.samples);
    }
}

// Bricks that are culled are none that a gradient reads, lit or not.
TEST(GradedCulling, ChangesNoBit) {
    for (const Gradient kind : {Gradient::central, Gradient::sobel, Gradient::forward}) {
        Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, {64, 64});
        scene.shading.on = false;
        scene.shading.gradient = kind;
        grade(scene);
        Prepared culled("torso", scene), all("torso", scene, false);
        EXPECT_GT(culled.p.layer().selection.counts[Selection::kEmpty], 0u);
        EXPECT_EQ(differing(nativePicture(culled).image, nativePicture(all).image), 0u);
    }
}

// Modes of single values take none, nor do isosurfaces alone.
TEST(GradedNothing, SingleValuesTakeNone) {
    for (const Mode mode : {Mode::maximum, Mode::slice, Mode::isosurface}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, kSize);
        scene.mode = mode;
        scene.surfaces = {{250, {0.95, 0.9, 0.8}, 1}};
        scene.valueColour = ValueColour::transferFunction;
        Prepared plain("torso", asDrawn(scene));
        grade(scene);
        Prepared prepared("torso", asDrawn(scene));
        EXPECT_FALSE(prepared.p.layer().optics.grades());
        EXPECT_TRUE(bitEqual(nativePicture(plain).image, nativePicture(prepared).image));
    }
}

// Functions with and without it follow one another: each is drawn as a renderer draws it that knows no other.
TEST(GradedChange, ComesAndGoes) {
    const Scene graded = GradedCase{"soft-tissue", 0, Lit::no, Gradient::sobel}.scene({48, 48});
    Scene plain = graded;
    TransferFunction function = std::get<TransferFunction>(graded.volumes.front().transferFunction);
    function.setGradientOpacity({});
    plain.volumes.front().transferFunction = function;
    const auto alone = [&](const Scene& scene) {
        Session session(scene, std::size_t{1} << 30);
        session.converge();
        return session.renderer.picture();
    };
    const Image withIt = alone(graded), without = alone(plain);
    EXPECT_FALSE(bitEqual(withIt, without));
    Session session(plain, std::size_t{1} << 30);
    session.converge();
    session.renderer.setFunction(std::get<TransferFunction>(graded.volumes.front().transferFunction));
    session.converge();
    EXPECT_TRUE(bitEqual(session.renderer.picture(), withIt));
    session.renderer.setFunction(function);
    session.converge();
    EXPECT_TRUE(bitEqual(session.renderer.picture(), without));
}

} // namespace
} // namespace tessera
