// tests/render/contract/optics_numbers_test.cpp: a scene's looks as the numbers that all engines read: places
// in the table, gradients, materials, lights in their frames and channels, isosurfaces. By hand, for falling
// values and a sheared volume.
#include "render/contract/optics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace tessera {
namespace {

VolumeInfo sheared() {
    VolumeInfo info;
    info.extentVoxels = {20, 30, 40};
    info.rescaleSlope = -2, info.rescaleIntercept = 100;
    info.patientFromVoxel = glm::dmat4(1.5, 0.2, 0, 0, 0, 0.8, 0.3, 0, 0.1, 0, 2, 0, 7, 8, 9, 1);
    return info;
}

TEST(OpticsNumbers, ArePlacesInTheTable) {
    const VolumeInfo info = sheared();
    TransferFunction function = TransferFunction::fromExtinction({{-300, 0}, {-50, 0.2}, {100, 0.4}}, {});
    const TransferTable table = makeTable(function);
    Shading shading;
    shading.on = true;
    shading.gradient = Gradient::sobel;
    shading.ambient = 0.3, shading.diffuse = 0.6, shading.specular = 0.2;
    shading.specularPower = 12.6;
    const Optics o = makeOptics(table, info, shading, 0.01);
    EXPECT_EQ(o.table, table.entries);
    EXPECT_EQ(o.termination, 0.01f);
    EXPECT_EQ(o.integrator, Integrator::midpoint);
    EXPECT_TRUE(o.volumeShows && o.shading && o.takesGradients());
    EXPECT_FALSE(o.grades());
    EXPECT_EQ(o.gradient, Gradient::sobel);
    EXPECT_EQ(o.phong, glm::vec3(0.3f, 0.6f, 0.2f));
    EXPECT_EQ(o.specularPower, 13) << "rounded";
    for (const double stored : {30.0, 75.0, 120.0, 199.0}) {
        const double value = 100 - 2 * stored;
        const double entry = (value - double{table.firstValue}) * double{table.entriesPerValue};
        EXPECT_NEAR(placeOf(o, stored), entry, 1e-3) << stored;
        EXPECT_NEAR(lookUp(o, stored).a, function.extinction(value), 1e-3);
    }
    const glm::dmat3 linear(info.patientFromVoxel);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) {
            EXPECT_NEAR(o.patientFromVoxel[column][row], linear[column][row], 1e-6);
            EXPECT_NEAR(o.voxelFromPatientTransposed[column][row], glm::inverse(linear)[row][column], 1e-6);
        }
    shading.on = false;
    for (const auto& [named, power] : {std::pair(0.2, 1), {1.5, 2}, {1024.4, 1024}, {5000.0, 1024}}) {
        shading.specularPower = named;
        const Optics unlit = makeOptics(table, info, shading, 0);
        EXPECT_EQ(unlit.specularPower, power);
        EXPECT_FALSE(unlit.shading || unlit.takesGradients());
        EXPECT_EQ(unlit.termination, 0);
    }
    const TransferTable nothing = makeTable(TransferFunction::fromExtinction({}, {}));
    EXPECT_FALSE(makeOptics(nothing, info, shading, 0).volumeShows);
}

// Lengths are physical units per mm in the scene, stored units per mm in the numbers; slopes from point to
// point.
TEST(OpticsNumbers, GradeByStoredUnits) {
    const VolumeInfo info = sheared();
    const GradientOpacity factor = GradientOpacity::fromPoints({{10, 0.2}, {50, 0.8}, {50, 0.5}, {90, 0.1}});
    const leaf::GradientNumbers<double> numbers = gradientNumbers(factor, info);
    ASSERT_EQ(numbers.count, 4);
    const double lengths[] = {5, 25, 25, 45}, factors[] = {0.2, 0.8, 0.5, 0.1},
                 slopes[] = {0.03, 0, -0.02, 0};
    for (int n = 0; n < 4; ++n) {
        EXPECT_NEAR(numbers.length[n], lengths[n], 1e-12) << n;
        EXPECT_NEAR(numbers.factor[n], factors[n], 1e-12) << n;
        EXPECT_NEAR(numbers.slope[n], slopes[n], 1e-12) << n;
    }
    EXPECT_EQ(gradientNumbers(GradientOpacity(), info).count, 0);
}

TEST(OpticsNumbers, OfMaterialsAndWeightsAreStored) {
    const VolumeInfo info = sheared();
    Shading shading;
    shading.on = true;
    shading.gradientWeight = GradientWeight{20, 60};
    shading.model = ShadingModel::blinnPhong;
    Optics o;
    const std::vector<Material> materials = {{-40, 20, 0.1, 0.2, 0.3, 7, {0, 0.5, 1}},
                                             {20, 60, 0.4, 0.5, 0.6, 9}};
    setLighting(o, shading, {}, materials, {}, info);
    EXPECT_TRUE(o.hasLights && o.lighting.emits);
    EXPECT_EQ(o.lighting.model.halfway, 1);
    EXPECT_FLOAT_EQ(o.lighting.model.weightLow, 10);
    EXPECT_FLOAT_EQ(o.lighting.model.weightScale, 1.0f / 20);
    ASSERT_EQ(o.materials.size(), 2u);
    EXPECT_EQ(o.materials[0].from, 70);
    EXPECT_EQ(o.materials[0].to, 40);
    EXPECT_EQ(o.materials[1].from, 40);
    EXPECT_EQ(o.materials[1].to, 20);
    EXPECT_EQ(o.materials[0].ambient, 0.1f);
    EXPECT_EQ(o.materials[0].diffuse, 0.2f);
    EXPECT_EQ(o.materials[0].specular, 0.3f);
    EXPECT_EQ(o.materials[0].power, 7);
    EXPECT_EQ(o.materials[0].emission[1], 0.5f);
    EXPECT_EQ(o.materials[0].emission[2], 1);
    EXPECT_EQ(o.materials[1].power, 9);
    EXPECT_EQ(o.materials[1].emission[0], 0);
    // Nothing is asked for: a head light alone, and no numbers.
    Shading plain;
    plain.on = true;
    setLighting(o, plain, {}, {}, {}, info);
    EXPECT_FALSE(o.hasLights || o.lighting.emits);
    EXPECT_TRUE(o.materials.empty());
    EXPECT_EQ(o.lighting.count, 0);
    // Each that asks for more.
    const auto asks = [&](const Shading& s, const Lighting& l, const std::vector<Material>& m) {
        setLighting(o, s, l, m, {}, info);
        return o.hasLights;
    };
    Lighting occluded, dim, two;
    occluded.occlusion.emplace();
    dim.lights = {Light{}};
    dim.lights[0].intensity = 0.9;
    EXPECT_TRUE(asks(plain, occluded, {}));
    EXPECT_TRUE(asks(plain, dim, {}));
    EXPECT_TRUE(asks(plain, {}, {materials[1]}));
    EXPECT_FALSE(o.lighting.emits);
    Shading halfway = plain, weighted = plain, off = plain;
    halfway.model = ShadingModel::blinnPhong;
    weighted.gradientWeight = GradientWeight{5, 5};
    off.on = false;
    EXPECT_TRUE(asks(halfway, {}, {}));
    EXPECT_TRUE(asks(weighted, {}, {}));
    EXPECT_EQ(o.lighting.model.weightScale, std::numeric_limits<float>::max()) << "a step";
    EXPECT_EQ(o.lighting.model.halfway, 0);
    EXPECT_FALSE(asks(off, dim, materials));
}

TEST(OpticsNumbers, OfLightsAreInTheirFrames) {
    const VolumeInfo info = sheared();
    const glm::dmat4 toVoxels = glm::inverse(info.patientFromVoxel);
    Camera camera; // right is x, up z, towards the viewer -y
    camera.position = {5, -90, 7}, camera.focalPoint = {5, 10, 7}, camera.viewUp = {0, 0, 1};
    Light sun, fixed, lamp, head;
    sun.kind = LightKind::directional, sun.direction = {0, 3, 4};
    sun.colour = {1, 0.5, 0.25}, sun.intensity = 2, sun.shadow = true;
    fixed.kind = LightKind::directional, fixed.frame = LightFrame::patient, fixed.direction = {0, 3, 4};
    lamp.kind = LightKind::point, lamp.position = {1, 2, 3}, lamp.attenuation = {0.5, 0.02, 0.001},
    lamp.shadow = true;
    head.shadow = true; // at the eye: none is seen
    Lighting lighting;
    lighting.lights = {sun, fixed, head, lamp};
    Shading shading;
    shading.on = true;
    Optics o;
    setLighting(o, shading, lighting, {}, camera, info);
    ASSERT_EQ(o.lighting.count, 4);
    EXPECT_EQ(o.lighting.channels, 2);
    EXPECT_EQ(o.lighting.occlusionChannel, -1);
    EXPECT_EQ(o.lighting.ambientChannels, 1);
    const auto expect = [&](int light, leaf::LightSort sort, const glm::dvec3& place, int channel) {
        const leaf::LightNumbers& n = o.lighting.lights[light];
        EXPECT_EQ(n.sort, sort) << light;
        EXPECT_EQ(n.channel, channel) << light;
        for (int i = 0; i < 3 && sort != leaf::LightSort::head; ++i) // which has none
            EXPECT_NEAR(n.place[i], place[i], 1e-5) << light;
    };
    const auto voxelOf = [&](const glm::dvec3& patient) {
        return glm::dvec3(toVoxels * glm::dvec4(patient, 1));
    };
    expect(0, leaf::LightSort::directional, {0, -0.8, 0.6}, 0);
    expect(1, leaf::LightSort::directional, {0, 0.6, 0.8}, -1);
    expect(2, leaf::LightSort::head, {0, 0, 0}, -1);
    expect(3, leaf::LightSort::point, voxelOf({6, -93, 9}), 1);
    EXPECT_EQ(o.lighting.lights[0].colour[0], 2);
    EXPECT_EQ(o.lighting.lights[0].colour[1], 1);
    EXPECT_EQ(o.lighting.lights[0].colour[2], 0.5f);
    EXPECT_EQ(o.lighting.lights[3].fading[0], 0.5f);
    EXPECT_EQ(o.lighting.lights[3].fading[1], 0.02f);
    EXPECT_EQ(o.lighting.lights[3].fading[2], 0.001f);
    // From elsewhere, with ambient light before the shadows; one light shines no more.
    camera.position = {105, 10, 7};
    lighting.occlusion = Occlusion{.emission = 1};
    lighting.lights[1].intensity = 0;
    lighting.lights[3].frame = LightFrame::patient;
    const int ambient = ambientChannels(lighting);
    ASSERT_EQ(ambient, 3);
    placeLights(o, lighting, camera, info);
    ASSERT_EQ(o.lighting.count, 3);
    EXPECT_EQ(o.lighting.occlusionChannel, 0);
    EXPECT_EQ(o.lighting.ambientChannels, 3);
    EXPECT_EQ(o.lighting.channels, 5);
    expect(0, leaf::LightSort::directional, {0.8, 0, 0.6}, 3);
    expect(1, leaf::LightSort::head, {0, 0, 0}, -1);
    expect(2, leaf::LightSort::point, voxelOf({1, 2, 3}), 4);
}

TEST(OpticsNumbers, OfSurfacesAreSortedAsStored) {
    const VolumeInfo info = sheared();
    const double voxelMm = std::cbrt(1.5 * 0.8 * 2 + 0.2 * 0.3 * 0.1);
    const std::vector<SurfaceLook> looks = surfaceLooks(
        {{-20, {1, 0.5, 0}, 0.3}, {40, {0, 1, 0}, 0}, {60, {0, 0, 1}, 1}, {0, {1, 1, 1}, 0.9}}, info);
    ASSERT_EQ(looks.size(), 3u) << "what is transparent is left out";
    const double values[] = {60, 0, -20}, opacities[] = {1, 0.9, 0.3};
    for (int n = 0; n < 3; ++n) {
        const SurfaceLook& look = looks[static_cast<std::size_t>(n)];
        EXPECT_FLOAT_EQ(look.isovalue, static_cast<float>((100 - values[n]) / 2));
        EXPECT_FLOAT_EQ(look.opacity, static_cast<float>(opacities[n]));
        const double opacity = std::min(opacities[n], 1 - std::ldexp(1.0, -24));
        EXPECT_NEAR(look.occlusion, -std::log(1 - opacity) / voxelMm, 1e-4);
    }
    EXPECT_EQ(looks[0].colour, glm::vec3(0, 0, 1));
}

} // namespace
} // namespace tessera
