// render/plan/layer_labels.cpp: see layer_labels.h.
#include "render/plan/layer_labels.h"

#include "core/base/error.h"
#include "render/labels/label_looks.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tessera {
namespace {

/// Throws InputError naming the labels where their voxels are not those of the volume.
void requireSameLattice(const StoreReader& labels, const VolumeInfo& volume) {
    const VolumeInfo& info = labels.info();
    const auto text = [](const glm::ivec3& e) {
        return std::to_string(e.x) + " x " + std::to_string(e.y) + " x " + std::to_string(e.z) + " voxels";
    };
    if (info.extentVoxels != volume.extentVoxels)
        throw badFile(labels.path().string(), "labels of " + text(volume.extentVoxels) + ", as the volume",
                      text(info.extentVoxels));
    constexpr double kSame = 1e-3; // of a voxel
    const glm::dmat4 between = glm::inverse(volume.patientFromVoxel) * info.patientFromVoxel;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at =
            glm::dvec3(volume.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2);
        const glm::dvec3 off = glm::abs(glm::dvec3(between * glm::dvec4(at, 1)) - at);
        if (!(std::max({off.x, off.y, off.z}) < kSame))
            throw badFile(labels.path().string(), "labels on the volume's voxels",
                          "others, " + std::to_string(std::max({off.x, off.y, off.z})) + " voxels away");
    }
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
    requireSameLattice(volume->voxels(), layer.info());
    LabelTable table = namedLabels(volume->table(), labels);
    LabelMedium medium = labelLooks(table, labels, typicalVoxelMm(layer.info()), "volumes[0].labels");
    layer.labels = std::make_unique<DrawnLabels>(std::move(volume), std::move(table), std::move(medium.bySet),
                                                 medium.density);
    layer.labelBricks = std::make_unique<LabelBricks>(*layer.labels, ram);
    layer.labels->showOnly(layer.statistics, ram);
}

} // namespace tessera
