// render/backends/splat/slice_walk.h: the slices of a plan's bricks front to back, layer by layer of bricks:
// each brick is listed, and its slices go to a batch in their order (docs/sampling.md, "Splats").
#pragma once

#include "core/base/budget.h"
#include "core/base/progress.h"
#include "core/base/work.h"
#include "render/backends/splat/sheet_tiles.h"
#include "render/backends/splat/splat_batch.h"
#include "render/backends/splat/splat_samples.h"
#include "render/backends/splat/splat_settings.h"
#include "render/plan/frame_plan.h"

#include <cstddef>
#include <vector>

namespace tessera {

class SliceWalk {
  public:
    /// All of it outlives this.
    SliceWalk(const FramePlan& plan, const SplatView& view, const SplatSettings& settings,
              const SliceOrder& order, int threads, MemoryBudget& budget);

    Image draw(const ShareDone& progress, Work& work);
    const SplatCounts& counts() const { return batch_.counts(); }
    double secondsListing() const { return secondsListing_; }

  private:
    struct ShownBrick {
        glm::ivec3 brick;
        int level;
        TileBox tiles;
    };
    std::vector<ShownBrick> bricksOf(int layer) const;
    /// Voxels along the axis that are listed together: half as many until their lists have room.
    int voxelsTogether(const std::vector<ShownBrick>& bricks) const;
    /// Points before a sheet and in it.
    void addPoints(int sheet);
    void drawPart(const std::vector<ShownBrick>& bricks, int layer, int from, int to, Work& work);

    const FramePlan& plan_;
    int threads_;
    MemoryBudget& budget_;
    SliceOrder order_;
    SampleLister lister_;
    SheetTiles tiles_;
    Charge scratch_;
    std::size_t listBytes_; // that lists may take
    SplatBatch batch_;
    int step_; // voxels of a sheet: the finest level's
    SplatPoints points_;
    double secondsListing_ = 0;
};

} // namespace tessera
