// render/picture/ray_renderer.h: the renderer of all ray backends. Bricks are loaded, a step is chosen, rays
// are drawn, and samples of pixels added, on an engine that takes rays.
#pragma once

#include "render/picture/deferred_light.h"
#include "render/renderer.h"

#include <memory>

namespace tessera {

struct RaysDrawn;
class StepSearch;

class RayRenderer : public Renderer {
  public:
    /// @param exact  the engine draws the true integral: EngineTraits::exact
    RayRenderer(std::unique_ptr<Engine> engine, bool exact);
    ~RayRenderer() override;

    Engine::About about() const override { return engine_->about(); }
    TextureLimits limits() const override { return engine_->limits(); }
    bool draw(const FrameTask& task, RenderResult& result, Image& added) override;
    std::unique_ptr<PixelSource> pixels(const FrameTask& task) override;
    void endFrame() override;
    void close() override;
    BrickResidency* bricks() override { return engine_->bricks(); }
    std::string fault() override { return engine_->fault(); }

    Engine& engine() { return *engine_; }

  private:
    struct Samples;
    void settleExposure(const FrameTask& task);
    void chooseStep(const FrameTask& task, StepSearch& search, RenderResult& result);
    bool drawAreas(const FrameTask& task, std::unique_ptr<DeferredLight> light, RenderResult& result,
                   Image& added);
    /// Samples of an earlier run, where they are kept.
    void takeKept(const FrameTask& task, const RaysDrawn& these, AreaPicture& picture, RenderResult& result);
    PictureTiles::Parts partsOfTiles(const FramePlan& plan) const;
    /// The picture's tiles, as long as there are any to draw.
    void drawTiles(const FrameTask& task, RenderResult& result);
    void drawTile(const FrameTask& task, const PictureTile& tile, RenderResult& result);
    Image drawSome(const FrameTask& task, const Rays& rays);

    std::unique_ptr<Engine> engine_;
    bool exact_;
    std::unique_ptr<RayCaster> caster_;
    std::unique_ptr<Samples> samples_; // of the round before: the next one of the same rays goes on from them
    double stepOfMeans_ = 0;           // of the picture's rays with phases, voxels; 0: there are none
};

} // namespace tessera
