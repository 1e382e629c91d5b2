// tests/bricking/statistics/statistics_test.cpp: a store's statistics of its volume, known without voxels,
// against brute force: cells, histogram, means, and the sampled rays of its bricks.
#include "tests/support/bricking_store_tools.h"
#include "tests/support/recorded_numbers.h"

#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/checked_json.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(StoreStatistics, EqualBruteForce) {
    for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32}) {
        ScratchFolder scratch;
        const glm::ivec3 n(70, 47, 65);
        // Mostly equal, rarely extreme: so that most cells differ in what their ghost layer sees.
        HashSource source(plainInfo(n, type), [](int x, int y, int z) {
            const auto h = mixed(static_cast<std::uint64_t>(x + 100 * y + 10000 * z));
            return h % 97 == 0 ? static_cast<double>(h >> 57) : 40;
        });
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        const Statistics statistics = loadStatistics(store, ram, 2);
        ASSERT_EQ(statistics.cells, cellGrid(n));
        EXPECT_GT(ram.usedBytes(), statistics.cellMin.size() * 8);
        for (int k = 0; k < statistics.cells.z; ++k)
            for (int j = 0; j < statistics.cells.y; ++j)
                for (int i = 0; i < statistics.cells.x; ++i) {
                    double lo = 1e9, hi = -1e9;
                    for (int z = std::max(8 * k - 1, 0); z <= std::min(8 * k + 8, n.z - 1); ++z)
                        for (int y = std::max(8 * j - 1, 0); y <= std::min(8 * j + 8, n.y - 1); ++y)
                            for (int x = std::max(8 * i - 1, 0); x <= std::min(8 * i + 8, n.x - 1); ++x) {
                                lo = std::min(lo, source.valueAt(x, y, z));
                                hi = std::max(hi, source.valueAt(x, y, z));
                            }
                    const std::size_t at = linearIndex({i, j, k}, statistics.cells);
                    ASSERT_EQ(statistics.cellMin[at], lo) << i << " " << j << " " << k;
                    ASSERT_EQ(statistics.cellMax[at], hi) << i << " " << j << " " << k;
                }
        const auto coarsest = readLevel(store, 5);
        ASSERT_EQ(statistics.brickMean.size(), coarsest.size());
        EXPECT_TRUE(std::equal(coarsest.begin(), coarsest.end(), statistics.brickMean.begin()));
        const auto finest = readLevel(store, 0);
        EXPECT_EQ(statistics.lowest, *std::min_element(finest.begin(), finest.end()));
        EXPECT_EQ(statistics.highest, *std::max_element(finest.begin(), finest.end()));

        std::vector<std::uint64_t> histogram(kHistogramBins);
        const double width = (static_cast<double>(statistics.highest) - statistics.lowest) / kHistogramBins;
        for (const double v : finest)
            ++histogram[static_cast<std::size_t>(
                std::min(63.0, std::floor((v - statistics.lowest) / width)))];
        EXPECT_EQ(histogram, statistics.histogram);
        float lo = 0, hi = 0;
        for (const int layers : {1, 2})
            for (std::size_t b = 0; b < cellCount(statistics.bricks); ++b) {
                const glm::ivec3 brick = gridPosition(b, statistics.bricks);
                const glm::ivec3 first = glm::max(brick * kBrickExtent - layers, glm::ivec3(0));
                const glm::ivec3 end =
                    glm::min((brick + 1) * kBrickExtent + layers, store.info().extentVoxels);
                double expectedLo = 1e9, expectedHi = -1e9;
                for (int z = first.z; z < end.z; ++z)
                    for (int y = first.y; y < end.y; ++y)
                        for (int x = first.x; x < end.x; ++x) {
                            expectedLo = std::min(expectedLo, source.valueAt(x, y, z));
                            expectedHi = std::max(expectedHi, source.valueAt(x, y, z));
                        }
                statistics.brickRange({brick.x, brick.y, brick.z}, layers, lo, hi);
                ASSERT_EQ(lo, expectedLo) << b << ", layers " << layers;
                ASSERT_EQ(hi, expectedHi) << b << ", layers " << layers;
            }
    }
}

/// A value of a level's field at p (voxels), by the definition, from the whole level.
double fieldAt(const std::vector<double>& values, const glm::ivec3& extent, int level, const glm::dvec3& p) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        glm::ivec3 sample;
        for (int axis = 0; axis < 3; ++axis) {
            const double at = p[axis] / std::ldexp(1.0, level) - 0.5, low = std::floor(at);
            const int bit = corner >> axis & 1;
            weight *= bit ? at - low : 1 - (at - low);
            sample[axis] = std::clamp(static_cast<int>(low) + bit, 0, extent[axis] - 1);
        }
        sum += weight * values[linearIndex(sample, extent)];
    }
    return sum;
}

// Stores of version 4 hold no ranges of two layers: bounds take their place, nothing is computed again.
TEST(StoreStatistics, OfVersion4BoundTheWiderRanges) {
    ScratchFolder scratch;
    const glm::ivec3 n(70, 47, 65);
    // Rising along all axes: the extremes around a brick lie in the furthest of the layers around it.
    // Some bricks are below 0, others above.
    HashSource source(plainInfo(n, ValueType::i16), [](int x, int y, int z) { return x + y + z - 90; });
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const Statistics today = loadStatistics(store, ram, 1);
    const fs::path file = scratch / "v.zarr/stats/zarr.json";
    Json group = parseJson(fileText(file), "test");
    group["attributes"]["tessera"]["version"] = 4;
    for (const char* name : {"brick_min", "brick_max"}) {
        group["attributes"]["tessera"]["arrays"].erase(name);
        fs::remove_all(scratch / "v.zarr/stats" / name);
    }
    // A value that only the file has, to show where the figures come from.
    group["attributes"]["tessera"]["highest"] = today.highest + 1;
    seal(group);
    setFileText(file, group.dump(1));
    const Statistics older = loadStatistics(store, ram, 1);
    EXPECT_EQ(older.highest, today.highest + 1);
    EXPECT_EQ(older.cellMin, today.cellMin);
    EXPECT_EQ(older.brickMin, today.brickMin);
    bool wider = false;
    for (std::size_t b = 0; b < today.wideMin.size(); ++b) {
        EXPECT_LE(older.wideMin[b], today.wideMin[b]);
        EXPECT_GE(older.wideMax[b], today.wideMax[b]);
        // of its cells, and those around
        const glm::ivec3 own = gridPosition(b, today.bricks) * kCellsPerBrick;
        const glm::ivec3 low = glm::max(own - 1, glm::ivec3(0)),
                         count = glm::min(own + kCellsPerBrick + 1, today.cells) - low;
        float least = 1e9f, most = -1e9f;
        for (std::size_t c = 0; c < cellCount(count); ++c) {
            const std::size_t cell = linearIndex(low + gridPosition(c, count), today.cells);
            least = std::min(least, today.cellMin[cell]);
            most = std::max(most, today.cellMax[cell]);
        }
        EXPECT_EQ(older.wideMin[b], least) << b;
        EXPECT_EQ(older.wideMax[b], most) << b;
        wider = wider || older.wideMax[b] > today.wideMax[b];
    }
    EXPECT_TRUE(wider);
}

// Statistics are a cache, and another store's are none: of equal size, they would be believed.
TEST(StoreStatistics, OfAnotherStoreAreNotBelieved) {
    const ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", kPlenty);
    for (const int top : {100, 200}) {
        HashSource source(plainInfo({40, 40, 40}, ValueType::u8),
                          [top](int x, int y, int z) { return x + y + z == 60 ? top : 7; });
        import(scratch / std::to_string(top), source);
    }
    fs::remove_all(scratch / "200/stats");
    fs::copy(scratch / "100/stats", scratch / "200/stats", fs::copy_options::recursive);
    const Statistics found = loadStatistics(StoreReader(scratch / "200", ram), ram, 1);
    EXPECT_EQ(found.highest, 200);
    EXPECT_GT(found.histogram.back(), 100u);
}

// Longer than a chunk of 64 cells, and than 32 samples of the coarsest level: all of it is read from disk,
// for the voxels are gone.
TEST(StoreStatistics, OfLongVolumesAreReadWhole) {
    for (const glm::ivec3& n : {glm::ivec3(1100, 3, 2), glm::ivec3(3, 1100, 2), glm::ivec3(3, 2, 1100)}) {
        const ScratchFolder scratch;
        HashSource source(plainInfo(n, ValueType::i16), [](int x, int y, int z) { return x + y + z - 500; });
        import(scratch / "v", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v", ram);
        const std::vector<double> coarsest = readLevel(store, 5);
        fs::remove_all(scratch / "v/0/c");
        const Statistics found = loadStatistics(store, ram, 1);
        EXPECT_TRUE(
            std::equal(coarsest.begin(), coarsest.end(), found.brickMean.begin(), found.brickMean.end()));
        const std::size_t last = found.cellMax.size() - 1;
        EXPECT_EQ(found.cellMax[last], 1099 + 3 - 500);
        EXPECT_EQ(found.cellMin[last], 1096 - 1 - 500); // the last four, and the one before
        EXPECT_EQ(found.highest, found.cellMax[last]);
    }
}

/// Every stored ray must be a row of the brick, sampled at the documented places at every level.
TEST(RayStatistics, AreRowsOfTheBrickAtEveryLevel) {
    for (const ValueType type : {ValueType::i16, ValueType::f32}) {
        ScratchFolder scratch;
        const glm::ivec3 n(70, 47, 97), bricks = brickGrid(n);
        HashSource source(plainInfo(n, type), [](int x, int y, int z) {
            const auto h = mixed(static_cast<std::uint64_t>(x + 100 * y + 10000 * z));
            return std::floor(300 * std::sin(0.2 * x + 0.1 * y) * std::cos(0.15 * z)) +
                   static_cast<double>(h >> 58);
        });
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        std::vector<std::vector<double>> levels;
        for (int level = 0; level < kLevelCount; ++level)
            levels.push_back(readLevel(store, level));
        BrickRays rays = noBrickRays(store.info(), kBrickRayParts, ram);
        addBrickRays(store, std::vector<std::uint8_t>(cellCount(bricks), 1), rays, ram);
        std::set<std::tuple<std::size_t, int, int, int>> found;
        for (std::size_t brick = 0; brick < cellCount(bricks); ++brick) {
            const glm::ivec3 first = 32 * glm::ivec3(static_cast<int>(brick) % bricks.x,
                                                     static_cast<int>(brick) / bricks.x % bricks.y,
                                                     static_cast<int>(brick) / bricks.x / bricks.y);
            const glm::ivec3 size = glm::min(n - first, glm::ivec3(32));
            for (int p = 0; p < kBrickRayParts; ++p) {
                const BrickRayPart part = decodeRays(rays.part(rays.rowOf[brick], p));
                const double range = static_cast<double>(part.hi) - static_cast<double>(part.lo);
                for (int ray = 0; ray < kRaysPerPart; ++ray) {
                    const int axis = part.axis(ray), u = (axis + 1) % 3, w = (axis + 2) % 3;
                    bool matched = false;
                    for (int b = 0; b < size[w] && !matched; ++b)
                        for (int a = 0; a < size[u] && !matched; ++a) {
                            std::size_t code = static_cast<std::size_t>(ray * kSamplesPerRay);
                            matched = true;
                            for (int level = 0; level < kLevelCount && matched; ++level)
                                for (int j = 0; j < kRaySamples[static_cast<std::size_t>(level)] && matched;
                                     ++j) {
                                    glm::dvec3 at;
                                    at[axis] = raySampleAt(j, kRaySamples[static_cast<std::size_t>(level)],
                                                           size[axis]);
                                    at[u] = a + 0.5;
                                    at[w] = b + 0.5;
                                    const double value =
                                        fieldAt(levels[static_cast<std::size_t>(level)],
                                                levelExtent(n, level), level, glm::dvec3(first) + at);
                                    const double stored =
                                        static_cast<double>(part.lo) + range * part.codes[code++] / 255;
                                    matched = std::abs(value - stored) <= range * 0.502 / 255 + 1e-4;
                                }
                            if (matched)
                                found.insert({brick, axis, a, b});
                        }
                    EXPECT_TRUE(matched) << "brick " << brick << " part " << p << " ray " << ray;
                }
            }
        }
        EXPECT_GT(found.size(), 13 * cellCount(bricks)); // different rays, but for bricks a few voxels wide
    }
}

/// The rays of brick_rays.h's first lines, chosen and sampled plainly.
struct PlainRays {
    struct Row {
        int axis;
        glm::ivec3 start;
        std::size_t number = 0; // of candidates: the first of equal ones
        double mean = 0, residual = 0;
    };
    const BrickFields& fields;

    double at(int level, const glm::dvec3& p) const {
        if (level == 0)
            return fields.voxels[linearIndex(glm::ivec3(glm::floor(p)), fields.size)];
        const BrickFields::Box& box = fields.levels[static_cast<std::size_t>(level)];
        const std::vector<double> values(box.samples.begin(), box.samples.end());
        return fieldAt(values, box.extent, level, p - glm::dvec3(box.first) * std::ldexp(1.0, level));
    }
    std::vector<Row> rows() const {
        const BrickFields::Box& box = fields.levels[3];
        std::vector<Row> rows;
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, w = (axis + 2) % 3;
            for (int q = 0; 2 * q < fields.size[w]; ++q)
                for (int p = 0; 2 * p < fields.size[u]; ++p) {
                    Row row{axis, glm::ivec3(0), rows.size()};
                    row.start[u] = std::min(2 * p + q % 2, fields.size[u] - 1);
                    row.start[w] = std::min(2 * q + p % 2, fields.size[w] - 1);
                    for (int i = 0; i < fields.size[axis]; ++i) {
                        glm::ivec3 voxel = row.start;
                        voxel[axis] = i;
                        const double value = fields.voxels[linearIndex(voxel, fields.size)];
                        row.mean += value; // whole numbers, whose sums are exact
                        row.residual += std::abs(
                            value -
                            static_cast<double>(box.samples[linearIndex(voxel / 8 - box.first, box.extent)]));
                    }
                    row.mean /= fields.size[axis];
                    row.residual /= fields.size[axis];
                    rows.push_back(row);
                }
        }
        return rows;
    }
    /// Samples of two parts, and the axes.
    void choose(std::array<std::vector<double>, 2>& samples, std::array<std::vector<int>, 2>& axes) const {
        std::vector<Row> sorted = rows();
        std::stable_sort(sorted.begin(), sorted.end(),
                         [](const Row& a, const Row& b) { return a.mean < b.mean; });
        const auto take = [&](std::size_t part, const Row& row) {
            axes[part].push_back(row.axis);
            for (int level = 0; level < kLevelCount; ++level) {
                const int count = std::array{16, 16, 8, 4, 2, 2}[static_cast<std::size_t>(level)];
                for (int j = 0; j < count; ++j) {
                    glm::dvec3 p = glm::dvec3(row.start) + 0.5;
                    p[row.axis] = raySampleAt(j, count, fields.size[row.axis]);
                    samples[part].push_back(at(level, p));
                }
            }
        };
        const std::size_t n = sorted.size();
        for (std::size_t group = 0; group < 11; ++group) {
            const std::size_t first = n * group / 11, end = n * (group + 1) / 11;
            std::vector<Row> own(sorted.begin() + static_cast<std::ptrdiff_t>(first),
                                 sorted.begin() + static_cast<std::ptrdiff_t>(end));
            if (own.empty()) // fewer rows than groups
                own.push_back(sorted[std::min(first, n - 1)]);
            std::sort(own.begin(), own.end(), [](const Row& a, const Row& b) {
                return std::tuple(a.residual, a.number) < std::tuple(b.residual, b.number);
            });
            for (std::size_t half = 0; half < 2; ++half)
                take((half + group) % 2, own[own.size() * (1 + 2 * half) / 4]);
        }
        const auto [least, most] = std::minmax_element(fields.voxels.begin(), fields.voxels.end());
        for (int part = 0; part < 2; ++part) {
            const auto voxel = static_cast<std::size_t>((part == 0 ? most : least) - fields.voxels.begin());
            Row row{part, gridPosition(voxel, fields.size), 0};
            row.start[part] = 0;
            take(static_cast<std::size_t>(part), row);
        }
    }
};

TEST(RayStatistics, AreTheRaysThatRepresentABrick) {
    for (const glm::ivec3& size : {glm::ivec3(32), {31, 17, 9}, {5, 3, 32}, {2, 6, 1}, {1, 1, 1}})
        for (const bool inside : {true, false}) { // with a layer around, or a volume of a brick
            BrickFields fields;
            fields.size = size;
            std::vector<float> voxels(cellCount(size));
            for (std::size_t i = 0; i < voxels.size(); ++i) {
                const glm::ivec3 v = gridPosition(i, size);
                voxels[i] =
                    static_cast<float>(7 * v.x + 3 * v.y - 5 * v.z) + static_cast<float>(mixed(i) % 64);
            }
            fields.voxels = voxels;
            std::array<std::vector<float>, kLevelCount> levels;
            for (int level = 1; level < kLevelCount; ++level) {
                BrickFields::Box& box = fields.levels[static_cast<std::size_t>(level)];
                box.first = glm::ivec3(inside ? -1 : 0);
                box.extent = ceilDiv(size, 1 << level) + (inside ? 2 : 0);
                std::vector<float>& samples = levels[static_cast<std::size_t>(level)];
                samples.resize(cellCount(box.extent));
                for (std::size_t i = 0; i < samples.size(); ++i)
                    samples[i] = static_cast<float>(mixed(i + 1000 * static_cast<std::size_t>(level)) % 200);
                box.samples = samples;
            }
            std::array<std::vector<double>, 2> samples;
            std::array<std::vector<int>, 2> axes;
            PlainRays{fields}.choose(samples, axes);
            const auto parts = sampleRays(fields);
            for (std::size_t part = 0; part < 2; ++part) {
                const auto [lo, hi] = std::minmax_element(samples[part].begin(), samples[part].end());
                EXPECT_FLOAT_EQ(parts[part].lo, static_cast<float>(*lo));
                EXPECT_FLOAT_EQ(parts[part].hi, static_cast<float>(*hi));
                for (int ray = 0; ray < kRaysPerPart; ++ray)
                    EXPECT_EQ(parts[part].axis(ray), axes[part][static_cast<std::size_t>(ray)])
                        << size.x << ", part " << part << ", ray " << ray;
                ASSERT_EQ(samples[part].size(), parts[part].codes.size());
                for (std::size_t i = 0; i < samples[part].size(); ++i) {
                    const double range = std::max(*hi - *lo, 1e-9);
                    ASSERT_NEAR(parts[part].codes[i], (samples[part][i] - *lo) / range * 255, 0.51)
                        << size.x << ", part " << part << ", sample " << i;
                }
            }
        }
    // where a row is sampled: voxels before and after the middles of its parts, or the middles
    EXPECT_EQ(raySampleAt(0, 16, 32), 0.5);
    EXPECT_EQ(raySampleAt(1, 16, 32), 3.5);
    EXPECT_EQ(raySampleAt(15, 16, 32), 31.5);
    EXPECT_EQ(raySampleAt(15, 16, 1), 0.5);
    EXPECT_EQ(raySampleAt(0, 8, 32), 2);
    EXPECT_EQ(raySampleAt(3, 4, 30), 26.25);
}

TEST(RayStatistics, ComeFromTheVoxelsWhereTheStoreHasNone) {
    ScratchFolder scratch;
    const glm::ivec3 n(70, 47, 97), bricks = brickGrid(n);
    HashSource source(plainInfo(n, ValueType::u16));
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const std::size_t before = ram.usedBytes();
    const auto rowsOf = [&](std::vector<std::vector<std::uint8_t>> steps, int parts) {
        BrickRays rays = noBrickRays(store.info(), parts, ram);
        std::vector<std::uint8_t> all(cellCount(bricks));
        for (const auto& wanted : steps) {
            addBrickRays(store, wanted, rays, ram, 2);
            for (std::size_t b = 0; b < all.size(); ++b)
                all[b] |= wanted[b];
        }
        EXPECT_GE(ram.usedBytes(), before + rays.pages.size() * rays.pages[0].size());
        std::vector<std::vector<std::uint8_t>> rows;
        for (std::size_t b = 0; b < all.size(); ++b) {
            EXPECT_EQ(rays.rowOf[b] != BrickRays::kNoRow, all[b] != 0);
            rows.emplace_back();
            if (all[b])
                rows.back().assign(rays.row(rays.rowOf[b]).begin(), rays.row(rays.rowOf[b]).end());
        }
        return rows;
    };
    const std::vector<std::uint8_t> every(cellCount(bricks), 1);
    std::vector<std::uint8_t> some(cellCount(bricks)), rest(cellCount(bricks), 1);
    some[3] = some[11] = 1;
    const auto expected = rowsOf({every}, 2);
    EXPECT_EQ(rowsOf({some, every}, 2), expected); // step by step
    const auto few = rowsOf({some}, 2);
    EXPECT_EQ(few[3], expected[3]);
    EXPECT_TRUE(few[4].empty());
    const auto half = rowsOf({every}, 1);
    for (std::size_t b = 0; b < half.size(); ++b)
        EXPECT_TRUE(std::equal(half[b].begin(), half[b].end(), expected[b].begin()));
    EXPECT_EQ(ram.usedBytes(), before);

    const fs::path chunk = scratch / "v.zarr/stats/rays/1/c/1/0/0/0";
    std::string bytes = fileText(chunk);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    setFileText(chunk, bytes);
    EXPECT_EQ(rowsOf({every}, 2), expected);
    fs::remove(scratch / "v.zarr/stats/zarr.json");
    EXPECT_EQ(rowsOf({every}, 2), expected);
    EXPECT_EQ(rowsOf({some}, 2), few);
    const Statistics rebuilt = loadStatistics(store, ram, 2);
    EXPECT_EQ(rebuilt.brickMin.size(), cellCount(bricks));

    MemoryBudget small("RAM", "--ram", 20000);
    BrickRays rays = noBrickRays(store.info(), 2, small);
    EXPECT_THAT([&] { addBrickRays(store, every, rays, small); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("rays of bricks"), HasSubstr("--ram"))));
    EXPECT_EQ(rays.rows, 0u);
}

TEST(StoreStatistics, BinsCoverTheRange) {
    EXPECT_EQ(histogramBin(5, 5, 5), 0);
    EXPECT_EQ(histogramBin(0, 0, 64), 0);
    EXPECT_EQ(histogramBin(0.999, 0, 64), 0);
    EXPECT_EQ(histogramBin(1, 0, 64), 1);
    EXPECT_EQ(histogramBin(64, 0, 64), 63);
    EXPECT_EQ(histogramBin(NAN, 0, 64), 0);
    EXPECT_EQ(histogramBin(1e300, 0, 64), 63);
}

/// Memory that is promised for statistics.
TEST(StoreStatistics, FloorsAreThoseOfTheRecord) {
    test::RecordedNumbers record("tests/bricking/statistics/recorded/floors.txt");
    for (const glm::ivec3& extent : {glm::ivec3(9, 8, 7), {300, 210, 90}, {33, 1025, 700}})
        for (const ValueType type : {ValueType::u8, ValueType::f32})
            record.expect("floors",
                          {static_cast<double>(statisticsFloorBytes(plainInfo(extent, type), 1)),
                           static_cast<double>(statisticsFloorBytes(plainInfo(extent, type), 5))},
                          0, 0.5);
}

} // namespace
} // namespace tessera
