// tests/bricking/cache/chunk_source_test.cpp: the cache reads any source of chunks, whatever the size of the
// source's own.
#include "bricking/cache/brick_cache.h"

#include <cstring>
#include <glm/common.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

std::uint16_t valueAt(int level, const glm::ivec3& sample) {
    return static_cast<std::uint16_t>(sample.x + 131 * sample.y + 7919 * sample.z + 13 * level + 1);
}

/// Values of a formula in chunks of an odd size; what lies beyond the level's edge is rubbish.
class OddChunks : public RechunkedSource {
  public:
    explicit OddChunks(const glm::ivec3& own) : own_(own) {
        info_.extentVoxels = {70, 41, 90};
        info_.type = ValueType::u16;
        info_.fillStored = 65535;
    }
    const VolumeInfo& info() const override { return info_; }

  protected:
    glm::ivec3 ownExtent(int) const override { return own_; }
    void readOwn(int level, const glm::ivec3& chunk, std::span<std::byte> out) const override {
        const glm::ivec3 extent = levelExtent(info_.extentVoxels, level);
        for (std::size_t n = 0; n < cellCount(own_); ++n) {
            const glm::ivec3 sample = chunk * own_ + gridPosition(n, own_);
            const bool inside = glm::all(glm::lessThan(sample, extent));
            const std::uint16_t value = inside ? valueAt(level, sample) : std::uint16_t{12345};
            std::memcpy(out.data() + 2 * n, &value, 2);
        }
    }

  private:
    VolumeInfo info_;
    glm::ivec3 own_;
};

TEST(ChunkSource, ChunksOfAnySizeBecomeThoseOfTheCache) {
    for (const glm::ivec3 own :
         {glm::ivec3(20, 17, 40), glm::ivec3(64), glm::ivec3(1, 90, 5), glm::ivec3(32)}) {
        const OddChunks source(own);
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        BrickCache cache(source, ram, std::size_t{8} << 20, 2);
        for (int level = 0; level < 3; ++level) {
            const glm::ivec3 extent = levelExtent(source.info().extentVoxels, level);
            const glm::ivec3 grid = chunkGrid(source.info().extentVoxels, level);
            for (std::size_t c = 0; c < cellCount(grid); ++c) {
                const glm::ivec3 at = gridPosition(c, grid);
                const ChunkPointer chunk = cache.get({level, at.x, at.y, at.z});
                for (std::size_t n = 0; n < cellCount(glm::ivec3(kChunkExtent)); ++n) {
                    const glm::ivec3 sample = at * kChunkExtent + gridPosition(n, glm::ivec3(kChunkExtent));
                    std::uint16_t value = 0;
                    std::memcpy(&value, chunk->bytes.get() + 2 * n, 2);
                    const bool inside = glm::all(glm::lessThan(sample, extent));
                    ASSERT_EQ(value, inside ? valueAt(level, sample) : 65535)
                        << own.x << " level " << level << " sample " << sample.x << " " << sample.y << " "
                        << sample.z;
                }
            }
        }
    }
}

} // namespace
} // namespace tessera
