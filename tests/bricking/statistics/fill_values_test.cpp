// tests/bricking/statistics/fill_values_test.cpp: fill values: extremes that stand alone are told from
// measurements, whatever share of the voxels holds them, and the rest is counted as if they were not there.
#include "tests/support/bricking_store_tools.h"

#include "bricking/levels/level_error.h"
#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/coarse_statistics.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/checked_json.h"
#include "core/scene/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <optional>

namespace tessera {
namespace {

using namespace test;

constexpr int kEdge = 40; // chunks beyond the volume's edge, too

std::uint64_t hashAt(int x, int y, int z) {
    return mixed(static_cast<std::uint64_t>(x + 100 * y + 10000 * z));
}
/// Noise around a dark background and a bright object, from 3 to 903.
double measured(int x, int y, int z) {
    const bool inside = x > 10 && x < 30 && y > 10 && y < 30 && z > 10;
    return 3 + static_cast<double>(hashAt(x, y, z) % 101) + (inside ? 800 : 0);
}

struct Case {
    VolumeInfo info;
    HashSource::Formula value;
};
struct Found {
    Statistics statistics;
    VolumeInfo info;
    std::vector<double> voxels;
};
Found found(const Case& of) {
    const ScratchFolder scratch;
    HashSource source(of.info, of.value);
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    Found all{loadStatistics(store, ram, 2), store.info(), readLevel(store, 0)};
    all.statistics.charge = {};
    return all;
}

std::map<double, std::uint64_t> countsOf(const FillValues& fills) {
    std::map<double, std::uint64_t> counts;
    for (const FillValues::Value& fill : fills.values)
        counts[static_cast<double>(fill.value)] += fill.voxels;
    return counts;
}

/// Against brute force over all voxels.
/// @param fills  the values that must be told, and no others
void expectFills(const Found& of, const std::vector<double>& fills, const std::string& what) {
    const FillValues& told = of.statistics.fills;
    std::map<double, std::uint64_t> counts;
    std::vector<double> rest;
    for (const double voxel : of.voxels)
        if (std::ranges::find_if(fills, [&](double fill) {
                return static_cast<double>(static_cast<float>(fill)) == voxel;
            }) == fills.end())
            rest.push_back(voxel);
        else
            ++counts[voxel];
    EXPECT_EQ(countsOf(told), counts) << what;
    if (fills.empty())
        return;
    const auto [least, most] = std::ranges::minmax(rest);
    EXPECT_EQ(static_cast<double>(told.lowest), least) << what;
    EXPECT_EQ(static_cast<double>(told.highest), most) << what;
    std::vector<std::uint64_t> histogram(kHistogramBins);
    for (const double value : rest)
        ++histogram[static_cast<std::size_t>(histogramBin(value, least, most))];
    EXPECT_EQ(told.histogram, histogram) << what;
}

TEST(FillValues, AnyShareOfAFarValueLeavesTheOthersAsTheyAre) {
    const auto plain = plainInfo(glm::ivec3(kEdge), ValueType::f32);
    for (const double fill : {-9999.0, -1e30, -3.4e38, 1e20, -32768.5, 65535.0, -900.0})
        for (const std::uint64_t perMille : {0u, 10u, 210u, 900u}) {
            const auto value = [&](int x, int y, int z) {
                const bool isOne = x == 5 && y == 39 && z == 38;
                return isOne || (hashAt(x, y, z) >> 20) % 1000 < perMille ? fill : measured(x, y, z);
            };
            expectFills(found({plain, value}), {fill}, std::to_string(fill) + " " + std::to_string(perMille));
        }
    expectFills(found({plain, measured}), {}, "no fill value");
}

TEST(FillValues, BothEndsAndSeveralAreTold) {
    const auto with = [&](std::vector<double> fills, ValueType type) {
        const auto value = [=](int x, int y, int z) {
            const std::uint64_t n = (hashAt(x, y, z) >> 20) % 16;
            return n < fills.size() ? fills[n] : measured(x, y, z);
        };
        expectFills(found({plainInfo(glm::ivec3(kEdge), type), value}), fills, std::to_string(fills[0]));
    };
    with({-1e30, 1e30}, ValueType::f32);
    with({-9999, 32767}, ValueType::i16);
    with({-32768, -4096}, ValueType::i16);
    with({-3.4e38, -9999, 1e20}, ValueType::f32);
    with({65535}, ValueType::u16);
}

/// At least as far as the others are apart.
TEST(FillValues, ANearerExtremeIsAMeasurement) {
    for (const ValueType type : {ValueType::i16, ValueType::f32})
        for (const int side : {-1, 1}) {
            const auto at = [&](double beyond) {
                return found({plainInfo(glm::ivec3(kEdge), type), [=](int x, int y, int z) {
                                  const double end = side < 0 ? 3 - 900 - beyond : 903 + 900 + beyond;
                                  return x == 7 && y % 3 == 0 ? end : measured(x, y, z);
                              }});
            };
            expectFills(at(0), {side < 0 ? -897.0 : 1803.0}, "as far");
            expectFills(at(-1), {}, "nearer");
        }
}

TEST(FillValues, NaturalBackgroundsAndFewValuesStay) {
    const auto expectNone = [](VolumeInfo info, double end, const std::string& what, double base = 5000) {
        expectFills(
            found({info, [=](int x, int y, int z) { return x < 9 ? end : base + measured(x, y, z); }}), {},
            what);
    };
    const auto of = [](ValueType type) { return plainInfo(glm::ivec3(kEdge), type); };
    expectNone(of(ValueType::f32), 0, "0");
    expectNone(of(ValueType::i16), -1000, "air");
    expectNone(of(ValueType::i16), -1024, "air of scanners");
    VolumeInfo scaled = of(ValueType::u16);
    scaled.rescaleSlope = 2, scaled.rescaleIntercept = -77;
    expectNone(scaled, 0, "a stored 0 without a sign");
    VolumeInfo ct = of(ValueType::i16);
    ct.unit = "HU";
    expectNone(ct, -1100, "air in HU", 100);
    ct.rescaleSlope = -1;
    expectNone(ct, 1100, "air in HU, turned over", -2000);
    // Few values are regions, which may have any numbers.
    expectFills(found({of(ValueType::i16), [](int x, int, int z) { return x < 9 ? -500.0 : 3.0 + z % 7; }}),
                {}, "labels");
    expectFills(found({of(ValueType::u8), [](int x, int, int) { return x < 9 ? 7.0 : 255.0; }}), {},
                "a mask");
    expectFills(found({of(ValueType::u8), [](int, int, int) { return 7.0; }}), {}, "one value");
    expectFills(found({ct, [](int x, int y, int z) { return x < 9 ? 9000.0 : -measured(x, y, z); }}), {9000},
                "padding below air, turned over");
}

bool operator==(const FillValues& a, const FillValues& b) {
    return countsOf(a) == countsOf(b) && a.lowest == b.lowest && a.highest == b.highest &&
           a.histogram == b.histogram;
}

/// What the store says, what an earlier program's store makes one look for, and what is computed anew.
TEST(FillValues, AreKeptInTheStoreAndFoundWhereTheyAreNot) {
    const ScratchFolder scratch;
    HashSource source(plainInfo(glm::ivec3(kEdge), ValueType::f32), [](int x, int y, int z) {
        return hashAt(x, y, z) % 5 == 0 ? -1e30 : measured(x, y, z);
    });
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const fs::path file = store.path() / "stats" / "zarr.json";
    const FillValues kept = loadStatistics(store, ram, 2).fills;
    ASSERT_EQ(kept.values.size(), 1u);
    EXPECT_TRUE(loadCoarseStatistics(store, ram, 2).value().fills == kept);
    const auto rewrite = [&](const std::function<void(Json&)>& change) {
        std::ifstream in(file);
        Json group = Json::parse(in);
        change(group["attributes"]["tessera"]);
        seal(group);
        std::ofstream(file) << storedText(group);
    };
    rewrite([](Json& all) { all["fill"]["voxels"][0] = all["fill"]["voxels"][0].get<int>() - 1; });
    EXPECT_TRUE(loadStatistics(store, ram, 2).fills == kept) << "damaged: computed anew";
    rewrite([](Json& all) { all.erase("fill"); });
    EXPECT_FALSE(loadCoarseStatistics(store, ram, 2).has_value()) << "voxels must be looked at";
    EXPECT_TRUE(loadStatistics(store, ram, 2).fills == kept) << "of an earlier program";
    fs::remove_all(store.path() / "stats");
    EXPECT_TRUE(loadStatistics(store, ram, 2).fills == kept) << "without statistics";
}

/// A function over the measured values alone, beside the largest floats: places in its table overflow.
TEST(FillValues, LevelsArePredictedBesideThem) {
    for (const double fill : {-3.4e38, 3.4e38}) {
        const ScratchFolder scratch;
        HashSource source(plainInfo(glm::ivec3(kEdge), ValueType::f32), [=](int x, int y, int z) {
            return x < 12 || hashAt(x, y, z) % 50 == 0 ? fill : measured(x, y, z);
        });
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        BrickRays rays = noBrickRays(store.info(), kBrickRayParts, ram);
        const std::vector<std::uint8_t> all(rays.rowOf.size(), 1);
        addBrickRays(store, all, rays, ram, 2);
        for (const double above : {0.0, 0.5}) { // a ridge, and a step
            const auto function =
                TransferFunction::fromOpacity({{3, 0}, {500, 0.1}, {903, 0.5}, {904, above}}, {}, 1);
            const LevelErrors errors = predictErrors(rays, all, makeTable(function), store.info(), 2);
            for (std::size_t brick = 0; brick < all.size(); ++brick) {
                EXPECT_TRUE(std::isfinite(errors.transmittances[brick])) << fill;
                for (const float error : errors.errors[brick])
                    EXPECT_TRUE(std::isfinite(error)) << fill;
            }
            if (fill < 0 && above > 0) { // what is measured is the highest code
                EXPECT_LT(errors.transmittances.front(), 0.9f);
            }
        }
    }
}

/// Nearly all stores stay as they were, to the byte.
TEST(FillValues, AreNotSpokenOfWhereThereCanBeNone) {
    const ScratchFolder scratch;
    HashSource source(plainInfo(glm::ivec3(kEdge), ValueType::f32), measured);
    import(scratch / "v.zarr", source);
    std::ifstream in(scratch / "v.zarr" / "stats" / "zarr.json");
    EXPECT_FALSE(Json::parse(in)["attributes"]["tessera"].contains("fill"));
}

} // namespace
} // namespace tessera
