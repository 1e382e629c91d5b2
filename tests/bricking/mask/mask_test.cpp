// tests/bricking/mask/mask_test.cpp: masks, and volumes whose hidden part reads as air: at every level, and
// in statistics.
#include "bricking/analysis/body/kept_table.h"
#include "bricking/mask/masked_source.h"
#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/pyramid.h"
#include "tests/support/bricking_store_tools.h"

#include <cstring>
#include <fstream>
#include <random>

namespace tessera::test {
namespace {

constexpr double kAir = -1000;

MemoryBudget& plenty() {
    static MemoryBudget ram("RAM", "--ram", kPlenty);
    return ram;
}

/// Blobs of hidden samples: nothing, all and parts of cells.
std::vector<std::uint8_t> blobs(const glm::ivec3& extent, int level, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> shares(cellCount(levelExtent(extent, level)));
    const glm::ivec3 samples = levelExtent(extent, level);
    for (int n = 0; n < 4; ++n) {
        const glm::dvec3 middle(random() % static_cast<unsigned>(samples.x),
                                random() % static_cast<unsigned>(samples.y),
                                random() % static_cast<unsigned>(samples.z));
        const double radius = 0.12 * samples.x + 0.002 * samples.x * static_cast<double>(random() % 100);
        for (std::size_t i = 0; i < shares.size(); ++i)
            if (glm::length(glm::dvec3(gridPosition(i, samples)) - middle) < radius)
                shares[i] = n == 0 ? 100 : 255;
    }
    return shares;
}

TEST(Mask, SharesAreTrilinearBetweenItsSamplesAndMeansAbove) {
    const Mask mask({8, 4, 4}, 1, {0, 255, 51, 0, 0, 255, 51, 0, 0, 255, 51, 0, 0, 255, 51, 0}, plenty());
    const auto along = [&](int level, int count) {
        std::vector<float> shares(static_cast<std::size_t>(count));
        mask.read(level, glm::ivec3(0), {count, 1, 1}, shares);
        return shares;
    };
    // Samples of level 1 are at 1, 3, 5 and 7; voxels at halves.
    const std::vector<float> voxels = {0, 0.25f, 0.75f, 0.8f, 0.4f, 0.15f, 0.05f, 0};
    for (std::size_t i = 0; i < 8; ++i)
        EXPECT_NEAR(along(0, 8)[i], i == 3 ? 0.8f : voxels[i], 1e-6) << i;
    EXPECT_EQ(along(1, 4)[0], 0);
    EXPECT_EQ(along(1, 4)[1], 1);
    EXPECT_NEAR(along(1, 4)[2], 0.2, 1e-6);
    EXPECT_NEAR(along(2, 2)[0], 0.5, 0.002);
    EXPECT_NEAR(along(2, 2)[1], 0.1, 0.002);
    EXPECT_EQ(mask.of({0, 0, 0}, {1, 1, 1}), Mask::Part::some); // its neighbour reaches it
    const Mask half(
        {64, 8, 8}, 0,
        [] {
            std::vector<std::uint8_t> shares(64 * 64);
            for (std::size_t i = 0; i < shares.size(); ++i)
                shares[i] = i % 64 < 32 ? 0 : 255;
            return shares;
        }(),
        plenty());
    EXPECT_EQ(half.of({0, 0, 0}, {31, 8, 8}), Mask::Part::none);
    EXPECT_EQ(half.of({0, 0, 0}, {32, 8, 8}), Mask::Part::some);
    EXPECT_EQ(half.of({33, 0, 0}, {64, 8, 8}), Mask::Part::all);
}

// Weights are those of their own axis: a mask that is a ramp along one axis is read along it alone.
TEST(Mask, EveryAxisHasItsOwnWeights) {
    constexpr glm::ivec3 kCoarse{4, 3, 5};
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<std::uint8_t> shares(cellCount(kCoarse));
        for (std::size_t i = 0; i < shares.size(); ++i)
            shares[i] = static_cast<std::uint8_t>(50 * gridPosition(i, kCoarse)[axis]);
        const Mask mask(4 * kCoarse, 2, shares, plenty());
        std::vector<float> read(cellCount(4 * kCoarse));
        mask.read(0, glm::ivec3(0), 4 * kCoarse, read);
        for (std::size_t i = 0; i < read.size(); ++i) {
            const double at = (gridPosition(i, 4 * kCoarse)[axis] + 0.5) / 4 - 0.5;
            EXPECT_NEAR(read[i], 50 * std::clamp(at, 0.0, kCoarse[axis] - 1.0) / 255, 1e-6) << axis;
        }
    }
}

/// A byte for each sample of its level and of the coarser ones; which a budget must have.
TEST(Mask, IsChargedForItsLevels) {
    for (const int level : {0, 1, 5}) {
        const glm::ivec3 extent(37, 70, 9);
        std::size_t bytes = 0;
        for (int l = level; l < kLevelCount; ++l)
            bytes += cellCount(ceilDiv(extent, 1 << l));
        EXPECT_EQ(Mask::bytes(extent, level), bytes);
        for (const bool enough : {true, false}) {
            MemoryBudget ram("RAM", "--ram", enough ? bytes : bytes - 1);
            const auto make = [&] {
                const Mask mask(extent, level,
                                std::vector<std::uint8_t>(cellCount(levelExtent(extent, level))), ram);
                EXPECT_EQ(ram.usedBytes(), bytes);
            };
            if (enough) {
                EXPECT_NO_THROW(make());
            } else {
                EXPECT_THROW(make(), InputError);
            }
            EXPECT_EQ(ram.usedBytes(), 0u);
        }
    }
}

/// What is hidden of a box: the samples on either side of any of its places count.
TEST(Mask, PartsOfBoxesAreThoseOfTheSamplesAround) {
    const glm::ivec3 extent(45, 38, 29);
    for (const int level : {0, 2}) {
        const glm::ivec3 samples = levelExtent(extent, level);
        std::vector<std::uint8_t> shares(cellCount(samples));
        for (std::size_t i = 0; i < shares.size(); ++i)
            shares[i] = static_cast<std::uint8_t>(
                gridPosition(i, samples).x + gridPosition(i, samples).y < samples.y ? 255
                : gridPosition(i, samples).z == 3                                   ? 7
                                                                                    : 0);
        const Mask mask(extent, level, shares, plenty());
        std::mt19937 random(3);
        std::size_t of[3] = {};
        for (int n = 0; n < 400; ++n) {
            glm::ivec3 low, high;
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = static_cast<int>(random() % static_cast<unsigned>(extent[axis]));
                high[axis] = std::min(extent[axis], low[axis] + 1 + static_cast<int>(random() % 12));
            }
            int least = 255, most = 0;
            for (std::size_t i = 0; i < shares.size(); ++i) {
                const glm::ivec3 at = gridPosition(i, samples);
                // the samples of the box's voxels, and one more on every side
                if (glm::all(glm::greaterThanEqual(at, (low >> level) - 1)) &&
                    glm::all(glm::lessThanEqual(at, ((high - 1) >> level) + 1))) {
                    least = std::min<int>(least, shares[i]);
                    most = std::max<int>(most, shares[i]);
                }
            }
            const Mask::Part part = most == 0      ? Mask::Part::none
                                    : least == 255 ? Mask::Part::all
                                                   : Mask::Part::some;
            EXPECT_EQ(mask.of(low, high), part) << level;
            ++of[static_cast<std::size_t>(part)];
        }
        EXPECT_GT(std::min({of[0], of[1], of[2]}), 20u);
    }
}

/// A store of noise over several bricks, with borders that are not whole.
struct MaskedStore : ::testing::Test {
    ScratchFolder folder;
    fs::path path = folder.path() / "noise.zarr";
    static constexpr glm::ivec3 kExtent{83, 70, 101};
    VolumeInfo info = [] {
        VolumeInfo i = plainInfo(kExtent, ValueType::i16);
        i.unit = "HU";
        return i;
    }();
    std::unique_ptr<StoreReader> store;
    std::vector<std::int16_t> values = std::vector<std::int16_t>(cellCount(kExtent));

    void SetUp() override {
        std::mt19937 random(5);
        for (std::int16_t& v : values)
            v = static_cast<std::int16_t>(static_cast<int>(random() % 3000) - 900);
        store = stored(path, values);
    }
    std::unique_ptr<StoreReader> stored(const fs::path& at, const std::vector<std::int16_t>& voxels) const {
        HashSource source(info, [&](int x, int y, int z) { return voxels[linearIndex({x, y, z}, kExtent)]; });
        import(at, source);
        return std::make_unique<StoreReader>(at, plenty());
    }
    MaskedSource masked(int level) const {
        return {*store, std::make_shared<const Mask>(kExtent, level, blobs(kExtent, level, 3), plenty()),
                kAir, plenty(), 2};
    }
    template <typename What> void forSamples(const ChunkSource& source, int level, const What& what) const {
        const glm::ivec3 extent = levelExtent(kExtent, level), chunks = chunkGrid(kExtent, level);
        std::vector<std::byte> bytes(source.chunkBytes());
        for (std::size_t n = 0; n < cellCount(chunks); ++n) {
            const glm::ivec3 at = gridPosition(n, chunks), first = at * kChunkExtent;
            source.readChunk({level, at.x, at.y, at.z}, bytes);
            const glm::ivec3 count = glm::min(extent - first, glm::ivec3(kChunkExtent));
            for (std::size_t i = 0; i < cellCount(count); ++i) {
                const glm::ivec3 in = gridPosition(i, count);
                what(first + in, reinterpret_cast<const std::int16_t*>(
                                     bytes.data())[linearIndex(in, glm::ivec3(kChunkExtent))]);
            }
        }
    }
};
struct MaskedLevels : MaskedStore, ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Levels, MaskedLevels, ::testing::Values(0, 1, 3, 4));

TEST_P(MaskedLevels, SamplesAreMixedWithAirByTheirShares) {
    const MaskedSource source = masked(GetParam());
    for (int level = 0; level <= Mask::kExactLevel; ++level) {
        std::vector<float> shares(cellCount(levelExtent(kExtent, level)));
        source.mask().read(level, glm::ivec3(0), levelExtent(kExtent, level), shares);
        std::vector<std::int16_t> plain(shares.size());
        forSamples(*store, level, [&](const glm::ivec3& at, std::int16_t v) {
            plain[linearIndex(at, levelExtent(kExtent, level))] = v;
        });
        std::size_t mixed = 0;
        forSamples(source, level, [&](const glm::ivec3& at, std::int16_t v) {
            const std::size_t i = linearIndex(at, levelExtent(kExtent, level));
            const double share = static_cast<double>(shares[i]);
            EXPECT_NEAR(v, plain[i] + share * (kAir - plain[i]), share > 0 && share < 1 ? 0.5 : 0);
            mixed += share > 0;
        });
        EXPECT_GT(mixed, shares.size() / 50) << level;
        EXPECT_LT(mixed, shares.size()) << level;
    }
}

// What skipping and culling rely on: no sample of any level leaves the range of the cells that it covers.
TEST_P(MaskedLevels, SamplesStayWithinTheRangesOfTheirCells) {
    const MaskedSource source = masked(GetParam());
    Statistics statistics = loadStatistics(*store, plenty(), 2);
    hideMasked(statistics, source, plenty(), 2);
    for (int level = 0; level < kLevelCount; ++level)
        forSamples(source, level, [&](const glm::ivec3& at, std::int16_t v) {
            const glm::ivec3 low = at << level, high = glm::min((at + 1) << level, kExtent);
            float least = 1e9f, most = -1e9f;
            for (int z = low.z / kCellExtent; z <= (high.z - 1) / kCellExtent; ++z)
                for (int y = low.y / kCellExtent; y <= (high.y - 1) / kCellExtent; ++y)
                    for (int x = low.x / kCellExtent; x <= (high.x - 1) / kCellExtent; ++x) {
                        const std::size_t cell = linearIndex({x, y, z}, statistics.cells);
                        least = std::min(least, statistics.cellMin[cell]);
                        most = std::max(most, statistics.cellMax[cell]);
                    }
            EXPECT_GE(v, least) << level;
            EXPECT_LE(v, most) << level;
            if (level == kLevelCount - 1) {
                EXPECT_EQ(v, statistics.brickMean[linearIndex(at, statistics.bricks)]);
            }
        });
    // Bricks: their voxels, and one and two layers around.
    std::vector<std::int16_t> voxels(cellCount(kExtent));
    forSamples(source, 0,
               [&](const glm::ivec3& at, std::int16_t v) { voxels[linearIndex(at, kExtent)] = v; });
    for (std::size_t brick = 0; brick < cellCount(statistics.bricks); ++brick)
        for (const int layers : {1, 2}) {
            const glm::ivec3 own = gridPosition(brick, statistics.bricks) * kBrickExtent;
            const glm::ivec3 low = glm::max(own - layers, glm::ivec3(0));
            const glm::ivec3 count = glm::min(own + kBrickExtent + layers, kExtent) - low;
            float lo = 0, hi = 0;
            const glm::ivec3 id = own / kBrickExtent;
            statistics.brickRange({id.x, id.y, id.z}, layers, lo, hi);
            for (std::size_t i = 0; i < cellCount(count); ++i) {
                const std::int16_t v = voxels[linearIndex(low + gridPosition(i, count), kExtent)];
                ASSERT_GE(v, lo);
                ASSERT_LE(v, hi);
            }
        }
}

// Above the exact level, what is hidden in part is the mean of the level below, over the seams of its chunks
// too.
TEST(MaskedLongVolume, CoarseSamplesAreMeansOfTheLevelBelow) {
    const ScratchFolder folder;
    const VolumeInfo info = plainInfo({2100, 21, 9}, ValueType::i16);
    std::mt19937 random(7);
    HashSource source(info, [&](int, int, int) { return static_cast<int>(random() % 2000); });
    import(folder / "s.zarr", source);
    const StoreReader store(folder / "s.zarr", plenty());
    std::vector<std::uint8_t> shares(cellCount(levelExtent(info.extentVoxels, 2)));
    for (std::uint8_t& share : shares)
        share = random() % 3 == 0 ? static_cast<std::uint8_t>(random()) : std::uint8_t{0};
    const auto mask = std::make_shared<const Mask>(info.extentVoxels, 2, std::move(shares), plenty());
    const MaskedSource masked(store, mask, kAir, plenty(), 2);
    const auto samplesOf = [&](const ChunkSource& of, int level) {
        const glm::ivec3 extent = levelExtent(info.extentVoxels, level),
                         chunks = chunkGrid(info.extentVoxels, level);
        std::vector<std::int16_t> samples(cellCount(extent));
        std::vector<std::byte> bytes(of.chunkBytes());
        for (std::size_t n = 0; n < cellCount(chunks); ++n) {
            const glm::ivec3 at = gridPosition(n, chunks), first = at * kChunkExtent;
            of.readChunk({level, at.x, at.y, at.z}, bytes);
            const glm::ivec3 count = glm::min(extent - first, glm::ivec3(kChunkExtent));
            for (std::size_t i = 0; i < cellCount(count); ++i)
                std::memcpy(&samples[linearIndex(first + gridPosition(i, count), extent)],
                            &bytes[2 * linearIndex(gridPosition(i, count), glm::ivec3(kChunkExtent))], 2);
        }
        return samples;
    };
    for (int level = Mask::kExactLevel + 1; level < kLevelCount; ++level) {
        const glm::ivec3 extent = levelExtent(info.extentVoxels, level),
                         below = levelExtent(info.extentVoxels, level - 1);
        const std::vector<std::int16_t> finer = samplesOf(masked, level - 1), plain = samplesOf(store, level),
                                        found = samplesOf(masked, level);
        std::vector<std::int16_t> means(found.size());
        reduceByTwo(ValueType::i16, below, std::as_bytes(std::span(finer)),
                    std::as_writable_bytes(std::span(means)), 1);
        std::vector<float> hidden(found.size());
        mask->read(level, glm::ivec3(0), extent, hidden);
        std::size_t some = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_EQ(found[i], hidden[i] > 0 ? means[i] : plain[i]) << level << ", " << i;
            some += hidden[i] > 0 ? 1 : 0;
        }
        EXPECT_GT(some, found.size() / 4);
    }
}

TEST_P(MaskedLevels, WhatIsHiddenWhollyIsAirAndTwiceIsOnce) {
    const MaskedSource source = masked(GetParam());
    Statistics statistics = loadStatistics(*store, plenty(), 2);
    const std::vector<float> before = statistics.cellMax;
    hideMasked(statistics, source, plenty(), 2);
    std::size_t air = 0, changed = 0;
    for (std::size_t cell = 0; cell < before.size(); ++cell) {
        air += statistics.cellMin[cell] == kAir && statistics.cellMax[cell] == kAir;
        changed += statistics.cellMin[cell] == kAir;
    }
    if (GetParam() < 3) {
        EXPECT_GT(air, before.size() / 50);
    }
    EXPECT_LT(changed, before.size());
    const std::vector<float> once = statistics.cellMax, wide = statistics.wideMin,
                             means = statistics.brickMean;
    hideMasked(statistics, source, plenty(), 1);
    EXPECT_EQ(once, statistics.cellMax);
    EXPECT_EQ(wide, statistics.wideMin);
    EXPECT_EQ(means, statistics.brickMean);
}

TEST_F(MaskedStore, BeyondTheEdgeIsTheFillValue) {
    const MaskedSource source(*store,
                              std::make_shared<const Mask>(
                                  kExtent, 0, std::vector<std::uint8_t>(cellCount(kExtent), 255), plenty()),
                              kAir, plenty(), 2);
    std::vector<std::byte> chunk(store->chunkBytes());
    const auto at = [&](const glm::ivec3& place) {
        return reinterpret_cast<const std::int16_t*>(
            chunk.data())[linearIndex(place, glm::ivec3(kChunkExtent))];
    };
    source.readChunk({0, 2, 2, 3}, chunk); // begins at 64, 64, 96
    EXPECT_EQ(at({18, 5, 4}), kAir);
    EXPECT_EQ(at({19, 5, 4}), info.fillStored);
    EXPECT_EQ(at({18, 6, 4}), info.fillStored);
    EXPECT_EQ(at({18, 5, 5}), info.fillStored);
    source.readChunk({0, 1, 1, 1}, chunk);
    EXPECT_EQ(at({31, 31, 31}), kAir);
}

TEST_P(MaskedLevels, AnEmptyMaskChangesNoBit) {
    const int level = GetParam();
    const MaskedSource source(
        *store,
        std::make_shared<const Mask>(
            kExtent, level, std::vector<std::uint8_t>(cellCount(levelExtent(kExtent, level))), plenty()),
        kAir, plenty(), 2);
    Statistics statistics = loadStatistics(*store, plenty(), 2), plain = loadStatistics(*store, plenty(), 2);
    hideMasked(statistics, source, plenty(), 2);
    EXPECT_EQ(statistics.cellMin, plain.cellMin);
    EXPECT_EQ(statistics.wideMax, plain.wideMax);
    EXPECT_EQ(statistics.brickMean, plain.brickMean);
    std::vector<std::byte> a(store->chunkBytes()), b(a.size());
    for (int l = 0; l < kLevelCount; ++l) {
        store->readChunk({l, 0, 0, 0}, a);
        source.readChunk({l, 0, 0, 0}, b);
        EXPECT_EQ(a, b) << l;
    }
}

/// Of every thread that reads: shares, and for two levels a chunk, its means, eight chunks below and shares.
TEST_F(MaskedStore, ReadersAreCharged) {
    const auto mask = std::make_shared<const Mask>(kExtent, 2, blobs(kExtent, 2, 3), plenty());
    for (const int threads : {1, 2, 5}) {
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const MaskedSource source(*store, mask, kAir, ram, threads);
        EXPECT_EQ(ram.usedBytes(), static_cast<std::size_t>(threads) *
                                       (3 * 32768 * sizeof(float) + 2 * 10 * store->chunkBytes()));
    }
}

// Bricks that nothing is hidden of keep the ranges of their two layers, which are tighter than those of
// cells.
TEST_F(MaskedStore, BricksBesideKeepTheirRanges) {
    std::vector<std::int16_t> ramp(values.size());
    for (std::size_t i = 0; i < ramp.size(); ++i) {
        const glm::ivec3 at = gridPosition(i, kExtent);
        ramp[i] = static_cast<std::int16_t>(at.x + 3 * at.y + 7 * at.z);
    }
    const auto even = stored(folder / "ramp.zarr", ramp);
    const Statistics plain = loadStatistics(*even, plenty(), 2);
    for (const glm::ivec3& hiddenBrick : {glm::ivec3(2, 2, 3), glm::ivec3(0, 0, 0)}) {
        std::vector<std::uint8_t> shares(values.size()); // one voxel in the middle of a brick
        shares[linearIndex(glm::min(32 * hiddenBrick + 4, kExtent - 1), kExtent)] = 255;
        const MaskedSource source(*even, std::make_shared<const Mask>(kExtent, 0, shares, plenty()), kAir,
                                  plenty(), 2);
        Statistics masked = loadStatistics(*even, plenty(), 2);
        hideMasked(masked, source, plenty(), 2);
        std::size_t same = 0;
        for (std::size_t brick = 0; brick < plain.wideMin.size(); ++brick) {
            if (gridPosition(brick, plain.bricks) == hiddenBrick) {
                EXPECT_EQ(masked.wideMin[brick], kAir);
                continue;
            }
            EXPECT_EQ(masked.wideMin[brick], plain.wideMin[brick]) << brick;
            EXPECT_EQ(masked.wideMax[brick], plain.wideMax[brick]) << brick;
            EXPECT_EQ(masked.brickMin[brick], plain.brickMin[brick]) << brick;
            EXPECT_EQ(masked.brickMean[brick], plain.brickMean[brick]) << brick;
            ++same;
        }
        EXPECT_EQ(same + 1, plain.wideMin.size());
    }
}

// What is hidden by whole cells is as if it had never been scanned: every level, and the rays of bricks, from
// which errors are predicted.
TEST_F(MaskedStore, WholeCellsAreAsInAStoreWithoutThem) {
    std::vector<std::uint8_t> hidden(values.size());
    std::vector<std::int16_t> edited = values;
    for (std::size_t i = 0; i < edited.size(); ++i) {
        const glm::ivec3 cell = gridPosition(i, kExtent) / kCellExtent;
        if (mixed(linearIndex(cell, cellGrid(kExtent))) % 3 == 0 || cell.y > 5) {
            hidden[i] = 255;
            edited[i] = static_cast<std::int16_t>(kAir);
        }
    }
    const MaskedSource source(*store, std::make_shared<const Mask>(kExtent, 0, hidden, plenty()), kAir,
                              plenty(), 2);
    const auto without = stored(folder / "edited.zarr", edited);
    for (int level = 0; level < kLevelCount; ++level) {
        std::vector<std::int16_t> expected(cellCount(levelExtent(kExtent, level)));
        const auto at = [&](const glm::ivec3& place) {
            return linearIndex(place, levelExtent(kExtent, level));
        };
        forSamples(*without, level,
                   [&](const glm::ivec3& place, std::int16_t v) { expected[at(place)] = v; });
        forSamples(source, level, [&](const glm::ivec3& place, std::int16_t v) {
            ASSERT_EQ(v, expected[at(place)]) << level << " " << place.x << " " << place.y << " " << place.z;
        });
    }
    const auto rays = [&](const StoreReader& of, const MaskedSource* masked) {
        BrickRays all = noBrickRays(info, kBrickRayParts, plenty());
        addBrickRays(of, std::vector<std::uint8_t>(all.rowOf.size(), 1), all, plenty(), 2, masked);
        return all;
    };
    const BrickRays a = rays(*store, &source), b = rays(*without, nullptr), plain = rays(*store, nullptr);
    ASSERT_EQ(a.rows, b.rows);
    for (std::uint32_t row = 0; row < a.rows; ++row)
        for (int part = 0; part < kBrickRayParts; ++part) {
            EXPECT_EQ(std::memcmp(a.part(row, part).data(), b.part(row, part).data(), kBrickRayBytes), 0)
                << row;
            EXPECT_NE(std::memcmp(a.part(row, part).data(), plain.part(row, part).data(), kBrickRayBytes), 0);
        }
    // Without room for sampling they are the store's.
    MemoryBudget few("RAM", "--ram", std::size_t{600} << 10);
    BrickRays held = noBrickRays(info, kBrickRayParts, few);
    addBrickRays(*store, std::vector<std::uint8_t>(held.rowOf.size(), 1), held, few, 2, &source);
    for (std::uint32_t row = 0; row < held.rows; ++row)
        for (int part = 0; part < kBrickRayParts; ++part)
            EXPECT_EQ(std::memcmp(held.part(row, part).data(), plain.part(row, part).data(), kBrickRayBytes),
                      0);
}

// -- kept beside the statistics

FoundTable someTable() {
    FoundTable found;
    found.litres = 1.5;
    found.mask =
        std::make_shared<const Mask>(MaskedStore::kExtent, 1, blobs(MaskedStore::kExtent, 1, 8), plenty());
    return found;
}

TEST_F(MaskedStore, ATableIsKeptAndTheStoreStaysAsItIs) {
    const std::string hash = store->contentHash();
    const FoundTable kept = someTable();
    keepTable(kept, *store, path);
    const FoundTable read = tableOf(*store, plenty(), 2);
    ASSERT_TRUE(read.mask);
    EXPECT_EQ(read.litres, 1.5);
    EXPECT_EQ(read.mask->level(), 1);
    EXPECT_TRUE(std::equal(read.mask->shares().begin(), read.mask->shares().end(),
                           kept.mask->shares().begin(), kept.mask->shares().end()));
    EXPECT_EQ(StoreReader(path, plenty()).contentHash(), hash);
    FoundTable none;
    none.why = "there is no body";
    keepTable(none, *store, path);
    EXPECT_EQ(tableOf(*store, plenty(), 2).why, "there is no body");
}

TEST_F(MaskedStore, DamagedOrForeignTablesAreFoundAnew) {
    const std::string anew = findTable(*store, plenty(), 2).why;
    ASSERT_NE(anew, "");
    const auto spoil = [&](const fs::path& file, std::size_t at) {
        std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
        stream.seekg(0, std::ios::end);
        const auto size = static_cast<std::size_t>(stream.tellg());
        stream.seekg(static_cast<std::streamoff>(at % size));
        const char was = static_cast<char>(stream.get());
        stream.seekp(static_cast<std::streamoff>(at % size));
        stream.put(static_cast<char>(was ^ 0x10));
    };
    const fs::path table = path / "stats/table";
    std::size_t spoilt = 0;
    for (std::size_t at = 3; at < 4000; at += 257) {
        fs::remove_all(table);
        keepTable(someTable(), *store, path);
        std::vector<fs::path> files;
        for (const auto& entry : fs::recursive_directory_iterator(table))
            if (entry.is_regular_file())
                files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        spoil(files[at % files.size()], at * 31);
        EXPECT_EQ(tableOf(*store, plenty(), 2).why, anew) << files[at % files.size()] << " " << at;
        ++spoilt;
        EXPECT_EQ(tableOf(*store, plenty(), 2).why, anew); // kept now
    }
    EXPECT_GT(spoilt, 10u);
    keepTable(someTable(), *store, path);
    std::vector<std::int16_t> other = values;
    other[17] = 3;
    const fs::path copy = folder.path() / "other.zarr";
    const auto foreign = stored(copy, other);
    fs::remove_all(copy / "stats/table");
    fs::copy(table, copy / "stats/table", fs::copy_options::recursive);
    EXPECT_EQ(tableOf(*foreign, plenty(), 2).why, findTable(*foreign, plenty(), 2).why);
}

TEST_F(MaskedStore, AStoreThatCannotBeWrittenIsNoError) {
    fs::remove_all(path / "stats");
    std::ofstream(path / "stats") << "a file in the way";
    EXPECT_EQ(tableOf(*store, plenty(), 2).why, findTable(*store, plenty(), 2).why);
}

} // namespace
} // namespace tessera::test
