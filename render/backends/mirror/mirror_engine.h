// render/backends/mirror/mirror_engine.h: the contract on the CPU, in float, as an engine. Bricks are read
// from the cache as rays need them.
#pragma once

#include "render/engine.h"
#include "render/engine_traits.h"

namespace tessera {

class MirrorEngine : public Engine {
  public:
    /// @param threads  0: all processors
    explicit MirrorEngine(int threads) : threads_(threads) {}
    About about() const override {
        About about;
        about.choosesSteps = true;
        return about;
    }
    void open(const FramePlan& plan, std::size_t pages) override;
    std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) override;
    std::unique_ptr<VisibilityCounter> counter(MemoryBudget& gpu) override;

  private:
    int threads_;
    const FramePlan* scene_ = nullptr;
};

EngineTraits mirrorTraits();

} // namespace tessera
