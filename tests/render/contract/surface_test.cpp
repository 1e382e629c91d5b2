// Isosurfaces: places and lighting of crossings, against closed forms, and their cuts of the volume's
// segments. Their cost, and that cutting the work changes nothing: render_surface_work_test.cpp.
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

/// Largest distance of hits from the surface, voxels, and angle of their normals to the formula's gradient,
/// degrees.
struct HitError {
    double voxels = 0, degrees = 0;
};
HitError errorOf(const std::vector<SurfaceHit>& hits, const VolumeInfo& info, const Formula& value,
                 double isovalue) {
    HitError worst;
    const glm::dmat3 toPatient = glm::transpose(glm::inverse(glm::dmat3(info.patientFromVoxel)));
    for (const SurfaceHit& hit : hits) {
        if (hit.surface == 0)
            continue;
        const glm::dvec3 p(hit.position), normal(hit.normal);
        glm::dvec3 slope(0);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 h(0);
            h[axis] = 1e-5;
            slope[axis] = (value(p + h) - value(p - h)) / 2e-5;
        }
        worst.voxels = std::max(worst.voxels, std::abs(value(p) - isovalue) / glm::length(slope));
        const glm::dvec3 truth = toPatient * slope;
        worst.degrees = std::max(worst.degrees, std::atan2(glm::length(glm::cross(truth, normal)),
                                                           std::abs(glm::dot(truth, normal))) *
                                                    57.29577951308232);
    }
    return worst;
}

struct ClosedForm {
    const char* name;
    Formula value;
    double isovalue;
    Gradient gradient;
    double voxels, degrees; // that hits may be off by
};
const glm::dvec3 kMiddle(21.3, 20.1, 24.2);
std::vector<ClosedForm> closedForms() {
    const auto ball = [](const glm::dvec3& p) { return 100 * glm::length(p - kMiddle); };
    const auto saddle = [](const glm::dvec3& p) {
        const glm::dvec3 q = p - kMiddle;
        return q.x * q.y * q.z;
    };
    const auto gyroid = [](const glm::dvec3& p) {
        const glm::dvec3 q = p * (glm::two_pi<double>() / 20);
        return std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
    };
    return {
        // Planes and xyz are what trilinear interpolation has exactly; what is left is rounding of floats.
        {"plane", [](const glm::dvec3& p) { return 3 * p.x - 2 * p.y + 5 * p.z; }, 140, Gradient::central,
         2e-5, 0.01},
        {"plane", [](const glm::dvec3& p) { return 3 * p.x - 2 * p.y + 5 * p.z; }, 140, Gradient::analytic,
         2e-5, 0.01},
        {"saddle", saddle, 300, Gradient::analytic, 2e-5, 0.01},
        // Spheres of radius R lie h^2/8R deep at most; the gyroid's radii of curvature go down to some 3
        // voxels.
        {"sphere", ball, 1400, Gradient::central, 0.02, 0.5},
        {"sphere", ball, 1400, Gradient::centralHalf, 0.02, 0.5},
        {"sphere", ball, 1400, Gradient::sobel, 0.02, 0.8},
        {"sphere", ball, 1400, Gradient::forward, 0.02, 4},
        {"sphere", ball, 1400, Gradient::analytic, 0.02, 4},
        {"gyroid", gyroid, 0.3, Gradient::central, 0.06, 2.5},
    };
}

TEST(Isosurfaces, LieWhereTheirFormulasSay) {
    const GlContext context({"software"});
    for (const ClosedForm& form : closedForms()) {
        const Stored stored(form.value);
        for (const int camera : {0, 2}) {
            Scene scene = stored.scene({{form.isovalue, glm::dvec3(1), 1}}, camera);
            scene.shading.gradient = form.gradient;
            const auto prepared = stored.prepare(scene);
            const Drawn drawn = draw(*prepared);
            EXPECT_GT(hitCount(drawn.hits), 50u) << form.name << " " << camera;
            // Inside the outermost samples, where the field is flat.
            std::vector<SurfaceHit> inner = drawn.hits;
            std::erase_if(inner, [&](const SurfaceHit& h) {
                return glm::any(glm::lessThan(h.position, glm::vec3(1.5f))) ||
                       glm::any(glm::greaterThan(h.position, glm::vec3(stored.info.extentVoxels) - 1.5f));
            });
            const HitError error = errorOf(inner, stored.info, form.value, form.isovalue);
            EXPECT_LE(error.voxels, form.voxels) << form.name << " " << camera;
            EXPECT_LE(error.degrees, form.degrees)
                << form.name << " " << camera << " "
                << gradientNames()[static_cast<std::size_t>(form.gradient)];
            RecordProperty(std::string(form.name) + std::to_string(camera) +
                               gradientNames()[static_cast<std::size_t>(form.gradient)],
                           std::to_string(error.voxels) + " voxels, " + std::to_string(error.degrees) +
                               " degrees");
        }
    }
}

// Depth, facing normals, and rays that miss: a sphere by its own equation.
TEST(Isosurfaces, ASphereIsHitWhereARayMeetsIt) {
    const GlContext context({"software"});
    const double radius = 14;
    const Stored stored([](const glm::dvec3& p) { return glm::length(p - kMiddle); });
    const auto prepared = stored.prepare(stored.scene({{radius, glm::dvec3(1), 1}}));
    const Drawn drawn = draw(*prepared);
    const auto rays = gpuRays(prepared->p.view.frame, prepared->budgets.gpu);
    int hits = 0, misses = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::dvec3 d(rays[i].direction), o = glm::dvec3(rays[i].entry) - kMiddle;
        if (rays[i].count == 0)
            continue;
        const double along = -glm::dot(o, d), nearest = glm::length(o + along * d);
        if (nearest > radius + 0.05) {
            EXPECT_EQ(drawn.hits[i].surface, 0);
            EXPECT_EQ(drawn.image.pixels[i], glm::vec4(0));
            ++misses;
        } else if (nearest < radius - 0.05) {
            ASSERT_EQ(drawn.hits[i].surface, 1);
            const double t = along - std::sqrt(radius * radius - nearest * nearest);
            const double mm = glm::length(glm::dmat3(stored.info.patientFromVoxel) * d);
            EXPECT_NEAR(glm::dot(glm::dvec3(drawn.hits[i].position) - kMiddle - o, d) * mm, t * mm,
                        0.02 * mm * radius / std::sqrt(radius * radius - nearest * nearest));
            EXPECT_EQ(drawn.image.pixels[i].a, 1.0f);
            const glm::dvec3 view = glm::dmat3(stored.info.patientFromVoxel) * d;
            EXPECT_LT(glm::dot(glm::dvec3(drawn.hits[i].normal), view), 0);
            ++hits;
        }
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(misses, 20);
}

/// White noise: every cell is another trilinear patch, and rays meet many of them twice.
Formula noise(unsigned seed) {
    return [seed](const glm::dvec3& p) {
        std::mt19937 random(seed + static_cast<unsigned>(p.x) + 1000 * static_cast<unsigned>(p.y) +
                            1000000 * static_cast<unsigned>(p.z));
        random.discard(3);
        return std::uniform_real_distribution<double>(-1, 1)(random);
    };
}

// The number of hits of every ray, from its opacity, against a scan of the field along the ray. All crossings
// are found, also pairs within a cell, whatever the step.
TEST(Isosurfaces, AllCrossingsAreFoundWhateverTheStep) {
    const Stored stored(noise(5), {20, 18, 22});
    std::vector<int> first;
    for (const double q : {0.5, 2.0, 7.3}) {
        Scene scene = stored.scene({{0.1, glm::dvec3(1), 0.02}}, 0, 24);
        scene.shading.on = false;
        scene.quality.stepVoxels = q;
        const auto prepared = stored.prepare(scene);
        const MirrorInput input = mirrorInput(prepared->p, true);
        const RaySource<double> rays = frameRays(prepared->p.view.frame);
        Work work;
        const auto pixels = mirrorRays<double>(input, 24 * 24, rays, 0, work);
        LatticeReader samples(*prepared->p.layer().cache, stored.info, 0, nullptr);
        std::vector<int> counts;
        int unlike = 0, missedBySteps = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const double count = std::log1p(-pixels[i].a) / std::log1p(-static_cast<double>(0.02f));
            counts.push_back(static_cast<int>(std::lround(count)));
            ASSERT_NEAR(count, counts.back(), 1e-6);
            if (q != 0.5)
                continue;
            const SegmentedRay<double> ray = rays(i);
            const double last = ray.count > 0 ? ray.count - 1 + ray.tail : 0;
            int scanned = 0, atSteps = 0;
            double before = fieldValue(samples, ray.entry, 1.0), stepBefore = before;
            const int places = static_cast<int>(std::ceil(last * 100));
            for (int k = 1; k <= places; ++k) {
                const double t = std::min(k / 100.0, last);
                const double here = fieldValue(samples, ray.entry + t * ray.step, 1.0);
                scanned += (before < 0.1) != (here < 0.1) ? 1 : 0;
                before = here;
                if (k % 100 == 0) {
                    atSteps += (stepBefore < 0.1) != (here < 0.1) ? 1 : 0;
                    stepBefore = here;
                }
            }
            unlike += scanned != counts.back() ? 1 : 0;
            missedBySteps += counts.back() - atSteps;
            ASSERT_EQ((counts.back() - scanned) % 2, 0);
            ASSERT_GE(counts.back(), scanned);
        }
        if (q == 0.5) {
            first = counts;
            EXPECT_LE(unlike, 6); // pairs nearer to each other than the scan's places
            EXPECT_GT(missedBySteps, 50) << "nothing that a test at a segment's ends would not have found";
        }
        EXPECT_EQ(counts, first) << "step " << q;
    }
}

// A sheet a tenth of a step thick, of which a sample in 20 knows nothing: both of its faces are met by every
// ray.
TEST(Isosurfaces, ThinSheetsAreNotMissed) {
    const GlContext context({"software"});
    const Stored stored([](const glm::dvec3& p) { return std::max(0.0, 1 - std::abs(p.z - 24.5)); },
                        {40, 40, 48}, true);
    for (const double q : {0.5, 4.0}) {
        Scene scene = stored.scene({{0.8, glm::dvec3(1), 0.5}}, 1);
        scene.camera = fitCamera(stored.info, View::superior, Projection::parallel, {32, 32});
        scene.shading.on = false;
        scene.quality.stepVoxels = q;
        const auto prepared = stored.prepare(scene);
        const Drawn drawn = draw(*prepared);
        const auto rays = gpuRays(prepared->p.view.frame, prepared->budgets.gpu);
        for (std::size_t i = 0; i < drawn.hits.size(); ++i) {
            if (rays[i].count == 0)
                continue;
            EXPECT_NEAR(drawn.image.pixels[i].a, 0.75f, 1e-6f);
            EXPECT_NEAR(std::abs(drawn.hits[i].position.z - 24.5f), 0.2f, 1e-5f);
        }
        EXPECT_GT(hitCount(drawn.hits), 300u);
    }
}

// Several semi-transparent surfaces, in the order in which the ray meets them; two of one value as listed.
TEST(Isosurfaces, CompositeInOrder) {
    const GlContext context({"software"});
    const Stored stored([](const glm::dvec3& p) { return glm::length(p - kMiddle); });
    const Isosurface inner{6, {1, 0, 0}, 0.5}, outer{12, {0, 1, 0}, 0.25}, same{12, {0, 0, 1}, 0.5};
    Scene scene = stored.scene({inner, outer, same}, 1, 33);
    scene.shading.on = false;
    const auto prepared = stored.prepare(scene);
    const Drawn drawn = draw(*prepared);
    glm::dvec4 expected(0);
    const auto over = [&](const Isosurface& s) {
        const double weight = (1 - expected.a) * s.opacity;
        expected += glm::dvec4(weight * s.colour, weight);
    };
    // Inwards values fall, outwards they rise.
    for (const Isosurface& s : {same, outer, inner, inner, outer, same})
        over(s);
    int found = 0;
    const auto rays = gpuRays(prepared->p.view.frame, prepared->budgets.gpu);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::dvec3 d(rays[i].direction), o = glm::dvec3(rays[i].entry) - kMiddle;
        if (glm::length(o - glm::dot(o, d) * d) > 5.5)
            continue;
        ++found;
        for (int c = 0; c < 4; ++c)
            EXPECT_NEAR(static_cast<double>(drawn.image.pixels[i][c]), expected[c], 1e-6);
    }
    EXPECT_GT(found, 10);
}

// The volume before and behind a surface, by every integrator. A slab of constant extinction is cut exactly,
// however long the segments, and an opaque surface hides everything behind it.
TEST(Isosurfaces, CutTheVolumeWhereTheyAre) {
    const GlContext context({"software"});
    const Stored stored([](const glm::dvec3& p) { return p.z; }, {32, 32, 40}, true);
    for (const Integrator integrator :
         {Integrator::midpoint, Integrator::linear, Integrator::preintegrated, Integrator::preintegrated2d})
        for (const double opacity : {0.5, 1.0})
            for (const double q : {0.5, 6.0}) {
                // Red, but far on one side of the surface green, on the other blue; the surface is black.
                const double sigma = 0.04;
                Scene scene = stored.scene({{17.3, glm::dvec3(0), opacity}}, 1, 8);
                const glm::dvec3 red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1);
                scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
                    {{0, sigma}}, {{8, green}, {8, red}, {30, red}, {30, blue}});
                scene.camera = fitCamera(stored.info, View::inferior, Projection::parallel, {8, 8});
                scene.shading.on = false;
                scene.quality.stepVoxels = q;
                scene.quality.integrator = integrator;
                const auto prepared = stored.prepare(scene);
                const Drawn drawn = draw(*prepared);
                const glm::dvec4 pixel(drawn.image.pixels[3 * 8 + 3]);
                const SurfaceHit hit = drawn.hits[3 * 8 + 3];
                SCOPED_TRACE(integratorNames()[static_cast<std::size_t>(integrator)] + " " +
                             std::to_string(q));
                ASSERT_EQ(hit.surface, 1);
                EXPECT_NEAR(hit.position.z, 17.3f, 1e-5f);
                const bool rises = prepared->p.view.frame.toCentre.z > 0; // values along the ray
                const double before = -std::expm1(-sigma * (rises ? 17.3 : 22.7));
                const double behind = -std::expm1(-sigma * (rises ? 22.7 : 17.3));
                const double through = (1 - before) * (1 - opacity);
                EXPECT_NEAR(hit.weight, 1 - before, 2e-6);
                EXPECT_NEAR(pixel.r + pixel.g + pixel.b, before + through * behind, 2e-6);
                EXPECT_NEAR(pixel.a, 1 - through * (1 - behind), 2e-6);
                EXPECT_GT(rises ? pixel.g : pixel.b, 0.05);
                if (opacity == 1) {
                    EXPECT_EQ(rises ? pixel.b : pixel.g, 0);
                } else {
                    EXPECT_GT(rises ? pixel.b : pixel.g, 0.02);
                }
            }
}

// Edges so steep that a cell's values go past surfaces and past 0. After the last hit of a piece no other is
// searched, neither before nor behind it, and no part of the volume is added twice.
TEST(Isosurfaces, NothingIsMetBeyondTheLastOfSteepEdges) {
    const GlContext context({"software"});
    const Formula random = noise(7);
    const Stored stored([&](const glm::dvec3& p) { return 1000 * random(p); }, {12, 10, 12});
    const Isosurface high{300, {1, 0.9, 0.8}, 0.2}, low{-300, {0.2, 0.9, 0.1}, 0.3};
    for (const std::vector<Isosurface>& surfaces :
         {std::vector{high}, std::vector{low}, std::vector{low, high}}) {
        Scene scene = stored.scene(surfaces, 0, 12);
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, 0.1}}, {{0, glm::dvec3(0.1, 0.3, 0.9)}});
        scene.quality.fetch = Fetch::exact;
        scene.quality.terminationTransmittance = 0;
        const auto prepared = stored.prepare(scene);
        const Drawn drawn = draw(*prepared);
        const auto rays = gpuRays(prepared->p.view.frame, prepared->budgets.gpu);
        Work work;
        const auto mirrored = mirrorRays<float>(
            mirrorInput(prepared->p, true), rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
        float largest = 0;
        for (std::size_t i = 0; i < rays.size(); ++i)
            for (int c = 0; c < 4; ++c)
                largest = std::max(largest, std::abs(drawn.image.pixels[i][c] - mirrored[i][c]));
        EXPECT_LE(largest, 1e-5f) << surfaces.size() << " surfaces";
        EXPECT_GT(hitCount(drawn.hits), 40u);
    }
}

// An opaque dark medium hides the bright one behind it and the surface in that, however many segments follow.
// Where alpha can grow no more, colour must not either. Only float's rounding of alpha, 2^-25 over a
// segment's opacity, may shine through.
TEST(Isosurfaces, NothingGrowsBehindAnOpaqueMedium) {
    const GlContext context({"software"});
    const Stored stored([](const glm::dvec3& p) { return p.z; }, {16, 16, 96}, true);
    const glm::dvec3 dark(0.3, 0.1, 0.02), bright(1);
    for (const double sigma : {1.0, 4.0}) {
        Scene scene = stored.scene({{48.3, bright, 1}}, 1, 8);
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
            {{0, sigma}}, {{24, dark}, {24, bright}, {72, bright}, {72, dark}});
        scene.camera = fitCamera(stored.info, View::inferior, Projection::parallel, {8, 8});
        scene.shading.on = false;
        scene.quality.stepVoxels = 1.0 / 64;
        const double segment = -std::expm1(-sigma * scene.quality.stepVoxels);
        const auto prepared = stored.prepare(scene);
        const Drawn drawn = draw(*prepared);
        Work work;
        const auto mirrored = mirrorRays<float>(mirrorInput(prepared->p, true), 64,
                                                frameRays(cast<float>(prepared->p.view.frame)), 1, work);
        for (const glm::vec4& pixel : {drawn.image.pixels[3 * 8 + 3], mirrored[3 * 8 + 3]})
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(static_cast<double>(pixel[c]), dark[c], 1e-6 + std::ldexp(1.0, -24) / segment);
    }
}

} // namespace
} // namespace tessera
