// bricking/import/files/foreign_format.h: recognizes unsupported formats, so that a refusal can name them and
// advise.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct ForeignFormat {
    std::string what;   // "an NRRD volume"; "" if unknown
    std::string advice; // "convert it to .nii.gz (3D Slicer saves it as NIfTI)"; may be ""
    bool known() const { return !what.empty(); }
    std::string text() const { return advice.empty() ? what : what + ": " + advice; }
};

/// By the name and first bytes of a file or folder. It knows Zarr v2 and v3, OME-Zarr, a .zarr without
/// metadata, DICOMDIR, and volumes, archives and pictures by their extensions and magic numbers.
ForeignFormat foreignFormatOf(const std::filesystem::path& path);

/// The foreign volumes among files: "2 NRRD volumes (a.nrrd, b.nhdr), ..."; "" for none. With the advice for
/// the first.
std::string countForeign(const std::vector<std::filesystem::path>& files);

} // namespace tessera
