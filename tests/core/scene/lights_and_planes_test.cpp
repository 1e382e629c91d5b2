// tests/core/scene/lights_and_planes_test.cpp: planes, windows, lights and cuts against their definitions.
#include "core/base/error.h"
#include "core/scene/cuts.h"
#include "core/scene/lighting.h"
#include "core/scene/mode.h"
#include "core/scene/scene.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

/// Planes lie where they are put, and their pictures have right-handed axes.
TEST(SlicePoses, LieAtTheirPlaceAndAreSeenAsRadiologistsDo) {
    const glm::dvec3 middle(3, 5, 7);
    struct Row {
        Orientation orientation;
        int axis;
        glm::dvec3 normal, right, up;
    };
    for (const Row& row : {Row{Orientation::axial, 2, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}},
                           Row{Orientation::coronal, 1, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
                           Row{Orientation::sagittal, 0, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}) {
        SlicePlane slice;
        slice.orientation = row.orientation;
        EXPECT_EQ(poseOf(slice, middle).point, middle);
        slice.positionMm = -41;
        glm::dvec3 point = middle;
        point[row.axis] = -41;
        const SlicePose pose = poseOf(slice, middle);
        EXPECT_EQ(pose.point, point);
        EXPECT_EQ(pose.normal, row.normal);
        EXPECT_LT(glm::length(pose.right - row.right), 1e-12);
        EXPECT_LT(glm::length(pose.up - row.up), 1e-12);
    }
    SlicePlane oblique;
    oblique.orientation = Orientation::oblique;
    oblique.point = {1, 2, 3};
    for (const glm::dvec3 normal :
         {glm::dvec3(1, 2, -3), {0, 0, 5}, {0.01, 0, -1}, {0.02, 0, 1}, {-4, 1, 0.5}}) {
        oblique.normal = normal;
        const SlicePose pose = poseOf(oblique, middle);
        EXPECT_EQ(pose.point, oblique.point);
        EXPECT_LT(glm::length(pose.normal - glm::normalize(normal)), 1e-12);
        EXPECT_LT(glm::length(glm::cross(pose.right, pose.up) - pose.normal), 1e-12);
        const bool level = std::abs(glm::normalize(normal).z) > std::cos(glm::radians(1.0));
        EXPECT_GT(level ? -pose.up.y : pose.up.z, 0) << normal.x;
        EXPECT_NEAR(level ? pose.right.y : pose.right.z, 0, 1e-9);
    }
}

TEST(Windows, OfValuesWithoutAUnitLeaveAFewBrightOnesOut) {
    ValueSummary values{0, 1000, false, 1, std::vector<double>(10)};
    values.histogram = {5000, 3000, 1000, 990, 0, 0, 0, 0, 0, 10}; // exactly a thousandth at the top
    const auto window = [&] { return windowOf("auto", values, Mode::slice); };
    EXPECT_DOUBLE_EQ(window().low(), 0);
    EXPECT_DOUBLE_EQ(window().high(), 400);
    values.histogram[9] = 20; // half of the last bin
    EXPECT_DOUBLE_EQ(window().high(), 1000) << "not that few";
    values.histogram = {5000, 3000, 1000, 0, 0, 990, 0, 0, 0, 10}; // more than half of the range is used
    EXPECT_DOUBLE_EQ(window().high(), 1000);
    values.histogram = {0, 0, 0, 10000, 0, 0, 0, 0, 0, 5};
    EXPECT_NEAR(window().high(), 400 - 100 * (10.005 - 5) / 10000, 1e-9) << "linear within a bin";
    EXPECT_EQ(windowOf("auto", {5, 5, false, 1, {}}, Mode::slice), (GreyWindow{5, 1}));
    EXPECT_EQ(windowOf("auto", {-1024, 3000, true, 1, {}}, Mode::slice), (GreyWindow{50, 400}));
    for (const std::string& name : modeNames()) {
        const auto mode = parseName<Mode>(name, "mode");
        const GreyWindow ofHu = mode == Mode::maximum ? GreyWindow{350, 1100} : GreyWindow{50, 400};
        EXPECT_EQ(windowOf("auto", {-1024, 3000, true, 1, {}}, mode), ofHu) << name;
        EXPECT_EQ(windowOf("lung", {-1024, 3000, true, 1, {}}, mode), (GreyWindow{-600, 1500})) << name;
        EXPECT_EQ(windowOf(GreyWindow{7, 9}, {-1024, 3000, true, 1, {}}, mode), (GreyWindow{7, 9})) << name;
        EXPECT_EQ(windowOf("auto", values, mode), window()) << name;
    }
    const std::vector<std::pair<std::string, GreyWindow>> customary = {
        {"brain", {40, 80}},    {"subdural", {75, 215}}, {"lung", {-600, 1500}}, {"mediastinum", {50, 350}},
        {"abdomen", {50, 400}}, {"liver", {30, 150}},    {"bone", {400, 1800}}};
    for (const auto& [name, expected] : customary)
        EXPECT_EQ(windowOf(name, values, Mode::slice), expected) << name;
    EXPECT_EQ(windowNames().size(), customary.size() + 1);
    EXPECT_EQ(std::get<GreyWindow>(parseWindow("-20,1.5", "--window")), (GreyWindow{-20, 1.5}));
    for (const char* bad :
         {"1,0", "1,-2", "1,", ",1", "1,2,3", "1,x", "1e39,1", "3e38,2e38", "-3e38,2e38", "bon"})
        EXPECT_THROW(parseWindow(bad, "--window"), InputError) << bad;
}

Light lamp(LightKind kind, double intensity, bool shadow) {
    Light light;
    light.kind = kind;
    light.intensity = intensity;
    light.shadow = shadow;
    return light;
}

TEST(Lights, ChannelsAreCountedByWhatShines) {
    Lighting lighting;
    EXPECT_EQ(shiningLights({}).size(), 1u);
    EXPECT_EQ(shiningLights({})[0], Light{});
    EXPECT_TRUE(isHeadLightAlone({}));
    EXPECT_EQ(Light{}.intensity, 1);
    EXPECT_EQ(lightChannels(lighting), 0);
    lighting.lights = {lamp(LightKind::head, 1, true), lamp(LightKind::directional, 1, true),
                       lamp(LightKind::point, 0, true), lamp(LightKind::point, 2, false)};
    EXPECT_EQ(shiningLights(lighting.lights).size(), 3u);
    EXPECT_EQ(castingLights(lighting.lights).size(), 1u) << "none at the eye, none that is out";
    EXPECT_EQ(lightChannels(lighting), 1);
    lighting.lights[2].intensity = 1;
    EXPECT_EQ(lightChannels(lighting), 2);
    lighting.lights[1].colour = glm::dvec3(0);
    EXPECT_EQ(lightChannels(lighting), 1);
    lighting.occlusion.emplace();
    EXPECT_EQ(ambientChannels(lighting), 1);
    EXPECT_EQ(lightChannels(lighting), 2);
    EXPECT_EQ(keptLightChannels(lighting), 2);
    lighting.occlusion->emission = 0.5;
    EXPECT_EQ(ambientChannels(lighting), 3);
    EXPECT_EQ(lightChannels(lighting), 4);
    lighting.lights.clear();
    EXPECT_EQ(lightChannels(lighting), 3);
    EXPECT_EQ(keptLightChannels(lighting), 4);
    lighting.occlusion.reset();
    EXPECT_FALSE(scatters(lighting));
    lighting.lights = {lamp(LightKind::directional, 0, false)};
    lighting.lights[0].scatter = 1;
    EXPECT_FALSE(scatters(lighting)) << "none that is out";
    EXPECT_EQ(lightChannels(lighting), 0);
    lighting.lights[0].intensity = 1;
    EXPECT_TRUE(scatters(lighting));
    EXPECT_EQ(lightChannels(lighting), 3);
    EXPECT_FALSE(isHeadLightAlone({lamp(LightKind::head, 0.5, false)}));
    EXPECT_FALSE(isHeadLightAlone({lamp(LightKind::point, 1, false)}));
    EXPECT_FALSE(isHeadLightAlone({lamp(LightKind::head, 1, false), lamp(LightKind::point, 1, false)}));
    EXPECT_TRUE(isHeadLightAlone({lamp(LightKind::head, 1, false), lamp(LightKind::point, 0, false)}));
    Light coloured = lamp(LightKind::head, 1, false);
    coloured.colour = {1, 0.9, 1};
    EXPECT_FALSE(isHeadLightAlone({coloured}));
}

TEST(Lights, TheMostThatArrivesIsTheSumsBrightestComponent) {
    Light red = lamp(LightKind::directional, 2, false), green = lamp(LightKind::point, 3, false);
    red.colour = {1, 0.1, 0.2}, green.colour = {0.1, 1, 0.4};
    green.attenuation = {2, 0.1, 0};
    EXPECT_DOUBLE_EQ(maxIncidentLight({red, green}), 2 * 1 + 1.5 * 0.1);
    green.intensity = 5;
    EXPECT_DOUBLE_EQ(maxIncidentLight({red, green}), 2 * 0.1 + 2.5 * 1);
    EXPECT_EQ(maxIncidentLight({}), 1);
}

/// What a mode does not show is not drawn, and what it does is kept.
TEST(Modes, DrawWhatTheyShow) {
    Scene scene;
    scene.surfaces = {Isosurface{300}};
    scene.lighting.occlusion.emplace();
    scene.quality.integrator = Integrator::linear;
    EXPECT_EQ(reductionOf(scene), Reduction::composite);
    EXPECT_EQ(asDrawn(scene).surfaces.size(), 1u);
    EXPECT_TRUE(asDrawn(scene).lighting.occlusion);
    EXPECT_EQ(asDrawn(scene).quality.integrator, Integrator::linear);
    for (const auto& [mode, reduction] : {std::pair{Mode::maximum, Reduction::maximum},
                                          {Mode::minimum, Reduction::minimum},
                                          {Mode::average, Reduction::average},
                                          {Mode::slice, Reduction::maximum}}) {
        scene.mode = mode;
        EXPECT_EQ(reductionOf(scene), reduction);
        const Scene drawn = asDrawn(scene);
        EXPECT_TRUE(drawn.surfaces.empty());
        EXPECT_FALSE(drawn.shading.on);
        EXPECT_EQ(drawn.lighting, Lighting{});
        EXPECT_EQ(drawn.quality.integrator, Integrator::midpoint);
    }
    scene.slice.thicknessMm = 2;
    EXPECT_EQ(reductionOf(scene), Reduction::average) << "of the slab";
    scene.mode = Mode::isosurface;
    EXPECT_EQ(asDrawn(scene).surfaces.size(), 1u);
    scene.surfaces[0].opacity = 0;
    EXPECT_THROW(asDrawn(scene), InputError);
    scene.surfaces.clear();
    EXPECT_THROW(asDrawn(scene), InputError);
}

TEST(Cuts, AnOutlineHas3To1024Points) {
    Scissors scissors;
    scissors.camera.position = {0, 0, 5};
    scissors.camera.viewUp = {0, 1, 0};
    for (const std::size_t points : {3, 1024}) {
        scissors.outline.assign(points, {0.5, 0.5});
        EXPECT_NO_THROW(checkScissors(scissors, "f")) << points;
    }
    for (const std::size_t points : {2, 1025}) {
        scissors.outline.assign(points, {0.5, 0.5});
        try {
            checkScissors(scissors, "f");
            ADD_FAILURE() << points << " points are taken";
        } catch (const InputError& error) {
            EXPECT_EQ(error.what(),
                      "f: expected an outline of 3 to 1024 points, found " + std::to_string(points));
        }
    }
}

TEST(Cuts, BoundsAreMetExactly) {
    CropBox box;
    box.low = {0, 0, 0}, box.high = {1, 1, 1};
    checkBox(box, "f");
    for (int axis = 0; axis < 3; ++axis) {
        CropBox flat = box;
        flat.high[axis] = 0;
        EXPECT_THROW(checkBox(flat, "f"), InputError) << axis;
    }
    Scissors scissors;
    scissors.camera.position = {0, 0, 5};
    scissors.camera.focalPoint = {0, 0, 0};
    scissors.camera.viewUp = {0, 1, 0};
    scissors.outline.assign(3, {0.5, 0.5});
    checkScissors(scissors, "f");
    scissors.outline.resize(2);
    EXPECT_THROW(checkScissors(scissors, "f"), InputError);
    scissors.outline.assign(Cuts::kMostPoints, {-0.9e9, 0.9e9});
    checkScissors(scissors, "f");
    scissors.outline.emplace_back(0, 0);
    EXPECT_THROW(checkScissors(scissors, "f"), InputError);
    scissors.outline.assign(3, {0, 1e9});
    EXPECT_THROW(checkScissors(scissors, "f"), InputError);
    scissors.outline.assign(3, {-1e9, 0});
    EXPECT_THROW(checkScissors(scissors, "f"), InputError);
    scissors.outline.assign(3, {0, 0});
    for (const double bad : {0.0, -1.0, 1e9, 1e-9}) {
        scissors.aspect = bad;
        EXPECT_THROW(checkScissors(scissors, "f"), InputError) << bad;
    }
    scissors.aspect = 1.1e-9;
    checkScissors(scissors, "f");
}

TEST(GreyWindows, ReachHalfTheirWidthToEitherSide) {
    EXPECT_EQ((GreyWindow{40, 300}).low(), -110);
    EXPECT_EQ((GreyWindow{40, 300}).high(), 190);
}

} // namespace
} // namespace tessera
