// render/picture/several_volumes.h: pictures of several volumes in modes that show single values: each volume
// is drawn alone, and their pictures are put over one another (docs/sampling.md, "Several volumes").
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/renderer.h"

#include <span>

namespace tessera {

/// @param scene  of a mode of single values
/// @param stores  of its volumes, in order
/// The result is the first volume's, but for the picture and the work.
RenderResult drawVolumesAlone(const Scene& scene, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                              const RenderOptions& options);

/// Puts a volume's picture over those of the volumes before, both premultiplied.
void layOver(Image& below, const Image& above, Fusion rule);

} // namespace tessera
