// bricking/store/volume_parts.h: the parts of a volume along z. Each is written to a folder by itself, by any
// process; joined they are a store's shards, byte for byte those that one writer of the whole volume makes.
//
// A part's folder has its chunks in shard files (LevelWriter), of every level that has whole slabs in it, and
// the file "rest": the slices of the first level that has none, from which the levels from there on are made.
#pragma once

#include "bricking/store/level_writer.h"
#include "bricking/store/pyramid.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// Slices of a part: a row of shards of level 0; slabs of levels 1 to 4 are whole.
constexpr int kPartSlices = 512;

struct VolumeParts {
    int slicesInAll = 0;
    int slices = kPartSlices; // of a part, fewer of the last; kChunkExtent times a power of two
    int count() const { return (slicesInAll - 1) / slices + 1; }
    int first(int part) const { return part * slices; }
    int slicesOf(int part) const;
    /// Levels from the finest one on whose slabs belong to one part each.
    int wholeLevels() const;
};

struct WrittenPart {
    WrittenLevels levels;
    std::uint64_t restBytes = 0; // 0: no such file, every level is whole
    std::uint32_t restCrc = 0;
};

class PartWriter {
  public:
    /// Charges what StoreWriter does; of slabs that do not lie in memory, what SlabPyramid says.
    /// @param info  of the whole volume
    PartWriter(std::filesystem::path folder, const VolumeInfo& info, const VolumeParts& parts, int part,
               MemoryBudget& ram, int threads, const SlabPlan& plan = {}, Codec codec = Codec::lz4);

    /// As SlabPyramid's, of the part.
    int nextSlices() const { return pyramid_.nextSlices(); }
    int nextFirstRow() const { return pyramid_.nextFirstRow(); }
    int nextRows() const { return pyramid_.nextRows(); }
    std::span<std::byte> next() { return pyramid_.next(); }
    void swapNext(std::vector<std::byte>& slab) { pyramid_.swapNext(slab); }
    /// Throws as LevelWriter::write() does.
    void push() { pyramid_.push(); }
    /// After the last slab.
    WrittenPart finish();

  private:
    void take(const SlabPyramid::Slab& slab);
    void writeRest(const SlabPyramid::Slab& band);
    std::filesystem::path folder_;
    VolumeParts parts_;
    int part_;
    glm::ivec3 extent_; // of the part
    LevelWriter levels_;
    WrittenPart written_;
    SlabPyramid pyramid_; // last: its sink is take()
};

/// A part that is there.
struct PartFiles {
    std::filesystem::path folder;
    WrittenPart written;
};

/// True if every file of a part is there and has its size. What joining has moved is in `store`.
bool isWhole(const PartFiles& part, const std::filesystem::path& store);

/// Makes the shards of a store. A file that is alone in its shard is moved, others are copied. After a kill
/// it can be called again.
/// @param store  a folder, empty or left by such a call
/// @param planOf  of the slabs of the levels that no part has, of their extent
/// Throws InputError for a damaged file, Error if the disk fails.
WrittenLevels joinParts(const std::vector<PartFiles>& files, const VolumeParts& parts, const VolumeInfo& info,
                        const std::filesystem::path& store, MemoryBudget& ram, int threads,
                        const std::function<SlabPlan(const glm::ivec3&)>& planOf = {},
                        Codec codec = Codec::lz4);

} // namespace tessera
