// bricking/labels/label_files.h: the table and the cells of a label volume, in its store.
//
// STORE/sets/zarr.json holds the table in attributes.tessera: labels and sets, with the content hash of the
// store, sums over the arrays and a checksum over itself. Beside it are three arrays of uint16 along z:
// sets/counts has the number of shares of every cell, sets/set and sets/voxels have the shares, cell by cell.
#pragma once

#include "bricking/labels/label_cells.h"
#include "bricking/labels/label_table.h"
#include "bricking/store/store_reader.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Writes the cells while a label volume is written, then the table.
class LabelFilesWriter {
  public:
    /// @param folder  of the store that is being made
    LabelFilesWriter(const std::filesystem::path& folder, const glm::ivec3& extentVoxels, int threads);
    static std::size_t bytesNeeded(const glm::ivec3& extentVoxels, int threads);

    /// The next slices of level 0, a multiple of kCellExtent unless they are the last: [z][y][x].
    void add(std::span<const std::uint16_t> numbers, int slices);
    /// After the last slice.
    void finish(const LabelTable& table, const StoreReader& store);

  private:
    struct Array {
        std::string name;
        std::vector<std::uint16_t> kept; // not yet written
        std::uint64_t values = 0;        // in all
        int layers = 0;                  // written
        std::uint32_t crc = 0;
    };
    void append(Array& array, std::span<const std::uint16_t> values);
    void flush(Array& array);

    std::filesystem::path folder_;
    glm::ivec3 extent_;
    int threads_;
    int nextZ_ = 0;
    Array counts_{"counts", {}}, set_{"set", {}}, voxels_{"voxels", {}};
    std::vector<std::vector<std::uint16_t>> rowCounts_, rowSets_, rowVoxels_; // of rows of cells
};

/// OME's "image-label" as JSON: names of every set and, where its labels have some, their mean colour. "" for
/// more sets than metadata should hold.
std::string imageLabelOf(const LabelTable& table);

struct LabelFiles {
    LabelTable table;
    LabelCells cells;
};
/// Throws InputError naming the file that is missing, damaged, of another store or version, or whose numbers
/// contradict others. What the files hold is checked before memory for it is taken.
LabelFiles readLabelFiles(const StoreReader& store, MemoryBudget& ram);
/// The table alone, which is not charged. Throws InputError likewise.
LabelTable readLabelTable(const StoreReader& store, MemoryBudget& ram);

} // namespace tessera
