// bricking/import/files/hdf5/h5_chunks.h: where the chunks of a data set of an HDF5 file are, and what is in
// them once their filters are undone. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_arrays.h"
#include "bricking/import/files/hdf5/h5_set.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

namespace tessera {

using H5Place = std::vector<std::uint64_t>; // of a chunk in the grid of chunks, along every axis

struct H5Chunk {
    H5Place place;
    H5Extent extent;
};

class H5Chunks {
  public:
    /// Both must outlive it. Throws InputError naming file and set for damage.
    H5Chunks(const H5File& file, const H5Set& set);

    /// Of an axis: chunks from one on, up to another, which is not of it.
    struct Range {
        std::size_t axis = 0;
        std::uint64_t begin = 0, end = 0;
        std::uint64_t count() const { return end - begin; }
    };
    /// The chunks of a layer that are in the file, each once, in any order. Throws likewise, for chunks
    /// behind the end of the file, and for layers of more than 2^22.
    /// @param across  the two axes along which the layer has several; the other places are those of `at`
    std::vector<H5Chunk> ofLayer(const H5Place& at, const std::array<Range, 2>& across);

  private:
    struct Layer {
        const H5Place& at;
        std::array<Range, 2> across;
        std::vector<H5Chunk>& found;
    };
    void searchOldTree(std::uint64_t at, int expected, const Layer& layer,
                       std::set<std::uint64_t>& seen) const;
    void searchTree(const Layer& layer) const;
    void searchArray(const Layer& layer);
    H5Extent extentOf(const H5Place& place);
    int compare(const H5Place& place, const Layer& layer) const;
    void add(H5Place place, const H5Extent& extent, const Layer& layer) const;

    const H5File& file_;
    const H5Set& set_;
    H5Place chunks_;                   // of the grid, along every axis
    std::vector<std::uint64_t> steps_; // of a chunk's number, along every axis
    std::optional<H5FixedArray> fixed_;
    std::optional<H5GrowingArray> growing_;
};

/// Undoes the filters. Memory is taken for what the bytes in the file justify. Throws InputError naming file
/// and set for damage; fletcher32 tells of it.
std::vector<std::byte> readH5Chunk(const H5File& file, const H5Set& set, const H5Chunk& chunk);

} // namespace tessera
