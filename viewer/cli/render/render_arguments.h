// viewer/cli/render/render_arguments.h: the arguments of `tessera render` as the user gave them. They
// are checked and interpreted elsewhere (scene_from_arguments.h, run_render.h).
#pragma once

#include "viewer/cli/input/volume_input.h" // InputOptions
#include "viewer/cli/options/scene_options.h"

#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Empty texts, and numbers that no option takes, were not said: then the scene decides, or the path
/// of a film.
struct RenderArguments {
    std::string in, out, engine = "auto", ram, gpuMemory, preset, view, fit, projection;
    std::string device = "auto";
    double mmPerPixel = 0; // 0: as the scene says
    KeyOptions keys;       // those that set one key of the scene
    std::string first, light;
    std::vector<std::string> surfaces;
    std::string verify;
    std::string path, frames;                           // of films
    double framesPerSecond = 0, speed = 0, seconds = 0; // 0: as the path says
    std::optional<double> turn;                         // degrees, not 0; of turntables
    bool unfold = false, mayLeak = false;
    bool noCheck = false, explain = false, json = false, scaleBar = false;
    ModeOptions mode;
    InputOptions input;

    bool isFilm() const { return (!path.empty() && !unfold) || turn; }
};

} // namespace tessera
