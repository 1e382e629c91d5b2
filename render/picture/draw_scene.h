// render/picture/draw_scene.h: draws a scene on an open engine. renderScene() makes the engine for one
// picture; FrameRenderer keeps it for a film.
#pragma once

#include "render/backends/engine_maker.h"
#include "render/picture/draw_picture.h"
#include "render/plan/scene_plan.h"

#include <functional>
#include <memory>
#include <string>

namespace tessera {

/// An engine and what it draws with.
struct EngineInstance {
    EngineMaker maker;
    EngineKind kind;
    std::string reason; // why this one; empty where it was asked for
    std::unique_ptr<Engine> engine;

    EngineInstance(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu);
};

/// The plan of a scene for such limits, levels and RAM for a pixel.
using Planned = std::function<ScenePlan(const Scene&, const TextureLimits&, LevelChoice, std::size_t)>;

/// A picture by an engine that holds nothing, or the bricks of the picture before.
/// @param p  takes the plan; where bricks are kept, the engine was opened for what is in its place
/// @param planned  makes the plan, and may change what is kept
RenderResult drawScene(const Scene& scene, ScenePlan& p, const EngineInstance& made,
                       const FrameContext& context, const RenderOptions& options, const FrameReuse& reuse,
                       const Planned& planned);

} // namespace tessera
