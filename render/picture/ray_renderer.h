// render/picture/ray_renderer.h: the renderer of all ray backends. Bricks are loaded, a step is chosen, rays
// are drawn, and samples of pixels added, on an engine that takes rays.
#pragma once

#include "render/picture/deferred_light.h"
#include "render/renderer.h"

#include <memory>

namespace tessera {

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
    struct RaysDrawn;
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

// Pixels of a picture that rays drew, again by rays of the same engine: as they are, and through the finest
// level with a quarter of the step, or where phases help much with half of it and phases.

class RayPixels : public PixelSource {
  public:
    /// All outlive it.
    /// @param caster  of the engine; where coarser levels were drawn, toTruth() makes another, and the plan
    ///     is of the finest levels from then on
    /// @param stepOfMeans  of the picture's rays with phases, voxels; 0: there are none
    RayPixels(const FrameTask& task, Engine& engine, std::unique_ptr<RayCaster>& caster, double stepOfMeans);
    /// Rays end where they did.
    ~RayPixels() override;

    About about() const override;
    std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                              const Slicing& slicing, std::uint64_t mostBytes, Work& work) override;
    std::string toSingleWays() override;
    std::string toTruth() override;

  private:
    const FrameTask& task_;
    Engine& engine_;
    std::unique_ptr<RayCaster>& caster_;
    double step_, stepOfMeans_; // voxels
    float ends_;                // of rays of the picture
    bool phased_ = false;       // rays of the truth
    bool paths_ = false;        // rays follow single ways of light
};

} // namespace tessera
