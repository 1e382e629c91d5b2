// bricking/import/files/hdf5/h5_tree.h: what HDF5 files find by order: B-trees of version 2, and the heap
// that holds what their records name. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_bytes.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

/// Blocks of a file that were read and compared with their checksums, up to 16 MiB of them.
class H5Blocks {
  public:
    explicit H5Blocks(const H5File& file) : file_(file) {}
    /// As H5File::sealed(), or block() without a mark.
    /// @param check  is called once with what was read
    H5Bytes get(std::uint64_t at, std::uint64_t bytes, const char* mark, const char* what,
                const std::function<void(H5Bytes)>& check = {});

  private:
    const H5File& file_;
    std::map<std::uint64_t, std::pair<std::uint64_t, H5Bytes>> held_; // by place: bytes asked for
    std::uint64_t heldBytes_ = 0;
};

/// What records are asked for: below 0 a record lies before them, above 0 behind them.
using H5Compare = std::function<int(H5Bytes record)>;

/// Calls each(record) for those that compare equal, in the tree's order. Null: for all. Throws InputError
/// naming the file for damage, for records of another kind, and for nodes that are met twice.
void eachH5Record(const H5File& file, std::uint64_t at, int kind, const H5Compare& compare,
                  const std::function<void(H5Bytes& record)>& each);

/// Of records' bytes.
std::size_t h5RecordBytes(const H5File& file, std::uint64_t at);

/// A fractal heap.
class H5Heap {
  public:
    /// Throws InputError naming the file for damage, and for a heap with filters.
    H5Heap(const H5File& file, std::uint64_t at);
    std::size_t idBytes() const { return idBytes_; }
    /// An object by its number. Throws likewise, and for objects outside of blocks.
    H5Bytes object(H5Bytes& id);

  private:
    struct Block {
        std::uint64_t at = 0, begin = 0, bytes = 0; // begin: in the heap
    };
    Block directOf(std::uint64_t offset);
    std::uint64_t rowBytes(std::uint64_t row) const;

    const H5File& file_;
    H5Blocks blocks_;
    std::uint64_t at_;
    std::size_t idBytes_ = 0;
    bool isSummed_ = false; // direct blocks have checksums
    std::uint64_t mostObject_ = 0, width_ = 0, firstBytes_ = 0, mostDirect_ = 0, rootAt_ = 0, rootRows_ = 0;
    std::size_t offsetBytes_ = 0, lengthBytes_ = 0;
    int maxBits_ = 0;
};

} // namespace tessera
