// bricking/import/dicom/series_parts.cpp: see series_parts.h.
#include "bricking/import/dicom/series_parts.h"

#include "bricking/import/dicom/dicom_geometry.h"
#include "bricking/import/dicom/dicom_remarks.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kVolumeSlices = 3; // fewer under another identifier could be damage of a header

/// The number of slices with each text; slices without a text are left out.
using Tally = std::map<std::string, std::size_t>;

Tally tallyOf(const std::vector<SliceSays>& slices, std::string SliceSays::*text) {
    Tally tally;
    for (const SliceSays& slice : slices)
        if (!(slice.*text).empty())
            ++tally[slice.*text];
    return tally;
}

std::size_t slicesThatSay(const Tally& tally) {
    std::size_t slices = 0;
    for (const auto& [text, count] : tally)
        slices += count;
    return slices;
}

/// An identifier that differs in every slice, as from some anonymisers, identifies nothing.
bool isEverySlicesOwn(const Tally& tally, std::size_t least) {
    return tally.size() >= least && tally.size() == slicesThatSay(tally);
}

std::string missingIn(std::size_t missing, std::size_t of, const std::string& name) {
    return name + " is missing in " + std::to_string(missing) + " of " + std::to_string(of) + " slices";
}

} // namespace

void SeriesAgreement::judge(DicomSeries& series) const {
    const auto disagree = [&](const char* name) {
        if (series.disagreement.empty())
            series.disagreement = name;
    };
    const Tally modalities = tallyOf(slices_, &SliceSays::modality);
    if (modalities.size() > 1)
        disagree("Modality (0008,0060)");
    else if (!modalities.empty())
        series.acquisition.modality = modalityOf(modalities.begin()->first);
    if (const std::size_t said = slicesThatSay(modalities); said > 0 && said < slices_.size())
        series.oddities.push_back(missingIn(slices_.size() - said, slices_.size(), "Modality (0008,0060)") +
                                  ": taken as in the others");

    // HU is the default of CT; any other unit must be in every slice.
    std::map<std::string, int> types;
    for (const SliceSays& slice : slices_)
        ++types[slice.rescaleType == "HU" ? "" : slice.rescaleType];
    if (types.size() > 1)
        disagree("RescaleType (0028,1054)");
    series.isHounsfield = series.acquisition.modality == "CT" && types.size() == 1 &&
                          types.begin()->first.empty() &&
                          std::any_of(slices_.begin(), slices_.end(),
                                      [](const SliceSays& slice) { return slice.hasIntercept; });

    const Tally patients = tallyOf(slices_, &SliceSays::patient);
    if (isEverySlicesOwn(patients, kVolumeSlices))
        series.oddities.push_back("every slice has a PatientID of its own: they are ignored");
    else if (patients.size() > 1)
        disagree("PatientID (0010,0020)");
    else if (const std::size_t said = slicesThatSay(patients); said > 0 && said < slices_.size())
        series.oddities.push_back(missingIn(slices_.size() - said, slices_.size(), "PatientID (0010,0020)"));

    const Tally frames = tallyOf(slices_, &SliceSays::frame);
    if (isEverySlicesOwn(frames, 2))
        series.oddities.push_back("every slice has a FrameOfReferenceUID of its own: they are ignored");
    else if (frames.size() > 1)
        disagree("FrameOfReferenceUID (0020,0052)");
    else if (!frames.empty())
        series.frameOfReference = uidOrNone(frames.begin()->first);
}

std::vector<std::vector<std::size_t>> SeriesAgreement::framesApart() const {
    std::vector<std::string> order; // by their first slice
    std::map<std::string, std::vector<std::size_t>> slices;
    for (std::size_t i = 0; i < slices_.size(); ++i) {
        const std::string& frame = slices_[i].frame;
        if (slices.find(frame) == slices.end())
            order.push_back(frame);
        slices[frame].push_back(i);
    }
    // A slice without one could be of any.
    if (order.size() < 2 || slices.find("") != slices.end() ||
        std::any_of(slices.begin(), slices.end(),
                    [](const auto& frame) { return frame.second.size() < kVolumeSlices; }))
        return {};
    std::vector<std::vector<std::size_t>> apart;
    for (const std::string& frame : order)
        apart.push_back(slices[frame]);
    return apart;
}

void SeriesAgreement::add(const SeriesAgreement& other) {
    slices_.insert(slices_.end(), other.slices_.begin(), other.slices_.end());
}

SeriesAgreement SeriesAgreement::of(const std::vector<std::size_t>& slices) const {
    SeriesAgreement part;
    for (const std::size_t i : slices)
        part.add(slices_[i]);
    return part;
}

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
