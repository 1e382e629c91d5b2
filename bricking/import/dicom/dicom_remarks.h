// bricking/import/dicom/dicom_remarks.h: remarks about a series: harmless oddities that are accepted, said
// once and kept in the store. Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_geometry.h"
#include "bricking/import/dicom/dicom_scan.h"

#include <string>
#include <vector>

namespace tessera {

/// Of the slices that make the volume, a line each; quotes numbers and code words alone.
/// @param ofSeveralPhases  other pictures of the same places were left out
std::vector<std::string> remarksOn(const DicomSeries& series, const SlicePlan& plan, bool ofSeveralPhases);

/// The kernel, voltage and thickness that most slices have.
void takeCommonAcquisition(DicomSeries& series);

} // namespace tessera
