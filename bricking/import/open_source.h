// bricking/import/open_source.h: from a path to a SlabSource, whatever the format. Target tessera_import.
#pragma once

#include "bricking/import/slab_source.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

struct SourceOptions {
    int series = 0;         // DICOM: 1-based number from the list; 0: the only one, or refuse with the list
    bool resampleZ = false; // DICOM: uneven slices are interpolated to an even spacing
    /// Where data is spooled whose slowest axis has to move; "": the folder for temporary files.
    std::filesystem::path scratchFolder = {};
};

/// Opens a DICOM file or folder, .nii, .nii.gz, or the .json sidecar of a raw file. What comes out is in the
/// nearest LPS order already (lossless flips and permutations; the rest stays in the affine).
/// Throws InputError naming the path for everything that is not such a volume.
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
