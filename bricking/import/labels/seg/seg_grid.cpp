// bricking/import/labels/seg/seg_grid.cpp: see seg_grid.h.
#include "bricking/import/labels/seg/seg_grid.h"

#include "bricking/import/source/plausible.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>

namespace tessera {
namespace {

constexpr double kSamePlaceMm = 1e-3; // of positions, which are rounded texts
constexpr double kMostUneven = 0.02;  // of a distance, between neighbours
constexpr double kMostOff = 0.05;     // of a distance, from the slice
constexpr int kMostSlices = 32768;

/// Steps from each of ascending heights to the next in units of a pitch; nullopt: not whole.
std::optional<std::vector<int>> wholeSteps(const std::vector<double>& heights, double pitch) {
    std::vector<int> steps;
    double all = 0;
    for (std::size_t i = 1; i < heights.size(); ++i) {
        const double step = (heights[i] - heights[i - 1]) / pitch, whole = std::round(step);
        // A rounded pitch errs in proportion to the step.
        all += whole;
        if (whole < 1 || all >= kMostSlices ||
            std::abs(step - whole) > kMostUneven * std::max(1.0, whole / 10))
            return std::nullopt;
        steps.push_back(static_cast<int>(whole));
    }
    return steps;
}

} // namespace

SegGrid segGridOf(const SegObject& seg) {
    const std::string where = seg.file.string();
    const glm::dvec3 normal = glm::cross(seg.rowDirection, seg.columnDirection);
    const auto heightOf = [&](const SegFrame& frame) { return glm::dot(normal, frame.positionMm); };
    std::vector<std::size_t> order(seg.frames.size()); // by height
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return heightOf(seg.frames[a]) < heightOf(seg.frames[b]);
    });
    std::vector<double> heights; // different ones
    for (const std::size_t i : order)
        if (const double height = heightOf(seg.frames[i]);
            heights.empty() || height - heights.back() > kSamePlaceMm)
            heights.push_back(height);

    SegGrid grid;
    double pitch = seg.betweenSlicesMm > 0 ? seg.betweenSlicesMm : seg.thicknessMm;
    std::optional<std::vector<int>> steps;
    if (heights.size() > 1) {
        double least = std::numeric_limits<double>::infinity(), most = 0;
        for (std::size_t i = 1; i < heights.size(); ++i) {
            least = std::min(least, heights[i] - heights[i - 1]);
            most = std::max(most, heights[i] - heights[i - 1]);
        }
        if (seg.betweenSlicesMm > 0)
            steps = wholeSteps(heights, seg.betweenSlicesMm);
        if (!steps)
            steps = wholeSteps(heights, least);
        if (!steps)
            throw badFile(where,
                          "frames at multiples of one distance (ImagePositionPatient along the normal)",
                          "distances from " + numberText(least) + " to " + numberText(most) + " mm");
        const int all = std::accumulate(steps->begin(), steps->end(), 0);
        pitch = (heights.back() - heights.front()) / all;
        grid.info.extentVoxels.z = all + 1;
    } else {
        grid.info.extentVoxels.z = 1;
        if (!(pitch > 0)) {
            pitch = 1;
            grid.notes.emplace_back("the only slice has no thickness; it is taken as 1 mm");
        }
    }
    grid.info.extentVoxels.x = seg.columns;
    grid.info.extentVoxels.y = seg.rows;

    const glm::dvec3 first = seg.frames[order.front()].positionMm, last = seg.frames[order.back()].positionMm;
    const int slices = grid.info.extentVoxels.z;
    const glm::dvec3 step = slices > 1 ? (last - first) / static_cast<double>(slices - 1) : normal * pitch;
    const double mostOff = kMostOff * std::min({pitch, seg.spacingMm.x, seg.spacingMm.y}) + kSamePlaceMm;
    grid.sliceOf.resize(seg.frames.size());
    for (std::size_t i = 0; i < seg.frames.size(); ++i) {
        const SegFrame& frame = seg.frames[i];
        const double height = (heightOf(frame) - heights.front()) / pitch;
        const int slice = std::clamp(static_cast<int>(std::lround(height)), 0, slices - 1);
        const glm::dvec3 off = frame.positionMm - (first + static_cast<double>(slice) * step);
        if (glm::length(off) > mostOff)
            throw badFile(where, "frames above one another, at even distances",
                          "frame " + std::to_string(i + 1) + " off by " + numberText(glm::length(off)) +
                              " mm");
        grid.sliceOf[i] = slice;
    }
    grid.info.type = ValueType::u16; // labels have no type
    grid.info.patientFromVoxel = patientFromVoxelOf(first, seg.rowDirection * seg.spacingMm.x,
                                                    seg.columnDirection * seg.spacingMm.y, step);
    requirePlausibleGeometry(grid.info,
                             {"PixelSpacing (0028,0030)", "ImageOrientationPatient (0020,0037)",
                              "ImagePositionPatient (0020,0032)"},
                             where);
    grid.info.validate(where);
    return grid;
}

} // namespace tessera
