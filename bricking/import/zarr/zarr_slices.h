// bricking/import/zarr/zarr_slices.h: ZarrSlices: three axes of an array as slices, forward only, whatever
// the shape of its chunks. The chunks of a layer go through a temporary file, so memory holds one of them.
#pragma once

#include "bricking/import/source/source_files.h" // SpoolFile
#include "bricking/import/zarr/zarr_array.h"
#include "bricking/import/zarr/zarr_chunks.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// A volume of an array that may hold several.
struct ZarrVolumePlace {
    std::array<std::size_t, 3> axes{}; // of the array that become z, y, x
    std::vector<std::int64_t> at;      // its place along every axis, 0 along those three; empty: 0
    /// Of a box of it: where it begins along z, y, x, and its extents; of 0: all of the array.
    std::array<std::int64_t, 3> first{}, extents{};
};

class ZarrSlices {
  public:
    /// Chunks across a slice: each takes 8 bytes.
    static constexpr std::int64_t kMostAcross = 1 << 22;
    /// Throws InputError naming the array if it has more of them.
    /// @param scratch  folder for the temporary file; "": the system's
    ZarrSlices(ZarrArray array, ZarrVolumePlace place, std::filesystem::path scratch);
    /// Most memory that it takes.
    static std::size_t bytesNeeded(const ZarrArray& array, const ZarrVolumePlace& place);

    const ZarrArray& array() const { return array_; }
    /// The next slice, [y][x] values as chunks have them; fill where there is no chunk. Throws as ZarrChunks
    /// does, and Error if the temporary file cannot be written.
    void readSlice(std::span<std::byte> out);
    bool isAtEnd() const { return next_ == lengthOf(0); }
    /// Of the slices that were read.
    const ZarrChunks::Tally& tally() const { return chunks_.tally(); }
    /// "3 of 40 chunks are not there ...": "" where all are.
    std::string sayMissing() const;

  private:
    /// Of a layer: a chunk without what lies beyond the array.
    struct Part {
        std::int64_t x = 0, y = 0, sizeX = 0, sizeY = 0; // in the slice
        std::size_t firstByte = 0;                       // in the chunk
    };
    /// Of the layer: chunks that the volume touches, and the first of them.
    std::int64_t across(int axis) const {
        return (firstOf(axis) + lengthOf(axis) - 1) / chunkOf(axis) - firstChunk(axis) + 1;
    }
    std::int64_t firstChunk(int axis) const { return firstOf(axis) / chunkOf(axis); }
    /// @param number  x runs fastest
    Part partOf(std::int64_t number) const;
    std::vector<std::int64_t> chunkAt(std::int64_t number) const;
    void tellFrom(std::int64_t number) const;
    void readLayer();
    void spoolChunk(const Part& part, std::span<const std::byte> chunk, std::int64_t slices);
    std::int64_t lengthOf(int axis) const { return place_.extents[static_cast<std::size_t>(axis)]; }
    std::int64_t firstOf(int axis) const { return place_.first[static_cast<std::size_t>(axis)]; }
    std::int64_t chunkOf(int axis) const { return array_.chunk[place_.axes[static_cast<std::size_t>(axis)]]; }

    ZarrArray array_;
    ZarrVolumePlace place_;
    std::array<std::size_t, 3> stepBytes_{}; // of z, y, x in a chunk
    std::size_t firstByte_ = 0;              // of the volume in its chunks
    std::filesystem::path scratch_;
    ZarrChunks chunks_;
    std::vector<std::uint64_t> parts_; // of the layer: where they begin in the spool; kNone: all is fill
    std::unique_ptr<SpoolFile> spool_; // of the layer
    std::uint64_t spooled_ = 0;
    std::vector<std::byte> buffer_;       // a slice of a part
    std::int64_t next_ = 0, layerAt_ = 0; // the next slice, and the first of the layer
};

} // namespace tessera
