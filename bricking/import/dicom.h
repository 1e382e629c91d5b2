// bricking/import/dicom.h: a DICOM series as a SlabSource in its own slice order (along row x column).
//
// Values. Slope and intercept are applied slice by slice. If all are whole numbers the volume holds int16
// physical values (HU for CT; clamped values are counted), or uint16 where only that can hold them; else, and
// for other modalities whose range fits neither, float32. rescaleSlope is 1 and rescaleIntercept 0 then.
// Padding. fillStored of HU data is -1024. Voxels that the header declares as padding (PixelPaddingValue and
// its range limit) and that lie below -1024 HU become fillStored; every other value, whatever the scanner
// wrote outside its circle, stays as it is. Other data has the first slice's padding, or 0, as fillStored.
// Place. A gantry tilt stays in the affine as a shear. Multi-frame files are read if they are not compressed.
#pragma once

#include "bricking/import/dicom_scan.h"
#include "bricking/import/slab_source.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// Opens the series of that number (1-based), or with 0 the only one. Throws InputError naming the path: for
/// no series or several without a number (with the list), a damaged file, and as planSlices() does.
std::unique_ptr<SlabSource> openDicom(const std::filesystem::path& fileOrFolder, int series, bool resampleZ);

/// What openDicom() would give for each series, in order; series that would be refused come with their
/// resampled geometry if that is possible, and are left out (empty) if not. Nothing is thrown for bad files.
struct DicomListing {
    int series = 0; // 1-based
    VolumeInfo info;
};
std::vector<DicomListing> listDicom(const std::filesystem::path& fileOrFolder);

} // namespace tessera
