// core/scene/scene_presets.h: what gives a scene another appearance: presets, each one JSON file, and
// lighting presets.
#pragma once

#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"

#include <string>
#include <vector>

namespace tessera {

// A preset as one JSON file: a transfer function and the other keys of a picture's appearance. "Save as mine"
// writes it and `--preset FILE` reads it.
//
//     {"tesseraPreset": 1, "description": "...", "unit": "HU",
//      "scalarOpacity": ..., "rgbTransferFunction": ..., and any of lookKeys(), as a scene has them}

/// The domain of a preset's function.
enum class PresetUnit {
    any,   // physical units of any volume
    hu,    // Hounsfield units
    share, // [0,1], of the range of a volume's values
    object // [0,1], of the range above the background: objectRange() of core/scene/preset.h
};

struct Preset {
    std::string name, description;
    PresetUnit unit = PresetUnit::any;
    TransferFunction function;
    /// Other keys of a scene that it sets, a JSON object; "{}": none.
    std::string look = "{}";
};

/// Keys of a scene that a preset may set: "mode", "window", "valueColour", "slice", "shading", "lighting",
/// "isosurfaces", "cuts".
const std::vector<std::string>& lookKeys();

/// Throws InputError naming where and the JSON path for values that parseScene() refuses, another version,
/// unknown keys and wrong types.
Preset parsePreset(const std::string& text, const std::string& name, const std::string& where);
/// The inverse; ASCII, indented. The function must hold opacities.
std::string presetJson(const Preset& preset);

/// The appearance of a scene: its function, and lookKeys() without cuts and without a slice that it does not
/// have. Throws InputError if the function is a name, because it depends on a volume.
Preset presetOf(const Scene& scene, const std::string& name);
/// The scene with the preset's function and keys; what the preset does not name stays. Throws InputError for
/// a function over shares of a range: see overRange().
void applyPreset(const Preset& preset, Scene& scene);
/// The scene with a built-in preset (preset.h). Without a mode of the preset the mode is composite. Window,
/// value colour, plane and shading of an earlier built-in preset are removed. The user's own settings stay,
/// as do light, surfaces and cuts.
/// @param function  its name, or the function for a volume's values
/// Throws InputError for an unknown name.
void applyBuiltInPreset(const std::string& name, const TransferChoice& function, Scene& scene);
/// Those of lookKeys() that a preset sets to other values than a scene's defaults.
std::vector<std::string> lookSaysOf(const Preset& preset);
/// True if the function is over shares of a range instead of values.
bool overShares(const Preset& preset);
/// Converts a preset over shares of a range to one over [lowest, highest]; others are unchanged. Throws
/// InputError for a range that is empty or not finite.
Preset overRange(Preset preset, double lowest, double highest);

// Lighting presets, in core/scene/looks/*.json: lights, occlusion and material response by name. In code and
// files a lighting preset is called a look.

/// "plain", "studio", "soft", "dramatic", "endoscope", "cinematic", "daylight", "rim", "soft-1". NAME-1 is an
/// earlier version of NAME.
const std::vector<std::string>& lookNames();
/// Applies a lighting preset's light and the shading that it names; the gradient operator and `shade` stay
/// the scene's. Throws InputError, listing the names and the nearest one, for an unknown name.
void applyLook(const std::string& name, Scene& scene);

} // namespace tessera
