// render/plan/layer_histograms.cpp: see layer_histograms.h.
#include "render/plan/layer_histograms.h"

#include "bricking/statistics/local_histograms.h"
#include "bricking/store/codec.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <span>
#include <string>

namespace tessera {
namespace {

bool isByHistograms(const Scene& scene) {
    return scene.lighting.occlusion && scene.lighting.occlusion->method == OcclusionMethod::histogram;
}

InputError refused(const std::string& expected, const std::string& found) {
    return InputError("lighting.occlusion: expected " + expected + " with method \"histogram\", found " +
                      found);
}

LocalHistogramSettings settingsOf(const Scene& scene) {
    LocalHistogramSettings settings;
    settings.radiusMm = scene.lighting.occlusion->radiusMm;
    return settings;
}

/// What a picture of single values or without light has no use for.
bool isUsed(const Scene& scene) {
    return isByHistograms(scene) && scene.shading.on && reductionOf(scene) == Reduction::composite;
}

} // namespace

void checkHistograms(const Scene& scene) {
    const auto& occlusion = scene.lighting.occlusion;
    if (!occlusion)
        return;
    if (!isByHistograms(scene)) {
        if (occlusion->bleeding > 0)
            throw InputError("lighting.occlusion: bleeding needs method \"histogram\", because rays keep no "
                             "colours; set bleeding to 0, or use \"histogram\"");
        return;
    }
    if (scene.volumes.size() > 1)
        throw refused("one volume", std::to_string(scene.volumes.size()));
    if (!scene.volumes.at(0).labels.path.empty() && reductionOf(scene) == Reduction::composite)
        throw refused("no labels, which change tissue by its place,", "some");
}

std::uint32_t hiddenNumber(const Mask& mask) {
    return std::max(1u, crc32c(std::as_bytes(mask.shares())));
}

bool hasHistograms(const Scene& scene, const Layer& layer) {
    return !isUsed(scene) || (layer.histograms && layer.histograms->settings == settingsOf(scene));
}

void takeHistograms(const Scene& scene, KnownLayer* known, MemoryBudget& ram, int threads, Layer& layer) {
    if (!isUsed(scene))
        return;
    const LocalHistogramSettings settings = settingsOf(scene);
    if (localHistogramLevel(layer.info(), settings.radiusMm) >= kLevelCount)
        throw refused("a radius of at most 8 samples of the coarsest level",
                      numberText(settings.radiusMm) + " mm");
    if (known && known->histograms && known->histograms->settings == settings) {
        layer.histograms = std::move(known->histograms);
        return;
    }
    layer.histograms = localHistogramsOf(*layer.store, layer.voxels(), layer.hidden, layer.statistics,
                                         settings, ram, threads);
}

} // namespace tessera
