// tests/render/lit_plane_test.cpp: light, by numbers that stand in this file and come from no code of ours: a
// field of planes that is known in patient space, so that its normal is too, whatever the voxels' spacing and
// shear; seen at known angles. Phong's terms are worked out by hand.
#include "render/engines/reference/reference.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <iterator>

namespace tessera {
namespace {

using namespace tessera::test;

/// An orthonormal frame in patient space: the planes' normal, and two directions along them.
const glm::dvec3 kNormal(1.0 / 3, 2.0 / 3, 2.0 / 3), kAlong(2.0 / 3, 1.0 / 3, -2.0 / 3),
    kAside(2.0 / 3, -2.0 / 3, 1.0 / 3);

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
const glm::dvec3 kColour(0.8, 0.4, 0.1);

/// What the eye sees of the colour at an angle.
glm::dvec3 litBy(const Angle& angle) {
    return kColour * angle.times + glm::dvec3(angle.plus);
}

/// 40^3 voxels; the field is the distance in mm from the plane through the middle, along the normal.
struct Planes {
    explicit Planes(const glm::dmat3& linear)
        : stored([linear](const glm::dvec3& p) { return glm::dot(kNormal, linear * (p - 20.0)); },
                 glm::ivec3(40), true),
          place(glm::dmat4(linear)) {
        info = stored.info;
        place[3] = {-7, 31, 110, 1};
        info.patientFromVoxel = place;
    }
    /// Looks at the middle, at the angle, in a picture so narrow that no ray shown meets the volume's border.
    Scene scene(const Angle& angle, double reachMm, Projection projection) const {
        Scene s = stored.scene({}, 0, 7);
        const glm::dvec3 towards = angle.cosine * kNormal + angle.sine * kAlong;
        Camera camera;
        camera.projection = projection;
        camera.focalPoint = glm::dvec3(place * glm::dvec4(20, 20, 20, 1));
        camera.position = camera.focalPoint + 300.0 * towards;
        camera.viewUp = kAside;
        camera.parallelScale = reachMm;
        camera.viewAngle = 0.2;
        s.camera = camera;
        s.shading.ambient = 0.1;
        s.shading.diffuse = 0.6;
        s.shading.specular = 0.2;
        s.shading.specularPower = 3;
        s.quality.stepVoxels = 0.25;
        return s;
    }
    std::unique_ptr<Prepared> prepare(const Scene& scene) const {
        return std::make_unique<Prepared>((stored.folder / "v").string(), scene, true, 0, &place);
    }
    Stored stored;
    glm::dmat4 place;
    VolumeInfo info;
};

struct Space {
    const char* name;
    glm::dmat3 patientFromVoxel; // columns
    double millimetres;          // half the extinction's band, so that it stays inside the volume
};
const Space kSpaces[] = {
    {"plain", glm::dmat3(1), 2},
    {"anisotropic", glm::dmat3(glm::dvec3(0.5, 0, 0), glm::dvec3(0, 0.9, 0), glm::dvec3(0, 0, 3)), 2},
    {"sheared", glm::dmat3(glm::dvec3(0.8, 0, 0), glm::dvec3(0.3, 0.9, 0), glm::dvec3(-0.4, 0.7, 2)), 2},
    {"leftHanded", glm::dmat3(glm::dvec3(0, 0.7, 0), glm::dvec3(1.1, 0, 0), glm::dvec3(0.2, -0.3, 1.7)), 2},
};
/// Directions of kinds that are exact where the field is linear, whatever its pitch.
constexpr Gradient kKinds[] = {Gradient::central, Gradient::centralHalf, Gradient::sobel, Gradient::analytic,
                               Gradient::forward};

/// All pixels of a picture have a colour of the medium, weighed by how opaque they are.
void expectLit(const Image& image, const glm::dvec3& lit, double tolerance, const char* who) {
    for (const glm::vec4& pixel : image.pixels) {
        ASSERT_GT(pixel.a, 0.3f) << who;
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(static_cast<double>(pixel[c]) / static_cast<double>(pixel.a), lit[c], tolerance)
                << who << ", component " << c;
    }
}

template <typename Pixels> Image pictureOf(const Pixels& pixels) {
    Image image(glm::ivec2(7));
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = glm::vec4(pixels[i]);
    return image;
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
            Scene scene = planes.scene(angle, 0.5, projection);
            const double band = space.millimetres;
            scene.volumes[0].transferFunction =
                TransferFunction::fromExtinction({{-band, 0}, {-0.3 * band, 0.9}, {band, 0}}, {{0, kColour}});
            scene.shading.gradient = kKinds[(a + s) % std::size(kKinds)];
            const auto prepared = planes.prepare(scene);
            ScenePlan& p = prepared->p;
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
                          {p.volume.cache.get(), &p.info(), &p.volume.function, scene.shading, nullptr, 1},
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
            Scene scene = planes.scene(angle, 0.5, Projection::parallel);
            scene.surfaces = {{0.4, kColour, 1}};
            scene.shading.gradient = kKinds[(a + s) % std::size(kKinds)];
            const auto prepared = planes.prepare(scene);
            const Drawn drawn = draw(*prepared);
            const glm::dvec3 lit = litBy(angle);
            expectLit(drawn.image, lit, 2e-5, "march");
            ScenePlan& p = prepared->p;
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
