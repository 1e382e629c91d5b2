// bricking/labels/label_volume.cpp: see label_volume.h.
#include "bricking/labels/label_volume.h"

#include "bricking/labels/label_files.h"

#include <utility>

namespace tessera {

LabelVolume::LabelVolume(const std::filesystem::path& store, MemoryBudget& ram) : voxels_(store, ram) {
    LabelFiles files = readLabelFiles(voxels_, ram);
    table_ = std::move(files.table);
    cells_ = std::move(files.cells);
}

} // namespace tessera
