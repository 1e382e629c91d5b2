// render/plan/layer_histograms.h: the local histograms of a plan's volume, where its occlusion is by them
// (lighting.occlusion.method "histogram").
#pragma once

#include "bricking/mask/mask.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/plan/frame_plan.h"
#include "render/plan/layer_labels.h"

#include <cstdint>

namespace tessera {

/// Throws InputError for what histograms do not go with: labels and several volumes. Throws it for bleeding
/// by another method too.
void checkHistograms(const Scene& scene);
/// Tells masks apart; not 0.
std::uint32_t hiddenNumber(const Mask& mask);
/// True if the layer has what the scene's occlusion needs.
bool hasHistograms(const Scene& scene, const Layer& layer);
/// Gives the layer the histograms of the scene's occlusion, kept ones or new ones; none where the scene has
/// no use for any.
/// @param known  what was read before, or null
/// Throws InputError where ram has no room, and for a radius of more than 8 samples of every level.
void takeHistograms(const Scene& scene, KnownLayer* known, MemoryBudget& ram, int threads, Layer& layer);

} // namespace tessera
