// render/plan/plan_again.h: a plan for another scene of a volume whose statistics are loaded.
#pragma once

#include "render/plan/scene_plan.h"

namespace tessera {

/// As planScene(), which reads them.
ScenePlan planAgain(const Scene& scene, const StoreReader& store, Statistics statistics,
                    const TextureLimits& limits, const FrameContext& context, LevelChoice choice,
                    std::size_t bytesPerPixel);

} // namespace tessera
