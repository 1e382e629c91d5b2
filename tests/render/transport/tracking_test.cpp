// Free paths and transmittance by null collisions, against the depth of the field along a way; bounds of
// extinction.
#include "render/transport/tracking.h"

#include "tests/support/path_volume.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

/// Numbers from 0 to 1 that have nothing to do with those of paths.
float hashOf(const glm::ivec3& i, int salt = 0) {
    const glm::uvec3 u(i);
    auto n =
        u.x * 73856093u ^ u.y * 19349663u ^ u.z * 83492791u ^ static_cast<std::uint32_t>(salt) * 2654435u;
    n = (n ^ (n >> 13)) * 1274126177u;
    return static_cast<float>((n ^ (n >> 16)) & 0xffffu) / 65536.0f;
}

struct Case {
    const char* name;
    double most; // extinction per voxel
    std::function<float(const glm::ivec3&)> value;
};

std::vector<Case> cases() {
    std::vector<Case> all;
    for (const double scale : {1e-6, 0.05, 1.0, 100.0}) {
        const auto most = static_cast<float>(scale);
        all.push_back({"constant", scale, [=](const glm::ivec3&) { return most; }});
        all.push_back({"exponential", scale, [=](const glm::ivec3& i) {
                           return most * std::exp(-0.08f * static_cast<float>(i.x));
                       }});
        all.push_back({"Gaussian", scale, [=](const glm::ivec3& i) {
                           const float d = static_cast<float>(i.x) - 20.0f;
                           return most * std::exp(-0.02f * d * d);
                       }});
        all.push_back({"random", scale, [=](const glm::ivec3& i) {
                           return hashOf(i / 8) < 0.5f ? 0.0f : most * hashOf(i, 1);
                       }});
    }
    return all;
}

/// Depth of the field along a way up to each of many places, by the midpoint rule in double.
class Depths {
  public:
    Depths(const PathVolume& volume, const Way& way) : mm_(static_cast<double>(way.mm)) {
        depth_.push_back(0);
        for (int n = 0; n < kSteps; ++n) {
            const auto at = static_cast<float>((n + 0.5) / kSteps * mm_);
            depth_.push_back(depth_.back() +
                             mm_ / kSteps *
                                 static_cast<double>(volume.extinction(way.from + at * way.perMm)));
        }
    }
    double upTo(double mm) const {
        const double place = std::clamp(mm / mm_ * kSteps, 0.0, static_cast<double>(kSteps));
        const auto n = std::min(static_cast<std::size_t>(place), std::size_t{kSteps - 1});
        return depth_[n] + (place - static_cast<double>(n)) * (depth_[n + 1] - depth_[n]);
    }
    double all() const { return depth_.back(); }

  private:
    static constexpr int kSteps = 4000;
    double mm_;
    std::vector<double> depth_;
};

Way wayThrough(const PathVolume& volume, const glm::vec3& from, const glm::vec3& direction) {
    const glm::vec3 perMm = direction / glm::length(direction);
    return {from, perMm, mmToLeave(from, perMm, glm::vec3(volume.extent()))};
}

std::vector<std::pair<glm::vec3, glm::vec3>> ways() {
    return {{{0, 10.3f, 12.1f}, {1, 0, 0}},
            {{0.2f, 1.5f, 2.5f}, {1, 0.7f, 0.4f}},
            {{39.9f, 30.1f, 3.3f}, {-1, -0.3f, 0.2f}}};
}

TEST(FreePath, HasTheDistributionOfTheDepth) {
    constexpr int kPaths = 8000;
    for (const Case& c : cases()) {
        const PathVolume volume({40, 34, 30}, c.value, c.most);
        PathWork work;
        for (const auto& [from, direction] : ways()) {
            const Way way = wayThrough(volume, from, direction);
            const Depths depths(volume, way);
            std::vector<double> found;
            for (int path = 0; path < kPaths; ++path) {
                PathNumbers numbers({static_cast<float>(path), from.x + 0.5f}, 5);
                const float mm = freePath(
                    volume.bounds(), &volume.occupancy(), way,
                    [&](const glm::vec3& p) { return volume.extinction(p); }, numbers, work);
                ASSERT_LE(mm, way.mm);
                found.push_back(mm < 0 ? 1e30 : static_cast<double>(mm));
            }
            std::sort(found.begin(), found.end());
            double most = 0; // of the distributions' differences
            for (int n = 0; n < kPaths && found[static_cast<std::size_t>(n)] < 1e29; ++n) {
                const double share = -std::expm1(-depths.upTo(found[static_cast<std::size_t>(n)]));
                most = std::max({most, std::abs(share - static_cast<double>(n) / kPaths),
                                 std::abs(share - (n + 1.0) / kPaths)});
            }
            EXPECT_LT(most, 1.95 / std::sqrt(kPaths)) << c.name << " " << c.most; // of one in a thousand
            const double passed = static_cast<double>(std::count(found.begin(), found.end(), 1e30)) / kPaths;
            const double through = std::exp(-depths.all());
            EXPECT_NEAR(passed, through, 4 * std::sqrt(through * (1 - through) / kPaths) + 1e-4) << c.name;
        }
        EXPECT_EQ(work.exceeded, 0u) << c.name << " " << c.most;
    }
}

TEST(Transmittance, IsUnbiased) {
    constexpr int kPaths = 8000;
    for (const Case& c : cases()) {
        const PathVolume volume({40, 34, 30}, c.value, c.most);
        PathWork work;
        for (const auto& [from, direction] : ways()) {
            const Way way = wayThrough(volume, from, direction);
            double sum = 0, squares = 0;
            for (int path = 0; path < kPaths; ++path) {
                PathNumbers numbers({static_cast<float>(path), from.x + 0.5f}, 6);
                const double t = static_cast<double>(transmittance(
                    volume.bounds(), &volume.occupancy(), way,
                    [&](const glm::vec3& p) { return volume.extinction(p); }, numbers, work));
                sum += t, squares += t * t;
            }
            const double mean = sum / kPaths;
            const double error = std::sqrt(std::max(squares / kPaths - mean * mean, 0.0) / kPaths);
            EXPECT_NEAR(mean, std::exp(-Depths(volume, way).all()), 4 * error + 2e-5)
                << c.name << " " << c.most;
        }
        EXPECT_EQ(work.exceeded, 0u) << c.name << " " << c.most;
    }
}

TEST(Transmittance, OfAWayThatEndsEarlierIsThatOfThePart) {
    const PathVolume volume(
        {40, 34, 30}, [](const glm::ivec3&) { return 0.1f; }, 0.1);
    Way way = wayThrough(volume, {3, 10.3f, 12.1f}, {1, 0.2f, 0});
    way.mm = 7;
    double sum = 0;
    PathWork work;
    for (int path = 0; path < 1000; ++path) {
        PathNumbers numbers({static_cast<float>(path), 0.5f}, 6);
        sum += static_cast<double>(transmittance(
            volume.bounds(), nullptr, way, [&](const glm::vec3& p) { return volume.extinction(p); }, numbers,
            work));
    }
    EXPECT_NEAR(sum / 1000, std::exp(-0.7), 5e-3); // bounds are 1/128 wide
}

TEST(Transmittance, IsExactToAShareOfItselfWhereItIsDark) {
    const PathVolume volume(
        {40, 34, 30}, [](const glm::ivec3&) { return 0.5f; }, 0.5);
    for (const float mm : {12.0f, 16.0f, 20.0f}) {
        Way way = wayThrough(volume, {1, 10.3f, 12.1f}, {1, 0, 0});
        way.mm = mm;
        double sum = 0;
        PathWork work;
        for (int path = 0; path < 1000; ++path) {
            PathNumbers numbers({static_cast<float>(path), 0.5f}, 6);
            sum += static_cast<double>(transmittance(
                volume.bounds(), nullptr, way, [&](const glm::vec3& p) { return volume.extinction(p); },
                numbers, work));
        }
        const double expected = std::exp(-0.5 * static_cast<double>(mm));
        EXPECT_NEAR(sum / 1000, expected, 0.02 * expected); // bounds are 1/128 wide
    }
}

/// Leaps over empty boxes change no result.
TEST(FreePath, IsTheSameWithoutLeaps) {
    const auto walls = [](const glm::ivec3& i) { return i.x < 6 || i.x > 33 ? 0.05f * hashOf(i) : -1.0f; };
    const PathVolume volume({40, 34, 30}, walls, 0.05);
    PathWork leaping, walking;
    for (int path = 0; path < 3000; ++path) {
        PathNumbers a({static_cast<float>(path), 0.5f}, 6), b = a;
        const Way way =
            wayThrough(volume, {0.2f, 1.5f + 0.01f * static_cast<float>(path), 2.5f}, {1, 0.1f, 0.4f});
        const auto extinction = [&](const glm::vec3& p) { return volume.extinction(p); };
        const float leapt = freePath(volume.bounds(), &volume.occupancy(), way, extinction, a, leaping);
        const float walked = freePath(volume.bounds(), nullptr, way, extinction, b, walking);
        EXPECT_NEAR(leapt, walked, 2e-2f);
    }
    EXPECT_LT(leaping.cells, walking.cells);
}

TEST(TableExtremes, AreThoseOfEveryPlaceBetween) {
    std::vector<glm::vec4> table;
    for (int n = 0; n < 1000; ++n)
        table.emplace_back(0, 0, 0, hashOf({n, 0, 0}));
    const TableExtremes extremes(table);
    const auto at = [&](double place) {
        place = std::clamp(place, 0.0, 999.0);
        const auto n = std::min(static_cast<std::size_t>(place), std::size_t{998});
        return table[n].a +
               static_cast<float>(place - static_cast<double>(n)) * (table[n + 1].a - table[n].a);
    };
    for (int n = 0; n < 4000; ++n) {
        const double a = 1040 * static_cast<double>(hashOf({n, 1, 0})) - 20;
        const double b = a + (n % 2 == 0 ? 3 : 700) * static_cast<double>(hashOf({n, 2, 0}));
        ExtinctionRange expected{std::min(at(a), at(b)), std::max(at(a), at(b))};
        for (double place = std::ceil(a); place <= b; ++place)
            expected = {std::min(expected.least, at(place)), std::max(expected.most, at(place))};
        ASSERT_EQ(extremes.between(a, b), expected) << a << " " << b;
    }
}

TEST(ExtinctionBounds, ArePackedOutwards) {
    for (int n = 0; n < 10000; ++n) {
        const float a = std::exp(40 * hashOf({n, 1, 0}) - 20), b = a * (1 + hashOf({n, 2, 0}));
        const ExtinctionRange range = ExtinctionBounds::unpacked(ExtinctionBounds::packed({a, b}));
        ASSERT_LE(range.least, a);
        ASSERT_GT(range.least, a * (1 - 1.0f / 128));
        ASSERT_GE(range.most, b);
        ASSERT_LT(range.most, b * (1 + 1.0f / 128));
    }
    EXPECT_EQ(ExtinctionBounds::packed({0, 0}), 0u);
}

} // namespace
} // namespace tessera
