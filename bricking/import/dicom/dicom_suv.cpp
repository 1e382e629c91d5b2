// bricking/import/dicom/dicom_suv.cpp: see dicom_suv.h.
#include "bricking/import/dicom/dicom_suv.h"

#include "bricking/import/dicom/dicom_objects.h" // hasType

#include <cmath>

namespace tessera {
namespace {

// Bounds of header values; beyond, the units are wrong.
constexpr double kLeastDoseBq = 1e6, kMostDoseBq = 1e11;
constexpr double kLeastKg = 0.01, kMostKg = 650; // from mice to humans
constexpr double kLeastHalfLifeS = 60, kMostHalfLifeS = 1e7;

SuvFactor unknown(const std::string& missing) {
    return {0, missing};
}

bool within(const std::optional<double>& value, double least, double most) {
    return value && *value >= least && *value <= most;
}

} // namespace

SuvFactor suvFactorOf(const DicomHeader& header) {
    if (header.text(DC::Units) != "BQML")
        return unknown("Units (0054,1001) of BQML");
    if (const std::string corrected = header.text(DC::CorrectedImage);
        !hasType(corrected, "ATTN") || !hasType(corrected, "DECY"))
        return unknown("ATTN and DECY in CorrectedImage (0028,0051)");
    const auto weight = header.real(DC::PatientWeight);
    if (!within(weight, kLeastKg, kMostKg))
        return unknown("PatientWeight (0010,1030) in kg");
    const auto tracer = header.itemOf(DC::RadiopharmaceuticalInformationSequence);
    if (!tracer)
        return unknown("one item of RadiopharmaceuticalInformationSequence (0054,0016)");
    const auto dose = tracer->real(DC::RadionuclideTotalDose),
               halfLife = tracer->real(DC::RadionuclideHalfLife);
    if (!within(dose, kLeastDoseBq, kMostDoseBq))
        return unknown("RadionuclideTotalDose (0018,1074) in Bq");
    const double perDose = 1000 * *weight / *dose; // g of body weight count as ml
    const std::string decay = header.text(DC::DecayCorrection);
    if (decay == "ADMIN") // values are those of the injection
        return {perDose, ""};
    if (decay != "START")
        return unknown("DecayCorrection (0054,1102) of START or ADMIN");
    if (!within(halfLife, kLeastHalfLifeS, kMostHalfLifeS))
        return unknown("RadionuclideHalfLife (0018,1075) in s");
    auto injected = tracer->seconds(DC::RadiopharmaceuticalStartDateTime, 0);
    if (!injected)
        injected = tracer->seconds(DC::RadiopharmaceuticalStartTime, 0);
    const auto started = header.seconds(DC::SeriesTime, 0), acquired = header.seconds(DC::AcquisitionTime, 0);
    if (!injected || !started || *started < *injected)
        return unknown("a time of injection (0018,1072) before SeriesTime (0008,0031) on one day");
    if (!acquired || *started > *acquired) // a series that was made later does not tell when the scan began
        return unknown("a SeriesTime (0008,0031) that is not after AcquisitionTime (0008,0032)");
    return {perDose * std::exp2((*started - *injected) / *halfLife), ""};
}

} // namespace tessera
