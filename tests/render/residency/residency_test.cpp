// tests/render/residency/residency_test.cpp: whatever bricks are asked for, in whatever order, the pages hold
// their samples, entries say where, and nothing moves without need.
#include "render/residency/brick_residency.h"

#include "tests/support/numbered_chunks.h"
#include "tests/support/sample_plane.h"

#include <algorithm>
#include <bit>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace tessera::test {
namespace {

constexpr glm::ivec3 kHeldExtent(100, 70, 40); // 4 x 3 x 2 bricks
constexpr int kMeanLevel = kLevelCount - 1;

Selection selectionOf(std::vector<std::uint8_t> levels) {
    Selection s;
    s.bricks = brickGrid(kHeldExtent);
    for (std::size_t b = 0; b < levels.size(); ++b) {
        ++s.counts[levels[b]];
        s.means.push_back(0.5f * static_cast<float>(b) - 3);
    }
    s.levels = std::move(levels);
    return s;
}
Selection randomSelection(std::mt19937& random, int finest = 0) {
    std::vector<std::uint8_t> levels(cellCount(brickGrid(kHeldExtent)));
    for (std::uint8_t& level : levels)
        level = static_cast<std::uint8_t>(std::uniform_int_distribution<int>(finest, kLevelCount)(random));
    return selectionOf(std::move(levels));
}

class Residency : public testing::Test {
  protected:
    BrickResidency residencyOf(const Selection& selection, std::size_t pages) {
        return {source.info(), selection, pages, TextureLimits{}, {&plane, &other}, ram};
    }
    /// What is resident has its own samples, at its level; entries are what the header says.
    void check(const BrickResidency& bricks, const Selection& selection) const {
        ASSERT_EQ(plane.entries.size(), selection.levels.size());
        ASSERT_EQ(plane.entries, other.entries);
        EXPECT_FALSE(plane.isBusy || other.isBusy) << "temporary memory is kept";
        std::set<std::size_t> texels;
        for (std::size_t b = 0; b < selection.levels.size(); ++b) {
            const int level = selection.levels[b];
            const BrickEntry entry = plane.entries[b];
            if (level >= kMeanLevel) {
                ASSERT_EQ(entry, BrickEntry(0x80000000u, std::bit_cast<std::uint32_t>(selection.means[b])));
                ASSERT_FALSE(bricks.residentLevel(b) || bricks.slotOf(b));
                continue;
            }
            const std::optional<AtlasSlot> slot = bricks.slotOf(b);
            if (!slot) {
                ASSERT_EQ(entry, BrickEntry(0x40000000u, 0)) << b;
                continue;
            }
            ASSERT_EQ(bricks.residentLevel(b), level);
            ASSERT_EQ(slot->level, level);
            const glm::uvec3 page(slot->page), in(slot->slot);
            ASSERT_EQ(entry, BrickEntry(page.x | page.y << 10 | page.z << 20, in.x | in.y << 5 | in.z << 10));
            const int edge = kBrickExtent >> level;
            const glm::ivec3 first = gridPosition(b, selection.bricks) * edge;
            for (const glm::ivec3& at : {glm::ivec3(0), glm::ivec3(edge - 1), glm::ivec3(edge / 2, 0, 0),
                                         glm::ivec3(0, edge - 1, 0), glm::ivec3(0, edge / 3, edge - 1)})
                for (const SamplePlane* each : {&plane, &other})
                    ASSERT_EQ(each->at(slot->originTexels() + at), NumberedChunks::valueOf(level, first + at))
                        << "brick " << b << ", level " << level;
        }
    }
    NumberedChunks source{kHeldExtent};
    MemoryBudget ram{"RAM", "--ram", std::size_t{64} << 20};
    BrickCache cache{source, ram, std::size_t{8} << 20, 2};
    SamplePlane plane, other;
    Work work;
};

TEST_F(Residency, BeginsWithMeansAndWithoutSamples) {
    std::mt19937 random(1);
    const Selection selection = randomSelection(random);
    const std::size_t before = ram.usedBytes();
    const BrickResidency bricks = residencyOf(selection, 3);
    EXPECT_EQ(ram.usedBytes() - before, 24 * (8 + 1)) << "an entry and a level of every brick";
    EXPECT_EQ(bricks.pages(), 3u);
    check(bricks, selection);
    for (std::size_t b = 0; b < 24; ++b)
        EXPECT_FALSE(bricks.slotOf(b));
    EXPECT_EQ(residencyOf(selection, 0).pages(), 1u);
}

TEST_F(Residency, LoadsEveryBrickOnceCoarseOnesFirst) {
    std::mt19937 random(2);
    for (int turn = 0; turn < 6; ++turn) {
        const Selection selection = randomSelection(random);
        BrickResidency bricks = residencyOf(selection, pagesFor(selection.counts));
        work = {};
        plane.putSince();
        bricks.load(cache, work);
        check(bricks, selection);
        const std::vector<std::size_t> put = plane.putSince();
        std::size_t expected = 0;
        for (std::size_t b = 0; b < 24; ++b) {
            const bool hasSamples = selection.levels[b] < kMeanLevel;
            expected += hasSamples;
            EXPECT_EQ(bricks.slotOf(b).has_value(), hasSamples);
        }
        EXPECT_EQ(put.size(), expected);
        EXPECT_EQ(std::set<std::size_t>(put.begin(), put.end()).size(), expected);
        EXPECT_EQ(work.bricksUploaded, expected);
        EXPECT_EQ(work.bytesUploaded, 2 * expected) << "planes count in the same work";
        for (std::size_t n = 1; n < put.size(); ++n)
            EXPECT_GE(selection.levels[put[n - 1]], selection.levels[put[n]]);
        bricks.load(cache, work);
        EXPECT_TRUE(plane.putSince().empty()) << "all of them were there";
    }
}

TEST_F(Residency, ServesWhatFitsAndKeepsTheRestWhileThereIsRoom) {
    std::mt19937 random(3);
    for (const std::size_t pages : {1u, 2u, 3u, 5u}) {
        const Selection selection = randomSelection(random);
        BrickResidency bricks = residencyOf(selection, pages);
        int kept = 0, evicted = 0;
        for (int turn = 0; turn < 60; ++turn) {
            std::vector<std::size_t> all(24), asked;
            std::iota(all.begin(), all.end(), std::size_t{0});
            std::shuffle(all.begin(), all.end(), random);
            std::array<std::size_t, kLevelCount + 1> counts{};
            for (const std::size_t b : all)
                if (const std::uint8_t level = selection.levels[b]; level < kMeanLevel && asked.size() < 5) {
                    ++counts[level];
                    if (pagesFor(counts) <= pages)
                        asked.push_back(b);
                    else
                        --counts[level];
                }
            std::set<std::size_t> before, missing;
            for (std::size_t b = 0; b < 24; ++b)
                if (bricks.slotOf(b))
                    before.insert(b);
            for (const std::size_t b : asked)
                if (!before.contains(b))
                    missing.insert(b);
            plane.putSince();
            bricks.serve(asked, cache, work);
            check(bricks, selection);
            std::set<std::size_t> after = before;
            after.insert(asked.begin(), asked.end());
            std::array<std::size_t, kLevelCount + 1> together{};
            for (const std::size_t b : after)
                ++together[selection.levels[b]];
            const std::vector<std::size_t> put = plane.putSince();
            for (const std::size_t b : asked)
                EXPECT_TRUE(bricks.slotOf(b)) << b;
            std::size_t there = 0;
            for (const std::size_t b : before)
                there += bricks.slotOf(b).has_value();
            if (missing.empty()) {
                EXPECT_TRUE(put.empty()) << "nothing was missing";
            }
            there == before.size() ? ++kept : ++evicted;
            if (there == before.size()) {
                EXPECT_EQ(std::set<std::size_t>(put.begin(), put.end()), missing);
            }
            if (there < before.size()) {
                EXPECT_FALSE(missing.empty()) << "an eviction without need";
            }
        }
        EXPECT_GT(kept, 0) << pages;
        EXPECT_TRUE(evicted > 0 || pages == 5) << pages;
    }
}

TEST_F(Residency, AnotherSelectionKeepsBricksOfTheSameLevel) {
    std::mt19937 random(4);
    Selection selection = randomSelection(random, 2);
    BrickResidency bricks = residencyOf(selection, 12);
    for (int turn = 0; turn < 20; ++turn) {
        bricks.load(cache, work);
        Selection next = randomSelection(random, 2);
        for (std::size_t b = 0; b < 24; b += 2)
            next.levels[b] = selection.levels[b];
        next = selectionOf(next.levels);
        plane.putSince();
        bricks.adopt(next);
        check(bricks, next);
        for (std::size_t b = 0; b < 24; ++b)
            EXPECT_EQ(bricks.slotOf(b).has_value(),
                      next.levels[b] == selection.levels[b] && next.levels[b] < kMeanLevel);
        EXPECT_TRUE(plane.putSince().empty());
        selection = next;
    }
}

// As pictures that are refined do: bricks move one by one, until there is no room.
TEST_F(Residency, PlacesOneByOneAndDropsToMeans) {
    std::mt19937 random(5);
    std::vector<std::uint8_t> levels(24, kMeanLevel);
    BrickResidency bricks = residencyOf(selectionOf(levels), 4);
    int full = 0, dropped = 0, freed = 0;
    for (int turn = 0; turn < 400; ++turn) {
        const auto b = std::uniform_int_distribution<std::size_t>(0, 23)(random);
        constexpr int kLevels[] = {1, 1, 1, 1, 2, 3, 0, kMeanLevel, kMeanLevel, kMeanLevel};
        const int level = kLevels[std::uniform_int_distribution<int>(0, 9)(random)];
        if (level == kMeanLevel) {
            bricks.dropToMean(b, selectionOf(levels).means[b]);
            levels[b] = kMeanLevel;
            ++dropped;
        } else {
            const ChunkKey key = chunkOf(b, level, brickGrid(kHeldExtent));
            const BrickToPlace one{b, level, cache.get(key)};
            const std::uint64_t uploaded = work.bricksUploaded;
            const std::size_t placed = bricks.place(std::span(&one, 1), work);
            EXPECT_EQ(work.bricksUploaded - uploaded, placed);
            if (placed == 1) {
                levels[b] = static_cast<std::uint8_t>(level);
            } else {
                ++full;
                // The sparsest page whose bricks have room in others of their level, if there is one.
                const std::vector<std::size_t> sparsest = bricks.bricksOfSparsestPage();
                for (const std::size_t d : sparsest) {
                    bricks.dropToMean(d, selectionOf(levels).means[d]);
                    levels[d] = kMeanLevel;
                }
                if (!sparsest.empty()) {
                    ++freed;
                    EXPECT_EQ(bricks.place(std::span(&one, 1), work), 1u) << "no page was freed";
                    levels[b] = static_cast<std::uint8_t>(level);
                }
            }
        }
        bricks.publish();
        check(bricks, selectionOf(levels));
        for (std::size_t n = 0; n < 24; ++n)
            ASSERT_EQ(bricks.slotOf(n).has_value(), levels[n] < kMeanLevel);
    }
    EXPECT_GT(full, 20);
    EXPECT_GT(dropped, 20);
    EXPECT_GT(freed, 0);
}

TEST_F(Residency, TheSparsestPageIsThatOfABruteForceSearch) {
    std::mt19937 random(6);
    int none = 0, some = 0;
    for (int turn = 0; turn < 200; ++turn) {
        Selection selection = randomSelection(random, 1);
        for (std::uint8_t& level : selection.levels)
            level = level < 4 ? 1 : 2;
        selection = selectionOf(selection.levels);
        BrickResidency bricks = residencyOf(selection, pagesFor(selection.counts));
        bricks.load(cache, work);
        const std::vector<std::uint8_t> full = selection.levels;
        for (std::size_t b = 0; b < 24; ++b) // holes
            if (std::uniform_int_distribution<int>(0, 2)(random) > 0) {
                bricks.dropToMean(b, 0);
                selection.levels[b] = kMeanLevel;
            }
        std::map<std::size_t, std::vector<std::size_t>> pages; // bricks by page
        std::array<std::size_t, kLevelCount> slots{};
        for (std::size_t b = 0; b < 24; ++b)
            if (const auto slot = bricks.slotOf(b))
                pages[linearIndex(slot->page, glm::ivec3(1024))].push_back(b);
        for (const auto& [page, held] : pages)
            slots[selection.levels[held[0]]] += std::size_t{1} << (3 * selection.levels[held[0]]);
        std::size_t fewest = SIZE_MAX;
        for (const auto& [page, held] : pages) {
            const int level = selection.levels[held[0]];
            std::size_t used = 0;
            for (std::size_t b = 0; b < 24; ++b)
                used += selection.levels[b] == level;
            const std::size_t elsewhere = slots[static_cast<std::size_t>(level)] -
                                          (std::size_t{1} << (3 * level)) - (used - held.size());
            if (slots[static_cast<std::size_t>(level)] >=
                    (std::size_t{1} << (3 * level)) + used - held.size() &&
                elsewhere >= held.size())
                fewest = std::min(fewest, held.size());
        }
        const std::vector<std::size_t> found = bricks.bricksOfSparsestPage();
        EXPECT_EQ(found.empty(), fewest == SIZE_MAX);
        if (!found.empty()) {
            EXPECT_EQ(found.size(), fewest);
            EXPECT_EQ(pages.at(linearIndex(bricks.slotOf(found[0])->page, glm::ivec3(1024))), found);
        }
        found.empty() ? ++none : ++some;
    }
    EXPECT_GT(none, 5);
    EXPECT_GT(some, 5);
}

} // namespace
} // namespace tessera::test
