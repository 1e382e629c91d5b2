// bricking/import/slab_feed.h: how an import reads and keeps slabs within its budget. Whole slabs of 32
// slices where they have room; else bands of their rows, of sources that give these. Of others each slab goes
// slice by slice through a file without a name.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/store/pyramid.h" // SlabPlan
#include "bricking/store/slab_file.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

struct ImportPlan {
    SlabPlan slabs;
    int bufferRows = 0;        // rows of a slice that go into the file at once; 0: bands come from the source
    std::size_t roomBytes = 0; // SlabSource::roomBytes(); of whole slabs 0
};

/// Least memory for writing the source's volume, in any way.
/// @param info  of the store
std::size_t leastImportBytes(const SlabSource& source, const VolumeInfo& info, int threads);
/// The way that has room in freeBytes, whole slabs before others.
/// @param folder  of files
ImportPlan planImport(const SlabSource& source, const VolumeInfo& info, std::size_t freeBytes, int threads,
                      const std::filesystem::path& folder);
/// Of a volume whose rows can be read in any order; of what is charged already freeBytes knows.
SlabPlan planSlabs(const glm::ivec3& extentVoxels, ValueType type, std::size_t freeBytes,
                   const std::filesystem::path& folder);

class SlabFeed {
  public:
    struct Band {
        int firstSlice = 0, slices = 0, firstRow = 0, rows = 0;
    };
    /// Charges what the plan needs for reading. Throws InputError if that does not fit, Error if the disk has
    /// too little room.
    /// @param info  of the volume
    SlabFeed(ImportPlan plan, const VolumeInfo& info, MemoryBudget& ram);

    /// Reads a band, [slices][rows][x]. Of a slab they come with y ascending.
    void read(SlabSource& source, const Band& band, std::span<std::byte> out);
    /// True if a band needs none that came before it.
    bool isAnywhere() const { return !plan_.slabs.isWhole() && plan_.bufferRows == 0; }
    /// Reads slice z, which comes next, for nothing.
    /// @param scratch  a slice, where slabs are whole
    void pass(SlabSource& source, int z, std::span<std::byte> scratch);

  private:
    template <typename Each> void eachPiece(SlabSource& source, int z, const Each& each);

    ImportPlan plan_;
    glm::ivec3 extent_;
    std::size_t rowBytes_;
    Charge charge_;
    std::vector<std::byte> buffer_;
    std::optional<SlabFile> file_; // the slab whose bands are read
};

} // namespace tessera
