// viewer/cli/render/phase_film.h: `tessera render --phase all`: what the frames of a film over phases share:
// one camera, one transfer function and one window.
#pragma once

#include "core/animation/path.h"
#include "core/scene/preset.h"
#include "core/scene/scene.h"
#include "viewer/cli/render/render_task.h"

#include <string>
#include <vector>

namespace tessera {

struct SharedByPhases {
    Scene scene;                     // with a function and a window in place of names
    std::vector<std::string> hashes; // of the phases' content
    ValueSummary values;             // of all together
};

/// From the values of all phases: ranges and histograms together. A camera by side is fitted to what any of
/// them shows, that of a turn to what any of them shows from any side; a path has the cameras. Opens one
/// store after another. Throws InputError for a mode whose window is that of each picture.
SharedByPhases sharedByPhases(const RenderTask& task);

/// Of several volumes' values as of one.
ValueSummary together(const std::vector<ValueSummary>& values);

/// The path with functions by these values in place of names.
Path withFunctions(Path path, const ValueSummary& values);

/// A film whose camera stands still, a frame each phase.
Path stillPath(const Camera& camera, std::size_t frames, double framesPerSecond);

} // namespace tessera
