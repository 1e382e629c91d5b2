// viewer/session/label_probe.h: whether a file that could be a volume is meant as labels of an open one.
#pragma once

#include "core/base/volume.h"

#include <filesystem>

namespace tessera {

/// True for a file that a format of volumes reads, too (by its name's ending), of one layer of whole numbers
/// on the volume's lattice, of kMostProbedLabels values or fewer, none below 0. A file with more is read up
/// to the value that is too many. It throws nothing but Cancelled and Interrupted.
bool mayBeLabelsOf(const VolumeInfo& volume, const std::filesystem::path& file);
constexpr int kMostProbedLabels = 256;

} // namespace tessera
