// bricking/import/files/hdf5/h5_slices.h: three axes of a data set of an HDF5 file as slices, whatever the
// shape of its chunks. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_chunks.h"
#include "bricking/import/files/hdf5/h5_set.h"
#include "bricking/import/source/source_files.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// A volume of a set that may hold several, and more than the volume.
struct H5VolumePlace {
    std::size_t slowest = 0;                // the axis that becomes z; y and x follow
    std::array<std::uint64_t, 3> extents{}; // z, y, x; at most the set's
    std::vector<std::uint64_t> at;          // along all axes; 0 along those three
    std::array<std::uint64_t, 3> first{};   // of the set's z, y, x: where the volume begins
};

class H5Slices {
  public:
    /// @param file  must outlive it
    /// @param scratch  folder for the temporary file; "": the system's
    H5Slices(const H5File& file, H5Set set, H5VolumePlace place, std::filesystem::path scratch);

    FileType type() const { return set_.type.isHalf ? FileType::f32 : *set_.type.number; }
    bool isBigEndian() const { return set_.type.isBig && !set_.type.isHalf; }
    std::size_t sliceBytes() const;

    /// [y][x] numbers of type(); fill where there is no chunk. Chunks of a layer are decoded at once. Memory
    /// holds the layer, or above 256 MiB the temporary file does, and memory a chunk. Throws InputError
    /// naming the file for damage, and Error if the temporary file cannot be written.
    void readSlice(std::uint64_t z, std::span<std::byte> out);

  private:
    struct Box { // of a layer: a chunk without what lies beyond the volume
        std::uint64_t x = 0, y = 0, sizeX = 0, sizeY = 0;
        std::uint64_t inX = 0, inY = 0; // where it begins in the chunk
        std::uint64_t at = 0;           // in the spool
    };
    void readLayer(std::uint64_t layer);
    Box boxOf(const H5Chunk& chunk) const;
    /// Copies slice z of a chunk, of its box [y][x], to rows that are so many bytes apart.
    void copyBox(const std::vector<std::byte>& chunk, const Box& box, std::uint64_t z, std::byte* to,
                 std::size_t rowBytes) const;
    void readRun(std::uint64_t z, std::span<std::byte> out) const;
    void fillWith(std::span<std::byte> out) const;

    const H5File& file_;
    H5Set set_;
    H5VolumePlace place_;
    std::filesystem::path scratch_;
    std::optional<H5Chunks> chunks_;
    std::array<std::size_t, 3> stepBytes_{}; // of z, y, x in a chunk
    std::size_t firstByte_ = 0;              // of the volume in its chunks
    std::optional<std::uint64_t> layer_;     // that is held,
    std::uint64_t layerFirst_ = 0;           // from this slice of the volume on
    std::vector<std::byte> held_, numbers_;
    std::unique_ptr<SpoolFile> spool_;
    std::vector<Box> boxes_; // in the spool
};

} // namespace tessera
