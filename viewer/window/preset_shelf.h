// viewer/window/preset_shelf.h: access to presets that are not built in, for the window, which itself reads
// and writes no files.
#pragma once

#include "core/scene/scene_presets.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// All of these throw Error or InputError, with a sentence for the user.
struct PresetShelf {
    /// Names of the user's presets.
    std::function<std::vector<std::string>()> names;
    /// One of those, or of a file; unsupported settings go to leftOut, a sentence each.
    std::function<Preset(const std::string& nameOrFile, std::vector<std::string>& leftOut)> find;
    /// Keeps it under its name.
    std::function<void(const Preset&)> keep;
    /// Writes it: ours, or, by the format's name, Slicer's or ParaView's. Returns the settings left out.
    std::function<std::vector<std::string>(const Preset&, const std::filesystem::path&,
                                           const std::string& format)>
        write;
};

} // namespace tessera
