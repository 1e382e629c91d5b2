// bricking/import/files/foreign_format.h: recognizes formats that are not read, so that a refusal can name
// them and advise.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct ForeignFormat {
    std::string what;   // "an NRRD volume"; "" where it is not known
    std::string advice; // "convert it to .nii.gz (3D Slicer saves it as NIfTI)"; may be ""
    bool known() const { return !what.empty(); }
    std::string text() const { return advice.empty() ? what : what + ": " + advice; }
};

/// Of a file or folder, by its name and first bytes: Zarr v2 and v3, OME-Zarr, a .zarr without metadata,
/// volumes, archives and pictures by their endings and marks, DICOMDIR.
ForeignFormat foreignFormatOf(const std::filesystem::path& path);

/// The foreign volumes among files: "2 NRRD volumes (a.nrrd, b.nhdr), ..."; "" for none. With the advice for
/// the first.
std::string countForeign(const std::vector<std::filesystem::path>& files);

} // namespace tessera
