// bricking/import/dicom/series_parts.h: series that differ from SeriesInstanceUID. Single slices with a
// series each that form one stack are joined. Series of several frames of reference are split. Private to the
// DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"
#include "bricking/import/dicom/series_agreement.h"

#include <vector>

namespace tessera {

/// Joins series of one slice that form an even stack of three or more to the first of them: some anonymisers
/// give every file its own SeriesInstanceUID. The others are left without slices. Not beside a longer series
/// of such slices, to which they could belong.
/// @param says  of each series, joined too
void joinLoneSlices(std::vector<DicomSeries>& series, std::vector<SeriesAgreement>& says);

/// The series itself, or one for each of its frames of reference, after the checks of series_agreement.h.
std::vector<DicomSeries> partsOf(DicomSeries series, const SeriesAgreement& says);

} // namespace tessera
