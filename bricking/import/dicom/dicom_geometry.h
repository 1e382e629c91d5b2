// bricking/import/dicom/dicom_geometry.h: the order, the affine and, on request, the resampling along z of a
// series, from its slices' positions. Slices that form no even volume are refused with the reason in numbers.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

namespace tessera {

/// Slices nearer than this have one position: headers are written with 3 to 7 decimals.
constexpr double kSamePlaceMm = 1e-3;

/// One slice of the result: (1-weight) * slice[lower] + weight * slice[lower+1], in sorted order.
struct SliceSample {
    int lower = 0;
    float weight = 0; // in [0,1); 0: the slice itself
};

struct SlicePlan {
    std::vector<int> order;           // indices into DicomSeries::slices, along row x column, ascending
    std::vector<SliceSample> samples; // one per slice of the volume
    glm::dmat4 patientFromVoxel{1};
    double tiltDegrees = 0; // gantryTiltDegrees() of the affine
    bool resampled = false;
    double gapMm = 0;   // the median of the gaps between slices; 0: a single slice
    std::string oddity; // rounded orientations or spacings in some slices; "" none
};

/// Orders the slices by position and checks them; `where` names the series in errors.
/// A gap between neighbours may deviate by 1 % from the median gap, and a slice by a quarter of a gap from
/// its place in an even stack. For larger deviations resampleZ chooses an even spacing. It is the smallest
/// gap, so that no slice is lost, but at least a quarter of the mean gap, so that the volume grows fourfold
/// at most. It is then stretched by less than one gap in total, so that the first and last slice are kept.
/// Throws InputError for missing position, orientation or spacing, for mixed sizes, orientations or pixel
/// spacings, and for two slices at one position. Throws it for uneven gaps without resampleZ: all are listed,
/// those above 1.5 medians named as missing slices. Throws it for slices that drift sideways by more than 5 %
/// of a pixel from a straight stack, and for rows not at right angles to columns. Throws it for a stack that
/// leans by more than 45 degrees. Deviations within the rounding of a slice's own numbers are no fault.
SlicePlan planSlices(const DicomSeries& series, bool resampleZ, const std::string& where);

} // namespace tessera
