// render/backends/splat/slice_walk.cpp: see slice_walk.h.
#include "render/backends/splat/slice_walk.h"

#include "core/base/brick.h"
#include "core/base/threads.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <glm/common.hpp>

namespace tessera {
namespace {

/// Bytes of the lists of a brick's slices, all of their samples shown.
std::size_t listBytesOf(int level, int voxels) {
    const std::size_t edge = static_cast<std::size_t>(kBrickExtent >> level);
    const std::size_t slices = static_cast<std::size_t>(std::max(voxels >> level, 1));
    return sizeof(BrickList) + edge * edge * slices * sizeof(ShownSample);
}

/// Of the bricks of a layer, and of each thread a brick's samples with those around.
template <typename Brick>
std::size_t scratchBytes(const FramePlan& plan, const SliceOrder& order, int threads) {
    const glm::ivec3& bricks = plan.layer().selection.bricks;
    const auto [across, along] = order.others();
    constexpr std::size_t kEdge = kBrickExtent + 2;
    return static_cast<std::size_t>(bricks[across]) * static_cast<std::size_t>(bricks[along]) *
               sizeof(Brick) +
           static_cast<std::size_t>(threads > 0 ? threads : defaultThreads()) * kEdge * kEdge * kEdge *
               sizeof(float);
}

} // namespace

SliceWalk::SliceWalk(const FramePlan& plan, const SplatView& view, const SplatSettings& settings,
                     const SliceOrder& order, int threads, MemoryBudget& budget)
    : plan_(plan), threads_(threads), budget_(budget), order_(order), lister_(plan, view, order_),
      tiles_(plan.view.imageSize, plan.layer().optics.termination, static_cast<float>(settings.cutOff),
             settings.composition, budget),
      scratch_(
          budget.charge(scratchBytes<ShownBrick>(plan, order_, threads), "bricks whose samples are listed")),
      listBytes_(budget.freeBytes() / 2),
      batch_(view, settings, order_, lister_.brightest(), tiles_, budget.freeBytes() / 4, budget),
      step_(1 << std::min(plan.layer().selection.finest(), kLevelCount - 1)),
      points_(plan, view, settings, order_, step_, budget) {}

std::vector<SliceWalk::ShownBrick> SliceWalk::bricksOf(int layer) const {
    const Selection& selection = plan_.layer().selection;
    const auto [across, along] = order_.others();
    std::vector<ShownBrick> bricks;
    glm::ivec3 brick;
    brick[order_.axis] = layer;
    for (brick[along] = 0; brick[along] < selection.bricks[along]; ++brick[along])
        for (brick[across] = 0; brick[across] < selection.bricks[across]; ++brick[across]) {
            const int level = selection.levels[linearIndex(brick, selection.bricks)];
            if (level == Selection::kEmpty)
                continue;
            // Middles of coarse samples may lie beyond the volume.
            const glm::dvec3 low(brick * kBrickExtent), high(low + double{kBrickExtent});
            if (plan_.view.part.any() && !plan_.view.part.meets(low, high))
                continue;
            const TileBox tiles = batch_.tilesOf(low, high, level);
            if (!tiles.empty() && !tiles_.ended(tiles))
                bricks.push_back({brick, level, tiles});
        }
    return bricks;
}

int SliceWalk::voxelsTogether(const std::vector<ShownBrick>& bricks) const {
    int voxels = kBrickExtent;
    const auto bytes = [&] {
        std::size_t sum = 0;
        for (const ShownBrick& b : bricks)
            sum += listBytesOf(b.level, voxels);
        return sum;
    };
    while (voxels > step_ && bytes() > listBytes_)
        voxels /= 2;
    return voxels;
}

void SliceWalk::addPoints(int sheet) {
    for (auto points = points_.next(sheet); !points.empty(); points = points_.next(sheet))
        batch_.add(points, points_.looks(), threads_);
}

void SliceWalk::drawPart(const std::vector<ShownBrick>& bricks, int layer, int from, int to, Work& work) {
    std::size_t bytes = 0;
    for (const ShownBrick& b : bricks)
        bytes += listBytesOf(b.level, to - from);
    const Charge charge = budget_.charge(bytes, "the lists of splats of a slice");
    std::vector<BrickList> lists(bricks.size());
    const auto listing = std::chrono::steady_clock::now();
    std::atomic<std::uint64_t> samples = 0, read = 0;
    parallelFor(bricks.size(), threads_, [&](std::size_t n) {
        const ShownBrick& b = bricks[n];
        if (tiles_.ended(b.tiles))
            return;
        const int first = from >> b.level;
        lists[n] = lister_.list(b.brick, first, std::max((to - from) >> b.level, 1));
        const auto edge = static_cast<std::uint64_t>(kBrickExtent >> b.level);
        samples += edge * edge * edge;
        ++read;
    });
    work.samples += samples;
    work.bricksUploaded += read;
    work.bytesUploaded += samples * bytesPerValue(plan_.info().type);
    secondsListing_ += secondsSince(listing);
    const int sheets = (to - from) / step_;
    for (int n = 0; n < sheets; ++n) {
        const int voxel = order_.fromEnd ? to - (n + 1) * step_ : from + n * step_;
        const int sheet = (layer * kBrickExtent + voxel) / step_;
        addPoints(sheet);
        for (std::size_t b = 0; b < bricks.size(); ++b)
            if (!lists[b].samples.empty() && !tiles_.ended(bricks[b].tiles))
                batch_.add(lists[b], voxel >> bricks[b].level, sheet,
                           static_cast<float>(step_) / static_cast<float>(1 << bricks[b].level), threads_);
    }
    batch_.draw(threads_);
}

Image SliceWalk::draw(const ShareDone& progress, Work& work) {
    const int layers = plan_.layer().selection.bricks[order_.axis];
    for (int n = 0; n < layers; ++n) {
        const int layer = order_.fromEnd ? layers - 1 - n : n;
        const std::vector<ShownBrick> bricks = bricksOf(layer);
        const int voxels = voxelsTogether(bricks);
        for (int part = 0; part < kBrickExtent / voxels && !bricks.empty(); ++part) {
            const int from = order_.fromEnd ? kBrickExtent - (part + 1) * voxels : part * voxels;
            drawPart(bricks, layer, from, from + voxels, work);
        }
        if (progress)
            progress((n + 1.0) / layers);
    }
    for (auto points = points_.next(); !points.empty(); points = points_.next())
        batch_.add(points, points_.looks(), threads_);
    batch_.draw(threads_);
    work.segments += batch_.counts().drawn;
    return tiles_.picture();
}

} // namespace tessera
