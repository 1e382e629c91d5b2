// render/plan/label_optics.h: labels with a transfer function or a material of their own: a further volume of
// the same voxels draws them (docs/sampling.md, "Labels").
#pragma once

#include "core/scene/preset.h"
#include "core/scene/scene.h"
#include "render/plan/frame_plan.h"

#include <vector>

namespace tessera {

/// The volumes of a picture.
struct DrawnVolumes {
    Scene scene;
    std::vector<const StoreReader*> stores; // of its volumes, in order
};

/// True if labels of a composite picture have optics of their own.
bool hasLabelOptics(const Scene& scene);

/// The scene with a volume more for each function and material that its labels have (opticsOf()), last.
/// @param stores  of the scene's volumes
/// Throws InputError for another fusion than mix, and for more than Scene::kMaxVolumes volumes.
DrawnVolumes withLabelOptics(const Scene& scene, Stores stores);

/// The function that a volume is drawn with: all values have the material of the labels that it draws alone.
TransferFunction ofLabels(TransferFunction function, const Labels& labels, const ValueSummary& values);

} // namespace tessera
