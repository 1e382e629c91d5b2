// render/backends/splat/splat_pixels.cpp: see splat_pixels.h.
#include "render/backends/splat/splat_pixels.h"

#include "bricking/cache/brick_cache.h"
#include "render/backends/reference/reference_engine.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tessera {

namespace {

class SplatPixels : public PixelSource {
  public:
    SplatPixels(const FrameTask& task, const Image& picture, int threads)
        : task_(task), picture_(picture), reference_(threads) {}

    About about() const override {
        const FramePlan& plan = task_.plan;
        const Selection& s = plan.layer().selection;
        const RayFrame<double>& frame = plan.view.frame;
        const double voxels = std::max(2 * glm::length(frame.right) / frame.imageSize.x,
                                       2 * glm::length(frame.up) / frame.imageSize.y); // of a pixel
        return {s.counts[0] == s.shownBricks(), false,
                std::max(1, static_cast<int>(std::lround(kBrickExtent / voxels)))};
    }
    std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                              const Slicing& slicing, std::uint64_t mostBytes, Work& work) override {
        if (!caster_) {
            Image image(arraySize);
            for (std::size_t n = 0; n < places.size(); ++n) {
                const glm::ivec2 at = glm::clamp(glm::ivec2(places[n]), glm::ivec2(0), picture_.size - 1);
                image.pixels[n] = picture_.pixels[static_cast<std::size_t>(at.y * picture_.size.x + at.x)];
            }
            return image;
        }
        Rays rays{task_.plan.view.frame, task_.plan.strides()};
        rays.places = places;
        rays.arraySize = arraySize;
        caster_->begin(rays);
        const BrickCache& cache = *task_.plan.layer().cache;
        const std::uint64_t before = cache.counters().bytesDecoded, earlier = work.bytesUploaded;
        bool done = false;
        while (!done) {
            done = caster_->draw(slicing, RayCaster::Clock::time_point::min(), work);
            work.bytesUploaded = earlier + cache.counters().bytesDecoded - before;
            if (work.bytesUploaded > mostBytes)
                return std::nullopt;
        }
        return caster_->image();
    }
    std::string toTruth() override {
        if (!task_.plan.view.meshes.empty())
            return "points of no lattice have no true integral";
        reference_.open(task_.plan, 0);
        caster_ = reference_.caster({}, task_.context.gpu);
        return {};
    }

  private:
    const FrameTask& task_;
    const Image& picture_;
    ReferenceEngine reference_;
    std::unique_ptr<RayCaster> caster_; // of the truth
};

} // namespace

std::unique_ptr<PixelSource> splatPixels(const FrameTask& task, const Image& picture, int threads) {
    return std::make_unique<SplatPixels>(task, picture, threads);
}

} // namespace tessera
