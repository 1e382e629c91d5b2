// bricking/import/dicom/dicom_source.h: a DICOM series as a SlabSource in its own slice order (along
// row x column).
//
// Values: slope and intercept are applied slice by slice. If all results are whole numbers, the volume holds
// int16 physical values (HU for CT; clamped values are counted), or uint16 if only that can hold them.
// Otherwise, and for other modalities whose range fits neither, it holds float32. rescaleSlope is 1 and
// rescaleIntercept 0 then.
//
// Padding: fillStored of HU data is -1024. Voxels that the header declares as padding (PixelPaddingValue and
// its range limit) and that lie below -1024 HU become fillStored. Every other value is unchanged, also
// outside the scanner's circle. Other data has the first slice's padding, or 0, as fillStored.
//
// Geometry: a gantry tilt stays in the affine as a shear. Every frame of a multi-frame file is a slice.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"
#include "bricking/import/source/slab_source.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Opens the series of that index. `where` names the path in messages. Throws InputError for unreadable files
/// that could be slices of it, unless options.allowMissing. Throws it for several images at one position
/// without options.phase (with the list), and as planSlices() does. Byte-identical copies are dropped.
std::unique_ptr<SlabSource> openDicom(const DicomScan& scan, std::size_t index, const SourceOptions& options,
                                      const std::string& where);

/// Preview of openDicom() for a series, for the choice. Throws nothing.
struct DicomListing {
    std::optional<VolumeInfo> info; // with its resampled geometry if the slices are uneven
    std::string problem; // why it is refused without options, or the option that it needs; "" if nothing
    std::vector<std::string> phases; // labels
    int slices = 0;                  // of one phase, without duplicates
    std::size_t duplicates = 0, missing = 0;
    double tiltDegrees = 0;
};
DicomListing listDicom(const DicomScan& scan, std::size_t index, bool allowMissing);

} // namespace tessera
