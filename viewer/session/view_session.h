// viewer/session/view_session.h: a session that draws a volume on a thread of its own. Pictures are in time
// while something moves, and improve at rest, up to the still of `tessera render`. Then drawing stops.
//
//   request --> coarse pictures --> all pixels, bricks as they come --> still --> rest
//     ^________________________________________________________________|
//
// Where light follows paths, the still alone has them. It comes in rounds of more and more samples.
//
// Each budget is split: one half for interactive pictures, one for stills. So a still does not depend on
// earlier views. It is the picture of `tessera render` with half of both budgets.
#pragma once

#include "render/picture/render_scene.h"   // EngineKind
#include "viewer/cli/input/volume_input.h" // InputOptions
#include "viewer/cli/options/options.h"
#include "viewer/session/viewing.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

struct ViewSessionOptions {
    EngineKind engine = EngineKind::automatic; // gpu, native, or automatic
    GlDeviceChoice device;
    std::size_t ramBytes = 0, gpuBytes = 0; // total budgets
    int threads = 0;                        // 0: all processors
    double frameMs = 60;                    // time of a picture while something moves
    std::size_t savedPanels = 1;            // of figures that it saves: its own picture and others
    bool stills = true;                     // at rest draw the picture of `tessera render`
    InputOptions input;
    /// Of a file of several levels that is not in the cache of imports, a level of at most so many bytes,
    /// decoded, is shown while the one that is meant is imported; 0: none is.
    std::uint64_t firstBytes = std::uint64_t{32} << 20;
    std::vector<std::string> sets = {}; // KEY=VALUE (applySets()): keys of every scene that is opened
    /// Sets keys of the scene of one path alone: labels lie beside one volume.
    std::filesystem::path own = {};
    std::function<void(Scene&)> setOwn = {};
    bool anyFrame =
        false; // labels and structures that are dropped are taken whatever their frame of reference
    CommonOptions common;
    /// Called from another thread when picture(), volume(), state() or picked() has changed.
    std::function<void()> news = [] {};
};

/// Ends the thread; a still being drawn is cancelled.
std::unique_ptr<Viewing> makeViewSession(const ViewSessionOptions& options);

} // namespace tessera
