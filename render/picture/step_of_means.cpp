// render/picture/step_of_means.cpp: see step_of_means.h.
#include "render/picture/step_of_means.h"

#include "render/picture/picture.h"
#include "render/pixels/pixel_places.h"
#include "render/plan/step_search.h"

#include <algorithm>
#include <span>
#include <vector>

namespace tessera {
namespace {

constexpr double kTimes[] = {1.5, 2, 3, 4, 6, 8}; // the plan's step
constexpr double kLongest = 4;                    // voxels
constexpr std::size_t kRays = kPhases;            // of a pixel
constexpr int kAcross = 24;                       // pixels that are tried, along an axis at most
constexpr int kFewestPixels = 256 * 256;
constexpr std::uint32_t kFirstSetOfMeans = 1u << 19; // of places, that no picture and no measurement takes

/// A ray of each phase through each of some pixels of a picture.
class SomeMeans {
  public:
    explicit SomeMeans(const FramePlan& plan)
        : every_((std::max(plan.view.imageSize.x, plan.view.imageSize.y) + kAcross - 1) / kAcross),
          grid_(thinnedSize(plan.view.imageSize, every_)), arraySize_(rayArraySize(rayCount(grid_) * kRays)),
          array_(rayCount(arraySize_), glm::vec2(0)) { // the remainder is drawn and dropped
        const PixelPlaces places(plan.view.quality.pixels.seed, plan.view.quality.pixels.filter);
        std::size_t slot = 0;
        forEachPixel(grid_, [&](const glm::ivec2& at) {
            glm::vec2 ofPixel[kRays];
            for (std::uint32_t set = 0; set < 2; ++set)
                places.put(at * every_ + every_ / 2, kFirstSetOfMeans + set, 0,
                           std::span(ofPixel).subspan(set * kRays / 2, kRays / 2));
            for (const glm::vec2& place : ofPixel)
                array_[raySlot(slot++, arraySize_)] = place;
        });
    }
    Image draw(Rays rays, const std::function<Image(const Rays&)>& draw) const {
        rays.frame.phased = true;
        rays.places = array_;
        rays.arraySize = arraySize_;
        const Image drawn = draw(rays);
        Image mean(grid_);
        std::size_t slot = 0;
        forEachPixel(grid_, [&](const glm::ivec2& at) {
            for (std::size_t n = 0; n < kRays; ++n)
                mean.at(at.x, at.y) += drawn.pixels[raySlot(slot++, arraySize_)] / static_cast<float>(kRays);
        });
        return mean;
    }

  private:
    int every_;
    glm::ivec2 grid_, arraySize_;
    std::vector<glm::vec2> array_;
};

} // namespace

std::optional<double> stepOfMeans(const FramePlan& plan, double rms,
                                  const std::function<Image(const Rays&)>& draw) {
    const Optics& optics = plan.layer().optics;
    if (optics.integrator != Integrator::midpoint || !optics.surfaces.empty() || plan.view.frame.cuts ||
        plan.view.imageSize.x * plan.view.imageSize.y < kFewestPixels)
        return std::nullopt;
    const SomeMeans some(plan);
    const double own = plan.view.quality.stepVoxels;
    const Strides strides = plan.strides();
    const int mostSegments = strides.map ? 1 << strides.map->mostStride : strides.uniformSegments;
    const Image better = some.draw(raysOf(plan, own), draw);
    std::optional<double> longest;
    for (const double times : kTimes) {
        const double step = times * own;
        if (step > kLongest || step * mostSegments > kBrickExtent / 2) // as mostStride() has it
            break;
        const EstimatedError error = errorBetween(some.draw(raysOf(plan, step), draw), better);
        if (!(error.rms <= rms && error.luvP99 <= StepSearch::kLuvOfLonger))
            break;
        longest = step;
    }
    return longest;
}

} // namespace tessera
