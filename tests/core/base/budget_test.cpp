// The budget keeps its promise under many threads, and sizes are parsed as people write them.
#include "core/base/budget.h"
#include "core/base/budget_error.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"
#include "core/image/colour.h"

#include <algorithm>
#include <atomic>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mutex>
#include <stdexcept>
#include <vector>

namespace tessera {
namespace {

TEST(MemoryBudget, NeverExceedsItsLimitUnderThreads) {
    MemoryBudget budget("RAM", "--ram", 1000);
    std::atomic<int> refused{0};
    parallelFor(2000, 4, [&](std::size_t i) {
        auto held = budget.tryCharge(i % 400);
        if (!held)
            ++refused;
        if (budget.usedBytes() > 1000)
            throw std::logic_error("over the limit");
    });
    EXPECT_LE(budget.peakBytes(), 1000u);
    EXPECT_EQ(budget.usedBytes(), 0u);
}

TEST(MemoryBudget, RefusalNamesEverythingNeeded) {
    MemoryBudget budget("GPU memory", "--gpu-memory", 1 << 20);
    const Charge most = budget.charge(1 << 19, "first");
    try {
        (void)budget.charge(1 << 20, "the brick atlas");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_THAT(e.what(),
                    testing::AllOf(testing::HasSubstr("the brick atlas"), testing::HasSubstr("1 MiB"),
                                   testing::HasSubstr("512 KiB"), testing::HasSubstr("--gpu-memory")));
    }
}

// A caller that can do with less, or later, knows by the type that a budget is the reason.
TEST(MemoryBudget, RefusalIsOfItsOwnType) {
    MemoryBudget budget("RAM", "--ram", 10);
    EXPECT_THROW((void)budget.charge(11, "a table"), OverBudget);
    EXPECT_THROW((void)budget.charge(11, "a table"), InputError) << "exit code 2";
}

TEST(MemoryBudget, ChargesMoveAndReturn) {
    MemoryBudget budget("RAM", "--ram", 100);
    {
        Charge a = budget.charge(60, "a");
        Charge b = std::move(a);
        EXPECT_EQ(budget.usedBytes(), 60u);
        std::vector<Charge> many;
        many.push_back(std::move(b));
        many.push_back(budget.charge(40, "c"));
        EXPECT_FALSE(budget.tryCharge(1));
    }
    EXPECT_EQ(budget.usedBytes(), 0u);
    EXPECT_EQ(budget.peakBytes(), 100u);
}

TEST(Bytes, Parses) {
    EXPECT_EQ(parseBytes("512MiB", "--ram"), std::size_t{512} << 20);
    EXPECT_EQ(parseBytes("1.5 GiB", "--ram"), std::size_t{3} << 29);
    EXPECT_EQ(parseBytes("65536", "--ram"), 65536u);
    EXPECT_EQ(parseBytes("3KiB", "--ram"), std::size_t{3} << 10);
    EXPECT_EQ(parseBytes("2TiB", "--ram"), std::size_t{2} << 40);
    for (const char* bad : {"", "0", "-1MiB", "12MB", "MiB", "nan", "inf", "1e30GiB", "1 2"})
        EXPECT_THROW(parseBytes(bad, "--ram"), InputError) << bad;
    EXPECT_EQ(formatBytes(std::size_t{512} << 20), "512 MiB");
    EXPECT_EQ(formatBytes(1536), "1.50 KiB");
    for (std::size_t bytes = 1; bytes < std::size_t{1} << 40; bytes = bytes * 5 / 3 + 1)
        EXPECT_GE(parseBytes(formatBytes(bytes), "--ram"), bytes) << "a stated need must suffice";
}

TEST(Threads, FirstExceptionReachesTheCaller) {
    EXPECT_THROW(parallelFor(100, 4,
                             [](std::size_t i) {
                                 if (i == 37)
                                     throw std::runtime_error("37");
                             }),
                 std::runtime_error);
}

TEST(Threads, SharesReachOne) {
    std::mutex mutex;
    std::vector<double> shares;
    parallelFor(
        8, 3, [](std::size_t) {},
        [&](double share) {
            const std::lock_guard lock(mutex);
            shares.push_back(share);
        });
    std::sort(shares.begin(), shares.end());
    EXPECT_EQ(shares, (std::vector<double>{0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1}));
}

TEST(Cancellations, OfNestedOnesTheInnerCountsWhileItLives) {
    const Cancellation::Flag goesOn{false};
    Cancellation::Flag outer{false}, inner{true};
    {
        const Cancellation first(&outer);
        EXPECT_NO_THROW(checkInterrupted());
        {
            const Cancellation second(&inner);
            EXPECT_THROW(checkInterrupted(), Cancelled);
            EXPECT_THROW(parallelFor(8, 3, [](std::size_t) {}), Cancelled) << "in other threads too";
            for (const Cancellation::Flag* flag :
                 {&goesOn, static_cast<const Cancellation::Flag*>(nullptr)}) {
                const Cancellation third(flag);
                EXPECT_EQ(Cancellation::current(), flag);
                EXPECT_NO_THROW(checkInterrupted());
            }
            EXPECT_THROW(checkInterrupted(), Cancelled);
        }
        EXPECT_EQ(Cancellation::current(), &outer);
        EXPECT_NO_THROW(checkInterrupted());
        outer = true;
        EXPECT_THROW(checkInterrupted(), Cancelled);
    }
    EXPECT_EQ(Cancellation::current(), nullptr);
    EXPECT_NO_THROW(checkInterrupted());
}

TEST(Colour, KnownValues) {
    EXPECT_NEAR(srgbFromLinear(0.5), 0.735357, 1e-6);
    for (double x = 0; x <= 1; x += 0.01)
        EXPECT_NEAR(linearFromSrgb(srgbFromLinear(x)), x, 1e-12);
    const glm::dvec3 white = luvFromLinear({1, 1, 1}), red = luvFromLinear({1, 0, 0});
    EXPECT_NEAR(white.x, 100, 1e-4);
    EXPECT_NEAR(white.y, 0, 1e-9);
    EXPECT_NEAR(red.x, 53.24, 0.01); // CIE L*u*v* of the sRGB red primary, D65
    EXPECT_NEAR(red.y, 175.01, 0.05);
    EXPECT_NEAR(red.z, 37.75, 0.05);
    EXPECT_NEAR(luvFromLinear(glm::dvec3(0.001)).x, 0.9033, 1e-4); // CIE 15: 24389/27 Y where that is dark
    EXPECT_NEAR(luvFromLinear(glm::dvec3(0.01)).x, 8.9914, 1e-4);
}

} // namespace
} // namespace tessera
