// viewer/annotations/figure_part.cpp: see figure_part.h.
#include "viewer/annotations/figure_part.h"

#include "core/base/shown_text.h"
#include "core/scene/preset.h"
#include "render/plan/frame_plan.h" // summarise
#include "render/verify/verify_plan.h"
#include "viewer/session/label_list.h"
#include "viewer/session/volume_labels.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

/// With the functions that the names of presets mean for the volumes' values.
std::vector<LegendBar> legendOf(Scene scene, const std::vector<LegendVolume>& volumes) {
    for (std::size_t n = 0; n < scene.volumes.size(); ++n)
        if (const auto* const name = std::get_if<std::string>(&scene.volumes[n].transferFunction))
            scene.volumes[n].transferFunction = presetFunction(std::string(*name), volumes[n].values);
    std::vector<LegendBar> bars = colourLegend(scene, volumes);
    for (LegendBar& bar : bars) // names of files may be those of patients
        bar.name = scene.volumes.size() > 1 ? "volume " + std::to_string(bar.volume + 1) : "";
    return bars;
}

std::string between(const Estimate& e) {
    return numberText(e.value, 2) + " (" + numberText(e.low, 2) + " to " + numberText(e.high, 2) + ")";
}

} // namespace

FigureMaker::FigureMaker(const Scene& scene, Stores stores, MemoryBudget& ram, int threads) {
    orientationKnown_ = std::all_of(stores.begin(), stores.end(),
                                    [](const StoreReader* store) { return store->info().orientationKnown; });
    for (std::size_t n = 0; n < scene.volumes.size() && scene.annotations.legend; ++n) {
        const VolumeInfo& info = stores[n]->info();
        const std::string& unit = scene.volumes[n].unit;
        volumes_.push_back({summarise(loadStatistics(*stores[n], ram, threads), info, unit),
                            unit.empty() ? info.unit : unit});
    }
    if (scene.annotations.labelLegend)
        for (const SceneVolume& volume : scene.volumes)
            labels_.push_back(volume.labels.path.empty() ? LabelList()
                                                         : VolumeLabels(volume.labels, ram).list());
}

FigurePart FigureMaker::part(const Scene& scene, const RenderResult& result) const {
    FigurePart part;
    part.size = result.image.size;
    part.camera = result.camera;
    part.annotations = scene.annotations;
    part.orientationKnown = orientationKnown_;
    part.onLight = isLight(scene.background);
    if (!volumes_.empty())
        part.legend = legendOf(scene, volumes_);
    for (std::size_t n = 0; n < labels_.size(); ++n) {
        const SceneVolume& volume = scene.volumes[n];
        if (volume.opacity > 0)
            for (LegendLabel& label : legendLabels(labels_[n], volume.labels))
                part.labels.push_back(std::move(label));
    }
    if (scene.annotations.measurements)
        part.measurements = scene.measurements;
    if (scene.annotations.error)
        part.error = errorCaption(result);
    return part;
}

Figure FigureMaker::figure(const Scene& scene, const RenderResult& result) const {
    return {result.image.size, scene.annotations.dpi, {part(scene, result)}};
}

std::string errorCaption(const RenderResult& result) {
    const std::string head = "measured error: ";
    if (!result.measured)
        return head + "not measured";
    const PictureMeasurement& m = *result.measured;
    if (!m.whyNot.empty())
        return head + "not measured, because " + m.whyNot;
    if (m.all.luvP99)
        return head + between(*m.all.luvP99) + " L*u*v* at the 99th percentile";
    if (m.all.luvMean)
        return head + between(*m.all.luvMean) + " L*u*v* in the mean";
    return head + "not measured, because too few pixels show something";
}

} // namespace tessera
