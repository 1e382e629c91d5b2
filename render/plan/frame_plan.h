// render/plan/frame_plan.h: FramePlan: everything that a renderer needs of a scene and its volumes. Renderers
// read it; a Planner (planner.h) makes it, and makes it again when something is learnt.
#pragma once

#include "core/scene/scene.h"
#include "render/contract/strides.h"
#include "render/plan/choose_levels.h"
#include "render/plan/layer.h"
#include "render/plan/memory_plan.h"
#include "render/plan/view_state.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace tessera {

/// Numbers that are never the same for two states of a part of any plan: who keeps something made from that
/// part compares them before rays begin.
struct PlanRevisions {
    std::uint64_t function = 0;   // transfer function, materials, lights
    std::uint64_t tables = 0;     // of the function, for the integrator and the step; where rays end
    std::uint64_t levels = 0;     // of bricks, and their map
    std::uint64_t emptySpace = 0; // its maps

    static std::uint64_t next();
};

/// The layers of a plan. They stay where they are when another plan takes this one's place, because light
/// that renderers keep from frame to frame refers to their statistics and tables.
class Layers {
  public:
    Layers() { all_.push_back(std::make_unique<Layer>()); }
    Layers(Layers&& other) noexcept : all_(std::move(other.all_)) {}
    Layers& operator=(Layers&& other) noexcept;
    Layer& front() { return *all_.front(); }
    const Layer& front() const { return *all_.front(); }

  private:
    std::vector<std::unique_ptr<Layer>> all_; // one so far
};

struct FramePlan {
    ViewState view;
    MemoryPlan memory;
    ChosenLevels chosen; // report of the choice of levels; the selection itself has moved to the layer
    PlanRevisions revisions;
    Integrator mayTake = Integrator::midpoint; // the largest that is taken without being named
    /// The visible volumes, each with levels of its own; one so far. Last: their caches go first.
    Layers layers;

    const Layer& layer() const { return layers.front(); }
    const VolumeInfo& info() const { return layer().info(); }
    /// Those worth trying on some pixels: one, where the function leaves no doubt or the scene names it.
    std::vector<Integrator> integratorsToTry() const;
    /// GPU memory of a function's tables, whichever integrator it may come to.
    std::size_t gpuTableBytes(std::size_t entries) const;
    /// Valid as long as the plan is there, moved or not.
    Strides strides() const;

  protected:
    Integrator automaticIntegrator() const;
    Integrator preintegration() const;
};

} // namespace tessera
