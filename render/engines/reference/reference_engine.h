// render/engines/reference/reference_engine.h: the true integral in double, as an engine. It reads every
// voxel at the finest level, whatever levels were chosen, and takes no steps.
#pragma once

#include "core/scene.h"
#include "render/engine.h"

#include <vector>

namespace tessera {

class ReferenceEngine : public Engine {
  public:
    /// @param scene    of it shading and isosurfaces
    /// @param threads  0: all processors
    ReferenceEngine(const Scene& scene, int threads)
        : shading_(scene.shading), surfaces_(scene.surfaces), threads_(threads) {}
    About about() const override { return {}; }
    void open(std::span<ScenePlan* const> volumes, std::size_t pages) override;
    std::unique_ptr<RayCaster> caster(const CasterOptions& options, Ledger& gpu) override;
    std::unique_ptr<VisibilityCounter> counter(Ledger&) override { return nullptr; }

  private:
    Shading shading_;
    std::vector<Isosurface> surfaces_;
    int threads_;
    const ScenePlan* scene_ = nullptr;
};

} // namespace tessera
