// bricking/import/dicom/dicom_place.h: reads a frame's position, time, rescale and padding from the header.
// Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_header.h"
#include "bricking/import/dicom/dicom_scan.h"

namespace tessera {

/// Tags of stored values (padding, extremes) have the sign of the pixels, whatever the file's own coding.
std::optional<std::int32_t> storedValueOf(std::optional<int> value, const DicomSlice& slice);

/// Fills these members of a slice whose number format is known. An invalid number goes to slice.fault.
void readPlace(const DicomHeader& header, int frame, DicomSlice& slice);

} // namespace tessera
