// bricking/import/dicom/dicom_suv.h: the factor from a PET's activity to SUV by body weight, where the header
// has all that it takes (QIBA, "SUV vendor-neutral pseudo-code"). Weight, dose and times are used and
// forgotten. Private to the DICOM importer.
#pragma once

#include "bricking/import/dicom/dicom_header.h"

#include <string>

namespace tessera {

struct SuvFactor {
    double perValue = 0; // SUVbw = perValue * value; 0: not known
    std::string missing; // why not: "PatientWeight (0010,1030)", or what of it means nothing
};

/// Of a PET image. Nothing is guessed: values in other units, other decay corrections, and doses, weights and
/// times that are missing or implausible give none.
SuvFactor suvFactorOf(const DicomHeader& header);

} // namespace tessera
