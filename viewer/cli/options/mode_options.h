// viewer/cli/options/mode_options.h: options of slices and cuts, and which options have an effect in which
// mode.
#pragma once

#include "core/scene/scene.h"
#include "viewer/cli/options/command.h"
#include "viewer/cli/options/key_options.h"

#include <algorithm>
#include <string>
#include <vector>

namespace tessera {

struct ModeOptions {
    std::string slice, slab; // "": the scene's
    std::vector<std::string> boxes, boxesInVoxels, planes;
    std::string keep;

    static constexpr const char* kBody = "body"; // "body": a box found in the volume
    bool cropsToBody() const { return std::find(boxes.begin(), boxes.end(), kBody) != boxes.end(); }
};
void addModeOptions(Command& command, ModeOptions& options);
/// Options override the scene; `--crop body` is left to cropToBody() (viewer/cli/render/body_crop.h). Throws
/// InputError naming the option, also for one without effect in its mode.
/// @param keys  applied to the scene before
void applyModeOptions(const ModeOptions& options, const KeyOptions& keys, Scene& scene);

} // namespace tessera
