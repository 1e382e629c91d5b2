// viewer/annotations/figure_part.cpp: see figure_part.h.
#include "viewer/annotations/figure_part.h"

#include "core/base/shown_text.h"
#include "core/scene/preset.h"
#include "render/plan/frame_plan.h" // summarise
#include "render/verify/verify_plan.h"
#include "viewer/session/label_list.h"
#include "viewer/session/volume_labels.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

constexpr glm::vec3 kLuminance{0.2126f, 0.7152f, 0.0722f}; // of linear Rec. 709
constexpr float kLight = 0.18f; // of a background; lighter ones look nearer to white than to black

/// With the functions that the names of presets mean for the volumes' values.
std::vector<LegendBar> legendOf(Scene scene, Stores stores, MemoryBudget& ram, int threads) {
    std::vector<LegendVolume> volumes;
    for (std::size_t n = 0; n < scene.volumes.size(); ++n) {
        SceneVolume& volume = scene.volumes[n];
        const VolumeInfo& info = stores[n]->info();
        const ValueSummary values = summarise(loadStatistics(*stores[n], ram, threads), info, volume.unit);
        if (const auto* const name = std::get_if<std::string>(&volume.transferFunction))
            volume.transferFunction = presetFunction(std::string(*name), values);
        volumes.push_back({values, volume.unit.empty() ? info.unit : volume.unit});
    }
    std::vector<LegendBar> bars = colourLegend(scene, volumes);
    for (std::size_t n = 0; n < bars.size(); ++n) // names of files may be those of patients
        bars[n].name = bars.size() > 1 ? "volume " + std::to_string(n + 1) : "";
    return bars;
}

/// Labels with voxels that the scene's rules show.
std::vector<LegendLabel> labelsOf(const Scene& scene, MemoryBudget& ram) {
    std::vector<LegendLabel> shown;
    for (const SceneVolume& volume : scene.volumes) {
        if (volume.labels.path.empty() || !(volume.opacity > 0))
            continue;
        const LabelList list = VolumeLabels(volume.labels, ram).list();
        const std::vector<LabelState> states = labelStates(list, volume.labels);
        for (std::size_t n = 0; n < list.size(); ++n)
            if (states[n].shows && list[n].hasVoxels)
                shown.push_back(
                    {list[n].name.empty() ? "label " + std::to_string(list[n].value) : list[n].name,
                     glm::vec3(states[n].colour)});
    }
    return shown;
}

std::string between(const Estimate& e) {
    return numberText(e.value, 2) + " (" + numberText(e.low, 2) + " to " + numberText(e.high, 2) + ")";
}

} // namespace

FigurePart figurePart(const Scene& scene, Stores stores, const RenderResult& result, MemoryBudget& ram,
                      int threads) {
    FigurePart part;
    part.size = result.image.size;
    part.camera = result.camera;
    part.annotations = scene.annotations;
    part.orientationKnown = std::all_of(stores.begin(), stores.end(), [](const StoreReader* store) {
        return store->info().orientationKnown;
    });
    part.onLight = scene.background && glm::dot(*scene.background, kLuminance) > kLight;
    if (scene.annotations.legend)
        part.legend = legendOf(scene, stores, ram, threads);
    if (scene.annotations.labelLegend)
        part.labels = labelsOf(scene, ram);
    if (scene.annotations.measurements)
        part.measurements = scene.measurements;
    if (scene.annotations.error)
        part.error = errorCaption(result);
    return part;
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
