// bricking/import/dicom/dicom_suv.h: the factor from a PET's activity to SUV by body weight, if the header
// has all values for it (QIBA, "SUV vendor-neutral pseudo-code"). Weight, dose and times are used and
// forgotten. Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_header.h"

#include <string>

namespace tessera {

struct SuvFactor {
    double perValue = 0; // SUVbw = perValue * value; 0: unknown
    std::string missing; // the reason if unknown: "PatientWeight (0010,1030)", or an invalid value of it
};

/// For a PET image. Nothing is guessed: values in other units, other decay corrections, and missing or
/// implausible doses, weights and times give no factor.
SuvFactor suvFactorOf(const DicomHeader& header);

} // namespace tessera
