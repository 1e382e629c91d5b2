// core/scene/preset_file.h: a preset as one JSON file: a transfer function and the other keys of a picture's
// appearance. "Save as mine" writes it and `--preset FILE` reads it.
//
//     {"tesseraPreset": 1, "description": "...", "unit": "HU",
//      "scalarOpacity": ..., "rgbTransferFunction": ..., and any of lookKeys(), as a scene has them}
#pragma once

#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"

#include <string>
#include <vector>

namespace tessera {

/// What the values of a preset's function are.
enum class PresetUnit {
    any,   // physical units of whatever volume it is for
    hu,    // Hounsfield units
    share, // [0,1], of the range of a volume's values
    object // the same of what is above the background: see objectRange() of core/scene/preset.h
};

struct Preset {
    std::string name, description;
    PresetUnit unit = PresetUnit::any;
    TransferFunction function;
    /// The keys of a scene that it sets besides, a JSON object; "{}": none.
    std::string look = "{}";
};

/// Of a scene, that a preset may set: "mode", "window", "valueColour", "slice", "shading", "lighting",
/// "isosurfaces", "cuts".
const std::vector<std::string>& lookKeys();

/// Throws InputError naming where and the JSON path for all that parseScene() refuses in those keys, and for
/// another version, unknown keys, wrong types.
Preset parsePreset(const std::string& text, const std::string& name, const std::string& where);
/// The inverse; ASCII, indented. The function must hold opacities.
std::string presetJson(const Preset& preset);

/// What a scene looks like: its function, and of lookKeys() all but cuts and a slice that it does not have.
/// Throws InputError where the function is a name: it depends on a volume.
Preset presetOf(const Scene& scene, const std::string& name);
/// The scene with the preset's function and look; what the preset does not name stays.
/// Throws InputError for a function over shares of a range: see overRange().
void applyPreset(const Preset& preset, Scene& scene);
/// The scene as a built-in preset (preset.h) says, whatever the scene looked like. Where the preset names no
/// mode it is composite. Window, colours of values, plane and shading go where another built-in preset
/// brought them. What the user set of them stays, as do light, surfaces and cuts.
/// @param function  its name, or what it is for a volume's values
/// Throws InputError for an unknown name.
void applyBuiltInPreset(const std::string& name, const TransferChoice& function, Scene& scene);
/// Of lookKeys(), those that a preset sets to something that a scene does not have by default.
std::vector<std::string> lookSaysOf(const Preset& preset);
/// Whether values of the function are shares of a range, and no values.
bool overShares(const Preset& preset);
/// A preset whose function is over shares of a range as one over [lowest, highest]; others as they are.
/// Throws InputError for a range that is empty or not finite.
Preset overRange(Preset preset, double lowest, double highest);

} // namespace tessera
