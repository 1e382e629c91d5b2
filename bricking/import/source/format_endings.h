// bricking/import/source/format_endings.h: names of files that a format of single files may read. For a list
// of a folder, which needs no importer.
#pragma once

#include <string>
#include <vector>

namespace tessera {

/// ".nii", ".nii.gz", ...: of all formats of bricking/import/files; empty where importers are left out.
const std::vector<std::string>& volumeFileEndings();

} // namespace tessera
