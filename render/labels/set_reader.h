// render/labels/set_reader.h: the set of labels that a place of a slice has (docs/sampling.md, "Labels in
// slices").
#pragma once

#include "core/scene/labels.h"
#include "render/contract/lattice.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// For one thread.
class SetReader {
  public:
    /// All outlive it.
    /// @param cache   of a volume of labels: numbers of sets
    /// @param shown   of every set its number without what does not show; 0: none
    SetReader(BrickCache& cache, const VolumeInfo& info, int level, LabelBorders borders,
              std::span<const std::uint16_t> shown);
    /// @param place  level-0 voxels; anywhere
    /// Throws InputError naming what cannot be read.
    std::uint16_t at(const glm::dvec3& place);

  private:
    using Place = glm::vec<3, std::int64_t>;
    using Sets = std::array<std::uint16_t, 8>;
    void read(const glm::ivec3& first);
    Sets numbersAround(const glm::ivec3& first);
    const std::byte* chunkOf(const glm::ivec3& sample);
    std::uint16_t numberAt(const std::byte* chunk, std::size_t at) const;

    BrickCache& cache_;
    bool wide_; // numbers of 16 bits, else 8
    int level_;
    bool nearest_;
    glm::dvec3 extent_;
    glm::ivec3 samples_; // of the level
    std::span<const std::uint16_t> shown_;
    /// Chunks by the low bits of their places: neighbours never evict each other.
    struct Pinned {
        glm::ivec3 place{-1};
        ChunkPointer chunk;
    };
    std::array<Pinned, SampleReader::kPinnedChunks> pinned_;
    glm::ivec3 first_{INT32_MIN}; // of the samples last read
    Sets sets_{};
    bool isOne_ = false; // they have one set
};

} // namespace tessera
