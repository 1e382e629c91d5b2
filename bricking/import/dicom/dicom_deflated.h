// bricking/import/dicom/dicom_deflated.h: undoes the deflated transfer syntax, which vtk-dicom does not read,
// by turning the whole file into the plain little-endian file that it stands for.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace tessera {

constexpr const char* kDeflatedSyntax = "1.2.840.10008.1.2.1.99";

/// The bytes of an explicit little-endian DICOM file with the same data set. The file is one image, held
/// whole. Throws InputError naming the file if it is damaged or larger than 512 MiB when inflated.
std::vector<std::byte> inflateDicom(const std::filesystem::path& path);

} // namespace tessera
