// viewer/options/mode_options.h: options of a picture's mode: what rays keep of values, windows, slices, and
// cuts.
#pragma once

#include "core/scene.h"
#include "viewer/options/command.h"

#include <string>
#include <vector>

namespace tessera {

struct ModeOptions {
    std::string mode, window, valueColour, slice, slab; // "": as the scene says
    std::vector<std::string> boxes, boxesInVoxels, planes;
    std::string keep;
};
void addModeOptions(Command& command, ModeOptions& options);
/// Options win over the scene. Throws InputError naming the option, also for one that its mode has no use
/// for.
void applyModeOptions(const ModeOptions& options, Scene& scene);

} // namespace tessera
