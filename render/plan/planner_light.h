// render/plan/planner_light.h: RAM that a plan's light of voxels takes.
#pragma once

#include "render/light/light_memory.h"
#include "render/plan/planner.h"

namespace tessera {

inline std::size_t lightBytes(const Planner& p, const Lighting& lighting) {
    return lightRamBytes(lighting, p.info(), p.view.shadowQuality, p.threads, !p.view.meshes.empty(),
                         p.view.amongOthers) +
           lightOfMeshesBytes(lighting, p.info(), p.view.meshes);
}

} // namespace tessera
