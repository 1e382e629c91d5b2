// bricking/analysis/lumen/lumen_text.cpp: the text about a lumen and its reliability. See centreline.h.
#include "bricking/analysis/lumen/centreline.h"

#include <cmath>
#include <cstdio>

namespace tessera {
namespace {

constexpr double kClearNoises =
    4; // least distance from the lumen's value to the threshold, in deviations of the remaining noise

/// HU: above fat's, and below those of blood with contrast.
constexpr double kMostFat = -150, kLeastContrast = 100;

std::string valueText(double value, const std::string& unit) {
    char text[48];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text + (unit.empty() ? "" : " " + unit);
}

} // namespace

bool LumenEvidence::clear(double threshold) const {
    return std::abs(threshold - lumen) >= kClearNoises * noiseLeft;
}

std::string lumenText(const Centrelines& found, const std::string& unit) {
    const LumenEvidence& evidence = found.evidence;
    const double threshold = found.lumen.threshold;
    std::string text = "lumen: " + std::string(found.lumen.side == Lumen::Side::below ? "below " : "above ") +
                       valueText(threshold, unit);
    if (evidence.leaksAt && !evidence.leaks)
        text += ", tightened from " + valueText(*evidence.leaksAt, unit) + ", at which it leaks";
    else if (evidence.given)
        text += ", as given";
    else
        text += ", half way from " + valueText(evidence.lumen, "") + " in it to " +
                valueText(evidence.wall, "") + " around it";
    if (found.lumen.branchesTo)
        text += "; thin branches to " + valueText(*found.lumen.branchesTo, unit);
    if (found.lumen.noise > 0)
        text += "; noise of " + valueText(evidence.noise, unit) + ", smoothed to " +
                valueText(evidence.noiseLeft, unit);
    if (evidence.leaks)
        text += "; it leaks: lines may lie outside of it" +
                (found.lumen.leavesAtMm ? " from " + valueText(*found.lumen.leavesAtMm, "mm") + " on" : "") +
                ", and a tighter threshold separates the seeds";
    else if (!evidence.clear(threshold))
        text += "; unsure: it hardly differs from the noise in it";
    if (unit == "HU" && evidence.lumen > kMostFat && evidence.lumen < kLeastContrast)
        text +=
            "; values in it are those of soft tissue, not of air or contrast: the line may be of no organ";
    return text;
}

} // namespace tessera
