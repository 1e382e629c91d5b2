// render/picture/ray_pixels.h: pixels of a picture that rays drew, again by rays of the same engine: as they
// are, and through the finest level with a quarter of the step, or where phases help much with half of it and
// phases.
#pragma once

#include "render/engine.h"
#include "render/renderer.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace tessera {

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
