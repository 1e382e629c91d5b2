// render/renderer.h: Renderer: a plan in, a frame out. All ray backends (engine.h) are drawn by one renderer,
// picture/ray_renderer.h; a renderer without rays is a sibling of it. A folder of render/backends/ brings
// either: its EngineTraits name it, and cmake/Backend.cmake makes the table of all.
#pragma once

#include "core/scene/scene.h"
#include "render/engine.h"
#include "render/plan/frame_context.h"
#include "render/plan/planner.h"
#include "render/render_result.h"

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace tessera {

/// A round of pictures of one scene that come nearer and nearer to the request.
struct Round {
    int number = 0; // from 0
    PixelGoal goal; // if pixels decide the number of their samples
};

/// Of pictures that follow one another.
struct FrameReuse {
    bool kept = false;            // the renderer holds the bricks of the picture before
    std::size_t pages = 0;        // to take, so that the next pictures' bricks have room; 0: the plan's
    std::function<void()> opened; // the renderer has its RAM
    bool first = false;           // a first, coarse picture: without occlusion of surfaces
};

/// A frame to be drawn; all of it outlives the call.
struct FrameTask {
    const Scene& scene;
    Planner& plan; // takes the step and integrator that pixels were tried for, and levels by visibility
    const FrameContext& context;
    const RenderOptions& options;
    Round round = {};
    FrameReuse reuse = {};
};

/// Pixels of the frame just drawn, again: for measured errors.
class PixelSource {
  public:
    virtual ~PixelSource() = default;

    struct About {
        bool finest = false; // the frame had the finest levels
        bool passes = false; // it took its bricks in several passes
        int brickPixels = 1; // a brick's width in the middle of the volume
    };
    virtual About about() const = 0;
    /// The colours of samples through places, at their end.
    /// @param places  in pixels of the picture, row by row of an array of arraySize, as Rays::places
    /// @param mostBytes  of bricks that may be loaded, for all work together; none if they would take more
    virtual std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                                      const Slicing& slicing, std::uint64_t mostBytes, Work& work) = 0;
    /// From here on draw() tells the true integral, through the finest level.
    /// Returns why it cannot; empty: it does.
    virtual std::string toTruth() = 0;
};

class Renderer {
  public:
    virtual ~Renderer() = default;

    virtual Engine::About about() const = 0;
    virtual TextureLimits limits() const { return {}; }
    /// Draws the plan's frame, and tells it and its causes in the result: the picture in result.image, light
    /// that is added once errors are known in `added`.
    /// Returns whether it went on from the samples of the round before.
    virtual bool draw(const FrameTask& task, RenderResult& result, Image& added) = 0;
    /// Of the frame just drawn, and valid until the next; null: its errors cannot be measured.
    /// @param task  that of the frame; outlives the result
    virtual std::unique_ptr<PixelSource> pixels(const FrameTask& task) {
        (void)task;
        return nullptr;
    }
    /// Releases memory of the last frame that the next does not need; bricks stay.
    virtual void endFrame() {}
    /// Releases the plan and all that was made from it.
    virtual void close() {}
    /// Of bricks that are kept from frame to frame; null where there are none.
    virtual BrickResidency* bricks() { return nullptr; }
    /// The errors since the last call that nothing reported; empty: none.
    virtual std::string fault() { return {}; }
};

} // namespace tessera
