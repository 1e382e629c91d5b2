// bricking/import/dicom/series_parts.cpp: see series_parts.h.
#include "bricking/import/dicom/series_parts.h"

#include "bricking/import/dicom/dicom_geometry.h"
#include "core/base/error.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <iterator>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kLeastJoined = 3; // fewer are a choice of slices, not a volume
constexpr double kAlikeSlices = 1e-3;   // of directions and spacings

bool hasPlace(const DicomSlice& slice) {
    return slice.positionMm && slice.rowDirection && slice.spacingMm;
}

/// True if slices could be neighbours: all but the position is the same.
bool alike(const DicomSeries& a, const DicomSeries& b) {
    const DicomSlice &p = a.slices.front(), &q = b.slices.front();
    return a.isScout == b.isScout && a.object == b.object && a.number == b.number && hasPlace(p) &&
           hasPlace(q) && p.columns == q.columns && p.rows == q.rows &&
           glm::length(*p.rowDirection - *q.rowDirection) < kAlikeSlices &&
           glm::length(*p.columnDirection - *q.columnDirection) < kAlikeSlices &&
           glm::length(*p.spacingMm - *q.spacingMm) < kAlikeSlices;
}

bool isEvenStack(const DicomSeries& series) {
    try {
        planSlices(series, false, "");
        return true;
    } catch (const InputError&) {
        return false;
    }
}

} // namespace

void joinLoneSlices(std::vector<DicomSeries>& series, std::vector<SeriesAgreement>& says) {
    std::vector<std::vector<std::size_t>> groups; // of similar lone slices
    for (std::size_t i = 0; i < series.size(); ++i) {
        if (series[i].slices.size() != 1 || series[i].isScout || !series[i].object.empty())
            continue;
        const auto at = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
            return alike(series[group.front()], series[i]);
        });
        if (at == groups.end())
            groups.push_back({i});
        else
            at->push_back(i);
    }
    for (const std::vector<std::size_t>& group : groups) {
        const bool isBesideLonger = std::any_of(series.begin(), series.end(), [&](const DicomSeries& each) {
            return each.slices.size() > 1 && alike(each, series[group.front()]);
        });
        if (group.size() < kLeastJoined || isBesideLonger)
            continue;
        DicomSeries joined = series[group.front()];
        for (std::size_t n = 1; n < group.size(); ++n)
            joined.slices.push_back(series[group[n]].slices.front());
        if (!isEvenStack(joined))
            continue;
        joined.oddities.push_back(
            "every slice has a SeriesInstanceUID of its own: by position they are one series");
        for (std::size_t n = 1; n < group.size(); ++n) {
            series[group[n]].slices.clear();
            says[group.front()].add(says[group[n]]);
        }
        series[group.front()] = std::move(joined);
    }
}

std::vector<DicomSeries> partsOf(DicomSeries series, const SeriesAgreement& says) {
    std::vector<DicomSeries> parts;
    const auto apart = says.framesApart();
    for (std::size_t n = 0; n < apart.size(); ++n) {
        DicomSeries part = series;
        part.slices.clear();
        for (const std::size_t i : apart[n])
            part.slices.push_back(series.slices[i]);
        part.part = "frame of reference " + std::to_string(n + 1) + " of " + std::to_string(apart.size());
        says.of(apart[n]).judge(part);
        parts.push_back(std::move(part));
    }
    if (parts.empty()) {
        says.judge(series);
        parts.push_back(std::move(series));
    }
    return parts;
}

} // namespace tessera
