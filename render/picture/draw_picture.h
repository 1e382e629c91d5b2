// render/picture/draw_picture.h: the picture of a plan, by any engine: bricks are loaded, a step is chosen,
// rays are drawn and errors reported. With an error goal it draws pictures, each finer than the one before,
// until the error is met. For renderer.cpp and frame_renderer.cpp.
#pragma once

#include "render/picture/renderer.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {

/// Everything that a ray's result depends on, for a fixed scene and engine.
struct RaysDrawn {
    std::vector<std::uint8_t> levels;
    double stepVoxels;
    Integrator integrator;
    explicit RaysDrawn(const ScenePlan& p)
        : levels(p.volume.selection.levels), stepVoxels(p.view.quality.stepVoxels),
          integrator(p.volume.optics.integrator) {}
    friend bool operator==(const RaysDrawn&, const RaysDrawn&) = default;
};

/// Samples of a picture: the next one of the same rays goes on from them.
struct SamplesDrawn {
    RaysDrawn rays;
    AreaPicture picture;
    std::unique_ptr<SurfaceLight> light = {}; // occlusion of surfaces, where there is any
};

/// Of pictures that follow one another.
struct FrameReuse {
    bool kept = false; // the engine holds the bricks of the picture before
    std::size_t pages =
        0; // to open the engine with, so that the next pictures' bricks have room; 0: the plan's
    std::function<void()> opened; // the engine has what it takes of RAM
    bool first = false;           // a first, coarse picture: without occlusion of surfaces
};

/// A round of pictures of one scene that come nearer and nearer to what is asked for.
struct Round {
    int number = 0; // from 0
    PixelGoal goal; // where pixels decide how many samples they take
};

/// Returns whether it went on from samples that were there.
/// @param samples  of the picture before, and afterwards of this one
bool drawPicture(const Scene& scene, ScenePlan& p, Engine& engine, const FrameContext& context,
                 const RenderOptions& options, const Round& round, std::optional<SamplesDrawn>& samples,
                 RenderResult& result, const FrameReuse& reuse = {});

/// Pictures, each finer than the one before, until the measured error is within what the scene asks for, or
/// nothing is left to gain, which the result says.
void drawUntilGoodEnough(const Scene& scene, ScenePlan& p, Engine& engine, const FrameContext& context,
                         const RenderOptions& options, RenderResult& result);

} // namespace tessera
