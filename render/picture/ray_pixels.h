// render/picture/ray_pixels.h: pixels of a picture that rays drew, again by rays of the same engine: as they
// are, and through the finest level with a quarter of the step.
#pragma once

#include "render/renderer.h"

namespace tessera {

class RayPixels : public PixelSource {
  public:
    /// All outlive it.
    /// @param caster  of the engine; where coarser levels were drawn, toTruth() makes another, and the plan
    /// is
    ///     of the finest levels from then on
    RayPixels(const FrameTask& task, Engine& engine, std::unique_ptr<RayCaster>& caster);
    /// Rays end where they did.
    ~RayPixels() override;

    About about() const override;
    std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                              const Slicing& slicing, std::uint64_t mostBytes, Work& work) override;
    std::string toTruth() override;

  private:
    const FrameTask& task_;
    Engine& engine_;
    std::unique_ptr<RayCaster>& caster_;
    double step_; // voxels
    float ends_;  // of rays of the picture
};

} // namespace tessera
