// render/backends/splat/splat_pixels.h: pixels of a picture of splats again, and what they should be: the
// true integral along rays, by the reference.
#pragma once

#include "core/image/image.h"
#include "render/backends/reference/reference_engine.h"
#include "render/renderer.h"

#include <memory>

namespace tessera {

class SplatPixels : public PixelSource {
  public:
    /// All of it outlives this.
    /// @param picture  as it was drawn: a pixel drawn again has the same bits
    SplatPixels(const FrameTask& task, const Image& picture, int threads)
        : task_(task), picture_(picture), reference_(threads) {}

    About about() const override;
    std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                              const Slicing& slicing, std::uint64_t mostBytes, Work& work) override;
    std::string toTruth() override;

  private:
    const FrameTask& task_;
    const Image& picture_;
    ReferenceEngine reference_;
    std::unique_ptr<RayCaster> caster_; // of the truth
};

} // namespace tessera
