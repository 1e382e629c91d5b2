// viewer/presets/preset_library.h: presets by name or file: built-in ones, the user's own, and files of ours
// and of other programs.
#pragma once

#include "core/scene/preset_file.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// ${XDG_CONFIG_HOME}/tessera/presets or ~/.config/tessera/presets; empty where there is no such
/// folder to be.
std::filesystem::path ownPresetsFolder();
/// Names of what was kept there, alphabetical.
std::vector<std::string> ownPresetNames();
/// Keeps a preset under its name, in place of one that has it.
/// Throws InputError for a name that is a built-in one's or is no file's name (letters, digits, "-", "_",
/// blanks and dots inside, at most 64); Error where it cannot be written.
std::filesystem::path keepPreset(const Preset& preset);
/// Throws InputError for a name that was not kept.
void forgetPreset(const std::string& name);

/// A preset that was looked for, and what of its file could not be taken, a sentence each.
struct FoundPreset {
    Preset preset;
    std::vector<std::string> leftOut;
};
/// Whether findPreset() would look for a file, or for a name that was kept: the text is no built-in name.
bool isOwnOrFile(const std::string& text);
/// The preset of a name that was kept, of FILE, or of FILE#NAME where it holds several: ours, a scene,
/// Slicer's (.vp.json, .vp, MRML), ParaView's. What a file is, its text says, not its name.
/// Throws InputError naming what was looked for, with the names that there are.
FoundPreset findPreset(const std::string& text);

/// Writes a preset as ours, or as Slicer's or ParaView's JSON. Returns what was left out.
/// @param format  "tessera", "slicer", "paraview"; empty: slicer for .vp.json, else tessera
/// Throws InputError for another format, Error where it cannot be written.
std::vector<std::string> writePreset(const Preset& preset, const std::filesystem::path& file,
                                     const std::string& format);
const std::vector<std::string>& presetFormatNames();

} // namespace tessera
