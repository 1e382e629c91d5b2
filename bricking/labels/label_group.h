// bricking/labels/label_group.h: LabelGroup: layers that share a grid, read together slice by slice. A voxel
// has a combination: the labels that the layers have there.
#pragma once

#include "bricking/import/source/source_files.h" // SpoolFile
#include "bricking/labels/label_sets.h"
#include "bricking/labels/label_source.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tessera {

/// The values of labels, numbered as they come.
class LabelNumbers {
  public:
    static constexpr std::size_t kMost = LabelTable::kMostSets;
    /// @param where  the file, for messages
    explicit LabelNumbers(std::string where) : where_(std::move(where)) {}
    const std::string& where() const { return where_; }
    std::size_t size() const { return values_.size(); }
    std::uint32_t valueOf(std::uint32_t number) const { return values_[number]; }
    /// Throws InputError for more than kMost values.
    std::uint32_t numberOf(std::uint32_t value);

  private:
    std::string where_;
    std::vector<std::uint32_t> values_;
    std::unordered_map<std::uint32_t, std::uint32_t> numbers_;
    std::uint32_t lastValue_ = 0, lastNumber_ = 0; // value 0: none yet
};

class LabelGroup {
  public:
    static constexpr std::size_t kMostCombinations = 65536;
    static constexpr std::size_t kMostOpen = 200; // layers at once: descriptors are few

    /// @param layers  of one grid, at least one; they outlive the group
    /// @param scratch  folder for temporary files
    LabelGroup(std::vector<LabelLayer*> layers, LabelNumbers& labels, MemoryBudget& ram, int threads,
               std::filesystem::path scratch);
    static std::size_t bytesNeeded(std::span<LabelLayer* const> layers, int threads);

    const VolumeInfo& info() const { return layers_.front()->info(); }
    /// The next slices: [z][y][x] combinations.
    void readSlices(int count, std::span<std::uint32_t> out);
    /// Of every combination: layer << 16 | number of a label. 0 is none.
    const LabelSets& combinations() const { return combinations_; }
    /// Throws InputError for more than kMostCombinations.
    void checkCombinations() const;
    static std::uint32_t labelIn(std::uint32_t entry) { return entry & 0xFFFF; }
    static std::uint32_t layerIn(std::uint32_t entry) { return entry >> 16; }

  private:
    void readPart(int count, std::span<std::uint32_t> out);
    void addLayers(std::size_t first, std::size_t end, int count, std::span<std::uint32_t> out);
    void spoolAllButLast();

    std::vector<LabelLayer*> layers_;
    LabelNumbers& labels_;
    int threads_;
    std::filesystem::path scratch_;
    LabelSets combinations_;
    int part_; // slices read at once
    Charge charge_;
    std::vector<std::vector<std::uint32_t>> buffers_; // of layers that are read at the same time
    std::unique_ptr<SpoolFile> before_;               // combinations of all but the last kMostOpen layers
    std::size_t next_ = 0;                            // the first layer that is not in it
    int nextZ_ = 0;
};

// Slices of numbers of 16 bits in a temporary file.

/// @param scratch  is resized; the numbers are below 65536
void spoolNumbers(SpoolFile& spool, std::span<const std::uint32_t> numbers,
                  std::vector<std::uint16_t>& scratch);

} // namespace tessera
