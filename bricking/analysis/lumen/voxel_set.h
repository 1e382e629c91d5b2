// bricking/analysis/lumen/voxel_set.h: a set of voxels of level 0 as bits, in chunks of 32^3. An empty chunk
// and a full chunk take no memory, any other 4 KiB. So a lumen of a volume of any size fits into a budget:
// one bit a voxel, and only near its wall.
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

namespace tessera {

constexpr int kRowsPerChunk = kChunkExtent * kChunkExtent;
/// Bit x of row y + 32 z is voxel (x, y, z) of the chunk.
using ChunkRows = std::array<std::uint32_t, kRowsPerChunk>;

/// Pool of ChunkRows: slabs on a budget, kept until the pool dies.
class RowsPool {
  public:
    RowsPool(MemoryBudget& ram, const char* what) : ram_(&ram), what_(what) {}
    /// Allocates one, uninitialised. Throws InputError if the budget is full.
    std::uint32_t take();
    void giveBack(std::uint32_t slot) { free_.push_back(slot); }
    ChunkRows& at(std::uint32_t slot) { return slabs_[slot / kPerSlab]->rows[slot % kPerSlab]; }
    const ChunkRows& at(std::uint32_t slot) const { return slabs_[slot / kPerSlab]->rows[slot % kPerSlab]; }

  private:
    static constexpr std::uint32_t kPerSlab = 32;
    struct Slab {
        Charge charge;
        std::array<ChunkRows, kPerSlab> rows;
    };
    MemoryBudget* ram_;
    const char* what_;
    std::vector<std::unique_ptr<Slab>> slabs_;
    std::vector<std::uint32_t> free_;
};

class VoxelSet {
  public:
    /// Empty.
    /// @param what  name of the set, for a budget's message
    VoxelSet(const glm::ivec3& extentVoxels, MemoryBudget& ram, const char* what = "the lumen");

    const glm::ivec3& extentVoxels() const { return extent_; }
    const glm::ivec3& chunks() const { return chunks_; }
    enum class Kind : std::uint8_t { none, some, all };
    Kind kind(std::size_t chunk) const {
        return slots_[chunk] == kNone ? Kind::none : slots_[chunk] == kAll ? Kind::all : Kind::some;
    }
    /// Row y + 32 z of a chunk.
    std::uint32_t row(std::size_t chunk, int number) const {
        const std::uint32_t slot = slots_[chunk];
        return slot == kNone ? 0 : slot == kAll ? ~0u : pool_.at(slot)[static_cast<std::size_t>(number)];
    }
    /// False outside the volume.
    bool contains(const glm::ivec3& voxel) const {
        if (voxel.x < 0 || voxel.y < 0 || voxel.z < 0 || voxel.x >= extent_.x || voxel.y >= extent_.y ||
            voxel.z >= extent_.z)
            return false;
        const std::size_t chunk = linearIndex({voxel.x >> 5, voxel.y >> 5, voxel.z >> 5}, chunks_);
        return row(chunk, (voxel.y & 31) + 32 * (voxel.z & 31)) >> (voxel.x & 31) & 1u;
    }
    /// The voxel at a point in voxel space.
    bool containsPlace(const glm::dvec3& place) const { return contains(glm::ivec3(glm::floor(place))); }

    /// Replaces a chunk's bits. None beyond the volume's edge may be set.
    void setChunk(std::size_t chunk, const ChunkRows& rows);
    void setAll(std::size_t chunk);
    /// The bits of a chunk, for changes in place; allocated if the chunk is empty. Not for a full chunk.
    ChunkRows& edit(std::size_t chunk);
    /// Frees a chunk's bits if they are all set or all clear.
    void settle(std::size_t chunk);
    std::uint64_t count(std::size_t chunk) const;
    std::uint64_t count() const;
    std::vector<std::size_t> filledChunks() const;

  private:
    static constexpr std::uint32_t kNone = ~0u, kAll = ~0u - 1;
    glm::ivec3 extent_, chunks_;
    Charge charge_;
    std::vector<std::uint32_t> slots_;
    RowsPool pool_;
};

/// Spreads `reached` within `inside` over faces, in a box of n rows of n x n bits (n at most 32; row y + n
/// z). reached must be part of inside.
void floodRows(const std::uint32_t* inside, std::uint32_t* reached, int n);

} // namespace tessera
