// bricking/import/open_source.h: opens a path of any format as a SlabSource. Target tessera_import.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// Opens a DICOM file, a file of a format of fileFormats(), or the volume of a folder by chooseRow() of
/// catalogue.h. The result is in the nearest LPS order (lossless flips and permutations; the
/// rest stays in the affine). Throws InputError naming the path for anything else, with the table of series
/// if the user must choose.
std::unique_ptr<SlabSource> openSource(const std::filesystem::path& path, const SourceOptions& options);

/// One volume of a folder, for the choice.
struct SourceCandidate {
    std::filesystem::path path; // path for openSource()
    int series = 0;             // SourceOptions::series for it
    std::string modality;       // "" unknown
    VolumeInfo info;
};
/// Every volume of a folder (recursively) or file, largest voxel count first; may be empty.
std::vector<SourceCandidate> listVolumes(const std::filesystem::path& path);

} // namespace tessera
