// bricking/import/dicom/dicom_remarks.cpp: see dicom_remarks.h.
#include "bricking/import/dicom/dicom_remarks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>

namespace tessera {
namespace {

constexpr double kApart = 1.5; // times the thickness: at this distance slices leave out some of the body
constexpr std::size_t kMostValues = 3;

std::string shown(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

/// The number of slices with each value.
template <class Value, class Of> std::map<Value, std::size_t> tallyOf(const DicomSeries& series, Of of) {
    std::map<Value, std::size_t> tally;
    for (const DicomSlice& slice : series.slices)
        ++tally[of(slice)];
    return tally;
}

template <class Value> Value commonOf(const std::map<Value, std::size_t>& tally) {
    return std::max_element(tally.begin(), tally.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
}

/// "is 1 in 11 slices, 2 in 1 slice", or "has 47 values, 0.5 to 2.5"; "" where all are alike.
template <class Value, class Words>
std::string differing(const std::map<Value, std::size_t>& tally, const Words& words) {
    if (tally.size() < 2)
        return "";
    if (tally.size() > kMostValues)
        return "has " + std::to_string(tally.size()) + " values, " + words(tally.begin()->first) + " to " +
               words(tally.rbegin()->first);
    std::vector<std::pair<std::size_t, std::string>> parts;
    for (const auto& [value, count] : tally)
        parts.emplace_back(count, words(value) + " in " + std::to_string(count) +
                                      (count == 1 ? " slice" : " slices"));
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::string text = "is ";
    for (const auto& [count, part] : parts)
        text += (text.size() > 3 ? ", " : "") + part;
    return text;
}

/// The increment of InstanceNumber from slice to slice in space; nullopt if it is not even.
std::optional<int> instanceStep(const DicomSeries& series, const SlicePlan& plan) {
    std::optional<int> step;
    for (std::size_t n = 1; n < plan.order.size(); ++n) {
        const auto& before = series.slices[static_cast<std::size_t>(plan.order[n - 1])].instance;
        const auto& here = series.slices[static_cast<std::size_t>(plan.order[n])].instance;
        if (!before || !here || (step && *here - *before != *step))
            return std::nullopt;
        step = *here - *before;
    }
    return step ? std::optional(std::abs(*step)) : std::nullopt;
}

/// Gaps between slices, which a scan may have on purpose; or every second slice was left out.
std::string leftOut(const DicomSeries& series, const SlicePlan& plan, bool ofSeveralPhases) {
    const double thickness = series.acquisition.sliceThicknessMm;
    const bool apart = thickness > 0 && plan.gapMm > kApart * thickness;
    const int step = ofSeveralPhases ? 1 : instanceStep(series, plan).value_or(1);
    const bool skips = step > 1 && (apart || !(thickness > 0));
    if (!apart && !skips)
        return "";
    std::string text;
    if (apart)
        text = "slices are " + shown(thickness) + " mm thick and lie " + shown(plan.gapMm) +
               " mm apart: the space between them is not in the scan";
    if (skips)
        text += (apart ? "; " : "") + std::string("InstanceNumber (0020,0013) goes up by ") +
                std::to_string(step) + ": were slices left out?";
    return text;
}

} // namespace

void takeCommonAcquisition(DicomSeries& series) {
    if (series.slices.empty())
        return;
    Acquisition& a = series.acquisition;
    a.kernel = commonOf(tallyOf<std::string>(series, [](const DicomSlice& s) { return s.kernel; }));
    a.tubeVoltageKv = commonOf(tallyOf<double>(series, [](const DicomSlice& s) { return s.tubeVoltageKv; }));
    a.sliceThicknessMm = commonOf(tallyOf<double>(series, [](const DicomSlice& s) { return s.thicknessMm; }));
}

std::vector<std::string> remarksOn(const DicomSeries& series, const SlicePlan& plan, bool ofSeveralPhases) {
    std::vector<std::string> remarks = series.oddities;
    const auto add = [&](const std::string& name, const std::string& differs, const char* meaning) {
        if (!differs.empty())
            remarks.push_back(name + " " + differs + ": " + meaning);
    };
    const char* const byItsOwn = "each slice is read by its own";
    add("RescaleSlope (0028,1053)",
        differing(tallyOf<double>(series, [](const DicomSlice& s) { return s.slope.value_or(1); }), shown),
        byItsOwn);
    add("RescaleIntercept (0028,1052)",
        differing(tallyOf<double>(series, [](const DicomSlice& s) { return s.intercept.value_or(0); }),
                  shown),
        byItsOwn);
    const auto word = [](const std::string& text) { return text.empty() ? "not told" : text; };
    const auto length = [](double value) { return value > 0 ? shown(value) : "not told"; };
    add("the kernel",
        differing(tallyOf<std::string>(series, [](const DicomSlice& s) { return s.kernel; }), word),
        "sharpness and noise change along the stack");
    add("the tube voltage (kV)",
        differing(tallyOf<double>(series, [](const DicomSlice& s) { return s.tubeVoltageKv; }), length),
        "values of contrast and bone change along the stack");
    add("the slice thickness (mm)",
        differing(tallyOf<double>(series, [](const DicomSlice& s) { return s.thicknessMm; }), length),
        "noise and sharpness change along the stack");
    for (const std::string& remark : {leftOut(series, plan, ofSeveralPhases), plan.oddity})
        if (!remark.empty())
            remarks.push_back(remark);
    return remarks;
}

} // namespace tessera
