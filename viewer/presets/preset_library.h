// viewer/presets/preset_library.h: presets by name or file: built-in ones, the user's own, and files of ours
// and of other programs.
#pragma once

#include "core/scene/scene_presets.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// ${XDG_CONFIG_HOME}/tessera/presets or ~/.config/tessera/presets; empty without either variable.
std::filesystem::path ownPresetsFolder();
/// Names of presets kept there, alphabetical.
std::vector<std::string> ownPresetNames();
/// Keeps a preset under its name, replacing an earlier one. Throws InputError for a built-in or invalid name
/// (letters, digits, "-", "_", blanks and dots inside, at most 64); Error if it cannot be written.
std::filesystem::path keepPreset(const Preset& preset);
/// Throws InputError for a name that was not kept.
void forgetPreset(const std::string& name);

/// A found preset, and the settings of its file that were left out, a sentence each.
struct FoundPreset {
    Preset preset;
    std::vector<std::string> leftOut;
};
/// True if findPreset() would look for a file or a kept name: the text is no built-in name.
bool isOwnOrFile(const std::string& text);
/// The preset of a kept name, of FILE, or of FILE#NAME if it holds several: ours, a scene, Slicer's
/// (.vp.json, .vp, MRML), ParaView's. The format follows from a file's content, not its name. Throws
/// InputError naming the text, with the known names.
FoundPreset findPreset(const std::string& text);

/// Writes a preset as ours, or as Slicer's or ParaView's JSON. Returns the settings left out.
/// @param format  "tessera", "slicer", "paraview"; empty: slicer for .vp.json, else tessera
/// Throws InputError for another format, Error if it cannot be written.
std::vector<std::string> writePreset(const Preset& preset, const std::filesystem::path& file,
                                     const std::string& format);
const std::vector<std::string>& presetFormatNames();

} // namespace tessera
