// render/backends/reference/reference_engine.h: the true integral in double, as an engine. It reads the
// finest level, whatever levels were chosen, and has no step.
#pragma once

#include "render/engine.h"
#include "render/engine_traits.h"

namespace tessera {

class ReferenceEngine : public Engine {
  public:
    /// @param threads  0: all processors
    explicit ReferenceEngine(int threads) : threads_(threads) {}
    About about() const override { return {}; }
    void open(const FramePlan& plan, std::size_t pages) override;
    std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) override;
    std::unique_ptr<VisibilityCounter> counter(MemoryBudget&) override { return nullptr; }

  private:
    int threads_;
    const FramePlan* scene_ = nullptr;
};

EngineTraits referenceTraits();

} // namespace tessera
