// render/plan/layer_labels.cpp: see layer_labels.h.
#include "render/plan/layer_labels.h"

#include "core/base/error.h"
#include "render/labels/label_looks.h"

#include <string>
#include <utility>

namespace tessera {
namespace {

std::string extentOf(const VolumeInfo& info) {
    const glm::ivec3& e = info.extentVoxels;
    return std::to_string(e.x) + " x " + std::to_string(e.y) + " x " + std::to_string(e.z) + " voxels";
}

/// Throws InputError naming the labels where their voxels are not those of the volume.
void requireSameGrid(const StoreReader& labels, const VolumeInfo& volume) {
    if (!isSameGrid(labels.info(), volume))
        throw badFile(labels.path().string(), "labels on the volume's grid of " + extentOf(volume),
                      extentOf(labels.info()) + " in size or place of their own");
}

} // namespace

KnownLayer KnownLayer::of(Layer& layer) {
    return {std::move(layer.statistics), std::move(layer.labels), std::move(layer.labelBricks)};
}

void takeLabels(const Scene& scene, KnownLayer* known, MemoryBudget& ram, Layer& layer) {
    const Labels& labels = scene.volumes.at(0).labels;
    if (labels.path.empty() || reductionOf(scene) != Reduction::composite) {
        layer.statistics.showFunction();
        return;
    }
    if (known && known->labels) {
        layer.labels = std::move(known->labels);
        layer.labelBricks = std::move(known->labelBricks);
        return;
    }
    if (!scene.surfaces.empty())
        throw InputError("volumes[0].labels: expected no isosurfaces beside labels, found " +
                         std::to_string(scene.surfaces.size()) + "; leave one of them out");
    if (const Integrator named = scene.quality.integrator;
        named != Integrator::automatic && named != Integrator::midpoint)
        throw InputError(
            "integrator: expected midpoint with labels, whose shares change within a segment, found " +
            integratorNames()[static_cast<std::size_t>(named)]);
    auto volume = std::make_unique<LabelVolume>(labels.store.empty() ? labels.path : labels.store, ram);
    requireSameGrid(volume->voxels(), layer.info());
    LabelTable table = namedLabels(volume->table(), labels);
    LabelMedium medium = labelLooks(table, labels, typicalVoxelMm(layer.info()), "volumes[0].labels");
    layer.labels = std::make_unique<DrawnLabels>(std::move(volume), std::move(table), std::move(medium.bySet),
                                                 medium.density);
    layer.labelBricks = std::make_unique<LabelBricks>(*layer.labels, ram);
    layer.labels->showOnly(layer.statistics, ram);
}

} // namespace tessera
