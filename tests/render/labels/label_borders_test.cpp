// tests/render/labels/label_borders_test.cpp: borders of labels, by which errors of levels are predicted.
#include "render/plan/planner.h"
#include "tests/support/label_tools.h"
#include "tests/support/labelled.h"
#include "tests/support/surface_fixture.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

/// The shares of border of four bricks along an axis; a label begins at a voxel.
std::vector<float> bordersOf(int axis, int first) {
    glm::ivec3 extent(32);
    extent[axis] = 128;
    const Stored volume([](const glm::dvec3&) { return 100.0; }, extent, true);
    HeldLayer layer(volume.info, Values(cellCount(extent)));
    for (std::size_t i = 0; i < layer.values.size(); ++i)
        layer.values[i] = gridPosition(i, extent)[axis] >= first ? 1 : 0;
    const ScratchFolder folder;
    LabelFile file = fileOf({layer});
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    importLabels(file, volume.info, folder / "l.zarr", ram, quickly());
    Scene scene = volume.scene({});
    label(scene, folder / "l.zarr");
    const auto prepared = volume.prepare(scene);
    std::vector<float> borders;
    for (const Statistics::LabelledBrick& brick : prepared->p.layer().statistics.labelledBricks)
        borders.push_back(brick.borders);
    return borders;
}

// A border counts in its brick, and a little in one that it comes near to; not further away.
TEST(LabelBorders, CountBesideTheirBrick) {
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<float> inside = bordersOf(axis, 48), near = bordersOf(axis, 36),
                                 between = bordersOf(axis, 32);
        ASSERT_EQ(inside.size(), 4u);
        EXPECT_EQ(inside[0], 0);
        EXPECT_GE(inside[1], 0.25f);
        EXPECT_EQ(inside[2], 0);
        EXPECT_GT(near[0], 0);
        EXPECT_LT(near[0], 0.2f * near[1]);
        EXPECT_EQ(near[2], 0);
        // Between two bricks: in both alike.
        EXPECT_EQ(between[0], between[1]);
        EXPECT_GE(between[0], 0.25f);
        EXPECT_EQ(between[3], 0);
    }
}

} // namespace
} // namespace tessera
