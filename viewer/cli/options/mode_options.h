// viewer/cli/options/mode_options.h: the options of a picture's mode: the values that rays keep, windows,
// slices, and cuts.
#pragma once

#include "core/scene/scene.h"
#include "viewer/cli/options/command.h"

#include <algorithm>
#include <string>
#include <vector>

namespace tessera {

struct ModeOptions {
    std::string mode, window, valueColour, slice, slab; // "": as the scene says
    std::vector<std::string> boxes, boxesInVoxels, planes;
    std::string keep;

    static constexpr const char* kBody = "body"; // a box that is found in the volume
    bool cropsToBody() const { return std::find(boxes.begin(), boxes.end(), kBody) != boxes.end(); }
};
void addModeOptions(Command& command, ModeOptions& options);
/// Options win over the scene; a body's box is left to cropToBody() (viewer/cli/render/body_crop.h).
/// Throws InputError naming the option, also for one that its mode has no use for.
void applyModeOptions(const ModeOptions& options, Scene& scene);

} // namespace tessera
