// bricking/store/stand_in_reader.h: StandInReader, a store for pictures: a chunk that cannot be read is drawn
// from the next coarser level that is whole there, and noted.
#pragma once

#include "bricking/store/store_reader.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace tessera {

/// A chunk that a coarser level stands in for.
struct DamagedChunk {
    ChunkKey key;
    int drawnFrom = 0; // level
    std::string why;   // what reading it said
};

class StandInReader : public StoreReader {
  public:
    static constexpr std::size_t kMostNamed = 1000;

    /// As StoreReader's.
    StandInReader(const std::filesystem::path& path, MemoryBudget& ram,
                  const glm::dmat4& moved = glm::dmat4(1));

    /// As StoreReader's, but for a damaged or missing chunk: then the samples of the next coarser level that
    /// is whole there, trilinear within its chunk; of labels the nearest. Throws what reading the chunk threw
    /// where no coarser level is whole.
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;

    /// Chunks that were asked for and are damaged, each once.
    std::uint64_t damagedCount() const;
    /// The first kMostNamed of them that were met, in order of level and place.
    std::vector<DamagedChunk> damaged() const;

  private:
    void note(const ChunkKey& key, int drawnFrom, const char* why) const;

    bool areNames_; // of labels, by the rule of levels: their means say nothing
    mutable std::mutex mutex_;
    mutable std::array<std::vector<bool>, kLevelCount> noted_; // per chunk; empty: none of the level
    mutable std::uint64_t count_ = 0;
    mutable std::vector<DamagedChunk> damaged_;
};

/// True if a store gave samples of coarser levels for others. What follows from them is not kept beside it.
bool hasStandIns(const StoreReader& store);

} // namespace tessera
