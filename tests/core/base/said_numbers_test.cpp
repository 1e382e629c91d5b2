// tests/core/base/said_numbers_test.cpp: bounds of numbers are met exactly and not exceeded, and messages
// have the numbers that they are about.
#include "core/base/budget.h"
#include "core/base/coverage.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/base/ownership.h"
#include "core/base/program_folders.h"
#include "core/base/shown_text.h"
#include "core/base/volume.h"
#include "tests/support/refusals.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera {
namespace {

using test::refusalOf;

TEST(Magnitude, BoundsAreMetExactly) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), more = std::nextafter(1e12, 2e12);
    for (const double sign : {1.0, -1.0}) {
        checkValue(sign * kLargestValue, "a value", "f");
        EXPECT_THROW(checkValue(sign * std::nextafter(kLargestValue, 1e300), "a value", "f"), InputError);
        checkLength(sign * 1e12, "a length", "f");
        EXPECT_THROW(checkLength(sign * more, "a length", "f"), InputError);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 place(0), farther(0), none(0);
            place[axis] = sign * 1e12, farther[axis] = sign * more, none[axis] = nan;
            checkPlace(place, "a place", "f");
            checkDirection(place, "a direction", "f");
            EXPECT_THROW(checkPlace(farther, "a place", "f"), InputError);
            EXPECT_THROW(checkDirection(farther, "a direction", "f"), InputError);
            EXPECT_THROW(checkPlace(none, "a place", "f"), InputError);
        }
        checkDirection({0, sign * kShortestDirection, 0}, "a direction", "f");
        EXPECT_THROW(checkDirection({0, 0, sign * 0.9e-30}, "a direction", "f"), InputError);
    }
    EXPECT_EQ(refusalOf([] {
                  checkPlace({0, -2e12, 0}, "a point", "f");
              }),
              "f: expected a point within +-1e+12 mm, found -2e+12");
    EXPECT_EQ(refusalOf([] {
                  checkDirection({0, 2e12, 0}, "a normal", "f");
              }),
              "f: expected a normal within +-1e+12, found 2e+12");
    EXPECT_EQ(refusalOf([] {
                  checkDirection({0, 0, 0}, "a normal", "f");
              }),
              "f: expected a normal that is not 0, found one of length 0");
    EXPECT_EQ(refusalOf([] { checkValue(4e38, "a value", "f"); }),
              "f: expected a value within +-3.40282e+38, which a voxel can hold, found 4e+38");
    EXPECT_EQ(refusalOf([] { checkLength(-3e12, "a thickness", "f"); }),
              "f: expected a thickness within +-1e+12 mm, found -3e+12");
}

/// Numbers read back differ by half of the last digit at most, and have no digits more.
TEST(NumberText, KeepsAsManyDigitsAsItSays) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> power(-3.9, 8), part(1, 10);
    for (int i = 0; i < 4000; ++i) {
        const double value = (i % 2 ? 1 : -1) * part(random) * std::pow(10, std::floor(power(random)));
        for (const int digits : {1, 3, 4, 6}) {
            const std::string text = numberText(value, digits);
            const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - digits + 1);
            EXPECT_NEAR(std::strtod(text.c_str(), nullptr), value,
                        0.5 * std::min(unit, std::max(1.0, unit)) + 1e-12)
                << text;
            EXPECT_EQ(text.find("e"), std::string::npos) << text;
            const std::size_t point = text.find('.');
            EXPECT_FALSE(point != std::string::npos && (text.back() == '0' || text.back() == '.')) << text;
            if (point != std::string::npos && std::abs(value) >= 1) {
                EXPECT_LE(text.size() - 1 - (value < 0 ? 1 : 0), static_cast<std::size_t>(digits) + 1)
                    << text;
            }
        }
    }
    EXPECT_EQ(numberText(1e15), "1e+15");
    EXPECT_EQ(numberText(999999999999999), "999999999999999");
    EXPECT_EQ(numberText(0.9999), "0.9999");
    EXPECT_EQ(numberText(1.00004, 4), "1");
    EXPECT_EQ(valueText(41.23, "HU"), "41.2 HU");
    EXPECT_EQ(valueText(1024, "HU"), "1024 HU");
    EXPECT_EQ(valueText(0.12345, ""), "0.123");
}

TEST(Coverage, IsSaidInOneSentence) {
    EXPECT_EQ(coverageText({}, 25), "seen: 0.0 % of 0.0 cm2 of wall; unseen patches of at least 25 mm2: 0");
    WallCoverage found;
    EXPECT_EQ(found.lines, 1u);
    EXPECT_EQ(found.flown, 1u);
    EXPECT_EQ(found.blind, 0u);
    EXPECT_EQ(found.faces, 0u);
    EXPECT_EQ(found.share(), 0);
    found.wallMm2 = 40000, found.seenMm2 = 39000;
    EXPECT_EQ(found.share(), 0.975);
    EXPECT_EQ(coverageText(found, 12.5),
              "seen: 97.5 % of 400.0 cm2 of wall; unseen patches of at least 12.5 mm2: 0");
    found.patches = {{{1, 2, 3}, 345.4, 123.4, 120, 130}, {{1, 2, 3}, 30, 50, 40, 60}};
    EXPECT_EQ(coverageText(found, 25),
              "seen: 97.5 % of 400.0 cm2 of wall; unseen patches of at least 25 mm2: "
              "2; the largest, 345 mm2, at 123 mm");
    found.lines = found.flown = 3;
    EXPECT_THAT(coverageText(found, 25), testing::EndsWith("at 123 mm"));
    found.flown = 2;
    EXPECT_THAT(coverageText(found, 25), testing::HasSubstr("at 123 mm; along 2 of 3 lines, the wall of"));
}

/// What is charged is free no more, and all of it comes back, whatever the order.
TEST(MemoryBudget, WhatIsUsedAndFreeAddsUp) {
    constexpr std::size_t kLimit = 5000;
    MemoryBudget budget("RAM", "--ram", kLimit);
    EXPECT_EQ(budget.name(), "RAM");
    EXPECT_EQ(budget.option(), "--ram");
    std::mt19937 random(9);
    std::vector<Charge> held;
    std::size_t used = 0, peak = 0;
    for (int i = 0; i < 3000; ++i) {
        if (random() % 2 == 0 || held.empty()) {
            const std::size_t bytes = random() % 900;
            auto charge = budget.tryCharge(bytes);
            ASSERT_EQ(charge.has_value(), bytes <= kLimit - used);
            if (charge) {
                EXPECT_EQ(charge->bytes(), bytes);
                used += bytes, peak = std::max(peak, used);
                held.push_back(std::move(*charge));
            }
        } else {
            const std::size_t at = random() % held.size();
            used -= held[at].bytes();
            held.erase(held.begin() + static_cast<std::ptrdiff_t>(at));
        }
        ASSERT_EQ(budget.usedBytes(), used);
        ASSERT_EQ(budget.freeBytes(), kLimit - used);
        ASSERT_EQ(budget.peakBytes(), peak);
    }
    held.clear();
    EXPECT_EQ(budget.freeBytes(), budget.limitBytes());
    const Charge all = budget.charge(kLimit - 24, "all but a little");
    EXPECT_FALSE(budget.tryCharge(25));
    EXPECT_TRUE(budget.tryCharge(24));
    EXPECT_EQ(refusalOf([&] { static_cast<void>(budget.charge(1024, "the picture")); }),
              "RAM: the picture needs 1 KiB, but only 24 B of the budget of 4.89 KiB are free; raise --ram");
}

TEST(Bytes, OfEveryUnit) {
    for (const auto& [text, bytes] :
         std::initializer_list<std::pair<const char*, double>>{{"7B", 7},
                                                               {"7K", 7 * 0x1p10},
                                                               {"7 MiB", 7 * 0x1p20},
                                                               {"7M", 7 * 0x1p20},
                                                               {"7GiB", 7 * 0x1p30},
                                                               {"7G", 7 * 0x1p30},
                                                               {"7T", 7 * 0x1p40},
                                                               {"1", 1}})
        EXPECT_EQ(static_cast<double>(parseBytes(text, "--ram")), bytes) << text;
    EXPECT_EQ(refusalOf([] { parseBytes("12MB", "--ram"); }),
              "--ram: expected a size such as 512MiB or 2GiB, found '12MB'");
    EXPECT_EQ(formatBytes(1023), "1023 B");
    EXPECT_EQ(formatBytes(1024), "1 KiB");
    EXPECT_EQ(formatBytes(102400), "100 KiB");
    EXPECT_EQ(formatBytes(102300), "99.91 KiB");
    EXPECT_EQ(formatBytes((std::size_t{5} << 40) + 1), "5.01 TiB");
    EXPECT_EQ(formatBytes(std::size_t{5000} << 40), "5000 TiB");
    EXPECT_THROW(parseBytes("4194304TiB", "--ram"), InputError); // 2^62
    EXPECT_EQ(parseBytes("4194303TiB", "--ram"), std::size_t{4194303} << 40);
}

/// Against the definition, by recursion.
TEST(NearestName, DistancesAreThoseOfTheDefinition) {
    const std::function<std::size_t(const std::string&, const std::string&)> slow =
        [&](const std::string& a, const std::string& b) -> std::size_t {
        if (a.empty() || b.empty())
            return a.size() + b.size();
        const std::string x = a.substr(1), y = b.substr(1);
        return std::min({slow(x, y) + (a[0] == b[0] ? 0 : 1), slow(x, b) + 1, slow(a, y) + 1});
    };
    std::mt19937 random(2);
    for (int i = 0; i < 300; ++i) {
        std::string a(random() % 6, ' '), b(random() % 6, ' ');
        for (std::string* word : {&a, &b})
            for (char& c : *word)
                c = static_cast<char>('a' + random() % 3);
        EXPECT_EQ(editDistance(a, b), slow(a, b)) << a << " " << b;
        EXPECT_EQ(editDistance(a, b), editDistance(b, a));
    }
    EXPECT_EQ(nearestName("b", {"a", "c"}), "a") << "the first of equals";
    EXPECT_EQ(joinNames({"a", "b", "c"}), "a, b, c");
    EXPECT_EQ(indexOfName("b", {"a", "b"}, "f"), 1u);
    EXPECT_EQ(refusalOf([] {
                  indexOfName("bon", {"auto", "bone"}, "f");
              }),
              "f: expected one of auto, bone, found \"bon\"; nearest: \"bone\"");
}

TEST(Ownership, WhatIsThereIsNoFailureAndAMissingFolderIs) {
    const ScratchFolder folder;
    const auto file = makeOwnFile(folder / "a"), none = makeOwnFile(folder / "a");
    EXPECT_TRUE(file);
    EXPECT_FALSE(none);
    EXPECT_THROW(makeOwnFile(folder / "missing" / "a"), Error);
    const auto own = makeOwnFolder(folder / "b", 0700);
    EXPECT_TRUE(own);
    EXPECT_FALSE(makeOwnFolder(folder / "b", 0700));
    EXPECT_THROW(makeOwnFolder(folder / "missing" / "b", 0700), Error);
    EXPECT_TRUE(tryLock(folder / "a", LockKind::shared).busy);
    EXPECT_FALSE(tryLock(folder / "c", LockKind::shared).locked);
    const LockTry first = tryLock(folder / "c", LockKind::shared, true);
    EXPECT_TRUE(first.locked);
    EXPECT_TRUE(tryLock(folder / "c", LockKind::shared).locked) << "many may share";
    const LockTry alone = tryLock(folder / "c", LockKind::exclusive);
    EXPECT_FALSE(alone.locked);
    EXPECT_TRUE(alone.busy);
}

/// A volume in a slanted place: its box holds all corners and touches each side.
TEST(VolumePlaces, TheBoxHoldsAllCornersTightly) {
    VolumeInfo info;
    info.extentVoxels = {10, 20, 30};
    info.patientFromVoxel =
        patientFromVoxelOf({5, -7, 11}, {0.8, 0.3, 0}, {-0.2, 0.9, 0.4}, {0.1, -0.3, 1.5});
    EXPECT_LT(glm::length(firstVoxelCentreMm(info) - glm::dvec3(5, -7, 11)), 1e-12);
    const PatientBox box = patientBoxOf(info);
    glm::dvec3 low(1e9), high(-1e9);
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 corner(info.patientFromVoxel *
                                glm::dvec4(10 * (n & 1), 20 * (n >> 1 & 1), 30 * (n >> 2), 1));
        low = glm::min(low, corner), high = glm::max(high, corner);
    }
    EXPECT_LT(glm::length(box.low - low), 1e-12);
    EXPECT_LT(glm::length(box.high - high), 1e-12);
    EXPECT_EQ(info.voxelCount(), 6000u);
    EXPECT_NEAR(info.spacingMm().x, std::hypot(0.8, 0.3), 1e-12);
    EXPECT_NEAR(info.spacingMm().y, std::sqrt(0.04 + 0.81 + 0.16), 1e-12);
    EXPECT_NEAR(info.spacingMm().z, std::sqrt(0.01 + 0.09 + 2.25), 1e-12);
}

TEST(VolumePlaces, WhatIsNoVolumeIsRefused) {
    const VolumeInfo good = [] {
        VolumeInfo info;
        info.extentVoxels = {4, 5, 6};
        info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3});
        return info;
    }();
    good.validate("f");
    const auto said = [&](const std::function<void(VolumeInfo&)>& change) {
        VolumeInfo info = good;
        change(info);
        return refusalOf([&] { info.validate("f"); });
    };
    for (int axis = 0; axis < 3; ++axis) {
        const std::string along = " along axis " + std::to_string(axis);
        EXPECT_EQ(said([&](VolumeInfo& v) { v.extentVoxels[axis] = 0; }),
                  "f: expected at least 1 voxel along every axis, found 0" + along);
        EXPECT_EQ(said([&](VolumeInfo& v) { v.extentVoxels[axis] = 1; }), "no refusal");
        EXPECT_EQ(said([&](VolumeInfo& v) { v.patientFromVoxel[axis] = glm::dvec4(0); }),
                  "f: expected a positive, finite voxel spacing, found 0.000000 mm" + along);
        EXPECT_THAT(said([&](VolumeInfo& v) { v.patientFromVoxel[3][axis] = INFINITY; }),
                    testing::HasSubstr("a finite position"));
    }
    EXPECT_THAT(said([](VolumeInfo& v) { v.patientFromVoxel[1] = v.patientFromVoxel[0]; }),
                testing::HasSubstr("three independent voxel directions"));
    EXPECT_THAT(said([](VolumeInfo& v) { v.rescaleSlope = 0; }), testing::HasSubstr("found 0.000000 and"));
    EXPECT_THAT(said([](VolumeInfo& v) { v.rescaleIntercept = NAN; }),
                testing::HasSubstr("finite intercept"));
    EXPECT_THAT(said([](VolumeInfo& v) { v.extentVoxels = glm::ivec3(1 << 30); }),
                testing::HasSubstr("fewer than 2^62 bytes"));
}

} // namespace
} // namespace tessera
