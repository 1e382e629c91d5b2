// render/picture/draw_scene.h: draws a scene by any renderer: plans, draws, measures, and plans again until
// the picture is as good as was asked. renderScene() makes the renderer for one picture; FrameRenderer keeps
// it for a film.
#pragma once

#include "render/backends/engine_maker.h"
#include "render/plan/planner.h"
#include "render/renderer.h"

#include <functional>
#include <memory>
#include <string>

namespace tessera {

/// A renderer and its resources.
struct RendererInstance {
    EngineMaker maker;
    EngineKind kind;
    std::string reason; // why this one; empty where it was asked for
    std::unique_ptr<Renderer> renderer;

    RendererInstance(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu);
};

/// The plan of a scene for such limits, levels and RAM of pixels.
using Planned = std::function<Planner(const Scene&, const TextureLimits&, LevelChoice, const PixelMemory&)>;

/// A picture by a renderer that holds nothing, or the bricks of the picture before.
/// @param p  takes the plan; where bricks are kept, the renderer has what is in its place
/// @param planned  makes the plan, and may change what is kept
RenderResult drawScene(const Scene& scene, Planner& p, const RendererInstance& made,
                       const FrameContext& context, const RenderOptions& options, const FrameReuse& reuse,
                       const Planned& planned);

} // namespace tessera
