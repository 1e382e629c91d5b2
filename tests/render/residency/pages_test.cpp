// tests/render/residency/pages_test.cpp: arithmetic of pages against plain counting: how many, in which box,
// of how many bytes, and which chunk holds a brick.
#include "render/residency/pages.h"

#include "render/residency/texels.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <set>

namespace tessera {
namespace {

TEST(Pages, HoldTheirBricks) {
    std::array<std::size_t, kLevelCount + 1> counts{};
    EXPECT_EQ(pagesFor(counts), 0u);
    counts = {3, 8, 65, 512, 1, 40000, 70000};
    EXPECT_EQ(pagesFor(counts), 3u + 1u + 2u + 1u + 1u) << "means and empty bricks take none";
    for (int level = 0; level + 1 < kLevelCount; ++level)
        for (const std::size_t more : {0u, 1u}) {
            const std::size_t full = 3 * PageAllocator::slotsPerPage(level);
            EXPECT_EQ(PageAllocator::pagesFor(full + more, level), 3u + more);
            const auto edge = static_cast<std::size_t>(kBrickExtent >> level);
            EXPECT_EQ(PageAllocator::slotsPerPage(level) * edge * edge * edge, 32768u);
        }
}

/// The fewest pages of a box with room, and the least sum of edges of such boxes.
std::pair<int, int> smallestBox(int wanted, int edge, int most) {
    const int longest = std::min(edge, 2 * static_cast<int>(std::ceil(std::cbrt(wanted))));
    int fewest = std::numeric_limits<int>::max(), sum = fewest;
    for (int x = 1; x <= longest; ++x)
        for (int y = 1; y <= longest; ++y)
            for (int z = 1; z <= edge; ++z)
                if (const int pages = x * y * z; pages >= wanted && pages <= most && pages <= fewest) {
                    sum = pages < fewest ? x + y + z : std::min(sum, x + y + z);
                    fewest = pages;
                }
    return {fewest, sum};
}

TEST(Pages, LieInTheSmallestAndRoundestBox) {
    for (const int edge : {3, 4, 64})
        for (int wanted = 1; wanted <= 150; ++wanted) {
            const std::size_t page = std::size_t{32768} * 2;
            const TextureLimits limits{.maxExtent = edge * kBrickExtent + 31, .maxBytes = 90 * page + 1};
            const glm::ivec3 box = atlasPages(static_cast<std::size_t>(wanted), ValueType::i16, limits);
            const auto [pages, sum] = smallestBox(wanted, edge, 90);
            if (pages == std::numeric_limits<int>::max()) {
                EXPECT_EQ(box, glm::ivec3(0)) << wanted << ", " << edge;
                EXPECT_EQ(atlasBytes(static_cast<std::size_t>(wanted), ValueType::i16, limits), SIZE_MAX);
                continue;
            }
            ASSERT_EQ(box.x * box.y * box.z, pages) << wanted << ", " << edge;
            EXPECT_EQ(box.x + box.y + box.z, sum) << wanted << ", " << edge;
            EXPECT_EQ(atlasBytes(static_cast<std::size_t>(wanted), ValueType::i16, limits),
                      static_cast<std::size_t>(pages) * page);
        }
    EXPECT_EQ(atlasPages(0, ValueType::i16, {}), glm::ivec3(1)) << "a texture has a page at least";
    EXPECT_EQ(atlasPages(90, ValueType::i16, {.maxBytes = 90 * 65536}).x > 0, true);
    EXPECT_EQ(atlasPages(91, ValueType::i16, {.maxBytes = 91 * 65536 - 1}), glm::ivec3(0));
    // By default: a gibibyte in a texture of 2048 texels.
    EXPECT_EQ(cellCount(atlasPages(1 << 14, ValueType::i16, {})), std::size_t{1} << 14);
    EXPECT_EQ(atlasPages((1 << 14) + 1, ValueType::i16, {}), glm::ivec3(0));
}

TEST(Pages, TakeTheBytesOfTheirSamplesAndOfLight) {
    const std::size_t plain = 32768, ghosted = 35 * 35 * 35;
    for (const auto& [type, bytes] :
         {std::pair{ValueType::u8, 2u}, {ValueType::i16, 2u}, {ValueType::u16, 2u}, {ValueType::f32, 4u}}) {
        EXPECT_EQ(texelBytes(type), bytes);
        EXPECT_EQ(atlasBytes(6, type, {}), 6 * plain * bytes);
        EXPECT_EQ(atlasBytes(6, type, {.pageEdge = 35}), 6 * ghosted * bytes);
        EXPECT_EQ(atlasBytes(6, type, {.pageEdge = 35, .channelsBeside = 3}), 6 * ghosted * (bytes + 6));
    }
    EXPECT_EQ(indexBytes({4, 3, 2}), 24u * 8);
    EXPECT_EQ(indexBytes({4, 3, 2}, 12), 24u * 12);
    VolumeInfo info;
    info.extentVoxels = {100, 70, 40}; // 24 bricks
    info.type = ValueType::f32;
    EXPECT_EQ(stagingBytes(info), 32768u * 4 + 24 * (8 + 8 + 1));
}

TEST(Pages, FitAsManyAsThereIsRoomFor) {
    const TextureLimits limits{.maxExtent = 4 * kBrickExtent, .maxBytes = 40 * 65536};
    for (std::size_t bytes = 0; bytes <= 45 * 65536; bytes += 16384)
        for (const std::size_t off : {std::size_t{0}, std::size_t{1}}) {
            std::size_t most = 0;
            for (std::size_t pages = 1; pages <= 64; ++pages)
                if (atlasBytes(pages, ValueType::i16, limits) <= bytes + off)
                    most = pages;
            EXPECT_EQ(pagesThatFit(bytes + off, ValueType::i16, limits), most) << bytes + off;
        }
    EXPECT_EQ(pagesThatFit(65535, ValueType::i16, limits), 0u);
    EXPECT_EQ(pagesThatFit(65536, ValueType::i16, limits), 1u);
}

TEST(Pages, OfABrickAreInTheChunkAroundIt) {
    const glm::ivec3 bricks(5, 3, 4);
    for (int level = 0; level < kLevelCount; ++level)
        for (std::size_t b = 0; b < cellCount(bricks); ++b) {
            const glm::ivec3 first = gridPosition(b, bricks) * (kBrickExtent >> level);
            EXPECT_EQ(chunkOf(b, level, bricks), (ChunkKey{level, first.x / kChunkExtent,
                                                           first.y / kChunkExtent, first.z / kChunkExtent}));
        }
}

TEST(PageAllocator, FillsAPageBeforeItTakesAnother) {
    for (int level = 0; level < 4; ++level) {
        PageAllocator allocator({3, 2, 1});
        const std::size_t each = PageAllocator::slotsPerPage(level);
        std::vector<AtlasSlot> held;
        for (std::size_t n = 0; n < 6 * each; ++n) {
            const auto slot = allocator.allocate(level);
            ASSERT_TRUE(slot) << n;
            EXPECT_EQ(allocator.freePages(), 6 - (n + each) / each);
            EXPECT_EQ(slot->level, level);
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_GE(slot->slot[axis], 0);
                EXPECT_LT(slot->slot[axis], PageAllocator::slotsPerEdge(level));
                EXPECT_GE(slot->page[axis], 0);
                EXPECT_LT(slot->page[axis], (glm::ivec3(3, 2, 1))[axis]);
            }
            held.push_back(*slot);
        }
        EXPECT_FALSE(allocator.allocate(level)) << "there is a page more than there are";
        EXPECT_FALSE(allocator.allocate(level + 1));
        std::set<std::size_t> places;
        for (const AtlasSlot& slot : held)
            places.insert(linearIndex(slot.originTexels(), glm::ivec3(128)));
        EXPECT_EQ(places.size(), held.size());
        allocator.release(held[each / 2]);
        const auto again = allocator.allocate(level);
        ASSERT_TRUE(again) << "the only free slot";
        EXPECT_EQ(again->originTexels(), held[each / 2].originTexels());
        for (std::size_t n = 0; n < each; ++n)
            allocator.release(held[n]);
        EXPECT_EQ(allocator.freePages(), 1u);
        EXPECT_TRUE(allocator.allocate(level + 1)) << "an empty page takes any level";
    }
}

} // namespace
} // namespace tessera
