// bricking/import/source/format_endings.h: file name endings of single-file formats, for folder listings
// without importers.
#pragma once

#include <string>
#include <vector>

namespace tessera {

/// ".nii", ".nii.gz", ...: of all formats of bricking/import/files; empty in builds without importers.
const std::vector<std::string>& volumeFileEndings();
/// Of those, the endings of files that may name others, which hold the voxels.
const std::vector<std::string>& namingFileEndings();
/// Of those, the endings of files that may have their volume at several resolutions.
const std::vector<std::string>& levelledFileEndings();

} // namespace tessera
