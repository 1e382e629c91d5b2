// viewer/annotations/figure_part.cpp: see figure_part.h.
#include "viewer/annotations/figure_part.h"

#include "bricking/cache/brick_cache.h"
#include "core/base/shown_text.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/mode.h"
#include "core/scene/preset.h"
#include "render/plan/frame_plan.h" // summarise
#include "render/verify/verify_plan.h"
#include "viewer/annotations/shown_plane.h"
#include "viewer/session/disc_values.h"
#include "viewer/session/label_list.h"
#include "viewer/session/volume_labels.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
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

/// Of a slice those labels that lie on it.
LabelList shownOn(const RenderResult& result, std::size_t volume, const LabelList& all) {
    if (!result.labels || result.labels->onSlice.empty())
        return all;
    LabelList shown;
    if (volume < result.labels->onSlice.size())
        for (const std::uint32_t value : result.labels->onSlice[volume])
            if (const std::optional<std::size_t> number = numberOf(all, value))
                shown.push_back(all[*number]);
    return shown;
}

std::string between(const Estimate& e) {
    return numberText(e.value, 2) + " (" + numberText(e.low, 2) + " to " + numberText(e.high, 2) + ")";
}

/// Mean and deviation in circles; "" of other measurements.
/// @param unit  of the scene; "": the store's
std::vector<std::string> valuesOf(const std::vector<Measurement>& measurements, const StoreReader& store,
                                  const std::string& unit, MemoryBudget& ram, int threads) {
    constexpr std::size_t kCacheBytes = std::size_t{8} << 20;
    std::vector<std::string> values(measurements.size());
    std::unique_ptr<BrickCache> cache;
    for (std::size_t n = 0; n < measurements.size(); ++n)
        if (measurements[n].kind == MeasurementKind::circle) {
            if (!cache)
                cache = std::make_unique<BrickCache>(store, ram, kCacheBytes, threads);
            values[n] = discText(discValues(*cache, store.info(), measurements[n]),
                                 unit.empty() ? store.info().unit : unit);
        }
    return values;
}

} // namespace

FigureMaker::FigureMaker(const Scene& scene, Stores stores, MemoryBudget& ram, int threads) {
    info_ = stores.front()->info();
    orientationKnown_ = std::all_of(stores.begin(), stores.end(),
                                    [](const StoreReader* store) { return store->info().orientationKnown; });
    for (std::size_t n = 0; n < scene.volumes.size() && scene.annotations.legend; ++n) {
        const VolumeInfo& info = stores[n]->info();
        const std::string& unit = scene.volumes[n].unit;
        volumes_.push_back({summarise(loadStatistics(*stores[n], ram, threads), info, unit),
                            unit.empty() ? info.unit : unit});
    }
    if (scene.annotations.measurements)
        values_ = valuesOf(scene.measurements, *stores.front(), scene.volumes.front().unit, ram, threads);
    if (scene.annotations.labelLegend)
        for (const SceneVolume& volume : scene.volumes)
            labels_.push_back(volume.labels.path.empty() ? LabelList()
                                                         : VolumeLabels(volume.labels, ram).list());
}

FigurePart FigureMaker::part(const Scene& scene, const RenderResult& result) const {
    FigurePart part;
    part.size = result.image.size == glm::ivec2(0) ? scene.imageSize : result.image.size;
    part.camera = result.camera;
    part.annotations = scene.annotations;
    part.orientationKnown = orientationKnown_;
    part.onLight = isLight(scene.background);
    const std::optional<glm::vec3> strips =
        scene.annotations.marginColour ? scene.annotations.marginColour : scene.background;
    part.stripColour = strips ? glm::vec4(*strips, 1) : glm::vec4(0);
    part.stripsAreLight = isLight(strips);
    if (!volumes_.empty())
        part.legend = legendOf(scene, volumes_);
    for (std::size_t n = 0; n < labels_.size(); ++n) {
        const SceneVolume& volume = scene.volumes[n];
        if (volume.opacity > 0)
            for (LegendLabel& label : legendLabels(shownOn(result, n, labels_[n]), volume.labels))
                part.labels.push_back(std::move(label));
    }
    if (scene.annotations.measurements)
        part.measurements = scene.measurements, part.values = values_;
    if (scene.mode == Mode::slice)
        part.plane = planeOf(scene.slice, info_);
    if (scene.annotations.error)
        part.error = errorCaption(result);
    return part;
}

FigurePart FigureMaker::partToCome(const Scene& scene) const {
    RenderResult none;
    if (const auto* const camera = std::get_if<Camera>(&scene.camera))
        none.camera = *camera;
    FigurePart to = part(scene, none);
    if (scene.annotations.error)
        to.error = "measured error: 0.00 (0.00 to 0.00) L*u*v* at the 99th percentile";
    return to;
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
