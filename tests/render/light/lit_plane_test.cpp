// tests/render/light/lit_plane_test.cpp: light, by numbers that stand in this file and come from no code of
// ours. A field of planes is known in patient space, and so is its normal, whatever the voxels' spacing and
// shear. It is seen at known angles. Phong's terms are worked out by hand.
#include "render/backends/reference/reference.h"
#include "tests/support/lit_planes.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <iterator>

namespace tessera {
namespace {

using namespace tessera::test;

/// The angle between view and normal, and what it does with ambient 0.1, diffuse 0.6, specular 0.2 and a
/// power of 3: colour * times + plus.
struct Angle {
    double degrees, cosine, sine;
    double times; // 0.1 + 0.6 |cos|
    double plus;  // 0.2 max(0, 2 cos^2 - 1)^3
};
constexpr double kRoot3 = 1.7320508075688772, kRoot2 = 1.4142135623730951;
const Angle kAngles[] = {
    {0, 1, 0, 0.7, 0.2},
    {30, kRoot3 / 2, 0.5, 0.1 + 0.3 * kRoot3, 0.025}, // 0.2 (1/2)^3
    {45, kRoot2 / 2, kRoot2 / 2, 0.1 + 0.3 * kRoot2, 0},
    {60, 0.5, kRoot3 / 2, 0.4, 0},
    {120, -0.5, kRoot3 / 2, 0.4, 0}, // lit from behind as from before
    {150, -kRoot3 / 2, 0.5, 0.1 + 0.3 * kRoot3, 0.025},
};
/// The visible colour at an angle.
glm::dvec3 litBy(const Angle& angle) {
    return kColour * angle.times + glm::dvec3(angle.plus);
}

// A medium of one colour, whatever its extinction does along the ray: all of it is lit alike.
TEST(LitPlane, AMediumHasPhongsColour) {
    const GlContext context({"software"});
    for (std::size_t s = 0; s < std::size(kSpaces); ++s) {
        const Space& space = kSpaces[s];
        const Planes planes(space.patientFromVoxel);
        for (std::size_t a = s % 2; a < std::size(kAngles); a += 2) { // every angle in two of the spaces
            const Angle& angle = kAngles[a];
            SCOPED_TRACE(testing::Message() << space.name << ", " << angle.degrees << " degrees");
            const Projection projection =
                angle.degrees == 60 ? Projection::perspective : Projection::parallel;
            Scene scene = planes.scene(angle.cosine, angle.sine, 0.5, projection);
            const double band = space.millimetres;
            scene.volumes[0].transferFunction =
                TransferFunction::fromExtinction({{-band, 0}, {-0.3 * band, 0.9}, {band, 0}}, {{0, kColour}});
            scene.shading.gradient = kKinds[(a + s) % std::size(kKinds)];
            const auto prepared = planes.prepare(scene);
            Planner& p = prepared->p;
            // A perspective ray is off by a tenth of a degree at most, and the light by 2 % of that.
            const double tolerance = projection == Projection::perspective ? 3e-3 : 2e-5;
            const glm::dvec3 lit = litBy(angle);
            Work work;
            expectLit(marchOn(*prepared, marchFeatures(p, true)).image, lit, tolerance, "march");
            expectLit(pictureOf(mirrorRays<float>(mirrorInput(p, true), 49,
                                                  frameRays(cast<float>(p.view.frame)), 1, work)),
                      lit, tolerance, "float mirror");
            expectLit(
                pictureOf(mirrorRays<double>(mirrorInput(p, true), 49, frameRays(p.view.frame), 1, work)),
                lit, projection == Projection::perspective ? tolerance : 1e-6, "double mirror");
            expectLit(pictureOf(renderReference(
                          {p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, nullptr, 1},
                          referenceRays(p.view.camera, p.info(), p.view.imageSize), 1)),
                      lit, projection == Projection::perspective ? tolerance : 1e-6, "reference");
            scene.shading.on = false;
            const auto dark = planes.prepare(scene);
            expectLit(marchOn(*dark, marchFeatures(dark->p, true)).image, kColour, 1e-6, "unlit march");
        }
    }
}

// An opaque surface is lit as the medium is; its normal is the planes', towards the viewer.
TEST(LitPlane, ASurfaceHasPhongsColourAndThePlanesNormal) {
    const GlContext context({"software"});
    for (std::size_t s = 0; s < std::size(kSpaces); ++s) {
        const Space& space = kSpaces[s];
        const Planes planes(space.patientFromVoxel);
        for (std::size_t a = s % 2; a < std::size(kAngles); a += 2) { // every angle in two of the spaces
            const Angle& angle = kAngles[a];
            SCOPED_TRACE(testing::Message() << space.name << ", " << angle.degrees << " degrees");
            Scene scene = planes.scene(angle.cosine, angle.sine, 0.5, Projection::parallel);
            scene.surfaces = {{0.4, kColour, 1}};
            scene.shading.gradient = kKinds[(a + s) % std::size(kKinds)];
            const auto prepared = planes.prepare(scene);
            const Drawn drawn = draw(*prepared);
            const glm::dvec3 lit = litBy(angle);
            expectLit(drawn.image, lit, 2e-5, "march");
            Planner& p = prepared->p;
            Work work;
            expectLit(
                pictureOf(mirrorRays<double>(mirrorInput(p, true), 49, frameRays(p.view.frame), 1, work)),
                lit, 1e-6, "double mirror");
            const glm::dvec3 facing = angle.cosine > 0 ? kNormal : -kNormal;
            for (std::size_t i = 0; i < drawn.hits.size(); ++i) {
                const SurfaceHit& hit = drawn.hits[i];
                ASSERT_EQ(hit.surface, 1);
                ASSERT_LE(glm::length(glm::dvec3(hit.normal) - facing), 2e-5);
                // On the plane, and as deep as the eye sees it.
                const glm::dvec3 at(p.info().patientFromVoxel * glm::dvec4(glm::dvec3(hit.position), 1));
                const glm::dvec3 middle(planes.place * glm::dvec4(20, 20, 20, 1));
                ASSERT_NEAR(glm::dot(kNormal, at - middle), 0.4, 1e-4);
            }
        }
    }
}

} // namespace
} // namespace tessera
