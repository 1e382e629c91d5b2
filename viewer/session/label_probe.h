// viewer/session/label_probe.h: whether a file or folder that could be volumes is meant as labels of an open
// one.
#pragma once

#include "core/base/volume.h"

#include <filesystem>

namespace tessera {

/// True for a file that a format of volumes reads, too (by its name's ending), that describes no labels, of
/// one layer of whole numbers on the volume's lattice, of kMostProbedLabels values or fewer, none below 0. A
/// file with more is read up to the value that is too many. True for a folder of masks as well: it has no
/// folders and no DICOM files, and all files of labels in it are of one layer of whole numbers on the
/// lattice, with one value besides 0 in the first slice that has one; some file has one. It throws nothing
/// but Cancelled and Interrupted.
bool mayBeLabelsOf(const VolumeInfo& volume, const std::filesystem::path& file);
constexpr int kMostProbedLabels = 256;

} // namespace tessera
