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
    std::string mode, window, valueColour, slice, slab; // "": the scene's
    std::vector<std::string> boxes, boxesInVoxels, planes;
    std::string keep;

    static constexpr const char* kBody = "body"; // "body": a box found in the volume
    bool cropsToBody() const { return std::find(boxes.begin(), boxes.end(), kBody) != boxes.end(); }
};
void addModeOptions(Command& command, ModeOptions& options);
/// Options override the scene; `--crop body` is left to cropToBody() (viewer/cli/render/body_crop.h). Throws
/// InputError naming the option, also for one without effect in its mode.
void applyModeOptions(const ModeOptions& options, Scene& scene);

} // namespace tessera
