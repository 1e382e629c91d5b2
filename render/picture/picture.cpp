// render/picture/picture.cpp: see picture.h.
#include "render/picture/picture.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <utility>

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

bool loadBricks(Engine& engine, Planner& plan, MemoryBudget& gpu, Work& work, bool kept, std::size_t pages) {
    Layer& volume = plan.layer();
    const FramePlan* const plans[] = {&plan};
    if (kept && engine.bricks() && engine.bricks()->pages() >= plan.chosen.atlasPages) {
        engine.bricks()->adopt(volume.selection);
    } else {
        engine.open(plans, std::max(pages, plan.chosen.atlasPages));
    }
    BrickResidency* const bricks = engine.bricks();
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
    if (plan.chosen.atlasPages < pagesFor(volume.selection.counts))
        return true;
    bricks->load(*volume.cache, work);
    return false;
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

/// Returns in how many passes; 0 where bricks would take too many bytes.
int drawPasses(RayCaster& caster, Engine& engine, const FramePlan& plan, const Slicing& slicing,
               std::uint64_t mostBytes, Work& work) {
    const Layer& volume = plan.layer();
    for (int passes = 1;; ++passes) {
        TESSERA_CHECK(caster.draw(slicing, RayCaster::Clock::time_point::max(), work));
        if (caster.waiting() == 0)
            return passes;
        BrickResidency& bricks = *engine.bricks();
        const auto next = bricksToServe(caster.takeWanted(), volume.selection, bricks.pages());
        if (mostBytes != UINT64_MAX && work.bytesUploaded + bytesToBring(next, bricks, volume) > mostBytes)
            return 0;
        bricks.serve(next, *volume.cache, work);
        if (work.bytesUploaded > mostBytes) // the present bricks had to be packed anew
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

} // namespace tessera
