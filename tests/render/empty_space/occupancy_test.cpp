// The distance map on the CPU. Distances are exact, whether filled or updated, and the map follows any
// sequence of changes of levels and functions bit for bit. Its empty cells are invisible.
#include "core/scene/preset.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr EdgeFunction kEdgeFunctions[] = {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::split,
                                           EdgeFunction::maximum};

bool occupiedAt(const std::vector<std::uint64_t>& masks, const glm::ivec3& extent, MapScale scale,
                const glm::ivec3& box) {
    if (scale == MapScale::bricks)
        return masks[linearIndex(box, brickGrid(extent))] != 0;
    const glm::ivec3 in = box % kCellsPerBrick;
    return (masks[linearIndex(box / kCellsPerBrick, brickGrid(extent))] >> (in.x + 4 * in.y + 16 * in.z)) &
           1u;
}

/// Largest empty cube from a box into an octant, by looking.
int cubeByLooking(const std::vector<std::uint64_t>& masks, const glm::ivec3& extent, MapScale scale,
                  const glm::ivec3& box, int octant) {
    const glm::ivec3 grid = mapGrid(extent, scale);
    const glm::ivec3 way((octant & 1) ? 1 : -1, (octant & 2) ? 1 : -1, (octant & 4) ? 1 : -1);
    for (int edge = 1; edge <= kFarthest; ++edge) {
        glm::ivec3 at(0);
        for (at.z = 0; at.z < edge; ++at.z)
            for (at.y = 0; at.y < edge; ++at.y)
                for (at.x = 0; at.x < edge; ++at.x) {
                    const glm::ivec3 there = box + at * way;
                    if (glm::all(glm::greaterThanEqual(there, glm::ivec3(0))) &&
                        glm::all(glm::lessThan(there, grid)) && occupiedAt(masks, extent, scale, there))
                        return edge - 1;
                }
        if (edge > std::max({grid.x, grid.y, grid.z}))
            return kFarthest; // all of the octant
    }
    return kFarthest;
}

TEST(DistanceMap, HoldsTheLargestEmptyCubeOfEveryOctant) {
    std::mt19937_64 random(3);
    int texels = 0;
    for (const glm::ivec3 extent : {glm::ivec3(100, 70, 41), glm::ivec3(33, 1, 70), glm::ivec3(300, 40, 20)})
        for (const MapScale scale : {MapScale::cells, MapScale::bricks})
            for (int sparse = 1; sparse < 7; sparse += 3) {
                std::vector<std::uint64_t> masks(cellCount(brickGrid(extent)), 0);
                for (std::size_t b = 0; b < masks.size(); ++b)
                    if (random() % static_cast<unsigned>(sparse) == 0)
                        masks[b] = random() & random() & random() & random();
                // Only cells that exist.
                const glm::ivec3 cells = cellGrid(extent);
                for (std::size_t b = 0; b < masks.size(); ++b)
                    for (int bit = 0; bit < 64; ++bit) {
                        const glm::ivec3 grid = brickGrid(extent);
                        const int n = static_cast<int>(b);
                        const glm::ivec3 brick(n % grid.x, n / grid.x % grid.y, n / (grid.x * grid.y));
                        const glm::ivec3 cell = brick * 4 + glm::ivec3(bit & 3, bit >> 2 & 3, bit >> 4);
                        if (glm::any(glm::greaterThanEqual(cell, cells)))
                            masks[b] &= ~(std::uint64_t{1} << bit);
                    }
                const glm::ivec3 grid = mapGrid(extent, scale);
                std::vector<SkippingTexel> map(cellCount(grid));
                fillDistanceMap(extent, masks, scale, map, 2);
                glm::ivec3 at(0);
                for (at.z = 0; at.z < grid.z; ++at.z)
                    for (at.y = 0; at.y < grid.y; ++at.y)
                        for (at.x = 0; at.x < grid.x; ++at.x, ++texels) {
                            const SkippingTexel texel = map[linearIndex(at, grid)];
                            ASSERT_EQ(isOccupied(texel), occupiedAt(masks, extent, scale, at));
                            if (isOccupied(texel)) {
                                const std::uint64_t blocks = scale == MapScale::bricks
                                                                 ? masks[linearIndex(at, grid)]
                                                                 : ~std::uint64_t{0};
                                ASSERT_EQ(texel, occupiedTexel(blocks));
                                continue;
                            }
                            for (int octant = 0; octant < 8; ++octant)
                                ASSERT_EQ(octantDistance(texel, octant),
                                          cubeByLooking(masks, extent, scale, at, octant));
                        }
            }
    EXPECT_GT(texels, 2000);
}

// Edits of one brick at a time, near and far from what is occupied: each mended map is the map filled anew,
// and no slice outside those named has changed.
TEST(DistanceMap, MendedIsWhatFillingAnewGives) {
    std::mt19937_64 random(5);
    int mended = 0;
    for (const glm::ivec3 extent :
         {glm::ivec3(200, 300, 260), glm::ivec3(33, 800, 130), glm::ivec3(1100, 150, 200)})
        for (const MapScale scale : {MapScale::cells, MapScale::bricks}) {
            const glm::ivec3 bricks = brickGrid(extent), cells = cellGrid(extent),
                             grid = mapGrid(extent, scale);
            const auto cellsOf = [&](std::size_t brick) {
                std::uint64_t exist = 0;
                for (int bit = 0; bit < 64; ++bit) {
                    const glm::ivec3 cell = gridPosition(brick, bricks) * kCellsPerBrick +
                                            glm::ivec3(bit & 3, bit >> 2 & 3, bit >> 4);
                    if (glm::all(glm::lessThan(cell, cells)))
                        exist |= std::uint64_t{1} << bit;
                }
                return exist;
            };
            std::vector<std::uint64_t> masks(cellCount(bricks), 0);
            std::vector<SkippingTexel> map(cellCount(grid)), fresh(map.size()), before;
            fillDistanceMap(extent, masks, scale, map, 1);
            for (int step = 0; step < 40; ++step) {
                std::vector<std::size_t> edited;
                for (std::size_t n = 0; n < (step % 10 == 9 ? masks.size() / 3 : 1 + random() % 2); ++n) {
                    edited.push_back(random() % masks.size());
                    std::uint64_t& mask = masks[edited.back()];
                    mask = (random() % 3 == 0 ? 0 : random() & random() & random()) & cellsOf(edited.back());
                }
                before = map;
                const ChangedSlices slices = updateDistanceMap(extent, masks, scale, edited, map, 2);
                fillDistanceMap(extent, masks, scale, fresh, 1);
                ASSERT_EQ(map, fresh) << "step " << step;
                const std::size_t slice = static_cast<std::size_t>(grid.x) * static_cast<std::size_t>(grid.y);
                for (std::size_t i = 0; i < map.size(); ++i) {
                    const int z = static_cast<int>(i / slice);
                    ASSERT_TRUE(map[i] == before[i] || (z >= slices.first && z < slices.end))
                        << "step " << step;
                }
                mended += slices.any() && slices.end - slices.first < grid.z ? 1 : 0;
            }
        }
    EXPECT_GT(mended, 20);
}

// If two functions are said not to differ, they say the same of every range of values; and they are not
// always said to differ.
TEST(ShownRanges, OutsideOfDifferencesBothTablesSayTheSame) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> value(-50, 1050);
    int same = 0, different = 0;
    for (int round = 0; round < 300; ++round) {
        std::vector<OpacityPoint> points;
        for (int i = 0; i < 5; ++i) // at some of these points nothing shows, and some share a value
            points.push_back({std::floor(value(random) / 40) * 40, random() % 2 == 0 ? 0.0 : 0.3});
        std::vector<OpacityPoint> edited = points;
        OpacityPoint& point = edited[random() % edited.size()];
        if (round % 3 == 0)
            point.opacity *= 0.5; // shows what it showed
        else if (round % 3 == 1)
            point.value += value(random) / 20;
        else
            point.opacity = 0.3 - point.opacity;
        const auto table = [](const std::vector<OpacityPoint>& p) {
            return makeTable(TransferFunction::fromOpacity(p, {}, 1));
        };
        const TransferTable one = table(points), other = table(edited);
        const std::vector<ValueRange> ranges = ShownRanges(one).differences(ShownRanges(other));
        for (int i = 0; i < 300; ++i) {
            const double a = value(random), b = i % 3 == 0 ? value(random) : a + value(random) / 100;
            const ValueRange range{std::min(a, b), std::max(a, b)};
            if (std::any_of(ranges.begin(), ranges.end(),
                            [&](const ValueRange& r) { return r.meets(range); })) {
                ++different;
                continue;
            }
            ++same;
            ASSERT_EQ(one.emptyOver(range.lowest, range.highest),
                      other.emptyOver(range.lowest, range.highest))
                << "round " << round << ", " << range.lowest << " to " << range.highest;
        }
    }
    EXPECT_GT(same, 20000);
    EXPECT_GT(different, 1000);
}

// An isosurface whose value is an entry's shows at that entry alone, any other at two.
TEST(ShownRanges, KnowIsosurfacesAtAnEntry) {
    const auto table = [](double value) {
        return makeTable({}, {{.value = 0}, {.value = value}, {.value = 1000}});
    };
    const TransferTable one = table(300.1234);
    const auto entry = [&](double number) {
        return static_cast<double>(one.firstValue) + number / static_cast<double>(one.entriesPerValue);
    };
    const double ofEntry = static_cast<double>(one.entriesPerValue);
    for (const double at : {2000.0, 2000.5, 2001.0}) {
        const TransferTable other = table(entry(at));
        ASSERT_EQ(static_cast<double>(other.entriesPerValue), ofEntry);
        const std::vector<ValueRange> ranges = ShownRanges(one).differences(ShownRanges(other));
        int shows = 0;
        for (double number = 1990; number < 2012; number += 0.125) {
            const double value = entry(number);
            const bool differs = one.emptyOver(value, value) != other.emptyOver(value, value);
            shows += differs ? 1 : 0;
            EXPECT_TRUE(!differs || std::any_of(ranges.begin(), ranges.end(),
                                                [&](const ValueRange& r) {
                                                    return r.meets({value, value});
                                                }))
                << at << ", " << number;
        }
        EXPECT_GT(shows, 8) << "nothing to tell apart";
        EXPECT_FALSE(std::any_of(ranges.begin(), ranges.end(), [&](const ValueRange& r) {
            return r.meets({entry(2100), entry(3000)});
        }));
    }
}

/// Random levels; every fourth brick empty whatever it shows, when asked.
Selection randomLevels(const Selection& like, std::mt19937& random, bool anyEmpty) {
    std::uniform_int_distribution<int> level(0, kLevelCount - 1), fourth(0, 3);
    Selection s = like;
    s.counts = {};
    for (std::uint8_t& mine : s.levels) {
        if (mine != Selection::kEmpty || anyEmpty)
            mine = static_cast<std::uint8_t>(anyEmpty && fourth(random) == 0 ? int{Selection::kEmpty}
                                                                             : level(random));
        ++s.counts[mine];
    }
    return s;
}

TransferFunction randomFunction(std::mt19937& random, double lowest, double highest) {
    std::uniform_real_distribution<double> value(lowest, highest), opacity(0, 0.5);
    std::vector<double> at(4);
    for (double& v : at)
        v = value(random);
    std::sort(at.begin(), at.end());
    return TransferFunction::fromOpacity(
        {{at[0], 0}, {at[1], opacity(random)}, {at[2], opacity(random)}, {at[3], 0}}, {}, 1);
}

/// Per cell, [z][y][x]: occupied and plain.
std::vector<bool> plainBits(const Occupancy& o) {
    const glm::ivec3 cells = cellGrid(o.extentVoxels());
    std::vector<bool> plain(cellCount(cells));
    for (std::size_t c = 0; c < plain.size(); ++c)
        plain[c] = !o.isEmpty(gridPosition(c, cells)) && o.isPlain(gridPosition(c, cells));
    return plain;
}

TEST(Occupancy, AnySequenceOfChangesGivesWhatAFreshOneHolds) {
    std::mt19937 random(11);
    for (const char* store : {"torso", "marschner-lobb", "thin"}) {
        Budgets budgets;
        const StoreReader reader(storePath(store), budgets.ram);
        const Statistics statistics = loadStatistics(reader, budgets.ram, 1);
        TransferTable table = makeTable(randomFunction(random, statistics.lowest, statistics.highest));
        Selection selection = cullBricks(statistics, table, reader.info(), 0, Culling::unlit);
        EdgeFunction edge = EdgeFunction::minimum;
        const auto input = [&] { return OccupancyInput{statistics, table, reader.info(), selection, edge}; };
        for (const MapScale scale : {MapScale::cells, MapScale::bricks}) {
            Occupancy followed(input(), scale, budgets.ram, 2);
            int changes = 0;
            std::vector<TransferTable> tables = {table};
            for (int step = 0; step < 60; ++step) {
                const int kind = static_cast<int>(random() % 8);
                bool changed = false;
                const std::uint64_t version = followed.version();
                const std::vector<SkippingTexel> mapBefore = followed.map();
                const std::vector<bool> plainBefore = plainBits(followed);
                if (kind == 0) {
                    if (tables.size() > 1 && random() % 2 == 0) // back to one that was there before
                        table = tables[random() % 2 == 0 ? 0 : tables.size() - 2];
                    else
                        table = makeTable(randomFunction(random, statistics.lowest, statistics.highest));
                    tables.push_back(table);
                    changed = followed.functionChanged(input(), 2);
                } else {
                    if (kind == 1)
                        selection = randomLevels(selection, random, true);
                    else if (kind == 2)
                        edge = kEdgeFunctions[random() % 4];
                    else
                        for (int n = 0; n < 3; ++n)
                            selection.levels[random() % selection.levels.size()] =
                                static_cast<std::uint8_t>(random() % (kLevelCount + 1));
                    selection.counts = {};
                    for (const std::uint8_t level : selection.levels)
                        ++selection.counts[level];
                    changed = followed.levelsChanged(input(), 2);
                }
                changes += changed ? 1 : 0;
                const Occupancy fresh(input(), scale, budgets.ram, 1);
                ASSERT_EQ(followed.masks(), fresh.masks()) << store << " step " << step << " kind " << kind;
                ASSERT_EQ(followed.map(), fresh.map()) << store << " step " << step << " kind " << kind;
                const std::vector<bool> plain = plainBits(followed);
                ASSERT_EQ(plain, plainBits(fresh)) << store << " step " << step << " kind " << kind;
                // A copy on the device learns of every slice that is another, also where only plain cells
                // are.
                const ChangedSlices slices = followed.changedSince(version);
                for (std::size_t i = 0; i < mapBefore.size(); ++i) {
                    const int z = gridPosition(i, followed.grid()).z;
                    ASSERT_TRUE(mapBefore[i] == followed.map()[i] || (z >= slices.first && z < slices.end));
                }
                const glm::ivec3 cells = cellGrid(reader.info().extentVoxels);
                for (std::size_t i = 0; i < plain.size(); ++i) {
                    const int z = gridPosition(i, cells).z / (scale == MapScale::cells ? 1 : kCellsPerBrick);
                    ASSERT_TRUE(plainBefore[i] == plain[i] || (z >= slices.first && z < slices.end));
                }
            }
            EXPECT_GT(changes, 5) << store;
        }
    }
}

// The proof: in an empty cell extinction is zero, whatever the levels. This includes visible bricks that are
// replaced by their mean, and the faces of cells.
TEST(Occupancy, EmptyCellsShowNothingAtAnyLevels) {
    std::mt19937 random(37);
    for (const char* store : {"torso", "abdomen", "marschner-lobb"}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        int checked = 0;
        for (int round = 0; round < 12; ++round) {
            Budgets budgets;
            const StoreReader reader(storePath(store), budgets.ram);
            const Statistics statistics = loadStatistics(reader, budgets.ram, 1);
            const bool bone = reader.info().unit == "HU" && round % 2 == 0;
            const TransferTable table =
                makeTable(bone ? presetFunction("bone-1", {})
                               : randomFunction(random, statistics.lowest, statistics.highest));
            const Optics optics = makeOptics(table, reader.info(), {}, 0);
            Selection s = cullBricks(statistics, table, reader.info(), 0, Culling::unlit);
            s = randomLevels(s, random, round % 3 == 2);
            if (round >= 8) // one level for all
                for (std::uint8_t& level : s.levels)
                    level = level == Selection::kEmpty ? level : static_cast<std::uint8_t>(round - 8 + 1);
            Quality quality;
            quality.edgeFunction = kEdgeFunctions[round % 4];
            const LevelMap levels = makeLevelMap(s, reader.info().extentVoxels, quality, budgets.ram);
            const Occupancy occupancy({statistics, table, reader.info(), s, quality.edgeFunction},
                                      MapScale::cells, budgets.ram);
            BrickCache cache(reader, budgets.ram, std::size_t{256} << 20, 2);
            MixedReader samples(cache, reader.info(), s, levels);
            std::uniform_real_distribution<float> unit(0, 1);
            for (int i = 0; i < 8000; ++i) {
                const glm::vec3 extent(reader.info().extentVoxels);
                glm::vec3 at = extent * glm::vec3(unit(random), unit(random), unit(random));
                for (int axis = 0; axis < 3; ++axis) // every other on or just before a face of cells
                    if (random() % 2 == 0) {
                        at[axis] = 8 * std::round(at[axis] / 8);
                        if (random() % 2 == 0)
                            at[axis] = std::max(std::nextafter(at[axis], 0.0f), 0.0f);
                    }
                at = glm::min(at, extent);
                if (!occupancy.isEmpty(glm::min(glm::ivec3(at) / kCellExtent, statistics.cells - 1)))
                    continue;
                ++checked;
                ASSERT_EQ(lookUp(optics, interblockValue(samples, at)).a, 0)
                    << store << " round " << round << " " << at.x << " " << at.y << " " << at.z;
            }
        }
        EXPECT_GT(checked, 2000) << store;
    }
}

// What shows lies two to twelve voxels behind a face, before which all is empty. A coarser sample there
// reaches across the face, whichever way it looks and whatever levels meet.
TEST(Occupancy, WhatShowsAcrossAFaceIsInNoEmptyCell) {
    std::mt19937 random(41);
    std::uniform_real_distribution<float> unit(0, 1);
    const TransferTable table = makeTable(TransferFunction::fromExtinction({{1, 0}, {100, 1}}, {}));
    for (int axis = 0; axis < 3; ++axis)
        for (const bool above : {false, true}) {
            const Stored stored(
                [&](const glm::dvec3& p) {
                    const double in = above ? p[axis] - 34 : 30 - p[axis];
                    return in > 0 && in < 10 ? 100 : 0;
                },
                glm::ivec3(64), true);
            Budgets budgets;
            const StoreReader reader(stored.folder / "v.zarr", budgets.ram);
            const Statistics statistics = loadStatistics(reader, budgets.ram, 1);
            const Optics optics = makeOptics(table, reader.info(), {}, 0);
            BrickCache cache(reader, budgets.ram, std::size_t{64} << 20, 2);
            int shown = 0;
            constexpr int kStates = Selection::kEmpty + 1; // a level, or empty
            for (int pair = 0; pair < kStates * kStates; ++pair)
                for (const EdgeFunction edge : kEdgeFunctions) {
                    const int here = pair % kStates, there = pair / kStates;
                    Selection s = cullBricks(statistics, table, reader.info(), 0, Culling::unlit);
                    s.counts = {};
                    for (std::size_t b = 0; b < s.levels.size(); ++b) {
                        const bool shows = (gridPosition(b, s.bricks)[axis] > 0) == above;
                        s.levels[b] = static_cast<std::uint8_t>(shows ? there : here);
                        ++s.counts[s.levels[b]];
                    }
                    Quality quality;
                    quality.edgeFunction = edge;
                    const LevelMap levels = makeLevelMap(s, reader.info().extentVoxels, quality, budgets.ram);
                    const Occupancy occupancy({statistics, table, reader.info(), s, quality.edgeFunction},
                                              MapScale::cells, budgets.ram);
                    MixedReader samples(cache, reader.info(), s, levels);
                    for (int i = 0; i < 100; ++i) {
                        glm::vec3 at = 64.0f * glm::vec3(unit(random), unit(random), unit(random));
                        at[axis] = above ? 32 - 24 * unit(random) * unit(random)
                                         : 32 + 24 * unit(random) * unit(random);
                        const bool shows = lookUp(optics, interblockValue(samples, at)).a > 0;
                        shown += shows;
                        ASSERT_FALSE(shows && occupancy.isEmpty(glm::ivec3(at) / kCellExtent))
                            << "axis " << axis << (above ? " up" : " down") << ", levels " << here << " and "
                            << there << ", " << at.x << " " << at.y << " " << at.z;
                    }
                }
            EXPECT_GT(shown, 200);
        }
}

// Sharp: at level 0 beside level 0 and beside proven emptiness, a cell counts by its own range alone.
TEST(Occupancy, AtLevelZeroACellCountsByItsOwnRange) {
    Budgets budgets;
    const StoreReader reader(storePath("torso"), budgets.ram);
    const Statistics statistics = loadStatistics(reader, budgets.ram, 1);
    const TransferTable table = makeTable(presetFunction("bone-1", {}));
    const Selection s = cullBricks(statistics, table, reader.info(), 0, Culling::unlit);
    const Occupancy occupancy({statistics, table, reader.info(), s}, MapScale::cells, budgets.ram);
    std::size_t occupied = 0;
    for (std::size_t c = 0; c < statistics.cellMin.size(); ++c)
        occupied += table.emptyOver(statistics.cellMin[c], statistics.cellMax[c]) ? 0 : 1;
    EXPECT_GT(occupied, 0u);
    EXPECT_EQ(occupancy.occupiedCells(), occupied);
}

// Tight: what shows in single voxels occupies no cell that lies further than a cell from it, at levels up to
// 3: their samples, and blends across faces, reach no further. A cell's range has a voxel around it.
TEST(Occupancy, CellsAreEmptyWhereNothingIsNear) {
    const glm::ivec3 extent(100, 75, 130);
    const std::vector<glm::ivec3> spots = {
        {3, 40, 9}, {66, 2, 77}, {33, 63, 96}, {99, 74, 64}, {40, 31, 127}};
    const Stored stored(
        [&](const glm::dvec3& p) {
            return std::count(spots.begin(), spots.end(), glm::ivec3(p)) > 0 ? 1.0 : 0.0;
        },
        extent, true);
    Budgets budgets;
    const StoreReader reader(stored.folder / "v.zarr", budgets.ram);
    const Statistics statistics = loadStatistics(reader, budgets.ram, 1);
    const TransferTable table = makeTable(TransferFunction::fromExtinction({{0.5, 0}, {1, 1}}, {}));
    const Selection culled = cullBricks(statistics, table, reader.info(), 0, Culling::unlit);
    std::mt19937 random(3);
    for (int round = 0; round < 12; ++round)
        for (const EdgeFunction edge : kEdgeFunctions) {
            Selection s = culled;
            s.counts = {};
            for (std::uint8_t& level : s.levels) {
                if (level != Selection::kEmpty)
                    level = static_cast<std::uint8_t>(round < 4 ? round : static_cast<int>(random() % 4));
                ++s.counts[level];
            }
            const Occupancy occupancy({statistics, table, reader.info(), s, edge}, MapScale::cells,
                                      budgets.ram);
            const glm::ivec3 cells = cellGrid(extent);
            std::size_t occupied = 0;
            for (std::size_t c = 0; c < cellCount(cells); ++c) {
                const glm::ivec3 cell = gridPosition(c, cells);
                const int around = s.uniform() && round == 0 ? 0 : 1;
                const glm::ivec3 low = (cell - around) * kCellExtent - 1,
                                 high = (cell + 1 + around) * kCellExtent;
                const bool isNear = std::any_of(spots.begin(), spots.end(), [&](const glm::ivec3& spot) {
                    return glm::all(glm::lessThanEqual(low, spot)) &&
                           glm::all(glm::lessThanEqual(spot, high));
                });
                ASSERT_TRUE(isNear || occupancy.isEmpty(cell))
                    << "round " << round << ", cell " << cell.x << "," << cell.y << "," << cell.z;
                occupied += occupancy.isEmpty(cell) ? 0 : 1;
            }
            EXPECT_EQ(occupied, occupancy.occupiedCells());
            EXPECT_GE(occupied, spots.size());
        }
}

/// Rays through an occupancy: leaps end exactly where a look at every stride says, and are long.
TEST(Occupancy, RaysLeapToTheFirstOccupiedStride) {
    const glm::ivec3 extent(100, 75, 130);
    const Stored stored(
        [&](const glm::dvec3& p) {
            return glm::length(p - glm::dvec3(30, 20, 40)) < 12 ||
                           glm::length(p - glm::dvec3(70, 60, 100)) < 9
                       ? 1
                       : 0;
        },
        extent, true);
    Budgets budgets;
    const StoreReader reader(stored.folder / "v.zarr", budgets.ram);
    const Statistics statistics = loadStatistics(reader, budgets.ram, 1);
    const TransferTable table = makeTable(TransferFunction::fromExtinction({{0.5, 0}, {1, 1}}, {}));
    const Selection s = cullBricks(statistics, table, reader.info(), 0, Culling::unlit);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const MapScale scale : {MapScale::cells, MapScale::bricks}) {
        const Occupancy o({statistics, table, reader.info(), s}, scale, budgets.ram);
        // Blocks of maps by bricks are cells, of which the last two of a brick share a bit; those of maps by
        // cells are all marked until a device looks.
        const auto occupiedAt = [&](const glm::dvec3& p) {
            const glm::ivec3 cell =
                glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), extent - 1) / kCellExtent;
            const glm::ivec3 in = cell % kCellsPerBrick;
            if (scale == MapScale::bricks && in.y == 3 && in.z == 3 && in.x >= 2) {
                const glm::ivec3 first(cell.x - in.x + 2, cell.y, cell.z);
                return !o.isEmpty(first) ||
                       (first.x + 1 < cellGrid(extent).x && !o.isEmpty(first + glm::ivec3(1, 0, 0)));
            }
            return !o.isEmpty(cell);
        };
        std::size_t strides = 0, calls = 0, shown = 0;
        for (int n = 0; n < 200; ++n) {
            const glm::dvec3 size(extent), a = size * glm::dvec3(unit(random), unit(random), unit(random));
            glm::dvec3 b = size * glm::dvec3(unit(random), unit(random), unit(random));
            if (n % 3 == 0)
                b[n % 9 / 3] = a[n % 9 / 3]; // along a plane
            SegmentedRay<double> ray;
            ray.entry = a;
            ray.direction = glm::normalize(b - a);
            const double step = n % 2 == 0 ? 0.5 : 1.25;
            ray.step = step * ray.direction;
            ray.count = static_cast<int>(std::floor(glm::distance(a, b) / step)) + 1;
            ray.tail = 1;
            Strides by;
            by.uniformSegments = 1 << n % 3;
            by.segmentVoxels = step;
            const auto middleOf = [&](int i) {
                return stridePosition(ray, i, strideLength(ray, i, strideAt(by, ray, i)));
            };
            for (int i = 0; i < ray.count;) {
                int expected = i;
                while (expected < ray.count && !occupiedAt(middleOf(expected)))
                    expected += by.uniformSegments, ++strides;
                expected = std::min(expected, ray.count);
                int found = i;
                while (found < ray.count) {
                    const int next = nextOccupied(o, by, ray, found, by.uniformSegments, middleOf(found));
                    ++calls;
                    ASSERT_GE(next, found);
                    if (next == found)
                        break;
                    found = next;
                }
                ASSERT_EQ(std::min(found, ray.count), expected) << "ray " << n;
                // By the ends of strides: nothing that shows at an end is left out, and nothing far from it
                // stays.
                const int byEnds = nextShown(o, by, ray, i), clear = nextNotClear(o, by, ray, i);
                for (int k = i; k < byEnds; k += by.uniformSegments)
                    ASSERT_FALSE(occupiedAt(segmentStart(ray, k))) << "ray " << n << " at " << k;
                ASSERT_LE(clear, byEnds) << "what is clear between its ends shows at none";
                for (int k = i; k < clear; k += by.uniformSegments)
                    ASSERT_FALSE(occupiedAt(middleOf(k)));
                if (byEnds < ray.count) {
                    const int length = by.uniformSegments;
                    ASSERT_TRUE(occupiedAt(segmentStart(ray, byEnds)) ||
                                occupiedAt(strideEnd(ray, byEnds, strideLength(ray, byEnds, length))))
                        << "ray " << n << " at " << byEnds;
                }
                if (found < ray.count)
                    ++shown;
                i = std::max(expected, i) + by.uniformSegments;
            }
        }
        EXPECT_GT(shown, 300u);
        EXPECT_LT(3 * calls, strides + 3 * shown + 600) << "leaps are long";
    }
}

} // namespace
} // namespace tessera
