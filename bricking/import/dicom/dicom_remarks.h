// bricking/import/dicom/dicom_remarks.h: remarks about a series: harmless irregularities that are accepted,
// reported once and kept in the store. Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_geometry.h"
#include "bricking/import/dicom/dicom_scan.h"

#include <string>
#include <vector>

namespace tessera {

/// For the slices of the volume, one per line; quotes only numbers and code words.
/// @param ofSeveralPhases  other images at the same positions were left out
std::vector<std::string> remarksOn(const DicomSeries& series, const SlicePlan& plan, bool ofSeveralPhases);

/// The kernel, voltage and thickness of most slices.
void takeCommonAcquisition(DicomSeries& series);

} // namespace tessera
