// tests/render/backends/surface_reference_test.cpp: isosurfaces against the reference, which finds them on
// its own: alone, where the step has no say, and in a volume, where it has.
#include "core/image/image_metrics.h"
#include "render/backends/mirror/mirror.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/reference_proof.h"
#include "render/backends/reference/simpson_ray.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;

std::vector<glm::dvec4> truthOf(Prepared& prepared, const Scene& scene) {
    Planner& p = prepared.p;
    const ReferenceInput input{p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading,
                               &p.layer().statistics, 1,         scene.surfaces};
    return renderReference(input, referenceRays(p.view.camera, p.info(), p.view.imageSize), 0);
}
std::vector<glm::dvec4> mirrored(Prepared& prepared) {
    Planner& p = prepared.p;
    Work work;
    return mirrorRays<double>(mirrorInput(p, true),
                              static_cast<std::size_t>(p.view.imageSize.x) *
                                  static_cast<std::size_t>(p.view.imageSize.y),
                              frameRays(p.view.frame), 0, work);
}
double largestOf(const glm::dvec4& a, const glm::dvec4& b) {
    const glm::dvec4 d = glm::abs(a - b);
    return std::max(std::max(d.x, d.y), std::max(d.z, d.w));
}

// The remaining difference: the mirror holds isovalues and colours as floats, 1e-5 where surfaces are met
// squarely. A normal turns fast across an edge of a cell, so that some pixels differ more. A ray that almost
// touches a surface may hit it by one of the two and not by the other.
TEST(SurfaceReference, SurfacesAloneAreTheTruthAtAnyStep) {
    for (const int camera : {0, 1, 2})
        for (const Gradient gradient : {Gradient::central, Gradient::analytic, Gradient::sobel,
                                        Gradient::centralHalf, Gradient::cubic, Gradient::sobel2}) {
            SCOPED_TRACE(camera);
            Scene scene = torsoScene(camera, false, Integrator::midpoint, {40, 40});
            scene.shading.gradient = gradient;
            scene.quality.stepVoxels = camera == 0 ? 8 : camera == 1 ? 2 : 0.5;
            Prepared prepared("torso", scene);
            ASSERT_EQ(prepared.p.layer().selection.finest(), 0);
            const auto truth = truthOf(prepared, scene), drawn = mirrored(prepared);
            std::size_t seen = 0, off = 0, far = 0;
            for (std::size_t i = 0; i < truth.size(); ++i) {
                seen += truth[i].a > 0 ? 1 : 0;
                off += largestOf(truth[i], drawn[i]) > 1e-5 ? 1 : 0;
                far += largestOf(truth[i], drawn[i]) > 1e-3 ? 1 : 0;
            }
            EXPECT_GT(seen, 100u);
            EXPECT_LE(off, truth.size() / 100);
            EXPECT_LE(far, truth.size() / 500);
        }
}

// Values whose plateau is the function's first point, in units in which rounding tells the two apart: the
// integrators of the verification see what rises above it.
TEST(SurfaceReference, BothIntegratorsSeeWhatBeginsAtAPointOfTheFunction) {
    const double slope = 0.7;
    ASSERT_LT(3 * slope / slope, 3);
    const Stored stored(
        [](const glm::dvec3& p) { return 3 + std::max(0.0, 6 - glm::length(p - glm::dvec3(20, 21, 22))); },
        glm::ivec3(44, 40, 48), true, slope, ValueType::f32);
    Scene scene = stored.scene({}, 0, 12);
    scene.shading.on = false;
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
        {{3 * slope, 0}, {30 * slope, 3}}, {{3 * slope, {1, 0.5, 0}}, {9 * slope, {0, 0.5, 1}}});
    const auto prepared = stored.prepare(scene);
    const FramePlan& p = prepared->p;
    const ReferenceInput input{
        p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, &p.layer().statistics, 1, {}};
    const auto truth = truthOf(*prepared, scene);
    const auto rays = referenceRays(p.view.camera, p.info(), p.view.imageSize);
    LatticeReader samples(*p.layer().cache, p.info(), 0, nullptr);
    SimpsonRay simpson(input, p.layer().optics, samples);
    std::size_t seen = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_LT(largestOf(simpson(rays[i]), truth[i]), 1e-9) << i;
        seen += truth[i].a > 0.01;
    }
    EXPECT_GT(seen, 3u);
}

// Plateaus at the isovalues, surfaces of one value, and values that fall where stored ones rise. The side of
// a value and the order of two surfaces are the same for the reference, the second integrator and the mirror.
TEST(SurfaceReference, SidesAndOrderAreTheSame) {
    for (const double slope : {1.0, -0.1}) {
        SCOPED_TRACE(slope);
        const Stored stored([](const glm::dvec3& p) { return std::floor((p.x + 0.3 * p.y) / 5); },
                            {44, 40, 48}, false, slope);
        Scene scene = stored.scene(
            {{3 * slope, {1, 0, 0}, 0.5}, {3 * slope, {0, 1, 0}, 0.5}, {5 * slope, {0, 0, 1}, 0.7}});
        scene.shading.on = false;
        const auto prepared = stored.prepare(scene);
        const auto truth = truthOf(*prepared, scene), drawn = mirrored(*prepared);
        std::size_t seen = 0, off = 0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            seen += truth[i].r > 0.3 && truth[i].g > 0.2 ? 1 : 0;
            off += largestOf(truth[i], drawn[i]) > 1e-5 ? 1 : 0;
        }
        EXPECT_GT(seen, 50u);
        EXPECT_EQ(off, 0u);
        Planner& p = prepared->p;
        const ReferenceInput input{
            p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, nullptr, 1, scene.surfaces};
        EXPECT_TRUE(
            proveOnRays(input, sampledRays(referenceRays(p.view.camera, p.info(), p.view.imageSize), 200), 0)
                .holds());
    }
}

// In a volume the parts between crossings are segments, and their error falls with the step.
TEST(SurfaceReference, TheVolumeBetweenThemConverges) {
    for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated}) {
        std::vector<double> errors;
        for (const double step : {1.0, 0.5, 0.25}) {
            Scene scene = torsoScene(1, true, integrator, {32, 32});
            scene.quality.stepVoxels = step;
            Prepared prepared("torso", scene);
            const auto truth = truthOf(prepared, scene), drawn = mirrored(prepared);
            double sum = 0;
            for (std::size_t i = 0; i < truth.size(); ++i)
                sum += std::pow(largestOf(truth[i], drawn[i]), 2);
            errors.push_back(std::sqrt(sum / static_cast<double>(truth.size())));
        }
        EXPECT_LT(errors[0], 0.03);
        EXPECT_LT(errors[1], 0.6 * errors[0]);
        EXPECT_LT(errors[2], 0.6 * errors[1]);
        EXPECT_GT(errors[2], 0);
    }
}

} // namespace
} // namespace tessera
