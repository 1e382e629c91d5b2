// viewer/session/view_session.h: a session that looks at a volume on a thread of its own. Pictures come in
// time while something moves, and improve at rest, up to the still that `tessera render` draws. Then nothing
// is drawn.
//
//   wish --> moving pictures --> all pixels, bricks as they come --> still --> rest
//     ^________________________________________________________________|
//
// Budgets are split: one half each for what moves and for stills. So a still does not depend on what was
// looked at before. It is the picture of `tessera render` with half of both budgets.
#pragma once

#include "render/picture/render_scene.h"   // EngineKind
#include "viewer/cli/input/volume_input.h" // InputOptions
#include "viewer/cli/options/options.h"
#include "viewer/session/viewing.h"

#include <functional>
#include <memory>

namespace tessera {

struct ViewSessionOptions {
    EngineKind engine = EngineKind::automatic; // gpu or native, or the one of them that suits
    GlDeviceChoice device;
    std::size_t ramBytes = 0, gpuBytes = 0; // budgets of everything together
    int threads = 0;                        // 0: all processors
    double frameMs = 60;                    // that a picture may take while something moves
    bool stills = true;                     // at rest draws what `tessera render` draws
    InputOptions input;
    CommonOptions common;
    /// Is called from another thread when picture(), volume(), state() or picked() is another.
    std::function<void()> news = [] {};
};

/// The thread ends with it; a still that is being drawn is called off.
std::unique_ptr<Viewing> makeViewSession(const ViewSessionOptions& options);

} // namespace tessera
