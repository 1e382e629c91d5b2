// bricking/import/dicom/dicom_place.cpp: see dicom_place.h.
#include "bricking/import/dicom/dicom_place.h"

#include <algorithm>
#include <utility>

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

} // namespace tessera
