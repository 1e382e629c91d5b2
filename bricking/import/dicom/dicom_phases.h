// bricking/import/dicom/dicom_phases.h: slices of one series that share a position. Duplicates are dropped;
// images of several phases or times become a choice.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// Removes slices whose pixels, position and moment equal those of an earlier one, and returns their number.
/// Reads pixels only for slices at the same position.
std::size_t dropDuplicates(DicomSeries& series);

struct DicomPhase {
    std::string label;               // "phase 40 %", "acquisition 2"; nothing of the date or time of day
    std::vector<std::size_t> slices; // indices into DicomSeries::slices
};

/// The phases of a series in which slices share positions, in order, each with every position at most once.
/// Cardiac phase, temporal position, trigger time, acquisition number or echo distinguish them, else the
/// order of their times. Empty if no positions are shared, or if nothing in the headers distinguishes the
/// images.
std::vector<DicomPhase> phasesOf(const DicomSeries& series);

} // namespace tessera
