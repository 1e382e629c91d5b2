// bricking/labels/label_import.h: from the layers of a segmentation to a volume of labels on its scan's
// lattice.
#pragma once

#include "bricking/labels/label_source.h"
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// Raise it with every change of the result for the same files.
constexpr int kLabelImportVersion = 2;

struct LabelImportOptions {
    bool force = false;           // replace an existing store
    int threads = 0;              // 0: all processors
    bool durable = true;          // synchronise to disk before the rename
    Progress* progress = nullptr; // null: silent
    bool sameFrame = false;       // the frames of reference are taken for one, whatever the files say
};
struct LabelImportReport {
    std::uint64_t voxels = 0, labelled = 0; // of the scan; with a label
    std::size_t labels = 0, sets = 0;       // of the table; the empty set counts
    std::uint64_t bytesOut = 0;
    std::vector<std::string> notes; // of the file and of its placement, one a line
    double seconds = 0;
};

/// Least memory for importing such a file, if its sets of labels are few.
std::size_t labelImportFloorBytes(const LabelFile& file, const VolumeInfo& scan, int threads);

/// Writes a store that LabelVolume opens, in a temporary folder beside `store`, then renames it. How layers
/// get to the scan's lattice: label_placement.h. Memory: slabs of slices, charged to ram. Numbers of sets on
/// the lattice go through a temporary file beside `store`, and so do layers in another order than the scan's.
/// The store's frame of reference is the scan's, else the file's.
/// Throws InputError for frames of reference that differ, layers outside of the scan, more than
/// LabelTable::kMostSets labels or sets, no labelled voxel, too little memory, and for an existing store.
LabelImportReport importLabels(LabelFile& file, const VolumeInfo& scan, const std::filesystem::path& store,
                               MemoryBudget& ram, const LabelImportOptions& options);

} // namespace tessera
