// tests/core/base/claims_test.cpp: claims of which only one process has each, and that end with their owner.
#include "core/base/claims.h"
#include "core/base/program_folders.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(Claims, OneAtATime) {
    const ScratchFolder folder;
    for (const ClaimKind kind : {ClaimKind::lock, ClaimKind::lease}) {
        const Claims claims(folder.path(), kind);
        std::unique_ptr<Claim> one = claims.claim("a");
        ASSERT_TRUE(one);
        EXPECT_TRUE(one->isHeld());
        EXPECT_FALSE(claims.claim("a"));
        EXPECT_TRUE(claims.claim("b"));
        one.reset();
        EXPECT_FALSE(claims.isTaken("a"));
        EXPECT_TRUE(claims.claim("a"));
    }
}

// Of those that see a dead owner's lease one takes it over, and nobody loses a lease that is renewed.
TEST(Claims, AStaleLeaseGoesToOne) {
    const ScratchFolder folder;
    const Claims claims(folder.path(), ClaimKind::lease, 5);
    for (int round = 0; round < 200; ++round) {
        const std::string name = std::to_string(round);
        const fs::path file = folder / ("." + name + ".claim");
        std::unique_ptr<Claim> dead = claims.claim(name);
        fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::minutes(1));
        std::vector<std::unique_ptr<Claim>> taken(6);
        std::atomic<int> ready{0};
        std::vector<std::thread> threads;
        for (auto& one : taken)
            threads.emplace_back([&] {
                for (++ready; ready < static_cast<int>(taken.size());) {
                }
                one = claims.claim(name);
            });
        for (std::thread& thread : threads)
            thread.join();
        int owners = 0;
        for (const auto& one : taken)
            owners += one && one->isHeld();
        EXPECT_EQ(owners, 1);
        EXPECT_FALSE(dead->isHeld());
    }
}

} // namespace
} // namespace tessera
