// render/lattice.h: the samples of one level as a CPU renderer reads them: through the brick cache, so that a
// volume never has to fit in memory; empty bricks read as their mean, exactly as on the GPU.
// One reader per thread: it keeps the few chunks pinned that a 2x2x2 neighbourhood can touch.
#pragma once

#include "bricking/brick_cache.h"
#include "bricking/selection.h"
#include "core/brick.h"
#include "core/volume.h"

#include <array>
#include <cstring>
#include <glm/vec3.hpp>

namespace tessera {

class LatticeReader {
  public:
    static constexpr std::size_t kPinnedChunks = 8;

    /// @param selection  which bricks stand as their mean; none: every sample is read (the reference)
    LatticeReader(BrickCache& cache, const VolumeInfo& info, int level, const Selection* selection)
        : cache_(cache), type_(info.type), level_(level), extent_(levelExtent(info.extentVoxels, level)),
          brickShift_(5 - level), selection_(selection) {}

    const glm::ivec3& extent() const { return extent_; }

    /// Stored value of sample i, inside [0,extent).
    double at(const glm::ivec3& i) {
        if (selection_) {
            const std::size_t brick = linearIndex(i >> brickShift_, selection_->bricks);
            if (selection_->states[brick] == BrickState::empty)
                return static_cast<double>(selection_->means[brick]);
        }
        const glm::ivec3 chunk = i >> 5;
        // Neighbouring chunks differ in some parity, so the eight of a neighbourhood never evict each other.
        Pinned& pinned =
            pinned_[static_cast<std::size_t>((chunk.x & 1) | (chunk.y & 1) << 1 | (chunk.z & 1) << 2)];
        if (!pinned.data || pinned.chunk != chunk) {
            pinned.data.reset(); // before asking: a full cache may need this very chunk's place
            pinned.data = cache_.get({level_, chunk.x, chunk.y, chunk.z});
            pinned.chunk = chunk;
        }
        const std::size_t index = linearIndex(i & (kChunkExtent - 1), glm::ivec3(kChunkExtent));
        const std::byte* bytes = pinned.data->bytes.get();
        switch (type_) {
        case ValueType::u8:
            return static_cast<double>(read<std::uint8_t>(bytes, index));
        case ValueType::i16:
            return static_cast<double>(read<std::int16_t>(bytes, index));
        case ValueType::u16:
            return static_cast<double>(read<std::uint16_t>(bytes, index));
        case ValueType::f32:
            return static_cast<double>(read<float>(bytes, index));
        }
        return 0;
    }

  private:
    template <typename T> static T read(const std::byte* bytes, std::size_t index) {
        T value;
        std::memcpy(&value, bytes + index * sizeof(T), sizeof(T));
        return value;
    }
    struct Pinned {
        glm::ivec3 chunk{-1};
        ChunkPointer data;
    };
    BrickCache& cache_;
    ValueType type_;
    int level_;
    glm::ivec3 extent_;
    int brickShift_;
    const Selection* selection_;
    std::array<Pinned, kPinnedChunks> pinned_;
};

} // namespace tessera
