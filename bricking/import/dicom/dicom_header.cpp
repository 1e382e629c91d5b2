// bricking/import/dicom/dicom_header.cpp: see dicom_header.h.
#include "bricking/import/dicom/dicom_header.h"

#include "bricking/import/dicom/dicom_remarks.h" // hasType

#include <algorithm>
#include <cmath>
#include <utility>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

namespace tessera {
namespace {

SliceMoment readMoment(const DicomHeader& header, int frame) {
    SliceMoment moment;
    moment.cardiacPercent = header.real(DC::NominalPercentageOfCardiacPhase, frame);
    moment.triggerMs = header.real(DC::TriggerTime, frame);
    moment.temporalPosition = header.integer(DC::TemporalPositionIdentifier, frame);
    if (!moment.temporalPosition)
        moment.temporalPosition = header.integer(DC::TemporalPositionIndex, frame);
    moment.acquisition = header.integer(DC::AcquisitionNumber, frame);
    moment.echo = header.integer(DC::EchoNumbers, frame);
    moment.acquisitionSecond = header.seconds(DC::AcquisitionTime, frame);
    moment.contentSecond = header.seconds(DC::ContentTime, frame);
    return moment;
}

} // namespace

std::optional<std::int32_t> storedValueOf(std::optional<int> value, const DicomSlice& slice) {
    if (!value)
        return std::nullopt;
    const int bits = *value & 0xffff;
    return slice.isSigned && bits >= 0x8000 ? bits - 0x10000 : bits;
}

void readPlace(const DicomHeader& header, int frame, DicomSlice& slice) {
    slice.positionMm = slice.rowDirection = slice.columnDirection = std::nullopt;
    slice.spacingMm = std::nullopt;
    std::optional<HeaderFault>& fault = slice.fault;
    fault.reset();
    if (const auto p =
            header.reals<3>(DC::ImagePositionPatient, frame, "ImagePositionPatient (0020,0032)", fault))
        slice.positionMm = glm::dvec3((*p)[0], (*p)[1], (*p)[2]);
    if (const auto o = header.reals<6>(DC::ImageOrientationPatient, frame,
                                       "ImageOrientationPatient (0020,0037)", fault)) {
        slice.rowDirection = glm::dvec3((*o)[0], (*o)[1], (*o)[2]);
        slice.columnDirection = glm::dvec3((*o)[3], (*o)[4], (*o)[5]);
    }
    // PixelSpacing is the distance between rows, then between columns.
    if (const auto s = header.reals<2>(DC::PixelSpacing, frame, "PixelSpacing (0028,0030)", fault))
        slice.spacingMm = glm::dvec2((*s)[1], (*s)[0]);
    slice.slope = header.real(DC::RescaleSlope, frame, "RescaleSlope (0028,1053)", fault);
    slice.intercept = header.real(DC::RescaleIntercept, frame, "RescaleIntercept (0028,1052)", fault);
    slice.moment = readMoment(header, frame);
    slice.kernel = codeWord(header.text(DC::ConvolutionKernel, frame));
    slice.tubeVoltageKv = std::max(0.0, header.real(DC::KVP, frame).value_or(0));
    slice.thicknessMm = std::max(0.0, header.real(DC::SliceThickness, frame).value_or(0));
    slice.instance = header.integer(DC::InstanceNumber, frame);
    slice.paddingFirst = storedValueOf(header.integer(DC::PixelPaddingValue, frame), slice);
    slice.paddingLast = storedValueOf(header.integer(DC::PixelPaddingRangeLimit, frame), slice);
    if (!slice.paddingLast)
        slice.paddingLast = slice.paddingFirst;
    if (slice.paddingFirst && *slice.paddingLast < *slice.paddingFirst)
        std::swap(slice.paddingFirst, slice.paddingLast);
}

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

namespace {

class SilentWindow final : public vtkOutputWindow {
  public:
    static SilentWindow* New();
    vtkTypeMacro(SilentWindow, vtkOutputWindow) void DisplayText(const char*) override {}
    void DisplayErrorText(const char*) override {}
    void DisplayWarningText(const char*) override {}
    void DisplayGenericWarningText(const char*) override {}
    void DisplayDebugText(const char*) override {}
};
vtkStandardNewMacro(SilentWindow)

} // namespace

struct QuietVtk::State {
    vtkSmartPointer<SilentWindow> silent = vtkSmartPointer<SilentWindow>::New();
    vtkSmartPointer<vtkOutputWindow> before;
};

QuietVtk::QuietVtk() : state_(std::make_unique<State>()) {
    state_->before = vtkOutputWindow::GetInstance();
    vtkOutputWindow::SetInstance(state_->silent);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF); // VTK 9 logs beside the output window
}

QuietVtk::~QuietVtk() {
    vtkOutputWindow::SetInstance(state_->before);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_INFO); // VTK's default; it cannot be asked
}

} // namespace tessera
