// bricking/import/dicom/dicom_phases.h: slices of one series that share a position. Duplicates are dropped;
// images of several phases or times become a choice.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// Removes slices whose pixels, place and moment equal those of an earlier one, and gives their number. Reads
/// pixels only of slices that share a place.
std::size_t dropDuplicates(DicomSeries& series);

struct DicomPhase {
    std::string label;               // "phase 40 %", "acquisition 2"; nothing of the date or time of day
    std::vector<std::size_t> slices; // indices into DicomSeries::slices
};

/// The phases of a series in which slices share places, in their order, each with every place at most once:
/// told apart by cardiac phase, temporal position, trigger time, acquisition number or echo, else by the
/// order of their times. Empty where no places are shared, or where nothing in the headers tells
/// the pictures apart.
std::vector<DicomPhase> phasesOf(const DicomSeries& series);

} // namespace tessera
