// render/plan/layer_labels.h: the labels of a layer: opened for a scene, or handed on from the plan before.
#pragma once

#include "render/plan/frame_plan.h"

#include <memory>

namespace tessera {

/// What a plan of the same volume and scene, but for its camera, has read before: moved from. What refers to
/// the labels stays valid, because they are the same.
struct KnownLayer {
    Statistics statistics;
    std::unique_ptr<DrawnLabels> labels; // null where the scene has none
    std::unique_ptr<LabelBricks> labelBricks;
    std::shared_ptr<SliceLabels> sliceLabels;
    std::shared_ptr<const LocalHistograms> histograms;
    /// Of a layer that is not used any more.
    static KnownLayer of(Layer& layer);
};

/// The stored value of what is hidden: -1000 HU, held to the volume's range; else its least value.
double storedAir(const Statistics& statistics, const VolumeInfo& info, bool isHu);

/// Hides the scene's hidden labels from isosurfaces and from rays that keep one value: their voxels read as
/// air, to a least value as the greatest. Nothing in other modes, and in slices. Throws InputError as
/// takeLabels() does, and for labels with looks where a volume shows beside isosurfaces.
void hideLabels(const Scene& scene, const ValueSummary& values, MemoryBudget& ram, int threads, Layer& layer);

/// Gives the layer the labels of the scene, and sets in its statistics what shows; in slices those that lie
/// over the values; none where the scene's mode has no labels.
/// @param known  null: labels are read
/// Throws InputError for a scene that labels do not go with, labels on other voxels than the volume's,
/// patterns that match nothing, and where ram has no room.
void takeLabels(const Scene& scene, KnownLayer* known, MemoryBudget& ram, int threads, Layer& layer);

} // namespace tessera
