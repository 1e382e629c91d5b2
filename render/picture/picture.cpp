// render/picture/picture.cpp: see picture.h.
#include "render/picture/picture.h"

#include "core/base/error.h"
#include "render/parts/process_group.h"
#include "render/pixels/pixel_places.h"
#include "render/plan/fusion.h"
#include "render/plan/step_search.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// The bricks of the next pass: those that the first waiting rays need, as many as fit. The very first ray's
/// are always among them, so that every pass gets on.
std::vector<std::size_t> bricksToServe(const std::vector<std::uint32_t>& firstRay, const Selection& selection,
                                       std::size_t pages) {
    std::vector<std::size_t> order;
    for (std::size_t b = 0; b < firstRay.size(); ++b)
        if (firstRay[b] != UINT32_MAX)
            order.push_back(b);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(firstRay[a], a) < std::pair(firstRay[b], b);
    });
    std::array<std::size_t, kLevelCount + 1> counts{};
    std::size_t served = 0;
    for (; served < order.size(); ++served) {
        ++counts[selection.levels[order[served]]];
        if (pagesFor(counts) > pages)
            break;
    }
    TESSERA_CHECK(served > 0);
    order.resize(served);
    return order;
}

} // namespace

Rays raysOf(const FramePlan& plan) {
    return {plan.view.frame, plan.strides()};
}

Rays raysOf(const FramePlan& plan, double stepVoxels) {
    Rays rays = raysOf(plan);
    rays.frame.segmentVoxels = rays.strides.segmentVoxels = stepVoxels;
    return rays;
}

namespace {

/// The bricks of this process's part, as many as fit. Rays wait for the rest.
void loadPart(const SharedVolume& shared, const Selection& selection, BrickResidency& residency,
              BrickCache& cache, Work& work) {
    std::vector<std::size_t> bricks = shared.parts.bricksAround(shared.mine(), selection);
    while (pagesFor(countsOf(bricks, selection)) > residency.pages())
        bricks.resize(bricks.size() - std::max<std::size_t>(1, bricks.size() / 16));
    residency.serve(bricks, cache, work);
}

} // namespace

bool loadBricks(Engine& engine, Planner& plan, MemoryBudget& gpu, Work& work, bool kept, std::size_t pages) {
    Layer& volume = plan.layer();
    if (kept && engine.bricks() && engine.bricks()->pages() >= plan.chosen.atlasPages) {
        engine.bricks()->adopt(volume.selection);
    } else {
        engine.open(plan, std::max(pages, plan.chosen.atlasPages));
    }
    BrickResidency* const bricks = engine.bricks();
    bool waits = false;
    for (std::size_t n = 0; n < plan.further.size(); ++n)
        if (Engine* const further = engine.further(n))
            waits = loadBricks(*further, plan.further[n].plan, plan.further[n].gpu, work) || waits;
    if (plan.chosen.chooser) {
        if (bricks)
            bricks->load(*volume.cache, work);
        const auto counter = engine.counter(gpu);
        counter->begin();
        TESSERA_CHECK(counter->count(Slicing{}, RayCaster::Clock::time_point::max()));
        plan.chooseByVisibility(counter->seen());
        if (bricks)
            bricks->adopt(volume.selection);
    }
    if (!bricks)
        return false;
    if (plan.shared) {
        loadPart(*plan.shared, volume.selection, *bricks, *volume.cache, work);
        return true;
    }
    if (plan.chosen.atlasPages < pagesFor(volume.selection.counts))
        return true;
    bricks->load(*volume.cache, work);
    return waits;
}

namespace {

/// Of those of them that are not there.
std::uint64_t bytesToBring(const std::vector<std::size_t>& bricks, const BrickResidency& residency,
                           const Layer& volume) {
    std::uint64_t bytes = 0;
    for (const std::size_t b : bricks)
        if (!residency.residentLevel(b))
            bytes += cellCount(glm::ivec3(kBrickExtent >> volume.selection.levels[b])) *
                     bytesPerValue(volume.info().type);
    return bytes;
}

/// Brings bricks that rays wait for. False where they would take too many bytes.
bool serve(RayCaster& caster, std::size_t number, BrickResidency& bricks, const Layer& volume,
           std::uint64_t mostBytes, Work& work) {
    const std::vector<std::uint32_t> wanted = caster.takeWanted(number);
    if (std::all_of(wanted.begin(), wanted.end(), [](std::uint32_t ray) { return ray == UINT32_MAX; }))
        return true; // its rays wait for another volume's
    const auto next = bricksToServe(wanted, volume.selection, bricks.pages());
    if (mostBytes != UINT64_MAX && work.bytesUploaded + bytesToBring(next, bricks, volume) > mostBytes)
        return false;
    bricks.serve(next, *volume.cache, work);
    return work.bytesUploaded <= mostBytes; // the present bricks may have had to be packed anew
}

/// Returns in how many passes; 0 where bricks would take too many bytes.
int drawPasses(RayCaster& caster, Engine& engine, const FramePlan& plan, const Slicing& slicing,
               std::uint64_t mostBytes, Work& work) {
    for (int passes = 1;; ++passes) {
        TESSERA_CHECK(caster.draw(slicing, RayCaster::Clock::time_point::max(), work));
        if (caster.waiting() == 0)
            return passes;
        if (!serve(caster, 0, *engine.bricks(), plan.layer(), mostBytes, work))
            return 0;
        for (std::size_t n = 0; n < plan.further.size(); ++n)
            if (!serve(caster, n + 1, *engine.further(n)->bricks(), plan.further[n].plan.layer(), mostBytes,
                       work))
                return 0;
    }
}

} // namespace

int drawToTheEnd(RayCaster& caster, Engine& engine, const FramePlan& plan, const Slicing& slicing,
                 Work& work) {
    return drawPasses(caster, engine, plan, slicing, UINT64_MAX, work);
}

bool drawWithin(RayCaster& caster, Engine& engine, const FramePlan& plan, const Slicing& slicing,
                std::uint64_t mostBytes, Work& work) {
    return drawPasses(caster, engine, plan, slicing, mostBytes, work) > 0;
}

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
