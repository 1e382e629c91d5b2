// bricking/labels/label_volume.cpp: see label_volume.h.
#include "bricking/labels/label_volume.h"

namespace tessera {

LabelVolume::LabelVolume(const std::filesystem::path& store, MemoryBudget& ram) : voxels_(store, ram) {}

} // namespace tessera
