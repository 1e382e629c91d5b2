// bricking/import/dicom/dicom_geometry.cpp: see dicom_geometry.h.
#include "bricking/import/dicom/dicom_geometry.h"

#include "bricking/import/source/plausible.h"
#include "bricking/import/source/printable_name.h"
#include "core/error.h"
#include "core/gantry_tilt.h"

#include <algorithm>
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
constexpr double kMostCosine = 0.02;    // 1.1 degrees: a real header's rounding stays below a tenth of it
constexpr double kMostTiltDegrees = 45; // a gantry tilts by 30
constexpr double kMostRounding = 0.1;   // of a gap: beyond, a slice could be misplaced visibly
constexpr double kMostGrowth = 4;       // slices after resampling, per slice before
constexpr int kMostListed = 12;         // runs of gaps in a message

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

/// Every slice has a place, and all agree in everything but position.
Stack checkAlike(const DicomSeries& series, const std::string& where) {
    const DicomSlice& first = series.slices.front();
    for (const DicomSlice& slice : series.slices) {
        for (int axis = 0; slice.positionMm && axis < 3; ++axis)
            if (!(std::abs((*slice.positionMm)[axis]) <= kFarthestMm))
                throw badFile(where, "ImagePositionPatient (0020,0032) within 1e+07 mm of the origin",
                              mm((*slice.positionMm)[axis]) + " mm in " +
                                  printableName(slice.file.filename()));
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
        if (slice.columns != first.columns || slice.rows != first.rows)
            throw badFile(where, "slices of one size",
                          std::to_string(first.columns) + " x " + std::to_string(first.rows) + " and " +
                              std::to_string(slice.columns) + " x " + std::to_string(slice.rows) + " in " +
                              printableName(slice.file.filename()));
        if (glm::length(*slice.rowDirection - *first.rowDirection) > kDirectionTolerance ||
            glm::length(*slice.columnDirection - *first.columnDirection) > kDirectionTolerance)
            throw badFile(where, "slices of one orientation",
                          "another in " + printableName(slice.file.filename()));
        if (glm::length(*slice.spacingMm - *first.spacingMm) > kSpacingTolerance * first.spacingMm->x)
            throw badFile(where, "slices of one pixel spacing",
                          "another in " + printableName(slice.file.filename()));
    }
    Stack stack;
    stack.row = unitDirection(*first.rowDirection, where);
    stack.column = unitDirection(*first.columnDirection, where);
    stack.spacing = *first.spacingMm;
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
                          " slices at the place of another (duplicates, or several time points in one "
                          "series), the first " +
                          pair);
    return distance;
}

/// What the last decimal that the headers give of a position is worth, mm: gaps differ by that much where
/// positions are rounded (0.625 mm between slices, written with two decimals). 0: none that is worth telling.
double roundingOf(const DicomSeries& series) {
    constexpr int kMostDecimals = 4;
    double unit = 1;
    for (int decimals = 0; decimals <= kMostDecimals; ++decimals, unit /= 10) {
        const auto isRound = [unit](double x) {
            return std::abs(x / unit - std::round(x / unit)) < 1e-6 * std::max(1.0, std::abs(x / unit));
        };
        if (std::all_of(series.slices.begin(), series.slices.end(), [&](const DicomSlice& slice) {
                const glm::dvec3 p = *slice.positionMm;
                return isRound(p.x) && isRound(p.y) && isRound(p.z);
            }))
            return decimals == 0 ? 0 : unit;
    }
    return 0;
}

/// The largest distance of a slice from its place in an even stack of the same ends, mm.
double driftAlong(const std::vector<double>& distance) {
    double largest = 0;
    const double step = distance.back() / static_cast<double>(distance.size() - 1);
    for (std::size_t n = 0; n < distance.size(); ++n)
        largest = std::max(largest, std::abs(distance[n] - step * static_cast<double>(n)));
    return largest;
}

/// A straight stack: each position lies on the line from the first to the last, whatever its distance along.
void checkStraight(const DicomSeries& series, const Stack& stack, const SlicePlan& plan,
                   const std::vector<double>& distance, const std::string& where) {
    const auto position = [&](std::size_t n) {
        return *series.slices[static_cast<std::size_t>(plan.order[n])].positionMm;
    };
    const std::size_t last = distance.size() - 1;
    for (std::size_t n = 1; n < last; ++n) {
        const glm::dvec3 expected =
            position(0) + (position(last) - position(0)) * (distance[n] / distance[last]);
        const double drift = glm::length(position(n) - expected);
        if (drift > kDriftTolerance * std::min(stack.spacing.x, stack.spacing.y))
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
    const Stack stack = checkAlike(series, where);
    SlicePlan plan;
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
        // Rounded positions of an even stack: each lies within one rounding of its place.
        const double rounding = roundingOf(series);
        if (rounding > 0 && rounding <= kMostRounding * median &&
            driftAlong(distance) <= rounding * (1 + 1e-6))
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
