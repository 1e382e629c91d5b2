// tests/support/numbered_chunks.h: a volume that needs no store: every sample of every level has a value of
// its own, so that a test can tell where a value comes from.
#pragma once

#include "bricking/cache/chunk_source.h"

#include <cstdint>
#include <cstring>

namespace tessera::test {

class NumberedChunks : public ChunkSource {
  public:
    explicit NumberedChunks(const glm::ivec3& extentVoxels) {
        info_.extentVoxels = extentVoxels;
        info_.type = ValueType::f32;
    }
    const VolumeInfo& info() const override { return info_; }
    /// The value of a sample of a level; different for any two samples of a volume of up to 127 voxels.
    static float valueOf(int level, const glm::ivec3& sample) {
        return static_cast<float>(((level * 128 + sample.z) * 128 + sample.y) * 128 + sample.x);
    }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        std::size_t n = 0;
        for (int z = 0; z < kChunkExtent; ++z)
            for (int y = 0; y < kChunkExtent; ++y)
                for (int x = 0; x < kChunkExtent; ++x, n += sizeof(float)) {
                    const float value = valueOf(key.level, first + glm::ivec3(x, y, z));
                    std::memcpy(out.data() + n, &value, sizeof value);
                }
    }

  private:
    VolumeInfo info_;
};

} // namespace tessera::test
