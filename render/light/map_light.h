// render/light/map_light.h: scattered light by light maps (light_map.h; docs/sampling.md, "Light maps"),
// which shadow maps of the scattered lights keep.
#pragma once

#include "render/light/scatter_light.h"

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace tessera {

class MapLight : public AddedLight {
  public:
    /// @param info  outlives this
    /// @param ambient  as AddedLight has it
    MapLight(const VolumeInfo& info, const Lighting& lighting, std::unique_ptr<LightSource> ambient)
        : AddedLight(info, lighting, std::move(ambient)) {}

  private:
    void add(const ChunkKey& chunk, BrickCache& cache, const OcclusionRoom& room,
             const Add& put) const override;
};

} // namespace tessera
