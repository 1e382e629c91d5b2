// render/picture/several_volumes.h: pictures of several volumes in modes that show single values: each volume
// is drawn alone, and their pictures are put over one another (docs/sampling.md, "Several volumes").
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/renderer.h"

#include <span>
#include <vector>

namespace tessera {

/// @param scene  of a mode of single values
/// @param stores  of its volumes, in order
/// The result is the first volume's, but for the picture and the work.
RenderResult drawVolumesAlone(const Scene& scene, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                              const RenderOptions& options);

/// A slice without a place lies in the middle of the first volume.
void placeSlice(SlicePlane& slice, const VolumeInfo& first);

// A volume but the first whose values have the function's colours is also times the function's opacity at the
// value, which a second picture tells.

bool takesOpacities(const Scene& scene, std::size_t number);
/// A function whose colours are the opacities. Both are linear between points.
TransferFunction opacitiesAsGreys(const TransferFunction& function);
/// The opacities of a picture that was drawn with it.
std::vector<float> opacitiesOf(const Image& greys);
/// @param opacities  empty: 1
void weigh(Image& picture, double opacity, const std::vector<float>& opacities);

/// Puts a volume's picture over those of the volumes before, both premultiplied.
void layOver(Image& below, const Image& above, Fusion rule);

} // namespace tessera
