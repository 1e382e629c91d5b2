// render/plan/layer_labels.cpp: see layer_labels.h.
#include "render/plan/layer_labels.h"

#include "bricking/mask/masked_source.h"
#include "core/base/error.h"
#include "render/labels/label_looks.h"
#include "render/labels/label_mask.h"
#include "render/labels/slice_labels.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tessera {
namespace {

struct OpenedLabels {
    std::unique_ptr<LabelVolume> volume;
    LabelTable table;
    LabelMedium medium;
};
OpenedLabels openLabels(const Labels& labels, MemoryBudget& ram, const VolumeInfo& info) {
    OpenedLabels opened;
    opened.volume = std::make_unique<LabelVolume>(labels.store.empty() ? labels.path : labels.store, ram);
    requireSameGrid(opened.volume->voxels(), info);
    opened.table = namedLabels(opened.volume->table(), labels);
    opened.medium = labelLooks(opened.table, labels, typicalVoxelMm(info), labels.place());
    return opened;
}

} // namespace

double storedAir(const Statistics& statistics, const VolumeInfo& info, bool isHu) {
    constexpr double kAirHu = -1000;
    const double least = info.rescaleSlope > 0 ? static_cast<double>(statistics.lowest)
                                               : static_cast<double>(statistics.highest);
    return isHu ? std::clamp(std::round((kAirHu - info.rescaleIntercept) / info.rescaleSlope),
                             static_cast<double>(statistics.lowest), static_cast<double>(statistics.highest))
                : least;
}

namespace {

/// True if labels hide by a mask, and have no looks.
bool hidesByMask(const Scene& scene) {
    return scene.mode != Mode::slice &&
           (reductionOf(scene) != Reduction::composite || !scene.surfaces.empty());
}

/// Throws InputError for labels that a volume beside isosurfaces would show by looks.
void requirePlain(const std::vector<LabelFactors>& bySet, const std::string& where) {
    for (const LabelFactors& f : bySet)
        if (f.shows() && f.plain != 1)
            throw badFile(where, "labels of look plain and opacity 1 beside isosurfaces and a volume",
                          "solid, tinted or translucent ones; mode isosurface takes any");
}

} // namespace

void hideLabels(const Scene& scene, const ValueSummary& values, MemoryBudget& ram, int threads,
                Layer& layer) {
    const Labels& labels = scene.volumes.at(0).labels;
    const Reduction reduction = reductionOf(scene);
    if (labels.path.empty() || !hidesByMask(scene))
        return;
    OpenedLabels opened = openLabels(labels, ram, layer.info());
    if (reduction == Reduction::composite && scene.mode != Mode::isosurface)
        requirePlain(opened.medium.bySet, labels.place());
    std::vector<LabelFactors> drawn = drawnOrHidden(std::move(opened.medium.bySet));
    if (std::all_of(drawn.begin(), drawn.end(), [](const LabelFactors& f) { return f.shows(); }))
        return;
    auto mask = std::make_shared<LabelMask>(std::make_unique<DrawnLabels>(
        std::move(opened.volume), std::move(opened.table), std::move(drawn), 0.0f));
    const bool risesWithStored = layer.info().rescaleSlope > 0;
    const double greatest = risesWithStored ? static_cast<double>(layer.statistics.highest)
                                            : static_cast<double>(layer.statistics.lowest);
    const double air = reduction == Reduction::minimum
                           ? greatest
                           : storedAir(layer.statistics, layer.info(), values.isHu || looksLikeHu(values));
    auto masked = std::make_unique<MaskedSource>(layer.voxels(), std::move(mask), air, ram, threads);
    hideMasked(layer.statistics, *masked, ram, threads);
    layer.unlabelled = std::move(masked);
}

KnownLayer KnownLayer::of(Layer& layer) {
    return {std::move(layer.statistics), std::move(layer.labels), std::move(layer.labelBricks),
            std::move(layer.sliceLabels), std::move(layer.histograms)};
}

void takeLabels(const Scene& scene, KnownLayer* known, MemoryBudget& ram, int threads, Layer& layer) {
    const Labels& labels = scene.volumes.at(0).labels;
    if (labels.path.empty() || reductionOf(scene) != Reduction::composite || hidesByMask(scene)) {
        layer.statistics.showFunction();
        if (!labels.path.empty() && scene.mode == Mode::slice)
            layer.sliceLabels =
                known && known->sliceLabels
                    ? std::move(known->sliceLabels)
                    : std::make_shared<SliceLabels>(labels, layer.info(), ram, threads, labels.place());
        return;
    }
    if (known && known->labels) {
        layer.labels = std::move(known->labels);
        layer.labelBricks = std::move(known->labelBricks);
        return;
    }
    if (const Integrator named = scene.quality.integrator;
        named != Integrator::automatic && named != Integrator::midpoint)
        throw InputError(
            "integrator: expected midpoint with labels, whose shares change within a segment, found " +
            integratorNames()[static_cast<std::size_t>(named)]);
    OpenedLabels opened = openLabels(labels, ram, layer.info());
    layer.labels =
        std::make_unique<DrawnLabels>(std::move(opened.volume), std::move(opened.table),
                                      std::move(opened.medium.bySet), opened.medium.density, labels.borders);
    layer.labelBricks = std::make_unique<LabelBricks>(*layer.labels, ram);
    layer.labels->showOnly(layer.statistics, ram);
}

} // namespace tessera
