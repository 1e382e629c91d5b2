// core/scene/preset.cpp: see preset.h. The CT presets are data (core/scene/presets/*.json, compiled in);
// "auto" is made from what is known of the values.
#include "core/scene/preset.h"

#include "core/base/embedded.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/base/shown_text.h"
#include "core/scene/scene_presets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace tessera {
namespace presets {
const EmbeddedFiles& embeddedFiles(); // generated from core/scene/presets/*.json
}
namespace {

constexpr const char* kAuto = "auto";
constexpr double kLeastPart = 0.02; // of the range: of a ramp

/// The upper end of the background, as an index of the first bin above it. The background is the largest peak
/// of the lower half of the range: air around the object, or nothing at all. It ends where the counts have
/// fallen to kTail of the peak, or where they rise again towards something else.
std::size_t endOfBackground(const std::vector<double>& histogram) {
    constexpr double kTail = 0.02; // a noisy peak's flank at about 2.8 standard deviations
    constexpr double kRise = 1.25; // more than the scatter of neighbouring bins
    const std::size_t bins = histogram.size();
    const auto half = histogram.begin() + static_cast<std::ptrdiff_t>((bins + 1) / 2);
    const auto peak = std::max_element(histogram.begin(), half);
    std::size_t i = static_cast<std::size_t>(peak - histogram.begin());
    while (i + 1 < bins && histogram[i + 1] > kTail * *peak && histogram[i + 1] <= kRise * histogram[i])
        ++i;
    return std::min(i + 1, bins - 1);
}

/// The value below which a fraction of the counts of bins [first, bins) lies, linear within a bin.
double quantile(const ValueSummary& values, std::size_t first, double fraction) {
    const std::vector<double>& histogram = values.histogram;
    const double width = (values.highest - values.lowest) / static_cast<double>(histogram.size());
    const double total =
        std::accumulate(histogram.begin() + static_cast<std::ptrdiff_t>(first), histogram.end(), 0.0);
    double left = fraction * total;
    for (std::size_t i = first; i < histogram.size(); ++i) {
        if (left <= histogram[i] && histogram[i] > 0)
            return values.lowest + width * (static_cast<double>(i) + left / histogram[i]);
        left -= histogram[i];
    }
    return values.highest;
}

/// The least value of an object, its median, and its largest value without the brightest.
struct ObjectValues {
    double start, middle, top;
};

ObjectValues objectValues(const ValueSummary& values) {
    const double range = values.highest - values.lowest;
    ObjectValues of{values.lowest + 0.2 * range, values.lowest + 0.5 * range, values.highest};
    if (!values.histogram.empty()) {
        const std::size_t first = endOfBackground(values.histogram);
        of.start =
            values.lowest + range * static_cast<double>(first) / static_cast<double>(values.histogram.size());
        of.middle = quantile(values, first, 0.5);
        of.top = quantile(values, first, 0.98); // the last percents are often a few very bright voxels
    }
    // An object of a single value would fold the ramp into a step; keep some width for the surface to show
    // in.
    const double least = kLeastPart * range;
    of.middle = std::min(std::max(of.middle, of.start + least), kLargestValue);
    of.top = std::min(std::max(of.top, of.middle + least), kLargestValue);
    return of;
}

TransferFunction autoFunction(const ValueSummary& all) {
    const ValueSummary values = withoutFills(all);
    if (!(values.highest > values.lowest))
        return TransferFunction::fromOpacity({}, {}, values.spacingMm, kAuto);
    const auto [start, middle, top] = objectValues(values);
    std::vector<OpacityPoint> opacity = {
        {start, 0}, {0.5 * (start + middle), 0.015}, {middle, 0.05}, {0.5 * (middle + top), 0.2}, {top, 0.6}};
    if (std::ranges::any_of(all.fills, [most = top](const FillValue& fill) { return fill.value > most; })) {
        // Beyond the measured values are fill values alone, and what lies between them and their neighbours.
        const double end = std::max(top, values.highest);
        if (end > top)
            opacity.push_back({end, 0.6});
        opacity.push_back({end + kLeastPart * (values.highest - values.lowest), 0});
    }
    const std::vector<ColourPoint> colour = {{start, {0.18, 0.03, 0.02}},
                                             {middle, {0.55, 0.20, 0.09}},
                                             {0.5 * (middle + top), {0.80, 0.55, 0.32}},
                                             {top, {0.95, 0.90, 0.80}}};
    return TransferFunction::fromOpacity(opacity, colour, values.spacingMm, kAuto);
}

} // namespace

std::string presetDescription(const std::string& name) {
    const auto found = presets::embeddedFiles().find(name + ".json");
    return found == presets::embeddedFiles().end()
               ? "Adapts to the volume's values: those above the background, dark red to ivory."
               : parsePreset(std::string(found->second), name, "preset " + name).description;
}

std::vector<std::string> presetNames() {
    std::vector<std::string> names = {kAuto};
    for (const auto& [file, text] : presets::embeddedFiles())
        names.emplace_back(file.substr(0, file.rfind('.')));
    std::sort(names.begin(), names.end());
    return names;
}

ValueSummary withoutFills(ValueSummary values) {
    if (values.fills.empty())
        return values;
    values.lowest = values.measured.lowest;
    values.highest = values.measured.highest;
    values.histogram = std::move(values.measured.histogram);
    values.fills.clear();
    values.measured = {};
    return values;
}

std::string sayFills(const std::vector<FillValue>& fills) {
    constexpr int kDigits = 6, kDigitsOfShare = 2;
    constexpr double kLeastPercent = 0.001;
    std::string text;
    for (const FillValue& fill : fills) {
        const double percent = 100 * fill.share;
        text += (text.empty() ? "" : " and ") + numberText(fill.value, kDigits) + ", which " +
                (percent < kLeastPercent ? "less than 0.001" : numberText(percent, kDigitsOfShare)) +
                " % of the voxels hold";
    }
    return text;
}

bool looksLikeHu(const ValueSummary& values) {
    if (!values.fills.empty())
        return looksLikeHu(withoutFills(values));
    constexpr double kAirLeast = -1100, kAirMost = -900, kBodyMost = 3100; // HU
    constexpr double kSomeAir = 0.02, kMost = 0.75;                        // of the voxels
    const double width = (values.highest - values.lowest) / static_cast<double>(values.histogram.size());
    double all = 0, air = 0, body = 0;
    for (std::size_t bin = 0; bin < values.histogram.size(); ++bin) {
        const double begin = values.lowest + width * static_cast<double>(bin), end = begin + width;
        all += values.histogram[bin];
        air += end >= kAirLeast && begin <= kAirMost ? values.histogram[bin] : 0;
        body += end >= kAirLeast && begin <= kBodyMost ? values.histogram[bin] : 0;
    }
    return all > 0 && width > 0 && air >= kSomeAir * all && body >= kMost * all;
}

Preset builtInPreset(const std::string& name) {
    if (name == kAuto)
        return {name, presetDescription(name), PresetUnit::any, {}, "{}"};
    const auto found = presets::embeddedFiles().find(name + ".json");
    if (found == presets::embeddedFiles().end()) {
        const std::vector<std::string> names = presetNames();
        throw badFile("preset", "one of " + joinNames(names),
                      "\"" + name.substr(0, 40) + "\"; nearest: \"" + nearestName(name, names) + "\"");
    }
    return parsePreset(std::string(found->second), name, "preset " + name);
}

glm::dvec2 objectRange(const ValueSummary& all) {
    const ValueSummary values = withoutFills(all);
    if (!(values.highest > values.lowest))
        return {values.lowest, std::nextafter(values.lowest, 1e300)};
    const ObjectValues of = objectValues(values);
    return {of.start, of.top};
}

Preset forValues(Preset preset, const ValueSummary& all) {
    const ValueSummary values = withoutFills(all);
    const glm::dvec2 range =
        preset.unit == PresetUnit::object
            ? objectRange(values)
            : glm::dvec2(values.lowest, std::max(values.highest, std::nextafter(values.lowest, 1e300)));
    return overShares(preset) ? overRange(std::move(preset), range.x, range.y) : preset;
}

TransferFunction presetFunction(const std::string& name, const ValueSummary& values) {
    if (name == kAuto)
        return autoFunction(values);
    const Preset preset = builtInPreset(name);
    if (overShares(preset))
        return forValues(preset, values).function;
    if (!values.isHu && !looksLikeHu(values))
        throw badFile("preset " + name, "values in HU",
                      "values without a unit that do not look like HU; --unit HU takes them for HU, and the "
                      "preset \"auto\" suits any");
    return preset.function;
}

} // namespace tessera
