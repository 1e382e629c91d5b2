// bricking/import/dicom/series_parts.h: series that differ from SeriesInstanceUID. Single slices with a
// series each that form one stack are joined. Series of several frames of reference are split. Private to the
// DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

// Elements that must be equal in all slices of a series. Identifiers are compared here and never leave this
// file's types, but for the one frame of reference of a series. Private to the DICOM importer.

/// An empty text is absent: it equals everything.
struct SliceSays {
    std::string modality, rescaleType, patient, frame; // frame: of reference
    bool hasIntercept = false;
};

class SeriesAgreement {
  public:
    /// In the order of the series' slices.
    void add(SliceSays slice) { slices_.push_back(std::move(slice)); }
    void add(const SeriesAgreement& other);
    /// Fills modality, isHounsfield, frameOfReference, disagreement and oddities of the series.
    void judge(DicomSeries& series) const;
    /// Positions in two frames of reference are unrelated: if each of several has enough slices for a volume,
    /// they are separate series. Returns a group of slice indices for each; empty: the series stays whole.
    std::vector<std::vector<std::size_t>> framesApart() const;
    SeriesAgreement of(const std::vector<std::size_t>& slices) const;

  private:
    std::vector<SliceSays> slices_;
};

/// Joins series of one slice that form an even stack of three or more to the first of them: some anonymisers
/// give every file its own SeriesInstanceUID. The others are left without slices. Not beside a longer series
/// of such slices, to which they could belong.
/// @param says  of each series, joined too
void joinLoneSlices(std::vector<DicomSeries>& series, std::vector<SeriesAgreement>& says);

/// The series itself, or one for each of its frames of reference, after the checks above.
std::vector<DicomSeries> partsOf(DicomSeries series, const SeriesAgreement& says);

} // namespace tessera
