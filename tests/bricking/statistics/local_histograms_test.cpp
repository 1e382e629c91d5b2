// tests/bricking/statistics/local_histograms_test.cpp: local histograms against their definition written out
// once more, in double; what vector quantisation costs; and what is kept of them in a store.
#include "bricking/statistics/local_histograms.h"
#include "bricking/statistics/vector_quantiser.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "tests/support/bricking_store_tools.h"
#include "tests/support/recorded_numbers.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <utility>

namespace tessera {
namespace {

using namespace test;

/// A store of a formula, and its histograms.
struct Volume {
    Volume(const glm::ivec3& extent, const HashSource::Formula& formula, ValueType type = ValueType::i16) {
        HashSource source(plainInfo(extent, type), formula);
        import(scratch / "v.zarr", source);
        store.emplace(scratch / "v.zarr", ram);
        statistics = loadStatistics(*store, ram, 1);
    }
    LocalHistograms make(const LocalHistogramSettings& settings, int threads = 2) {
        return makeLocalHistograms(*store, statistics, settings, ram, threads);
    }
    std::shared_ptr<const LocalHistograms> kept(const LocalHistogramSettings& settings,
                                                std::uint32_t hidden = 0) {
        return localHistogramsOf(*store, *store, hidden, statistics, settings, ram, 1);
    }
    const ScratchFolder scratch;
    MemoryBudget ram{"RAM", "--ram", kPlenty};
    std::optional<StoreReader> store;
    Statistics statistics;
};

/// Waves with some noise on them.
double waves(int x, int y, int z) {
    const double wave = std::sin(0.31 * x + 0.05 * z) + std::cos(0.23 * y - 0.11 * x) + std::sin(0.4 * z);
    return std::floor(300 * wave) +
           static_cast<double>(mixed(static_cast<std::uint64_t>(x + 64 * (y + 64 * z))) % 40);
}

/// Cumulative shares of both sides of a sample, by the definition.
std::vector<double> plainly(const Volume& volume, const LocalHistograms& of,
                            const std::vector<double>& values, const glm::ivec3& sample) {
    const std::vector<double>& centres = of.centres;
    const glm::dmat3 mm = glm::dmat3(volume.store->info().patientFromVoxel) * std::ldexp(1.0, of.level);
    const auto isInside = [&](const glm::ivec3& at) {
        return glm::all(glm::greaterThanEqual(at, glm::ivec3(0))) && glm::all(glm::lessThan(at, of.extent));
    };
    const auto placeOf = [&](const glm::ivec3& at) {
        const double value = std::clamp(values[linearIndex(at, of.extent)], centres.front(), centres.back());
        std::size_t above = 1;
        while (above + 1 < centres.size() && centres[above] <= value)
            ++above;
        const double part = (value - centres[above - 1]) / (centres[above] - centres[above - 1]);
        return std::round((static_cast<double>(above - 1) + part) * 256) / 256;
    };
    glm::dvec3 gradient(0);
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 to(0);
        to[axis] = 1;
        const bool before = isInside(sample - to), after = isInside(sample + to);
        gradient[axis] = placeOf(after ? sample + to : sample) - placeOf(before ? sample - to : sample);
        gradient[axis] *= before && after ? 1 : 2;
    }
    if (std::max({std::abs(gradient.x), std::abs(gradient.y), std::abs(gradient.z)}) < 1)
        gradient = glm::dvec3(0);
    std::vector<double> shares(LocalHistograms::kRow);
    double sums[2] = {};
    const int reach = 12;
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x) {
                const glm::ivec3 offset(x, y, z);
                const double d = glm::length(mm * glm::dvec3(offset));
                if (offset == glm::ivec3(0) || !isInside(sample + offset) ||
                    (d > of.settings.radiusMm * (1 + 1e-9) && std::abs(x) + std::abs(y) + std::abs(z) > 1))
                    continue;
                const double along = glm::dot(glm::dvec3(offset), gradient), place = placeOf(sample + offset);
                const auto bin = static_cast<std::size_t>(place);
                for (std::size_t side = 0; side < 2; ++side) {
                    const double weight = (along == 0 ? 0.5 : (along > 0) == (side == 0) ? 1 : 0) / (d * d);
                    sums[side] += weight;
                    const double part = place - static_cast<double>(bin);
                    shares[side * 64 + bin] += weight * (1 - part);
                    if (part > 0)
                        shares[side * 64 + bin + 1] += weight * part;
                }
            }
    std::vector<double> cumulative(shares.size());
    for (std::size_t side = 0; side < 2; ++side) {
        const std::size_t from = sums[side] > 0 ? side : 1 - side;
        double sum = 0;
        for (std::size_t b = 0; b < 64; ++b) {
            sum += shares[from * 64 + b] / sums[from];
            cumulative[side * 64 + b] = sum;
        }
    }
    return cumulative;
}

std::vector<double> cumulativeOf(const LocalHistograms& of, std::size_t number) {
    std::vector<double> cumulative;
    for (const LocalSide side : {LocalSide::rising, LocalSide::falling}) {
        double sum = 0;
        for (std::size_t b = 0; b < 64; ++b) {
            sum += of.of(number, side)[b] / double{LocalHistograms::kWhole};
            cumulative.push_back(sum);
        }
    }
    return cumulative;
}

/// Mean and greatest distance of samples' representatives from their own histograms.
std::pair<double, double> errorOf(const Volume& volume, const LocalHistograms& made, std::size_t every) {
    const std::vector<double> values = readLevel(*volume.store, made.level);
    double sum = 0, most = 0;
    std::size_t count = 0;
    for (std::size_t n = 0; n < values.size(); n += every, ++count) {
        const auto exact = plainly(volume, made, values, gridPosition(n, made.extent));
        const auto found = cumulativeOf(made, made.numbers[n]);
        for (std::size_t i = 0; i < exact.size(); ++i) {
            sum += std::abs(exact[i] - found[i]);
            most = std::max(most, std::abs(exact[i] - found[i]));
        }
    }
    return {sum / static_cast<double>(count * LocalHistograms::kRow), most};
}

TEST(LocalHistograms, AreWhatTheyAreDefinedToBe) {
    for (const ValueType type : {ValueType::i16, ValueType::f32}) {
        Volume volume({40, 36, 22}, waves, type);
        for (const double radius : {0.2, 3.1, 6.0}) {
            const LocalHistograms made = volume.make({.radiusMm = radius, .representatives = 65536});
            EXPECT_EQ(made.level, 1);
            ASSERT_GT(made.centres.size(), 50u);
            // Samples of one representative are alike to a part of 255, but for the few that the search gives
            // the number of another like them.
            const auto [mean, most] = errorOf(volume, made, 7);
            EXPECT_LT(mean, 0.002) << radius;
            EXPECT_LT(most, radius < 5 ? 0.008 : 0.12) << radius;
        }
    }
}

/// A half space, seen from a distance d of its plane: of a ball of radius R it fills ((1 - u) + u ln u) / 2
/// of the weight, u = d/R, because 1/d^2 weighs every part of a way alike.
TEST(LocalHistograms, OfAHalfSpaceAreTheCapsIntegral) {
    Volume volume({64, 64, 64}, [](int x, int, int) { return x < 32 ? 0 : 1000; });
    const double radius = 7.5, pitch = 1; // of level 1, along x and y; 2.5 along z
    const LocalHistograms made = volume.make({.radiusMm = radius});
    ASSERT_EQ(made.level, 1);
    const glm::ivec3 middle = made.extent / 2;
    double before = 1;
    for (int n = 0; n < 9; ++n) { // planes of samples before the half space
        const double u = (n + 0.5) * pitch / radius;
        const double expected = u >= 1 ? 0 : 0.5 * (1 - u + u * std::log(u));
        const std::size_t number = made.numbers[linearIndex({15 - n, middle.y, middle.z}, made.extent)];
        double dense = 0;
        for (const LocalSide side : {LocalSide::rising, LocalSide::falling})
            for (std::size_t b = 1; b < made.centres.size(); ++b)
                dense += 0.5 * made.of(number, side)[b] / double{LocalHistograms::kWhole};
        EXPECT_NEAR(dense, expected, n == 0 ? 0.045 : 0.025) << n; // samples are a lattice
        EXPECT_LE(dense, before);
        before = dense;
        // It lies on the rising side alone.
        double behind = 0;
        for (std::size_t b = 1; b < made.centres.size(); ++b)
            behind += made.of(number, LocalSide::falling)[b];
        if (n < 1) {
            EXPECT_EQ(behind, 0) << n;
        }
    }
    // By symmetry the mean of the samples on both sides of the plane is a half.
    double both = 0;
    for (const int x : {15, 16}) {
        const std::size_t number = made.numbers[linearIndex({x, middle.y, middle.z}, made.extent)];
        for (const LocalSide side : {LocalSide::rising, LocalSide::falling})
            for (std::size_t b = 1; b < made.centres.size(); ++b)
                both += 0.25 * made.of(number, side)[b] / double{LocalHistograms::kWhole};
    }
    EXPECT_NEAR(both, 0.5, 0.002);
}

TEST(LocalHistograms, OfOneValueHaveOneBin) {
    Volume volume({40, 40, 40}, [](int, int, int) { return 77; });
    const LocalHistograms made = volume.make({});
    EXPECT_EQ(made.centres, std::vector<double>{77});
    EXPECT_EQ(made.representatives(), 1u);
    EXPECT_EQ(made.of(0, LocalSide::falling)[0], LocalHistograms::kWhole);
}

TEST(LocalHistograms, ErrorsFallWithRepresentatives) {
    Volume volume({64, 64, 64}, waves);
    double before = 1;
    for (const int most : {4, 32, 256, 2048}) {
        const double error = errorOf(volume, volume.make({.radiusMm = 5, .representatives = most}), 61).first;
        EXPECT_LT(error, 0.75 * before) << most;
        before = error;
    }
}

/// Neither threads nor the memory that is left for them change a bit.
TEST(LocalHistograms, ThreadsChangeNothing) {
    Volume volume({70, 66, 90}, waves);
    const LocalHistogramSettings settings{.radiusMm = 4, .representatives = 300};
    const LocalHistograms one = volume.make(settings, 1), three = volume.make(settings, 3);
    EXPECT_EQ(one.centres, three.centres);
    EXPECT_EQ(one.numbers, three.numbers);
    EXPECT_EQ(one.shares, three.shares);
    EXPECT_GT(one.representatives(), 250u);
    MemoryBudget little("RAM", "--ram", std::size_t{12} << 20);
    EXPECT_EQ(makeLocalHistograms(*volume.store, volume.statistics, settings, little, 8).shares, one.shares);
    EXPECT_LE(little.peakBytes(), little.limitBytes());
    MemoryBudget none("RAM", "--ram", std::size_t{1} << 20);
    EXPECT_THROW(makeLocalHistograms(*volume.store, volume.statistics, settings, none, 1), InputError);
}

TEST(LocalHistograms, LevelsFollowTheRadius) {
    VolumeInfo info = plainInfo({64, 64, 64}, ValueType::i16); // half a millimetre along x and y
    EXPECT_EQ(localHistogramLevel(info, 0.01), 1);
    EXPECT_EQ(localHistogramLevel(info, 8), 1);
    EXPECT_EQ(localHistogramLevel(info, 8.1), 2);
    EXPECT_EQ(localHistogramLevel(info, 128), 5);
    EXPECT_EQ(localHistogramLevel(info, 129), kLevelCount);
}

/// Neighbours within the radius, and the six beside a sample, by 1/d^2 of the nearest one's 16384.
TEST(LocalHistograms, ABallHasItsNeighboursByTheirDistance) {
    VolumeInfo info = plainInfo({64, 64, 64}, ValueType::i16);
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {0.6, 0.1, 0}, {-0.1, 0.8, 0.05}, {0.02, 0, 1.3});
    for (const int level : {1, 2})
        for (const double radius : {0.5, 3.3, 6.2}) {
            const glm::dmat3 mm = glm::dmat3(info.patientFromVoxel) * static_cast<double>(1 << level);
            const LocalBall ball = localBall(info, level, radius);
            double least = 1e300;
            glm::ivec3 reach(1);
            std::size_t near = 0;
            const auto counts = [&](const glm::ivec3& offset) {
                const int steps = std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z);
                return steps == 1 || (steps > 0 && glm::length(mm * glm::dvec3(offset)) <= radius);
            };
            for (std::size_t i = 0; i < 25u * 25 * 25; ++i) {
                const glm::ivec3 offset = gridPosition(i, glm::ivec3(25)) - 12;
                if (!counts(offset))
                    continue;
                ++near;
                least = std::min(least, glm::length(mm * glm::dvec3(offset)));
                reach = glm::max(reach, glm::abs(offset));
            }
            EXPECT_EQ(2 * ball.half.size(), near) << radius;
            for (const LocalBall::Neighbour& n : ball.half) {
                EXPECT_TRUE(counts(n.offset));
                const double d = least / glm::length(mm * glm::dvec3(n.offset));
                EXPECT_EQ(n.weight, static_cast<std::uint32_t>(std::max(1.0, std::round(16384 * d * d))));
                for (const LocalBall::Neighbour& other : ball.half)
                    EXPECT_NE(n.offset, -other.offset);
            }
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(ball.reach, reach)));
            EXPECT_TRUE(glm::all(glm::lessThanEqual(ball.reach, reach + 1)));
        }
}

/// Numbers of representatives and their shares, as they are recorded: what settings make of them, errors do
/// not tell.
TEST(LocalHistograms, AreThoseOfTheRecord) {
    RecordedNumbers record("tests/bricking/statistics/recorded/histograms.txt");
    Volume volume({52, 45, 39}, [](int x, int y, int z) {
        return waves(x, y, z) + (x > 30 ? 200 + y : 0) + (x * y * z % 1009 == 5 ? 2900 : 0);
    });
    for (const LocalHistogramSettings settings :
         {LocalHistogramSettings{.radiusMm = 3.7, .bins = 23, .representatives = 90},
          LocalHistogramSettings{.radiusMm = 9, .representatives = 500}}) {
        const LocalHistograms made = volume.make(settings);
        std::vector<double> centres(made.centres.begin(), made.centres.end());
        record.expect("centres", centres);
        double numbers = 0, shares = 0;
        for (std::size_t i = 0; i < made.numbers.size(); ++i)
            numbers += made.numbers[i] * static_cast<double>(i % 101);
        for (std::size_t i = 0; i < made.shares.size(); ++i)
            shares += made.shares[i] * static_cast<double>(i % 103);
        record.expect("sums", {static_cast<double>(made.level), static_cast<double>(made.representatives()),
                               numbers, shares, static_cast<double>(made.bytes()),
                               static_cast<double>(localHistogramBytes(volume.store->info(), settings))});
    }
    // of more samples than representatives are learnt from, which every second one is then
    Volume large({113, 97, 92}, [](int x, int y, int z) { return waves(x, y, z) + x * y % 37; });
    const LocalHistograms learnt = large.make({.radiusMm = 0.4, .bins = 12, .representatives = 30});
    ASSERT_GT(learnt.numbers.size(), 100000u);
    double ofShares = 0;
    for (std::size_t i = 0; i < learnt.shares.size(); ++i)
        ofShares += learnt.shares[i] * static_cast<double>(i % 103);
    record.expect("learnt", {static_cast<double>(learnt.representatives()), ofShares});
    // a sample with clusters in clusters
    std::vector<VectorQuantiser::Vector> sample(6000);
    for (std::size_t n = 0; n < sample.size(); ++n)
        for (std::size_t i = 0; i < sample[n].size(); ++i)
            sample[n][i] = static_cast<std::uint8_t>(
                mixed(n % 9 * 1000 + i) % 100 + mixed(n % 211 * 1000 + i) % 60 + mixed(n * 1000 + i) % 50);
    for (const std::size_t most : {7u, 64u, 300u}) {
        const VectorQuantiser quantiser(sample, most, 1);
        double error = 0, numbers = 0;
        for (std::size_t n = 0; n < sample.size(); ++n) {
            const std::uint16_t number = quantiser.nearest(sample[n]);
            error += VectorQuantiser::distance(sample[n], quantiser[number]);
            numbers += number * static_cast<double>(n % 97);
        }
        record.expect("quantised", {static_cast<double>(quantiser.size()), error, numbers,
                                    static_cast<double>(VectorQuantiser::bytes(sample.size(), most))});
    }
}

bool same(const LocalHistograms& a, const LocalHistograms& b) {
    return a.level == b.level && a.extent == b.extent && a.centres == b.centres && a.numbers == b.numbers &&
           a.shares == b.shares && a.settings == b.settings;
}

const char* const kFiles[] = {"zarr.json", "numbers/zarr.json", "numbers/c/0/0/0", "shares/zarr.json"};

TEST(KeptHistograms, AreTheFreshOnes) {
    Volume volume({48, 40, 44}, waves);
    const LocalHistogramSettings settings{.radiusMm = 4, .representatives = 64};
    const LocalHistograms fresh = volume.make(settings);
    const fs::path folder = volume.scratch / "v.zarr/stats/histograms";
    EXPECT_FALSE(fs::exists(folder)) << "making keeps nothing";
    EXPECT_TRUE(same(*volume.kept(settings), fresh));
    ASSERT_TRUE(fs::exists(folder / "zarr.json"));
    const auto written = fs::last_write_time(folder / "zarr.json");
    EXPECT_TRUE(same(*volume.kept(settings), fresh));
    EXPECT_EQ(fs::last_write_time(folder / "zarr.json"), written) << "read, not made again";
    // Others take their place: of other settings, of a volume that hides something.
    LocalHistogramSettings other = settings;
    other.radiusMm = 5;
    EXPECT_EQ(volume.kept(other)->settings, other);
    EXPECT_TRUE(same(*volume.kept(settings), fresh));
    const auto before = fileText(folder / "zarr.json");
    volume.kept(settings, 5);
    EXPECT_NE(fileText(folder / "zarr.json"), before);
    // A store without statistics has no place for them.
    fs::remove_all(volume.scratch / "v.zarr/stats");
    EXPECT_TRUE(same(*volume.kept(settings), fresh));
}

TEST(KeptHistograms, DamagedOnesAreMadeAnew) {
    Volume volume({48, 40, 44}, waves);
    const LocalHistogramSettings settings{.radiusMm = 4, .representatives = 64};
    const auto fresh = volume.kept(settings);
    const fs::path folder = volume.scratch / "v.zarr/stats/histograms";
    std::mt19937 random(7);
    for (const char* name : kFiles) {
        ASSERT_TRUE(fs::exists(folder / name)) << name;
        const std::string whole = fileText(folder / name);
        for (int n = 0; n < 6; ++n) {
            std::string damaged = whole;
            if (n % 2 == 0)
                damaged.resize(random() % whole.size());
            else
                damaged[random() % whole.size()] ^= static_cast<char>(1u << random() % 8);
            setFileText(folder / name, damaged);
            EXPECT_TRUE(same(*volume.kept(settings), *fresh)) << name << " " << n;
            EXPECT_EQ(fileText(folder / name), whole) << "kept again";
        }
        fs::remove(folder / name);
        EXPECT_TRUE(same(*volume.kept(settings), *fresh)) << name;
    }
}

/// Sealed again, as no damage is.
TEST(KeptHistograms, LyingOnesAreMadeAnew) {
    Volume volume({48, 40, 44}, waves);
    const LocalHistogramSettings settings{.radiusMm = 4, .representatives = 64};
    const auto fresh = volume.kept(settings);
    const fs::path file = volume.scratch / "v.zarr/stats/histograms/zarr.json";
    const std::string whole = fileText(file);
    const std::function<void(Json&)> lies[] = {
        [](Json& about) { about["representatives"] = 1; },
        [](Json& about) { about["representatives"] = 65; },
        [](Json& about) { about["representatives"] = std::int64_t{1} << 40; },
        [](Json& about) { about["centres"] = Json::array(); },
        [](Json& about) { about["centres"] = std::vector<double>(100000, 1); },
        [](Json& about) { about["centres"][3] = about["centres"][2]; },
        [](Json& about) { about["centres"][1] = "x"; },
        [](Json& about) { about["version"] = 0; },
        [](Json& about) { about["store"] = "another"; },
        [](Json& about) { about["hidden"] = 1; },
        [](Json& about) { about.erase("radius"); },
        [](Json& about) { about["crcs"]["numbers"] = 1; },
    };
    int n = 0;
    for (const auto& lie : lies) {
        Json group = parseJson(whole, "test");
        lie(group["attributes"]["tessera"]);
        seal(group);
        setFileText(file, group.dump(1));
        EXPECT_TRUE(same(*volume.kept(settings), *fresh)) << n;
        EXPECT_EQ(fileText(file), whole) << n++;
    }
}

TEST(VectorQuantiser, FindsTheNearestOfFew) {
    std::vector<VectorQuantiser::Vector> sample(4000);
    for (std::size_t n = 0; n < sample.size(); ++n)
        for (std::size_t i = 0; i < sample[n].size(); ++i)
            sample[n][i] =
                static_cast<std::uint8_t>(mixed(n % 40 * 1000 + i) % 200 + mixed(n * 1000 + i) % 8);
    const VectorQuantiser quantiser(sample, 40, 1);
    ASSERT_EQ(quantiser.size(), 40u);
    std::size_t worse = 0;
    for (const auto& vector : sample) {
        unsigned least = UINT_MAX;
        for (std::size_t r = 0; r < quantiser.size(); ++r)
            least = std::min(least, VectorQuantiser::distance(vector, quantiser[r]));
        worse += VectorQuantiser::distance(vector, quantiser[quantiser.nearest(vector)]) > least ? 1 : 0;
    }
    EXPECT_LE(worse, sample.size() / 100);
    // Clusters that stand apart are found as they are.
    EXPECT_EQ(quantiser.nearest(sample[3]), quantiser.nearest(sample[43]));
    EXPECT_NE(quantiser.nearest(sample[3]), quantiser.nearest(sample[4]));
}

TEST(VectorQuantiser, OfEqualVectorsHasOne) {
    const std::vector<VectorQuantiser::Vector> sample(500);
    EXPECT_EQ(VectorQuantiser(sample, 64, 1).size(), 1u);
}

} // namespace
} // namespace tessera
