// tests/render/backends/native_blocks_test.cpp: in every block of 2^3 voxels the field stays within the range
// that the native engine says, whatever levels meet; and leaps over blocks change no picture.
#include "render/backends/native/block_ranges.h"
#include "render/backends/native/fine_blocks.h"
#include "render/backends/native/native_field.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

/// A scene's bricks in an engine, all there.
class Bricks {
  public:
    Bricks(Prepared& prepared, bool ghostLayers)
        : p_(prepared.p), engine_(0, prepared.budgets.gpu, prepared.budgets.ram) {
        p_.layer().pageEdge = ghostLayers ? kGhostedEdge : kBrickExtent;
        p_.chosen.chooser.reset();
        p_.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p_.layer().selection.counts));
        Work work;
        loadBricks(engine_, p_, prepared.budgets.gpu, work);
    }
    const HostPlane& plane() { return engine_.settled(); }

  private:
    Planner& p_;
    NativeEngine engine_;
};

/// Ranges in other units, as of a table's entries, are the same ranges.
void expectInOtherUnits(const native::CellRanges& r, const native::CellRanges& other, float scale,
                        float offset) {
    const auto expectScaled = [&](float value, float scaled) {
        const float expected = scale * value + offset;
        EXPECT_TRUE(std::abs(scaled - expected) <= (std::abs(scale * value) + std::abs(offset)) / 131072.0f)
            << scaled << ", expected " << expected;
    };
    for (int block = 0; block < 64; ++block) {
        expectScaled(r.blockLow[block], other.blockLow[block]);
        expectScaled(r.blockHigh[block], other.blockHigh[block]);
    }
    expectScaled(r.low, other.low);
    expectScaled(r.high, other.high);
}

/// Random points of every block of cells: each value within the block's range. If nothing is blended a
/// block's range is no wider than that of dense points, so that it is not "everything".
/// @param wasted  excess of ranges over the values found, in the mean, as a share of all cells' ranges
void expectWithinRanges(Prepared& prepared, bool ghostLayers, unsigned seed, double wasted) {
    Planner& p = prepared.p;
    Bricks bricks(prepared, ghostLayers);
    const HostPlane& plane = bricks.plane();
    const LevelMap* const map = p.layer().mixed() ? &p.layer().levels : nullptr;
    const int level = p.layer().selection.finest();
    constexpr float kScale = 0.37f, kOffset = -12;
    BlockRanges ranges(plane, map, level, 1, 0, native::packetTarget());
    BlockRanges inOtherUnits(plane, map, level, kScale, kOffset, native::packetTarget());
    NativeField field(plane, map, level, Gradient::central);
    std::mt19937 random(seed);
    const glm::ivec3 extent = p.info().extentVoxels, cells = cellGrid(extent);
    std::uniform_real_distribution<float> anywhere(0, 2);
    double widths = 0, found = 0;
    for (int n = 0; n < 400; ++n) {
        const glm::ivec3 cell(static_cast<int>(random() % static_cast<unsigned>(cells.x)),
                              static_cast<int>(random() % static_cast<unsigned>(cells.y)),
                              static_cast<int>(random() % static_cast<unsigned>(cells.z)));
        const native::CellRanges& r = ranges.of(cell);
        expectInOtherUnits(r, inOtherUnits.of(cell), kScale, kOffset);
        for (int block = 0; block < 64; ++block) {
            const glm::ivec3 at(block % 4, block / 4 % 4, block / 16);
            const glm::vec3 first(8 * cell + 2 * at);
            if (glm::any(glm::greaterThanEqual(glm::ivec3(first), extent)))
                continue;
            float low = std::numeric_limits<float>::infinity(), high = -low;
            for (int point = 0; point < 40; ++point) {
                glm::vec3 inside(anywhere(random), anywhere(random), anywhere(random));
                if (point < 27) // places of extreme values, if there are any
                    inside = {static_cast<float>(point % 3), static_cast<float>(point / 3 % 3),
                              static_cast<float>(point / 9)};
                const glm::vec3 where = glm::min(first + inside, glm::vec3(extent));
                const float value = field.value(where);
                low = std::min(low, value);
                high = std::max(high, value);
            }
            const float slack =
                (std::max(std::abs(r.low), std::abs(r.high)) + 1) / 131072.0f; // as fine_blocks.cpp
            ASSERT_GE(low, r.blockLow[block] - slack) << "cell " << cell.x << "," << cell.y << "," << cell.z;
            ASSERT_LE(high, r.blockHigh[block] + slack) << "block " << block;
            ASSERT_LE(r.low, r.blockLow[block]) << "a cell holds what its blocks hold";
            ASSERT_GE(r.high, r.blockHigh[block]);
            widths += static_cast<double>(r.blockHigh[block] - r.blockLow[block]);
            found += static_cast<double>(high - low);
        }
    }
    EXPECT_FALSE(field.takeMissing());
    EXPECT_LT(widths, (1 + wasted) * found);
}

TEST(BlockRanges, HoldTheFieldOfMixedLevels) {
    for (const EdgeFunction edge : kEdgeFunctions)
        for (const bool shown : {true, false}) {
            SCOPED_TRACE(static_cast<int>(edge));
            MixedScene mixed("torso", "soft-tissue", 0, edge, Sampling::limited, {8, 8});
            mixed.choose(shown ? randomShownLevels(mixed.p().layer().selection, 5)
                               : randomLevels(mixed.p().layer().selection, 6, true));
            ASSERT_TRUE(mixed.p().layer().mixed());
            // Hulls of neighbours that have little weight: wider than what comes of them.
            expectWithinRanges(*mixed.prepared, true, 7, 5);
        }
}

TEST(BlockRanges, HoldTheFieldOfOneLevelClosely) {
    for (int level = 0; level < kLevelCount; ++level)
        for (const bool ghostLayers : {true, false}) {
            SCOPED_TRACE(level);
            Prepared prepared("torso", sceneOn(infoOf("torso"), "soft-tissue", 0, {8, 8}));
            Selection s = prepared.p.layer().selection;
            s.counts = {};
            for (std::uint8_t& mine : s.levels) {
                if (mine != Selection::kEmpty)
                    mine = static_cast<std::uint8_t>(level);
                ++s.counts[mine];
            }
            prepared.p.setSelection(s);
            expectWithinRanges(prepared, ghostLayers, 11, level == 0 ? 0.2 : 0.1);
        }
}

TEST(BlockRanges, HoldFloatsAndBricksThatEndWithin) {
    for (const glm::ivec3& extent : {glm::ivec3(64, 32, 64), glm::ivec3(61, 35, 44)}) {
        const Stored stored(
            [](const glm::dvec3& p) {
                return 500 + 300 * std::sin(0.7 * p.x) * std::cos(0.53 * p.y) + 200 * std::sin(0.61 * p.z);
            },
            extent, true, 1, ValueType::f32);
        Scene s = stored.scene({}, 1, 41);
        s.volumes[0].transferFunction = "auto";
        const auto prepared = stored.prepare(s);
        expectWithinRanges(*prepared, false, 13, 0.3);
    }
}

/// All rays of a picture of mixed levels, with leaps over blocks and without, are the mirror's.
TEST(NativeBlocks, ChangeNoBitWhereLevelsMix) {
    std::uint64_t with = 0, without = 0;
    for (const EdgeFunction edge : kEdgeFunctions)
        for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated}) {
            if (edge == EdgeFunction::nearest && integrator != Integrator::midpoint)
                continue; // refused: values jump there
            SCOPED_TRACE(static_cast<int>(edge));
            MixedScene mixed("torso", "bone-1", 1, edge, Sampling::limited, {48, 48}, integrator);
            mixed.choose(randomShownLevels(mixed.p().layer().selection, 3));
            NativeChoices choices;
            choices.blocks = true;
            const NativePicture blocks = nativePicture(*mixed.prepared, choices);
            EXPECT_GT(blocks.refinedCells, 100u);
            EXPECT_EQ(differing(blocks.image, mirrorPicture(*mixed.prepared)), 0u);
            with += blocks.work.segments;
            without += nativePicture(*mixed.prepared).work.segments;
        }
    EXPECT_LT(static_cast<double>(with), 0.7 * static_cast<double>(without));
}

/// Functions with gaps between narrow peaks: blocks are judged entry by entry of the table, and on the edge.
TEST(NativeBlocks, ChangeNoBitUnderFunctionsWithGaps) {
    std::mt19937 random(53);
    std::uint64_t saved = 0;
    for (const char* store : {"torso", "marschner-lobb", "thin"})
        for (int round = 0; round < 3; ++round) {
            const VolumeInfo info = infoOf(store);
            Scene scene = sceneOn(info, "auto", round, {120, 120});
            scene.quality.stepVoxels = 0.3;
            MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
            const ValueSummary values =
                summarise(loadStatistics(StoreReader(storePath(store), ram), ram, 1), info);
            std::vector<OpacityPoint> points;
            std::uniform_real_distribution<double> width(0.02, 0.5);
            for (int peak = 0; peak < 6; ++peak) {
                const double each = (values.highest - values.lowest) / 6,
                             from = values.lowest + each * (peak + 0.2), half = 0.5 * each * width(random);
                points.push_back({from, 0});
                points.push_back({from + half, 0.05});
                points.push_back({from + 2 * half, 0});
            }
            scene.volumes[0].transferFunction = TransferFunction::fromOpacity(points, {}, values.spacingMm);
            Prepared prepared(store, scene);
            SCOPED_TRACE(std::string(store) + " round " + std::to_string(round));
            NativeChoices choices;
            choices.blocks = true;
            const NativePicture blocks = nativePicture(prepared, choices), cells = nativePicture(prepared);
            EXPECT_GT(blocks.refinedCells, 0u);
            EXPECT_EQ(differing(blocks.image, cells.image), 0u);
            saved += cells.work.segments - blocks.work.segments;
        }
    EXPECT_GT(saved, 10000u);
}

/// A cell that no ray gets to is not looked at, and one that many get to is looked at once.
TEST(NativeBlocks, AreLookedForWhereRaysGo) {
    Prepared prepared("torso", sceneOn(infoOf("torso"), "bone-1", 0, {96, 96}));
    NativeChoices choices;
    choices.blocks = true;
    choices.threads = 1;
    const NativePicture all = nativePicture(prepared, choices);
    EXPECT_GT(all.refinedCells, 100u);
    EXPECT_LE(all.refinedCells, prepared.p.layer().occupancy.occupiedCells());
    choices.threads = 4;
    EXPECT_EQ(nativePicture(prepared, choices).refinedCells, all.refinedCells);
    // The same rays, but for those of the left half of the picture, which is the left half of the volume.
    std::vector<glm::vec2> right;
    for (int y = 0; y < 96; ++y)
        for (int x = 48; x < 96; ++x)
            right.push_back(glm::vec2(x, y) + 0.5f);
    Rays rays = raysOf(prepared.p);
    rays.places = right;
    rays.arraySize = {48, 96};
    choices.rays = rays;
    const NativePicture half = nativePicture(prepared, choices);
    EXPECT_GT(half.refinedCells, all.refinedCells / 5);
    EXPECT_LT(half.refinedCells, all.refinedCells * 4 / 5);
    for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 48; ++x)
            ASSERT_EQ(half.image.at(x, y), all.image.at(x + 48, y)) << x << "," << y;
}

TEST(NativeBlocks, PayWhereManyRaysGoThroughACell) {
    EXPECT_TRUE(FineBlocks::pay(false, 12));
    EXPECT_FALSE(FineBlocks::pay(false, 6));
    EXPECT_TRUE(FineBlocks::pay(true, 20));
    EXPECT_FALSE(FineBlocks::pay(true, 12)) << "cells between levels take longer to look at";

    // One ray a pixel, as many as pixels choose, and as many as an error takes.
    const auto looks = [](int samples, std::optional<double> maxError) {
        Scene scene = sceneOn(infoOf("torso"), "vessels-1", 1, {56, 44});
        scene.quality.pixels.samples = samples;
        Prepared prepared("torso", scene);
        prepared.p.view.quality.maxError = maxError;
        NativeChoices choices;
        choices.refine = true;
        return nativePicture(prepared, choices).refinedCells > 0;
    };
    EXPECT_FALSE(looks(1, std::nullopt));
    EXPECT_FALSE(looks(PixelSampling::kAutomatic, std::nullopt));
    EXPECT_TRUE(looks(PixelSampling::kAutomatic, 5.0));
    EXPECT_TRUE(looks(16, std::nullopt));

    RayFrame<double> frame;
    frame.imageSize = {100, 50};
    frame.right = {0, 100, 0}; // from the picture's middle to its side: two voxels a pixel
    frame.up = {0, 0, 50};
    EXPECT_DOUBLE_EQ(raysPerCell(frame), 16);
}

} // namespace
} // namespace tessera::test
