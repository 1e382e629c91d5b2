// tests/support/lit_planes.h: a field of planes that is known in patient space, and so is its normal,
// whatever the voxels' spacing and shear. Also scenes of it and the expected pixels of their pictures.
#pragma once

#include "tests/support/surface_fixture.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <memory>

namespace tessera::test {

/// An orthonormal frame in patient space: the planes' normal, and two directions along them.
inline const glm::dvec3 kNormal(1.0 / 3, 2.0 / 3, 2.0 / 3), kAlong(2.0 / 3, 1.0 / 3, -2.0 / 3),
    kAside(2.0 / 3, -2.0 / 3, 1.0 / 3);

inline const glm::dvec3 kColour(0.8, 0.4, 0.1);

/// 40^3 voxels; the field is the distance in mm from the plane through the middle, along the normal.
struct Planes {
    /// @param slope  of the values that are stored, so of their gradient in physical units per mm
    explicit Planes(const glm::dmat3& linear, double slope = 1)
        : stored([linear](const glm::dvec3& p) { return glm::dot(kNormal, linear * (p - 20.0)); },
                 glm::ivec3(40), true, slope),
          place(glm::dmat4(linear)) {
        info = stored.info;
        place[3] = {-7, 31, 110, 1};
        info.patientFromVoxel = place;
    }
    /// Looks at the middle, at the angle, in a picture so narrow that no ray shown meets the volume's border.
    Scene scene(double cosine, double sine, double reachMm, Projection projection) const {
        Scene s = stored.scene({}, 0, 7);
        const glm::dvec3 towards = cosine * kNormal + sine * kAlong;
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
inline const Space kSpaces[] = {
    {"plain", glm::dmat3(1), 2},
    {"anisotropic", glm::dmat3(glm::dvec3(0.5, 0, 0), glm::dvec3(0, 0.9, 0), glm::dvec3(0, 0, 3)), 2},
    {"sheared", glm::dmat3(glm::dvec3(0.8, 0, 0), glm::dvec3(0.3, 0.9, 0), glm::dvec3(-0.4, 0.7, 2)), 2},
    {"leftHanded", glm::dmat3(glm::dvec3(0, 0.7, 0), glm::dvec3(1.1, 0, 0), glm::dvec3(0.2, -0.3, 1.7)), 2},
};
/// Directions of kinds that are exact where the field is linear, whatever its pitch.
constexpr Gradient kKinds[] = {Gradient::central,  Gradient::centralHalf, Gradient::sobel,
                               Gradient::analytic, Gradient::forward,     Gradient::cubic};

/// All pixels of a picture have a colour of the medium, weighed by how opaque they are.
inline void expectLit(const Image& image, const glm::dvec3& lit, double tolerance, const char* who) {
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

} // namespace tessera::test
