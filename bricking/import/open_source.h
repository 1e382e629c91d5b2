// bricking/import/open_source.h: opens a path of any format as a SlabSource. Target tessera_import.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/source_options.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// Opens a DICOM file, .nii, .nii.gz, the .json sidecar of a raw file, or of a folder the volume that
/// chooseRow() of catalogue.h takes. What comes out is in the nearest LPS order already (lossless flips and
/// permutations; the rest stays in the affine). Throws InputError naming the path for everything that is not
/// such a volume, with the table of what is there where a choice is needed.
std::unique_ptr<SlabSource> openSource(const std::filesystem::path& path, const SourceOptions& options);

/// One volume that a folder offers, for choosing.
struct SourceCandidate {
    std::filesystem::path path; // what openSource() takes
    int series = 0;             // SourceOptions::series for it
    std::string modality;       // "" unknown
    VolumeInfo info;
};
/// Every volume found in a folder (recursively) or file, largest voxel count first; none is not an error.
std::vector<SourceCandidate> listVolumes(const std::filesystem::path& path);

} // namespace tessera
