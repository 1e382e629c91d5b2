// Empty-space skipping on the device: with either map, with blocks, and after changes, pictures do not
// change by a bit.
#include "tests/support/scene_fixture.h"

#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr EdgeFunction kEdgeFunctions[] = {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::split,
                                           EdgeFunction::maximum};

// Both maps, any step: no bit of the picture changes.
TEST(Skipping, PicturesAreBitEqualWithEitherMap) {
    const GlContext context({"software"});
    for (const char* store : {"torso", "sphere"})
        for (const int camera : {0, 1, 2})
            for (const double step : {0.5, 3.0}) {
                MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
                const VolumeInfo info = StoreReader(storePath(store), ram).info();
                Scene scene =
                    sceneOn(info, store == std::string("torso") ? "bone-1" : "auto", camera, {40, 40});
                scene.quality.stepVoxels = step;
                Prepared prepared(store, scene);
                const std::uint32_t features = kFeatureSkipping | kFeatureShading;
                const GpuPicture every = marchOn(prepared, features & ~kFeatureSkipping);
                std::uint64_t segments[2] = {0, 0};
                for (const MapScale scale : {MapScale::cells, MapScale::bricks}) {
                    prepared.p.layer().mapScale = scale;
                    prepared.p.layer().occupancy = Occupancy();
                    prepared.p.layer().mapEmptySpace(prepared.p.view.quality, prepared.budgets.ram);
                    const GpuPicture skipped = marchOn(prepared, features);
                    EXPECT_TRUE(bitEqual(skipped.image, every.image)) << store << " camera " << camera;
                    EXPECT_LT(skipped.work.segments, every.work.segments);
                    segments[scale == MapScale::bricks] = skipped.work.segments;
                }
                // Blocks of the coarse map are the fine map's cells; two of a brick share a bit.
                EXPECT_LE(segments[0], segments[1]);
                EXPECT_LT(static_cast<double>(segments[1]), 1.1 * static_cast<double>(segments[0]));
            }
}

/// A random level for what is not empty, level 0 more often than not, so that borders of all kinds meet.
Selection mostlyFinest(const Selection& like, std::mt19937& random) {
    Selection s = like;
    s.counts = {};
    for (std::uint8_t& level : s.levels) {
        if (level != Selection::kEmpty && random() % 4 == 0)
            level = static_cast<std::uint8_t>(random() % kLevelCount);
        ++s.counts[level];
    }
    return s;
}

// Blocks of 2^3 voxels, found on the device: fewer samples, and not a bit of the picture changes, at one
// level and at mixed levels, with every edge function.
TEST(Skipping, BlocksOfCellsSaveSamplesAndChangeNoBit) {
    const GlContext context({"software"});
    std::mt19937 random(41);
    for (const char* store : {"torso", "abdomen"}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        for (const EdgeFunction edge : kEdgeFunctions)
            for (const bool mixed : {false, true}) {
                if (!mixed && edge != EdgeFunction::minimum)
                    continue; // one level has no edges
                MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
                const VolumeInfo info = StoreReader(storePath(store), ram).info();
                const int camera = static_cast<int>(random() % 3);
                Scene scene = sceneOn(info, info.unit == "HU" ? "bone-1" : "auto", camera, {28, 28});
                scene.quality.edgeFunction = edge;
                Prepared prepared(store, scene);
                if (mixed)
                    prepared.p.setSelection(mostlyFinest(prepared.p.layer().selection, random));
                const std::uint32_t features = kFeatureSkipping | kFeatureShading;
                const GpuPicture every = marchOn(prepared, features & ~kFeatureSkipping);
                const GpuPicture cells = marchOn(prepared, features);
                const GpuPicture blocks = marchOn(prepared, features, {}, true);
                SCOPED_TRACE(std::string(store) + " edge " + std::to_string(static_cast<int>(edge)) +
                             (mixed ? " mixed" : ""));
                EXPECT_FALSE(isBlank(every.image));
                EXPECT_GT(blocks.refinedCells, 0u);
                EXPECT_TRUE(bitEqual(blocks.image, every.image));
                EXPECT_TRUE(bitEqual(cells.image, every.image));
                EXPECT_LE(blocks.work.segments, cells.work.segments);
                if (!mixed && info.unit == "HU") {
                    EXPECT_LT(static_cast<double>(blocks.work.segments),
                              0.8 * static_cast<double>(cells.work.segments));
                }
            }
    }
}

// A GPU ray caster keeps its map, with the blocks that the device found empty, and takes the slices that an
// edit of levels changed.
TEST(Skipping, AMarchFollowsChangesOfLevels) {
    const GlContext context({"software"});
    std::mt19937 random(71);
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Prepared prepared("torso", sceneOn(info, "bone-1", 0, {28, 28}));
    Planner& p = prepared.p;
    MemoryBudget& gpu = prepared.budgets.gpu;
    Selection selection = mostlyFinest(p.layer().selection, random);
    p.setSelection(selection);
    const std::uint32_t features = kFeatureSkipping | kFeatureMixed | kFeatureNormalised;
    March march(features, p.view.frame, p.info(), p.strides(), p.layer().optics, &p.layer().occupancy, gpu);
    for (int edit = 0; edit < 6; ++edit) {
        const std::uint64_t version = p.layer().occupancy.version();
        if (edit > 0) {
            for (int n = 0; n < 2; ++n) { // some from the finest level, whose blocks were found, to another
                std::uint8_t& level = selection.levels[random() % selection.levels.size()];
                if (level != Selection::kEmpty)
                    level = static_cast<std::uint8_t>(level == 0 ? 2 : 0);
            }
            selection.counts = {};
            for (const std::uint8_t level : selection.levels)
                ++selection.counts[level];
            p.setSelection(selection);
            march.restart({p.view.frame, p.strides()}, &p.layer().occupancy);
            EXPECT_LE(p.layer().occupancy.version(), version + 1);
        }
        Work work;
        Atlas atlas(p.info(), p.layer().selection, pagesFor(p.layer().selection.counts), TextureLimits{}, gpu,
                    prepared.budgets.ram);
        atlas.bricks.load(*p.layer().cache, work);
        const LevelTextures textures(p.layer().levels, gpu);
        const FieldSource source{&atlas, p.layer().selection.finest(), &p.layer().levels, &textures};
        if (edit == 0 || edit == 3)
            refineSkipping(march.skippingMap(), p.layer().occupancy, p.layer().table, p.layer().optics,
                           features, p.info(), source, gpu);
        march.run(source, {}, work);
        const GpuPicture every = marchOn(prepared, features & ~kFeatureSkipping);
        EXPECT_FALSE(isBlank(every.image));
        EXPECT_TRUE(bitEqual(march.image(), every.image)) << "edit " << edit;
    }
    EXPECT_GT(p.layer().occupancy.version(), 3u);
}

// Functions with gaps, dense samples, filtered fetches too: the picture is the same.
TEST(Skipping, BlocksChangeNoBitUnderFunctionsWithGaps) {
    const GlContext context({"software"});
    std::mt19937 random(53);
    std::uint64_t saved = 0;
    for (const char* store : {"torso", "marschner-lobb", "thin"})
        for (int round = 0; round < 3; ++round) {
            MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
            const StoreReader reader(storePath(store), ram);
            Scene scene = sceneOn(reader.info(), "auto", round, {24, 24});
            scene.quality.stepVoxels = round == 0 ? 0.2 : 0.5;
            const Statistics statistics = loadStatistics(reader, ram, 1);
            const ValueSummary values = summarise(statistics, reader.info());
            std::vector<OpacityPoint> points; // five peaks with gaps between them
            std::uniform_real_distribution<double> width(0.1, 0.9);
            for (int peak = 0; peak < 5; ++peak) {
                const double each = (values.highest - values.lowest) / 5, from = values.lowest + each * peak;
                const double half = 0.5 * each * width(random);
                points.push_back({from, 0});
                points.push_back({from + half, 0.02});
                points.push_back({from + 2 * half, 0});
            }
            scene.volumes[0].transferFunction = TransferFunction::fromOpacity(points, {}, values.spacingMm);
            Prepared prepared(store, scene);
            const bool filtered = round == 2;
            const std::uint32_t features =
                kFeatureSkipping | kFeatureShading | (filtered ? std::uint32_t{kFeatureHardware} : 0);
            const GpuPicture every = marchOn(prepared, features & ~kFeatureSkipping);
            const GpuPicture cells = marchOn(prepared, features);
            const GpuPicture blocks = marchOn(prepared, features, {}, true);
            SCOPED_TRACE(std::string(store) + " round " + std::to_string(round));
            EXPECT_FALSE(isBlank(every.image));
            EXPECT_TRUE(bitEqual(blocks.image, every.image));
            saved += cells.work.segments - blocks.work.segments;
        }
    EXPECT_GT(saved, 10000u);
}

// One picture pays for refining where its rays are many for the cells; a map of bricks has none to refine.
TEST(Skipping, RefiningIsLeftOutWhereItDoesNotPay) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Prepared prepared("torso", sceneOn(info, "bone-1", 0, {8, 8}));
    const std::size_t cells = prepared.p.layer().occupancy.plainCells();
    EXPECT_EQ(cells, prepared.p.layer().occupancy.occupiedCells()) << "all of one level";
    EXPECT_TRUE(refiningPays(prepared.p.layer().occupancy, 1000 * cells));
    EXPECT_FALSE(refiningPays(prepared.p.layer().occupancy, cells));
    prepared.p.layer().mapScale = MapScale::bricks;
    prepared.p.layer().occupancy = Occupancy();
    prepared.p.layer().mapEmptySpace(prepared.p.view.quality, prepared.budgets.ram);
    EXPECT_FALSE(refiningPays(prepared.p.layer().occupancy, 1000 * cells));
}

} // namespace
} // namespace tessera
