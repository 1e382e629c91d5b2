// core/scene/preset.h: the named transfer functions in core/scene/presets/*.json.
#pragma once

#include "core/scene/transfer_function.h"

#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

/// Names, alphabetical: "auto" and those of core/scene/presets/*.json. NAME-1 is an earlier version of NAME.
std::vector<std::string> presetNames();

/// A description of one of them.
std::string presetDescription(const std::string& name);

struct Preset; // core/scene/scene_presets.h
/// One of them with its light, mode and window. "auto" has no function here, because it depends on values.
/// Throws InputError, listing the names and the nearest one, for an unknown name.
Preset builtInPreset(const std::string& name);

/// A value at an end of a volume's range, far from all others: that of voxels without a measurement.
struct FillValue {
    double value = 0; // physical units
    double share = 0; // of the voxels
};

/// Statistics of a volume's values, for adaptive presets ("auto").
struct ValueSummary {
    double lowest = 0, highest = 0; // physical units
    bool isHu = true;
    double spacingMm = 1; // typical voxel size; the unit distance of "auto", so that it suits any scale
    /// Counts over equal bins of [lowest, highest]; empty if unknown.
    std::vector<double> histogram;
    std::vector<FillValue> fills = {}; // none: no value stands alone
    /// Of all other values, where there are fill values.
    struct Measured {
        double lowest = 0, highest = 0;
        std::vector<double> histogram = {};
    } measured = {};
};

/// The summary of the values without fill values; it has none.
ValueSummary withoutFills(ValueSummary values);

/// "-9999, which 21 % of the voxels hold", several joined by "and"; "" where there are none.
std::string sayFills(const std::vector<FillValue>& fills);

/// True if values without a unit look like HU: some are air, between -1100 and -900, and at least three
/// quarters lie between -1100 and 3100. Padding outside the scanner's circle may lie below. It is decided by
/// the histogram's bins, so never certain. Fill values do not count.
bool looksLikeHu(const ValueSummary& values);

/// The least value and the 98th percentile of values above the background, which is the largest peak of the
/// histogram's lower half. Without a histogram the upper four fifths of the range. Never empty. Of values
/// without fill values, as is all that follows them.
glm::dvec2 objectRange(const ValueSummary& values);
/// Converts a preset over shares of a range to one over a volume's values; others are unchanged.
Preset forValues(Preset preset, const ValueSummary& values);

/// Throws InputError, listing the names and the nearest one, for an unknown name. Preset "auto" follows the
/// histogram: transparent below the background peak's upper end, ramps over the quantiles of the rest, dark
/// red to ivory. Fill values are left out, and those above the others are transparent. A volume of one value
/// is transparent. A CT preset on other data is refused with a message
/// that names "auto". Any data suits "auto" and presets over shares (forValues). The others need values in
/// HU, or values that look like HU (looksLikeHu).
TransferFunction presetFunction(const std::string& name, const ValueSummary& values);

} // namespace tessera
