// tests/core/scene/colour_legend_test.cpp: the legend's bars have the colours and values of the volumes that
// are shown.
#include "core/image/colour.h"
#include "core/scene/colour_legend.h"

#include <glm/vector_relational.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

Scene ofTwo() {
    Scene scene;
    scene.volumes = {
        {"/of a patient/ct.zarr", TransferFunction::fromOpacity({{-100, 0}, {300, 1}}, {{0, {1, 0, 0}}}, 1)},
        {"pet.zarr", TransferFunction::fromOpacity({{2, 0}, {50, 1}}, {{2, {0, 0, 0}}, {10, {0, 1, 0}}}, 1)}};
    return scene;
}
std::vector<LegendVolume> volumesOfTwo() {
    ValueSummary ct, pet;
    ct.lowest = -1024, ct.highest = 2000, ct.isHu = true;
    pet.lowest = 0, pet.highest = 20;
    return {{ct, "HU"}, {pet, ""}};
}

TEST(ColourLegend, HasTheFunctionsOfVisibleVolumes) {
    Scene scene = ofTwo();
    const std::vector<LegendBar> bars = colourLegend(scene, volumesOfTwo());
    ASSERT_EQ(bars.size(), 2u);
    EXPECT_EQ(bars[0].title(), "ct, HU");
    EXPECT_EQ(bars[1].title(), "pet");
    EXPECT_EQ(bars[0].textAt(0) + " " + bars[0].textAt(0.5) + " " + bars[0].textAt(1), "-100 100 300");
    EXPECT_EQ(bars[1].textAt(0) + " " + bars[1].textAt(1), "2 20") << "no further than the values go";
    EXPECT_EQ(bars[0].colours.front(), glm::dvec3(1, 0, 0));
    EXPECT_EQ(bars[1].colours.front(), glm::dvec3(0, 0, 0));
    EXPECT_EQ(bars[1].colours.back(), glm::dvec3(0, 1, 0));
    scene.volumes[0].opacity = 0;
    EXPECT_EQ(colourLegend(scene, volumesOfTwo()).size(), 1u);
    EXPECT_EQ(colourLegend(scene, volumesOfTwo()).front().title(), "pet");
    const std::vector<LegendVolume> first = {volumesOfTwo().front()};
    EXPECT_TRUE(colourLegend(scene, first).empty());
}

TEST(ColourLegend, HasTheGreysOfTheWindow) {
    Scene scene = ofTwo();
    scene.mode = Mode::slice;
    scene.window = GreyWindow{40, 400};
    scene.volumes[1].valueColour = ValueColour::transferFunction;
    const std::vector<LegendBar> bars = colourLegend(scene, volumesOfTwo());
    ASSERT_EQ(bars.size(), 2u);
    EXPECT_EQ(bars[0].textAt(0) + " " + bars[0].textAt(1), "-160 240");
    EXPECT_EQ(bars[0].colours.front(), glm::dvec3(0));
    EXPECT_EQ(bars[0].colours.back(), glm::dvec3(1));
    EXPECT_EQ(bars[1].colours.back(), glm::dvec3(0, 1, 0));
    EXPECT_TRUE(needsLegend(scene));
    scene.volumes[1].opacity = 0;
    EXPECT_FALSE(needsLegend(scene)) << "nothing lies over it";
    scene = ofTwo();
    EXPECT_FALSE(needsLegend(scene)) << "no slice";
    scene.mode = Mode::isosurface;
    EXPECT_TRUE(colourLegend(scene, volumesOfTwo()).empty());
}

TEST(ColourLegend, KnowsWhichVolumeItIsOf) {
    Scene scene = ofTwo();
    scene.volumes.push_back(scene.volumes[1]);
    scene.volumes[0].opacity = 0;
    std::vector<LegendVolume> volumes = volumesOfTwo();
    volumes.push_back(volumes[1]);
    const std::vector<LegendBar> bars = colourLegend(scene, volumes);
    ASSERT_EQ(bars.size(), 2u);
    EXPECT_EQ(bars[0].volume, 1u);
    EXPECT_EQ(bars[1].volume, 2u);
}

} // namespace
} // namespace tessera
