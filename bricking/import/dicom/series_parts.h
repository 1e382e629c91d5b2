// bricking/import/dicom/series_parts.h: series that SeriesInstanceUID does not describe. Single slices that
// each name a series of their own and make one stack are joined. Series of several frames of reference are
// split. Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"
#include "bricking/import/dicom/series_agreement.h"

#include <vector>

namespace tessera {

/// Series of one slice that make an even stack of three or more are joined to the first of them, as some who
/// take names out give every file a SeriesInstanceUID of its own; the others are left without slices. Not
/// beside a longer series of such slices, which they could be strays of.
/// @param says  of each series, joined too
void joinLoneSlices(std::vector<DicomSeries>& series, std::vector<SeriesAgreement>& says);

/// The series itself, or one for each of its frames of reference; judged.
std::vector<DicomSeries> partsOf(DicomSeries series, const SeriesAgreement& says);

} // namespace tessera
