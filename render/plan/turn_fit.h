// render/plan/turn_fit.h: what a turntable must hold of volumes. Those of several times, of which one is open
// after another, are joined before a camera is fitted.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h"

#include <vector>

namespace tessera {

struct TurnFit {
    std::vector<ViewFit> fits;     // from directions over half a turn (framing.h); empty: nothing yet
    std::vector<VolumeInfo> boxes; // of the volumes, which count where nothing is visible
    void add(const TurnFit& other);
};

/// Of what is visible of all volumes of a scene.
/// @param scene  with a camera by side
TurnFit turnFit(const Scene& scene, Stores stores, MemoryBudget& ram, int threads);

/// The camera that holds it. The scene is that of the fit.
Camera turningCamera(const Scene& scene, TurnFit fit);

} // namespace tessera
