// render/report_plan.h: the entries of a picture's result that any plan gives.
#pragma once

#include "core/scene/scene.h"
#include "render/plan/frame_plan.h"
#include "render/render_result.h"

namespace tessera {

/// Camera, values, window and cells of the plan's volume.
void reportVolume(const FramePlan& plan, const Scene& scene, RenderResult& result);

/// Levels, bricks, pages, integrator and step; once they are final. Bricks that no ray meets count as empty.
void reportLevels(const FramePlan& plan, RenderResult& result);

} // namespace tessera
