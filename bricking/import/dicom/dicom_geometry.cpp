// bricking/import/dicom/dicom_geometry.cpp: see dicom_geometry.h.
#include "bricking/import/dicom/dicom_geometry.h"

#include "bricking/import/source/plausible.h"
#include "bricking/import/source/source_files.h"
#include "core/base/error.h"
#include "core/base/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <numeric>

namespace tessera {
namespace {

constexpr double kGapTolerance = 0.01; // of the median gap; beyond, voxels would be misplaced visibly
constexpr double kDriftAlong = 0.25;   // of a gap: many small deviations must not add up to a squeezed volume
constexpr double kMissingFactor = 1.5; // a gap above this many medians is a missing slice
constexpr double kDirectionTolerance = 1e-3; // of unit vectors; 0.5 mm at the edge of a 500 mm field
constexpr double kSpacingTolerance = 1e-3;   // of the pixel spacing, between slices
constexpr double kDriftTolerance = 0.05;     // of a pixel, sideways from the straight stack
constexpr double kMostCosine = 0.02;      // 1.1 degrees: a real header's rounding stays below a tenth of it
constexpr double kMostTiltDegrees = 45;   // a gantry tilts by 30
constexpr double kMostRounding = 0.1;     // of a gap: beyond, a slice could be misplaced visibly
constexpr double kMostSideways = 1.0 / 3; // of a pixel, for positions that are rounded
constexpr double kMostRoundedDirection = 0.01; // two decimals
constexpr double kMostRoundedSpacing = 0.02;   // of the spacing, and two decimals
constexpr double kRoundingSlack = 1 + 1e-6;    // decimal fractions in binary
constexpr double kMostGrowth = 4;              // largest number of slices after resampling, per slice before
constexpr int kMostListed = 12;                // largest number of runs of gaps in a message

std::string mm(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

struct Stack {
    glm::dvec3 row{1, 0, 0}, column{0, 1, 0}, normal{0, 0, 1};
    glm::dvec2 spacing{1};
};

glm::dvec3 unitDirection(const glm::dvec3& given, const std::string& where) {
    const double length = glm::length(given);
    if (!(std::abs(length - 1) < 0.01))
        throw badFile(where, "ImageOrientationPatient (0020,0037) with directions of length 1",
                      "length " + mm(length));
    return given / length;
}

/// The value of the last decimal of some numbers in a header: 1 for whole ones; 0: finer than `mostDecimals`.
template <class Numbers> double unitOf(const Numbers& numbers, int mostDecimals) {
    double unit = 1;
    for (int decimals = 0; decimals <= mostDecimals; ++decimals, unit /= 10)
        if (std::all_of(numbers.begin(), numbers.end(), [unit](double x) {
                return std::abs(x / unit - std::round(x / unit)) < 1e-6 * std::max(1.0, std::abs(x / unit));
            }))
            return unit;
    return 0;
}

/// The coarsest rounding of directions and pixel spacing of a slice.
struct Rounding {
    double direction = 0, spacing = 0;
};
Rounding roundingOf(const DicomSlice& slice) {
    constexpr int kMostDecimals = 6;
    const glm::dvec3 &r = *slice.rowDirection, &c = *slice.columnDirection;
    const glm::dvec2& s = *slice.spacingMm;
    return {std::min(kMostRoundedDirection, unitOf(std::array{r.x, r.y, r.z, c.x, c.y, c.z}, kMostDecimals)),
            std::min({kMostRoundedDirection, kMostRoundedSpacing * std::min(s.x, s.y),
                      unitOf(std::array{s.x, s.y}, kMostDecimals)})};
}

/// True if two vectors are roundings of one.
template <class Vector> bool roundingExplains(const Vector& a, const Vector& b, double unitA, double unitB) {
    double largest = 0;
    for (int i = 0; i < Vector::length(); ++i)
        largest = std::max(largest, std::abs(a[i] - b[i]));
    return largest <= (unitA + unitB) / 2 * kRoundingSlack;
}

void checkComplete(const DicomSlice& slice, const std::string& where) {
    for (int axis = 0; slice.positionMm && axis < 3; ++axis)
        if (!(std::abs((*slice.positionMm)[axis]) <= kFarthestMm))
            throw badFile(where, "ImagePositionPatient (0020,0032) within 1e+07 mm of the origin",
                          mm((*slice.positionMm)[axis]) + " mm in " + printableName(slice.file.filename()));
    if (!slice.positionMm || !slice.rowDirection || !slice.spacingMm)
        throw badFile(where, "position, orientation and pixel spacing in every slice",
                      printableName(slice.file.filename()) + " without " +
                          (!slice.positionMm     ? "ImagePositionPatient (0020,0032)"
                           : !slice.rowDirection ? "ImageOrientationPatient (0020,0037)"
                                                 : "PixelSpacing (0028,0030)"));
    if (!(slice.spacingMm->x > 0) || !(slice.spacingMm->y > 0))
        throw badFile(where, "PixelSpacing (0028,0030), the pixel spacing, above 0",
                      mm(slice.spacingMm->x) + " x " + mm(slice.spacingMm->y) + " mm in " +
                          printableName(slice.file.filename()));
}

/// Checks that every slice has a position, and that all agree in everything else. Of numbers that are rounded
/// in some slices the finest are taken, as reported in plan.oddity.
Stack checkAlike(const DicomSeries& series, SlicePlan& plan, const std::string& where) {
    const DicomSlice& first = series.slices.front();
    std::vector<Rounding> rounding;
    std::size_t direction = 0, spacing = 0; // of the finest
    for (const DicomSlice& slice : series.slices) {
        checkComplete(slice, where);
        if (slice.columns != first.columns || slice.rows != first.rows)
            throw badFile(where, "slices of one size",
                          std::to_string(first.columns) + " x " + std::to_string(first.rows) + " and " +
                              std::to_string(slice.columns) + " x " + std::to_string(slice.rows) + " in " +
                              printableName(slice.file.filename()));
        rounding.push_back(roundingOf(slice));
        const std::size_t here = rounding.size() - 1;
        if (rounding[here].direction < rounding[direction].direction)
            direction = here;
        if (rounding[here].spacing < rounding[spacing].spacing)
            spacing = here;
    }
    const glm::dvec3 row = *series.slices[direction].rowDirection,
                     column = *series.slices[direction].columnDirection;
    const glm::dvec2 pixel = *series.slices[spacing].spacingMm;
    std::string rounded;
    for (std::size_t i = 0; i < series.slices.size(); ++i) {
        const DicomSlice& slice = series.slices[i];
        const double unit = rounding[i].direction, finest = rounding[direction].direction;
        if (glm::length(*slice.rowDirection - row) > kDirectionTolerance ||
            glm::length(*slice.columnDirection - column) > kDirectionTolerance) {
            if (!roundingExplains(*slice.rowDirection, row, unit, finest) ||
                !roundingExplains(*slice.columnDirection, column, unit, finest))
                throw badFile(where, "slices of one orientation",
                              "another in " + printableName(slice.file.filename()));
            rounded = "ImageOrientationPatient (0020,0037)";
        }
        if (glm::length(*slice.spacingMm - pixel) > kSpacingTolerance * pixel.x) {
            if (!roundingExplains(*slice.spacingMm, pixel, rounding[i].spacing, rounding[spacing].spacing))
                throw badFile(where, "slices of one pixel spacing",
                              "another in " + printableName(slice.file.filename()));
            rounded = "PixelSpacing (0028,0030)";
        }
    }
    if (!rounded.empty())
        plan.oddity = rounded + " is rounded in some slices: that with most decimals is taken for all";
    Stack stack;
    stack.row = unitDirection(row, where);
    stack.column = unitDirection(column, where);
    stack.spacing = pixel;
    const glm::dvec3 normal = glm::cross(stack.row, stack.column);
    if (!(std::abs(glm::dot(stack.row, stack.column)) < kMostCosine))
        throw badFile(
            where, "ImageOrientationPatient (0020,0037) with rows at right angles to columns",
            "an angle of " +
                mm(glm::degrees(std::acos(std::clamp(glm::dot(stack.row, stack.column), -1.0, 1.0)))) +
                " degrees");
    stack.normal = glm::normalize(normal);
    return stack;
}

double medianOf(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// "1-20: 4 mm, 20-21: 1.08 mm, ...": runs of like gaps, slices numbered from 1 in their order in space.
std::string listGaps(const std::vector<double>& gaps, double median) {
    std::string text;
    int listed = 0;
    for (std::size_t begin = 0; begin < gaps.size();) {
        std::size_t end = begin + 1;
        while (end < gaps.size() && std::abs(gaps[end] - gaps[begin]) <= kGapTolerance * gaps[begin])
            ++end;
        if (++listed > kMostListed)
            return text + ", ...";
        text += (text.empty() ? "" : ", ") + std::to_string(begin + 1) + "-" + std::to_string(end + 1) +
                ": " + mm(gaps[begin]) + " mm";
        if (gaps[begin] > kMissingFactor * median)
            text += " (missing slices: about " + std::to_string(std::lround(gaps[begin] / median) - 1) +
                    (end - begin > 1 ? " in each gap)" : ")");
        begin = end;
    }
    return text;
}

/// Distances along the normal from the first slice, ascending, one per slice of plan.order.
std::vector<double> sortAlongNormal(const DicomSeries& series, const Stack& stack, SlicePlan& plan,
                                    const std::string& where) {
    const auto along = [&](int i) {
        return glm::dot(*series.slices[static_cast<std::size_t>(i)].positionMm, stack.normal);
    };
    plan.order.resize(series.slices.size());
    std::iota(plan.order.begin(), plan.order.end(), 0);
    std::stable_sort(plan.order.begin(), plan.order.end(), [&](int a, int b) { return along(a) < along(b); });
    std::vector<double> distance;
    int shared = 0;
    std::string pair; // the first two that share a place
    for (const int i : plan.order) {
        distance.push_back(along(i) - along(plan.order.front()));
        const std::size_t n = distance.size() - 1;
        if (n == 0 || distance[n] - distance[n - 1] >= kSamePlaceMm)
            continue;
        const auto name = [&](int slice) {
            return printableName(series.slices[static_cast<std::size_t>(slice)].file.filename());
        };
        if (++shared == 1)
            pair = name(plan.order[n - 1]) + " and " + name(i);
    }
    if (shared > 0)
        throw badFile(where, "one slice at each position",
                      std::to_string(shared) + " of " + std::to_string(distance.size()) +
                          " slices at the position of another (duplicates, or several time points in one "
                          "series), the first " +
                          pair);
    return distance;
}

/// The largest displacement of each slice of plan.order by rounding, from a straight and even stack with the
/// same ends, mm. It is half a unit of its own last decimal and half of the ends'. 0: no relevant rounding,
/// or displacements above `most`.
std::vector<double> movedByRounding(const DicomSeries& series, const SlicePlan& plan, double most) {
    constexpr int kMostDecimals = 4;
    std::vector<double> units;
    for (const int i : plan.order) {
        const glm::dvec3 p = *series.slices[static_cast<std::size_t>(i)].positionMm;
        const double unit = unitOf(std::array{p.x, p.y, p.z}, kMostDecimals);
        units.push_back(unit < 1 && unit <= most ? unit : 0);
    }
    const double ends = std::max(units.front(), units.back());
    for (double& unit : units)
        unit = (unit + ends) / 2 * kRoundingSlack;
    return units;
}

/// The distance of slice n from its place in an even stack of the same ends, mm.
double driftOf(const std::vector<double>& distance, std::size_t n) {
    const double step = distance.back() / static_cast<double>(distance.size() - 1);
    return std::abs(distance[n] - step * static_cast<double>(n));
}

double driftAlong(const std::vector<double>& distance) {
    double largest = 0;
    for (std::size_t n = 0; n < distance.size(); ++n)
        largest = std::max(largest, driftOf(distance, n));
    return largest;
}

/// True if an even stack with rounded positions could have these gaps.
bool roundingMakesUneven(const DicomSeries& series, const SlicePlan& plan,
                         const std::vector<double>& distance, double medianMm) {
    const std::vector<double> moved = movedByRounding(series, plan, kMostRounding * medianMm);
    for (std::size_t n = 0; n < distance.size(); ++n)
        if (driftOf(distance, n) > std::max(moved[n], kGapTolerance / 2 * medianMm))
            return false;
    return true;
}

/// A straight stack: each position lies on the line from the first to the last, whatever its distance along.
void checkStraight(const DicomSeries& series, const Stack& stack, const SlicePlan& plan,
                   const std::vector<double>& distance, const std::string& where) {
    const auto position = [&](std::size_t n) {
        return *series.slices[static_cast<std::size_t>(plan.order[n])].positionMm;
    };
    const double pixel = std::min(stack.spacing.x, stack.spacing.y);
    const std::vector<double> moved = movedByRounding(series, plan, kMostSideways * pixel);
    const std::size_t last = distance.size() - 1;
    for (std::size_t n = 1; n < last; ++n) {
        const glm::dvec3 expected =
            position(0) + (position(last) - position(0)) * (distance[n] / distance[last]);
        const double drift = glm::length(position(n) - expected);
        if (drift > kDriftTolerance * pixel && !roundingExplains(position(n), expected, moved[n], moved[n]))
            throw badFile(where, "slices stacked along a straight line",
                          "slice " + std::to_string(n + 1) + " shifted sideways by " + mm(drift) + " mm");
    }
}

/// Even samples from the first to the last slice, at most about `stepMm` apart.
void planResampling(const std::vector<double>& distance, double stepMm, SlicePlan& plan) {
    const double span = distance.back();
    const auto count = static_cast<std::size_t>(std::max(1.0, std::round(span / stepMm))) + 1;
    plan.resampled = true;
    std::size_t lower = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double at = span * static_cast<double>(k) / static_cast<double>(count - 1);
        while (lower + 2 < distance.size() && distance[lower + 1] <= at)
            ++lower;
        const double weight = (at - distance[lower]) / (distance[lower + 1] - distance[lower]);
        if (weight >= 1 - 1e-9)
            plan.samples.push_back({static_cast<int>(lower) + 1, 0});
        else
            plan.samples.push_back({static_cast<int>(lower), weight < 1e-9 ? 0 : static_cast<float>(weight)});
    }
}

} // namespace

SlicePlan planSlices(const DicomSeries& series, bool resampleZ, const std::string& where) {
    SlicePlan plan;
    const Stack stack = checkAlike(series, plan, where);
    const std::vector<double> distance = sortAlongNormal(series, stack, plan, where);
    const glm::dvec3 firstMm = *series.slices[static_cast<std::size_t>(plan.order.front())].positionMm;
    const glm::dvec3 lastMm = *series.slices[static_cast<std::size_t>(plan.order.back())].positionMm;
    const auto keepAll = [&] {
        for (std::size_t n = 0; n < distance.size(); ++n)
            plan.samples.push_back({static_cast<int>(n), 0});
    };

    glm::dvec3 sliceStep;
    if (distance.size() == 1) {
        const double thickness = series.acquisition.sliceThicknessMm;
        const double gap = series.betweenSlicesMm > 0 ? series.betweenSlicesMm
                           : thickness > 0            ? thickness
                                                      : 1;
        sliceStep = stack.normal * gap;
        keepAll();
    } else {
        std::vector<double> gaps;
        for (std::size_t n = 1; n < distance.size(); ++n)
            gaps.push_back(distance[n] - distance[n - 1]);
        const double median = medianOf(gaps);
        auto uneven = std::count_if(gaps.begin(), gaps.end(), [&](double gap) {
            return std::abs(gap - median) > kGapTolerance * median;
        });
        plan.gapMm = median;
        if (uneven > 0 && roundingMakesUneven(series, plan, distance, median))
            uneven = 0;
        if (uneven > 0 && !resampleZ)
            throw badFile(where, "evenly spaced slices (within 1 % of the median gap, " + mm(median) + " mm)",
                          std::to_string(uneven) + " of " + std::to_string(gaps.size()) +
                              " gaps that are not: " + listGaps(gaps, median) +
                              "; --resample-z interpolates to an even spacing");
        const bool drifts = driftAlong(distance) > kDriftAlong * median;
        if (drifts && !resampleZ)
            throw badFile(where, "evenly spaced slices (gaps of " + mm(median) + " mm)",
                          "gaps that change slowly, so that a slice is " + mm(driftAlong(distance)) +
                              " mm from its place: " + listGaps(gaps, median) +
                              "; --resample-z interpolates to an even spacing");
        checkStraight(series, stack, plan, distance, where);
        if (uneven > 0 || drifts) {
            const double smallest = *std::min_element(gaps.begin(), gaps.end());
            const double mean = distance.back() / static_cast<double>(gaps.size());
            planResampling(distance, std::max(smallest, mean / kMostGrowth), plan);
        } else {
            keepAll();
        }
        sliceStep = (lastMm - firstMm) / static_cast<double>(plan.samples.size() - 1);
    }
    plan.patientFromVoxel =
        patientFromVoxelOf(firstMm, stack.row * stack.spacing.x, stack.column * stack.spacing.y, sliceStep);
    plan.tiltDegrees = gantryTiltDegrees(plan.patientFromVoxel);
    if (!(std::abs(plan.tiltDegrees) <= kMostTiltDegrees))
        throw badFile(
            where,
            "slices stacked within 45 degrees of their normal (ImageOrientationPatient (0020,0037) and "
            "ImagePositionPatient (0020,0032); a gantry tilts by 30)",
            "a skew of " + mm(std::abs(plan.tiltDegrees)) + " degrees");
    return plan;
}

} // namespace tessera
