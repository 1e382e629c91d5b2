// bricking/import/files/vgi/vgi_header.h: the header of a Volume Graphics volume (.vgi), a text that names
// the file of its voxels (.vol). Private to the reader.
#pragma once

#include "bricking/import/files/data_files.h"
#include "core/base/volume.h"

#include <filesystem>
#include <optional>

namespace tessera {

struct VgiHeader {
    DataFiles files;
    VolumeInfo info;         // in the file's order of axes
    bool saysSpacing = true; // "resolution", in a unit that is known
};

/// Reads the header alone. Throws InputError naming the file for a header that is damaged or ends early, for
/// several volumes or files of one, for a part of a file, for voxels that are packed or of a type that is not
/// known, and for a volume that its scene scales or shows with several resolutions.
/// @param spacingMm  where the file does not say it
VgiHeader readVgiHeader(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacingMm);

} // namespace tessera
