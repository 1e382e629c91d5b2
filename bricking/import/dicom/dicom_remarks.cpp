// bricking/import/dicom/dicom_remarks.cpp: see dicom_remarks.h.
#include "bricking/import/dicom/dicom_remarks.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>

namespace tessera {

// The numbers are those of DICOM PS3.4, table B.5-1.

namespace {

const std::string kRoot = "1.2.840.10008.5.1.4.1.1.";

constexpr std::array kSliceClasses = {"2", "2.1", "2.2", "4", "4.1", "4.4", "128", "130", "13.1.1", "128.1"};

// Defined terms of Modality (0008,0060), DICOM PS3.3, C.7.3.1.1.1, retired ones too.
constexpr std::array kModalities = {
    "ANN", "AR",     "ASMT",    "AU",         "BDUS",   "BI",    "BMD",      "CD",         "CFM",      "CP",
    "CR",  "CS",     "CT",      "CTPROTOCOL", "DD",     "DF",    "DG",       "DM",         "DMS",      "DOC",
    "DS",  "DX",     "EC",      "ECG",        "EEG",    "EMG",   "EOG",      "EPS",        "ES",       "FA",
    "FID", "FS",     "GM",      "HC",         "HD",     "IO",    "IOL",      "IVOCT",      "IVUS",     "KER",
    "KO",  "LEN",    "LP",      "LS",         "M3D",    "MA",    "MG",       "MR",         "MS",       "NM",
    "OAM", "OCT",    "OP",      "OPM",        "OPR",    "OPT",   "OPTBSV",   "OPTENF",     "OPV",      "OSS",
    "OT",  "PA",     "PLAN",    "POS",        "PR",     "PT",    "PX",       "REG",        "RESP",     "RF",
    "RG",  "RTDOSE", "RTIMAGE", "RTINTENT",   "RTPLAN", "RTRAD", "RTRECORD", "RTSEGANN",   "RTSTRUCT", "RWV",
    "SEG", "SM",     "SMR",     "SR",         "SRF",    "ST",    "STAIN",    "TEXTUREMAP", "TG",       "US",
    "VA",  "VF",     "XA",      "XAPROTOCOL", "XC"};

struct Words {
    const char* begins; // after kRoot; a whole number or parts of it, separated by points
    const char* words;
};
// The longer beginnings come first.
constexpr std::array kWords = {Words{"88.67", "dose report"},
                               Words{"88.68", "dose report"},
                               Words{"88.73", "dose report"},
                               Words{"88.74", "dose report"},
                               Words{"88.59", "key object selection"},
                               Words{"88", "structured report"},
                               Words{"104.1", "PDF document"},
                               Words{"104", "document"},
                               Words{"11", "presentation state"},
                               Words{"66.4", "segmentation"},
                               Words{"66.5", "surface segmentation"},
                               Words{"66", "raw data"},
                               Words{"67", "real-world value mapping"},
                               Words{"481.1", "radiotherapy image"},
                               Words{"481.2", "radiotherapy dose"},
                               Words{"481.3", "radiotherapy structure set"},
                               Words{"481", "radiotherapy object"},
                               Words{"7", "secondary capture"},
                               Words{"9", "waveform"},
                               Words{"12", "X-ray angiogram"},
                               Words{"1.1", "digital radiograph"},
                               Words{"1.2", "mammogram"},
                               Words{"1", "radiograph"},
                               Words{"3", "ultrasound"},
                               Words{"6", "ultrasound"},
                               Words{"20", "nuclear medicine image"},
                               Words{"77", "photograph or video"}};

bool beginsWithParts(const std::string& uid, const std::string& parts) {
    return uid.rfind(parts, 0) == 0 && (uid.size() == parts.size() || uid[parts.size()] == '.');
}

} // namespace

bool isSliceClass(const std::string& storageClass) {
    return std::any_of(kSliceClasses.begin(), kSliceClasses.end(),
                       [&](const char* item) { return storageClass == kRoot + item; });
}

std::string modalityOf(const std::string& text) {
    const bool known =
        std::any_of(kModalities.begin(), kModalities.end(), [&](const char* item) { return text == item; });
    return known ? text : "";
}

std::string objectWords(const std::string& storageClass) {
    if (storageClass == "1.2.840.10008.1.3.10")
        return "DICOMDIR";
    if (isSliceClass(storageClass))
        return "";
    const auto at = std::find_if(kWords.begin(), kWords.end(), [&](const Words& row) {
        return beginsWithParts(storageClass, kRoot + row.begins);
    });
    return at == kWords.end() ? "" : at->words;
}

bool hasType(const std::string& imageType, const std::string& word) {
    std::string plain = "\\"; // in capitals, without the blanks that some writers put around each value
    for (const char c : imageType)
        if (c != ' ')
            plain += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return (plain + "\\").find("\\" + word + "\\") != std::string::npos;
}

std::string derivationOf(const std::string& imageType) {
    for (const char* word : {"MPR", "CPR", "REFORMATTED", "MIP", "MINIP", "MIN_IP", "AVERAGE", "SUBTRACTION"})
        if (hasType(imageType, word))
            return word;
    return "";
}

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
