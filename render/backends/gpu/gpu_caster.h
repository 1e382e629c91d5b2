// render/backends/gpu/gpu_caster.h: the ray caster of a scene on the GPU: `March` with its distance maps,
// made finer on the device where that pays (fine_mask.h).
#pragma once

#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/gpu/march.h"
#include "render/engine.h"

#include <cstdint>

namespace tessera {

class GpuCaster : public RayCaster {
  public:
    /// Scene and engine outlive it.
    GpuCaster(const FramePlan& scene, GpuEngine& engine, const CasterOptions& options, MemoryBudget& gpu);
    /// The same with exactly these features: for tests and studies that leave out features of the scene.
    GpuCaster(const FramePlan& scene, GpuEngine& engine, std::uint32_t features, MemoryBudget& gpu);

    void begin(const Rays& rays) override;
    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override;
    std::size_t waiting() const override { return march_.waiting(); }
    std::vector<std::uint32_t> takeWanted() override { return march_.takeWanted(); }
    Image image() const override;
    std::vector<SurfaceHit> hits() const override { return march_.hits(); }
    void refine() override;
    std::size_t refinedCells() const override { return refinedCells_; }
    std::uint32_t features() const override { return features_; }

    const March& march() const { return march_; }

  private:
    void takeFunction();
    void putBounds();

    const FramePlan& scene_;
    GpuEngine& engine_;
    MemoryBudget& gpu_;
    std::uint32_t features_; // the integrator's and the lights' included
    PlanRevisions taken_;    // of the plan, when rays last began
    Fetch fetch_;            // then
    std::size_t refinedCells_ = 0;
    std::uint64_t boundsVersion_ = 0; // of the bounds on the device; 0: none
    March march_;
};

} // namespace tessera
