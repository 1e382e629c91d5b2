// render/exposure/exposed_caster.h: ExposedCaster: the ray caster of a scene whose rays show sums, by that of
// any engine (docs/sampling.md, "Sums along rays"). The engine draws a thin medium, and knows nothing of it.
#pragma once

#include "render/engine.h"

#include <memory>
#include <utility>
#include <vector>

namespace tessera {

class ExposedCaster : public RayCaster {
  public:
    /// @param plan  of what the caster draws, with an exposure; outlives this
    ExposedCaster(std::unique_ptr<RayCaster> sums, const FramePlan& plan, int threads);

    void begin(const Rays& rays) override;
    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override {
        return sums_->draw(slicing, deadline, work);
    }
    std::size_t waiting() const override { return sums_->waiting(); }
    std::vector<std::uint32_t> takeWanted(std::size_t volume) override { return sums_->takeWanted(volume); }
    /// Through the plan's window; where it has none, through one of this picture.
    Image image() const override;
    std::optional<GreyWindow> window() const override { return window_; }
    void refine() override { sums_->refine(); }
    std::size_t refinedCells() const override { return sums_->refinedCells(); }
    std::uint32_t features() const override { return sums_->features(); }

  private:
    std::unique_ptr<RayCaster> sums_;
    const FramePlan& plan_;
    int threads_;
    Rays rays_;
    mutable std::optional<GreyWindow> window_; // of the last image
};

/// An engine's caster for a plan, which it has opened, with what lies above engines: meshes, an exposure, or
/// other processes.
/// @param threads  0: all processors
/// @param shadows  fall on meshes; false: for pictures that must come soon
std::unique_ptr<RayCaster> casterOf(Engine& engine, const FramePlan& plan, const CasterOptions& options,
                                    MemoryBudget& gpu, int threads, bool shadows = true);

} // namespace tessera
