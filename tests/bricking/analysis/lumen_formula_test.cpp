// tests/bricking/analysis/lumen_formula_test.cpp: values, noise and thresholds of lumens against the plain
// formulas that their headers state, voxel by voxel and in double.
#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/seed_threshold.h"
#include "core/base/error.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/phantom_chunks.h"

#include <gtest/gtest.h>
#include <numbers>

namespace tessera::test {
namespace {

using Voxels = std::function<double(const glm::ivec3&)>; // stored values

/// Stored values of any type.
template <typename Value> class VoxelChunks final : public ChunkSource {
  public:
    VoxelChunks(const VolumeInfo& info, Voxels voxels) : info_(info), voxels_(std::move(voxels)) {}
    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        const glm::ivec3 corner = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        auto* to = reinterpret_cast<Value*>(out.data());
        for (std::size_t i = 0; i < out.size() / sizeof(Value); ++i)
            to[i] = static_cast<Value>(voxels_(corner + gridPosition(i, glm::ivec3(kChunkExtent))));
    }

  private:
    VolumeInfo info_;
    Voxels voxels_;
};

VolumeInfo infoOf(const glm::ivec3& extent, const glm::dvec3& spacing, ValueType type, double slope = 1) {
    VolumeInfo info = boxInfo(extent, spacing, glm::dvec3(0));
    info.type = type;
    info.rescaleSlope = slope;
    info.rescaleIntercept = 7;
    return info;
}

/// One bilateral mean over 3^3, whose spatial deviation is 1.2 of the smallest spacing. A voxel beyond all
/// but one of its neighbours counts as the nearest of these.
double meanAround(const Voxels& in, const glm::ivec3& v, const glm::dvec3& spacing, double full, double any) {
    const double reach = 1.2 * std::min({spacing.x, spacing.y, spacing.z});
    std::vector<std::pair<double, double>> others; // value, weight by distance
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                if (x != 0 || y != 0 || z != 0) {
                    const double mm = glm::length(glm::dvec3(x, y, z) * spacing) / reach;
                    others.emplace_back(in(v + glm::ivec3(x, y, z)), std::exp(-0.5 * mm * mm));
                }
    std::sort(others.begin(), others.end());
    const double own = std::clamp(in(v), others[1].first, others[24].first);
    double sum = own, weight = 1;
    for (const auto& [value, byDistance] : others) {
        const double w = byDistance * std::clamp((any - std::abs(value - own)) / (any - full), 0.0, 1.0);
        sum += w * value;
        weight += w;
    }
    return sum / weight;
}

/// Differences to the plain formula at every voxel of a volume of several chunks along each axis.
template <typename Value>
double worstOfQuiet(const VolumeInfo& info, const Voxels& voxels, double deviation) {
    const VoxelChunks<Value> loud(info, voxels);
    const glm::ivec3 n = info.extentVoxels;
    const double stored = deviation / std::abs(info.rescaleSlope);
    const glm::dvec3 mm = info.spacingMm();
    const glm::ivec3 wide = n + 2;
    std::vector<double> once(cellCount(wide)); // a voxel beyond the volume on every side
    const auto clamped = [&](const glm::ivec3& v) {
        return static_cast<double>(static_cast<Value>(voxels(glm::clamp(v, glm::ivec3(0), n - 1))));
    };
    for (std::size_t i = 0; i < once.size(); ++i)
        once[i] = meanAround(clamped, gridPosition(i, wide) - 1, mm, 2.5 * stored, 4.5 * stored);
    const auto second = [&](const glm::ivec3& v) { return once[linearIndex(v + 1, wide)]; };
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    LumenField field(loud, ram, 1);
    field.quieten(deviation);
    LumenValues values(field.cache(), info);
    double worst = 0;
    for (std::size_t i = 0; i < cellCount(n); ++i) {
        const glm::ivec3 v = gridPosition(i, n);
        double expected = meanAround(second, v, mm, 1.2 * stored, 2.4 * stored);
        if (std::is_integral_v<Value>)
            expected = std::round(expected);
        const double found = (values.voxel(v) - info.rescaleIntercept) / info.rescaleSlope;
        worst = std::max(worst, std::abs(found - expected));
    }
    return worst;
}

TEST(LumenFormula, DenoisingIsTwoBilateralMeans) {
    const auto voxels = [](const glm::ivec3& v) { // a slanting wall in noise of 20
        return (v.x + 2 * v.y - v.z > 20 ? 160 : 60) + 0.5 * v.z + 20 * normalAt(v);
    };
    const auto bytes = [&](const glm::ivec3& v) { return std::clamp(voxels(v), 0.0, 255.0); };
    const glm::ivec3 n(37, 35, 34);
    // integers: a value half way between two may be rounded either way
    EXPECT_LE(worstOfQuiet<std::int16_t>(infoOf(n, {0.7, 1.1, 1.6}, ValueType::i16), voxels, 20), 1);
    EXPECT_LE(worstOfQuiet<std::uint8_t>(infoOf({33, 9, 40}, {1.5, 0.9, 1}, ValueType::u8), bytes, 25), 1);
    EXPECT_LE(worstOfQuiet<float>(infoOf({9, 34, 35}, {1, 1.3, 0.8}, ValueType::f32, -0.25), voxels, 4),
              1e-3);
}

TEST(LumenFormula, DenoisingIsChargedForEveryReader) {
    const VoxelChunks<std::int16_t> source(infoOf({40, 40, 40}, glm::dvec3(1), ValueType::i16),
                                           [](const glm::ivec3& v) { return v.x; });
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(source, ram, 16u << 20, 1);
    const std::size_t before = ram.usedBytes();
    std::size_t own = 0;
    for (const int readers : {1, 2, 5}) {
        const QuietValues quiet(cache, source.info(), 3, ram, readers);
        own = own ? own : ram.usedBytes() - before;
        EXPECT_EQ(ram.usedBytes() - before, static_cast<std::size_t>(readers) * own);
    }
    // two boxes of floats that are two voxels wider on every side than a chunk
    EXPECT_EQ(own, 2 * 4 * std::size_t{36 * 36 * 36});
}

/// Each of two caches takes a quarter of what is free, 256 MiB at most; where little is free their floors,
/// and the first a chunk more for every reader.
TEST(LumenFormula, CachesTakeAQuarterOfTheBudget) {
    const VoxelChunks<std::int16_t> source(infoOf({40, 40, 40}, glm::dvec3(1), ValueType::i16),
                                           [](const glm::ivec3& v) { return v.x; });
    constexpr std::size_t kMiB = std::size_t{1} << 20, chunk = 2 * 32 * 32 * 32;
    for (const int threads : {1, 3}) {
        const std::size_t floor = BrickCache::floorBytes(source.info(), threads),
                          scratch = static_cast<std::size_t>(threads) * 2 * 4 * 36 * 36 * 36;
        MemoryBudget ram("RAM", "--ram", 64 * kMiB), much("RAM", "--ram", 8192 * kMiB);
        LumenField field(source, ram, threads), large(source, much, threads);
        EXPECT_EQ(ram.usedBytes(), 16 * kMiB);
        EXPECT_EQ(much.usedBytes(), 256 * kMiB);
        field.quieten(3);
        EXPECT_EQ(ram.usedBytes(), 16 * kMiB + scratch + (48 * kMiB - scratch) / 4);
        field.unquieten();
        EXPECT_EQ(ram.usedBytes(), 16 * kMiB);
        const std::size_t least = 2 * floor + static_cast<std::size_t>(threads) * chunk + scratch;
        for (const bool enough : {true, false}) {
            MemoryBudget little("RAM", "--ram", enough ? least : least - 1);
            LumenField small(source, little, threads);
            EXPECT_EQ(little.usedBytes(), floor + static_cast<std::size_t>(threads) * chunk);
            if (enough) {
                EXPECT_NO_THROW(small.quieten(3));
            } else {
                EXPECT_THROW(small.quieten(3), InputError);
            }
        }
    }
}

/// Standard deviation of the part of a normal distribution that is left above its quantile p.
double deviationAbove(double p) {
    double low = -9, high = 9; // the quantile, by halving
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(-middle / std::numbers::sqrt2) < p ? low : high) = middle;
    }
    const double rate = std::exp(-0.5 * low * low) / std::sqrt(2 * std::numbers::pi) / (1 - p);
    return std::sqrt(1 + low * rate - rate * rate);
}

/// As the header says: the quarter of the blocks with the least median difference of voxels two apart.
ValueNoise plainNoise(const VolumeInfo& info, const Voxels& voxels, const glm::dvec3& place) {
    const glm::dvec3 mm = info.spacingMm();
    glm::ivec3 low, high;
    int coarsest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int reach = std::clamp(static_cast<int>(20 / mm[axis]), 8, 16);
        const int middle = static_cast<int>(std::floor(place[axis]));
        low[axis] = std::max(middle - reach, 0);
        high[axis] = std::min(middle + reach, info.extentVoxels[axis] - 1);
        if (mm[axis] >= mm[coarsest])
            coarsest = axis;
    }
    const glm::ivec3 box = high - low + 1;
    double lowest = 1e300, lows = 0;
    for (std::size_t i = 0; i < cellCount(box); ++i)
        lowest = std::min(lowest, voxels(low + gridPosition(i, box)));
    for (std::size_t i = 0; i < cellCount(box); ++i)
        lows += voxels(low + gridPosition(i, box)) == lowest;
    const double share = lows / static_cast<double>(cellCount(box));
    const bool clips = share >= 0.02;
    std::vector<double> deviations;
    for (std::size_t b = 0; b < cellCount(box / 4); ++b) {
        const glm::ivec3 corner = low + 4 * gridPosition(b, box / 4);
        std::vector<double> apart;
        double clipped = 0;
        for (std::size_t i = 0; i < 64; ++i) {
            const glm::ivec3 v = corner + gridPosition(i, glm::ivec3(4));
            clipped += clips && voxels(v) == lowest ? 1 : 0;
            for (int axis = 0; axis < 3; ++axis) {
                glm::ivec3 other = v;
                other[axis] += 2;
                if (axis != coarsest && other[axis] <= high[axis] &&
                    !(clips && (voxels(v) == lowest || voxels(other) == lowest)))
                    apart.push_back(std::abs(voxels(v) - voxels(other)));
            }
        }
        if (apart.size() < 12)
            continue;
        std::sort(apart.begin(), apart.end());
        deviations.push_back(1.4826 / std::numbers::sqrt2 * apart[apart.size() / 2] /
                             deviationAbove(clipped / 64));
    }
    std::sort(deviations.begin(), deviations.end());
    const double found =
        deviations.empty()
            ? 0
            : deviations[static_cast<std::size_t>(0.25 * static_cast<double>(deviations.size() - 1))];
    return {found * std::abs(info.rescaleSlope), clips ? share : 0};
}

TEST(LumenFormula, NoiseIsThatOfTheQuietestBlocks) {
    struct Case {
        glm::ivec3 extent;
        glm::dvec3 spacing, place;
        double clip;
    };
    for (const Case& c : {Case{{60, 53, 47}, {1, 2.1, 1.4}, {30.2, 25.9, 20.5}, -1e9},
                          {{60, 53, 47}, {3.1, 1.6, 1.2}, {30.2, 25.9, 20.5}, -1e9},
                          {{60, 53, 47}, {1.1, 1.1, 3.1}, {3.2, 50.9, 44.5}, -1e9},
                          {{14, 11, 5}, {1.2, 1.1, 1.1}, {3.2, 5.9, 2.5}, -1e9},
                          {{60, 53, 47}, {1, 2.1, 1.4}, {28.2, 25.9, 20.5}, 92},
                          {{60, 53, 47}, {1.2, 1.2, 1.2}, {28.2, 25.9, 20.5}, 101}}) {
        const auto voxels = [&](const glm::ivec3& v) { // noise that grows along x, and a wall
            const double value = 100 + (v.y > 32 ? 80 : 0) + (6 + 0.5 * v.x) * normalAt(v);
            return std::round(10 * std::max(value, c.clip));
        };
        const VoxelChunks<std::int16_t> source(infoOf(c.extent, c.spacing, ValueType::i16, 0.1), voxels);
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        BrickCache cache(source, ram, 16u << 20, 1);
        LumenValues values(cache, source.info());
        const ValueNoise found = noiseAround(values, c.place),
                         expected = plainNoise(source.info(), voxels, c.place);
        EXPECT_EQ(found.clippedShare > 0, c.clip > 0);
        EXPECT_NEAR(found.clippedShare, expected.clippedShare, 1e-12);
        const double tolerance = c.clip > 0 ? 0.02 : 1e-7; // a table of deviationAbove()
        EXPECT_NEAR(found.deviation, expected.deviation, tolerance * expected.deviation)
            << c.spacing.x << c.clip;
        EXPECT_GT(found.deviation, 3);
    }
}

/// Fewer than a fiftieth of the voxels may have the lowest value by chance.
TEST(LumenFormula, LowestValuesAreClippedFromAFiftiethOn) {
    const glm::ivec3 n(10, 10, 10); // all of it is around
    for (const int lows : {19, 20}) {
        const VoxelChunks<std::int16_t> source(
            infoOf(n, glm::dvec3(1), ValueType::i16), [&](const glm::ivec3& v) {
                return v.x < 10 && v.y < 10 && v.z < 10 && static_cast<int>(linearIndex(v, n)) < lows
                           ? -1000.0
                           : std::round(20 * normalAt(v));
            });
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        BrickCache cache(source, ram, 16u << 20, 1);
        LumenValues values(cache, source.info());
        EXPECT_NEAR(noiseAround(values, {5, 5, 5}).clippedShare, lows < 20 ? 0 : 0.02, 1e-12);
    }
}

// ---- the wall around a seed

/// What the rays from the middle of a ball find; none: it is refused.
std::optional<SeedNeighbourhood> aroundIn(double spacing, double edge,
                                          const std::function<double(double)>& byRadius) {
    const int half = static_cast<int>(edge / spacing);
    const FieldChunks chunks(boxInfo(glm::ivec3(2 * half), glm::dvec3(spacing), glm::dvec3(-half * spacing)),
                             [&](const glm::dvec3& p) { return byRadius(glm::length(p)); });
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(chunks, ram, 32u << 20, 2);
    LumenValues values(cache, chunks.info());
    try {
        return neighbourhoodOf(values, glm::dvec3(half), "the seed");
    } catch (const InputError&) {
        return std::nullopt;
    }
}

TEST(LumenFormula, AWallIsLookedForWithin100Mm) {
    for (const double radius : {92.0, 105.0}) {
        const auto found = aroundIn(6, 118, [&](double r) { return r < radius ? -1000 : 40; });
        ASSERT_EQ(found.has_value(), radius < 100) << radius;
        if (found) {
            EXPECT_NEAR(found->lumen, -1000, 1e-9);
            EXPECT_NEAR(found->wall, 40, 30); // between voxels of 6 mm
            EXPECT_NEAR(found->rule.threshold, 0.5 * (found->wall - 1000), 1e-9);
            EXPECT_TRUE(found->rule.below);
            EXPECT_TRUE(std::isinf(found->rule.brightest));
        }
    }
}

/// A wall has 1.5 mm, or three voxels where these are less.
TEST(LumenFormula, AWallHasItsLeastThickness) {
    for (const auto& [spacing, thick] : {std::pair{1.0, 1.6}, {0.5, 1.6}, {0.25, 0.8}}) {
        const auto found =
            aroundIn(spacing, 10, [&](double r) { return r > 5 && r < 5 + thick ? 40 : -1000; });
        ASSERT_TRUE(found) << spacing;
        EXPECT_NEAR(found->wall, 40, 40);
    }
}

/// Values within a twentieth of the range of all rays are of the lumen.
TEST(LumenFormula, AFaintWallIsOneFromATwentiethOfTheRangeOn) {
    for (const double faint : {40.0, 48.0, 56.0, 70.0}) {
        const auto found = aroundIn(1, 20, [&](double r) {
            return r < 6 ? -1000 : r < 12 ? -1000 + faint : 40;
        });
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->wall, faint < 52 ? 40 : -1000 + faint, 1) << faint;
    }
}

/// So are values within six deviations of the noise, up to a quarter of the range.
TEST(LumenFormula, AFaintWallInNoiseStandsOutBySixDeviations) {
    for (const auto& [faint, isWall] : {std::pair{70.0, false}, {175.0, true}}) {
        const FieldChunks clean(boxInfo(glm::ivec3(40), glm::dvec3(1), glm::dvec3(-20)),
                                [&](const glm::dvec3& p) {
                                    const double r = glm::length(p);
                                    return r < 6 ? -1000 : r < 14 ? -1000 + faint : 40;
                                });
        const NoisyChunks noisy(clean, 17);
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        BrickCache cache(noisy, ram, 32u << 20, 2);
        LumenValues values(cache, noisy.info());
        const SeedNeighbourhood found = neighbourhoodOf(values, glm::dvec3(20), "the seed");
        EXPECT_NEAR(found.noise, 17, 4);
        EXPECT_EQ(found.wall < -700, isWall) << faint << ": " << found.wall;
    }
}

/// The wall's value is where it stops changing, by less than a tenth a step, within 15 mm.
TEST(LumenFormula, AWallGoesOnWhileItChangesUpTo15Mm) {
    const auto grows = [](double perStep) {
        return [=](double r) {
            return r < 18 ? -1000 : std::min(30000.0, -1000 + 100 * std::pow(perStep, 2 * (r - 18)));
        };
    };
    const auto steep = aroundIn(1, 38, grows(1.13));
    ASSERT_TRUE(steep);
    // values stay away from the lumen's within 1.5 mm behind its edge, and rays end 15 mm behind that
    EXPECT_GT(steep->wall, -1000 + 100 * std::pow(1.13, 28));
    EXPECT_LT(steep->wall, -1000 + 100 * std::pow(1.13, 44));
    const auto flat = aroundIn(1, 38, grows(1.06));
    ASSERT_TRUE(flat);
    EXPECT_LT(flat->wall, -500) << "a wall that hardly changes ends soon";
}

TEST(LumenFormula, ContrastHasAnUpperBound) {
    const auto found = aroundIn(1, 20, [](double r) { return r < 6 ? 300 : 60; });
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->rule.below);
    EXPECT_NEAR(found->rule.threshold, 180, 1e-9);
    EXPECT_NEAR(found->rule.brightest, 300 + 1.5 * 120, 1e-9);
    EXPECT_NEAR(found->contrast(), 240, 1e-9);
    EXPECT_FALSE(found->rule.takes(180));
    EXPECT_TRUE(found->rule.takes(180.1));
    EXPECT_TRUE(found->rule.takes(479.9));
    EXPECT_FALSE(found->rule.takes(480));
    SeedNeighbourhood noisy = *found;
    for (const double noise : {3.9, 4.0, 4.1}) { // a sixtieth of the contrast is not yet strong
        noisy.noise = noise;
        EXPECT_EQ(noisy.noisy(), noise > 4) << noise;
    }
}

TEST(LumenFormula, AGivenThresholdHasTheWallAsFarBeyond) {
    const FieldChunks chunks(boxInfo(glm::ivec3(40), glm::dvec3(1), glm::dvec3(-20)),
                             [](const glm::dvec3& p) { return glm::length(p) < 8 ? 300 : 60; });
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(chunks, ram, 32u << 20, 2);
    LumenValues values(cache, chunks.info());
    for (const double threshold : {120.0, 299.0, 300.0, 301.0, 500.0}) {
        const SeedNeighbourhood found = neighbourhoodOf(values, glm::dvec3(20), threshold);
        EXPECT_EQ(found.lumen, 300);
        EXPECT_EQ(found.wall, 2 * threshold - 300);
        EXPECT_EQ(found.rule.threshold, threshold);
        EXPECT_EQ(found.rule.below, threshold > 300);
        if (threshold > 300) {
            EXPECT_TRUE(std::isinf(found.rule.brightest));
        } else {
            EXPECT_EQ(found.rule.brightest, 300 + 1.5 * (300 - threshold));
        }
    }
}

TEST(LumenFormula, AWiderRuleTakesItsValueAndAHundredthMore) {
    for (const bool below : {true, false}) {
        const LumenRule rule{-500, below};
        const double sign = below ? 1 : -1;
        for (const double beyond : {-100.0, -1e-9, 0.0, 0.5, 300.0}) {
            const double value = -500 + sign * beyond;
            const LumenRule wider = rule.orTaking(value);
            EXPECT_TRUE(wider.takes(value)) << below << beyond;
            if (beyond < 0) {
                EXPECT_EQ(wider.threshold, -500);
            } else {
                EXPECT_NEAR(wider.threshold, -500 + sign * 1.01 * beyond, 1e-3);
            }
        }
    }
}

// ---- growing with a guard

/// Values grow with the sum of a voxel's coordinates, so a lumen from the corner holds what is below.
struct Wedge {
    glm::ivec3 extent{40, 35, 33};
    std::function<double(int)> bySum;
    VoxelChunks<std::int16_t> chunks(const glm::dvec3& spacing) const {
        VolumeInfo info = infoOf(extent, spacing, ValueType::i16);
        info.rescaleIntercept = 0;
        return {info, [f = bySum](const glm::ivec3& v) { return f(v.x + v.y + v.z); }};
    }
    std::uint64_t below(double threshold) const {
        std::uint64_t count = 0;
        for (std::size_t i = 0; i < cellCount(extent); ++i) {
            const glm::ivec3 v = gridPosition(i, extent);
            count += bySum(v.x + v.y + v.z) < threshold ? 1 : 0;
        }
        return count;
    }
};

/// The share of the way to the threshold that the guard takes, as its header says.
double guardedShare(const Wedge& wedge, double lumen, double way, double noise, double voxelMm3,
                    bool& leaked) {
    const double inside = std::clamp(3 * noise / way, 1 / 20.0, 1.0);
    const double few = std::floor(5000 / voxelMm3) + 1000;
    double share = inside;
    leaked = false;
    for (double step = 1 / 20.0; share < 1 && step >= 1 / 160.0;) {
        const double next = std::min(1.0, share + step);
        const auto now = static_cast<double>(wedge.below(lumen + share * way));
        if (static_cast<double>(wedge.below(lumen + next * way)) > std::max(few, std::floor(1.5 * now))) {
            leaked = true;
            step /= 2;
        } else
            share = next;
    }
    if (leaked && noise / way > 1 / 160.0)
        share = std::max(inside, share - noise / way);
    return share;
}

TEST(LumenFormula, AGuardedThresholdIsTheWidestBeforeALeak) {
    const double lumen = -1000, way = 400;
    for (const double voxel : {1.0, 3.0, 10.0})
        for (const double noise : {0.0, 2.0, 12.0, 70.0})
            for (const double leak : {-975.0, -823.0, -702.0, -500.0}) {
                // from sum 24 on it widens slowly, at one value by far
                const Wedge wedge{{40, 35, 33}, [=](int sum) {
                                      const double own = -1000 + 14.0 * std::max(0, sum - 24);
                                      return std::round(own < leak ? own : sum < 85 ? leak : 0);
                                  }};
                const auto chunks = wedge.chunks(glm::dvec3(voxel));
                MemoryBudget ram("RAM", "--ram", 64u << 20);
                BrickCache cache(chunks, ram, 32u << 20, 2);
                SeedNeighbourhood around;
                around.lumen = lumen;
                around.noise = noise;
                around.rule.threshold = lumen + way;
                bool leaks = false;
                const double share = guardedShare(wedge, lumen, way, noise, voxel * voxel * voxel, leaks);
                const GuardedLumen found =
                    growWithoutLeaks(cache, chunks.info(), around, {0, 0, 0}, true, ram);
                EXPECT_EQ(found.leaked, leaks) << voxel << " " << noise << " " << leak;
                EXPECT_NEAR(found.rule.threshold, lumen + share * way, 1e-9)
                    << voxel << " " << noise << " " << leak;
                EXPECT_EQ(found.grown.count, wedge.below(found.rule.threshold));
                EXPECT_EQ(found.grown.voxels.count(), found.grown.count);
            }
}

/// Where nothing asks for a tree, one growing tells: it leaks if most of the lumen is unlike the seed.
TEST(LumenFormula, ALumenLeaksIfMostOfItIsUnlikeTheSeed) {
    struct Case {
        int unlike;   // of 30 layers
        double value; // of these
        double noise;
        bool leaks;
    };
    for (const Case& c : {Case{15, -900, 0, false},
                          {16, -900, 0, true},
                          {16, -940, 0, false},
                          {16, -936, 0, true},
                          {16, -900, 32, true},
                          {16, -900, 34, false}}) {
        const VoxelChunks<std::int16_t> chunks(
            infoOf({20, 10, 30}, glm::dvec3(1), ValueType::i16),
            [&](const glm::ivec3& v) { return (v.z < c.unlike ? c.value : -1000) - 7; });
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        BrickCache cache(chunks, ram, 32u << 20, 2);
        SeedNeighbourhood around;
        around.lumen = -1000;
        around.noise = c.noise;
        around.rule.threshold = -500;
        const GuardedLumen found = growWithoutLeaks(cache, chunks.info(), around, {1, 1, 29}, false, ram);
        // a lumen as small as this never leaks when it grows step by step
        EXPECT_EQ(found.grown.unlike == 0, c.leaks || c.value < -938 || c.noise > 33) << c.unlike << c.value;
        EXPECT_EQ(found.grown.count, 6000u);
    }
}

} // namespace
} // namespace tessera::test
