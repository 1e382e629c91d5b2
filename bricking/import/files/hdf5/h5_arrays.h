// bricking/import/files/hdf5/h5_arrays.h: the arrays by which HDF5 files find chunks by number: fixed ones,
// and those that grow. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_bytes.h"
#include "bricking/import/files/hdf5/h5_tree.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// A chunk's bytes in the file.
struct H5Extent {
    std::uint64_t at = kH5Nowhere, bytes = 0;
    std::uint32_t mask = 0; // filters that it went without, by bits
};

/// An entry of one: its place, and where chunks are filtered their length and mask.
struct H5Entries {
    bool areFiltered = false;
    std::uint64_t chunkBytes = 0; // of those that are not
    std::size_t bytes = 0;        // of an entry
    /// @param bytes  as the file says
    void setBytes(std::size_t bytes, const H5File& file);
    H5Extent read(H5Bytes& entry) const;
    /// At the end of `bytes`, at most.
    H5Extent readAt(H5Bytes bytes, std::uint64_t number) const;
};

class H5FixedArray {
  public:
    /// Throws InputError naming the file for damage.
    H5FixedArray(const H5File& file, std::uint64_t at, H5Entries entries);
    std::uint64_t count() const { return count_; }
    /// Throws likewise. Nothing is there: no place.
    H5Extent entry(std::uint64_t number);

  private:
    const H5File& file_;
    H5Blocks blocks_;
    H5Entries entries_;
    std::uint64_t headerAt_, dataAt_ = 0, count_ = 0, perPage_ = 0;
};

/// One axis may grow without an end.
class H5GrowingArray {
  public:
    /// Throws InputError naming the file for damage.
    H5GrowingArray(const H5File& file, std::uint64_t at, H5Entries entries);
    H5Extent entry(std::uint64_t number);

  private:
    /// Blocks that one level of the array has.
    struct Level {
        std::uint64_t blocks = 0, entries = 0; // of a block
        std::uint64_t firstEntry = 0, firstBlock = 0;
    };
    H5Bytes headless(std::uint64_t at, std::uint64_t bytes, const char* mark);
    H5Extent ofBlock(std::uint64_t at, const Level& level, std::uint64_t number, bool isPageThere);
    std::uint64_t pagesOf(const Level& level) const;

    const H5File& file_;
    H5Blocks blocks_;
    H5Entries entries_;
    std::uint64_t headerAt_, indexAt_ = 0, inIndex_ = 0, perPage_ = 0, leastPointers_ = 0;
    std::size_t offsetBytes_ = 0;
    std::vector<Level> levels_;
};

} // namespace tessera
