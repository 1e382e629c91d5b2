// core/scene/preset.h: the named transfer functions in core/scene/presets/*.json.
#pragma once

#include "core/scene/transfer_function.h"

#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

/// Names, alphabetical: "auto" and those of core/scene/presets/*.json. NAME-1 is what NAME was before it
/// changed.
std::vector<std::string> presetNames();

/// A sentence or two on one of them.
std::string presetDescription(const std::string& name);

struct Preset; // core/scene/preset_file.h
/// One of them with all that it says of light, mode and window. "auto" has no function here, as it depends on
/// values. Throws InputError, listing the names and the nearest one, for an unknown name.
Preset builtInPreset(const std::string& name);

/// What is known of a volume's values, for presets that adapt ("auto").
struct ValueSummary {
    double lowest = 0, highest = 0; // physical units
    bool isHu = true;
    double spacingMm = 1; // typical voxel size; the unit distance of "auto", so that it suits any scale
    /// Counts over equal bins of [lowest, highest]; empty if unknown.
    std::vector<double> histogram;
};

/// Whether values without a unit look like HU: some are air, between -1100 and -900, and at least three
/// quarters lie between -1100 and 3100. What scanners write outside their circle may lie below. By the
/// histogram's bins, so never certain.
bool looksLikeHu(const ValueSummary& values);

/// Of the values above the background, which is the largest peak of the histogram's lower half: the least,
/// and the 98th percentile. Without a histogram the range's upper four fifths. Never empty.
glm::dvec2 objectRange(const ValueSummary& values);
/// A preset whose function is over shares as one over a volume's values; others as they are.
Preset forValues(Preset preset, const ValueSummary& values);

/// Throws InputError, listing the names and the nearest one, for an unknown name.
/// "auto": from the histogram; transparent below the background peak's upper end, ramps over the quantiles of
/// the rest, dark red to ivory. A volume of one value is transparent.
/// A CT preset on other data is refused with a message that names "auto".
/// "auto" suits any data, and so do presets over shares (forValues); the
/// others suit values in HU, and values that look like them (looksLikeHu).
TransferFunction presetFunction(const std::string& name, const ValueSummary& values);

} // namespace tessera
