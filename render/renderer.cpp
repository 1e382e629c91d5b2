// render/renderer.cpp: see renderer.h.
#include "render/renderer.h"

#include "core/scene/preset.h"
#include "core/scene/scene_presets.h"
#include "render/plan/fusion.h"
#include "render/residency/pages.h"

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

namespace tessera {

std::vector<FillValue> fillsLeftOut(const Scene& scene, const ValueSummary& values) {
    const Reduction reduction = reductionOf(scene);
    bool adapts = false;
    if (reduction == Reduction::composite) {
        const auto* const name = std::get_if<std::string>(&scene.volumes.front().transferFunction);
        adapts =
            name && scene.mode != Mode::isosurface && (*name == "auto" || overShares(builtInPreset(*name)));
    } else if (reduction != Reduction::sum) {
        const auto* const name = std::get_if<std::string>(&scene.window);
        adapts = name && *name == "auto" && !values.isHu && !looksLikeHu(values);
    }
    return adapts ? values.fills : std::vector<FillValue>();
}

void reportVolume(const FramePlan& plan, const Scene& scene, RenderResult& result) {
    const Layer& layer = plan.layer();
    const ValueSummary values = summarise(layer.statistics, plan.info(), scene.volumes.front().unit);
    result.camera = plan.view.camera;
    result.cells = cellCount(layer.statistics.cells);
    result.window = layer.look.window;
    result.lowest = values.lowest;
    result.highest = values.highest;
    result.leftOut = fillsLeftOut(scene, values);
    result.patientTable = layer.patientTable;
    if (layer.labels) {
        std::size_t shown = layer.labels->shownLabels();
        for (const auto& volume : plan.further) // labels with functions of their own
            if (const Layer& own = volume->plan.layer(); own.store == layer.store && own.labels)
                shown += own.labels->shownLabels();
        const std::size_t all = layer.labels->table().labels.size();
        result.labels = {all, std::min(all, shown), layer.labels->numbers().count};
    }
    result.tableRelativeError = layer.table.relativeError;
}

void reportLevels(const FramePlan& plan, RenderResult& result) {
    const Selection& selection = plan.layer().selection;
    result.level = selection.finest();
    result.integrator = plan.layer().optics.integrator;
    result.stepVoxels = plan.view.quality.stepVoxels;
    result.hulls = hullsOf(plan.view.frame);
    result.bricksOfLevel = selection.counts;
    result.selectionPages = pagesFor(selection.counts);
    result.atlasPages = std::min(plan.chosen.atlasPages, result.selectionPages);
    result.residentBricks = selection.shownBricks();
    result.emptyBricks = selection.counts[Selection::kEmpty];
    result.further.clear();
    if (plan.fused)
        result.rayExtent = plan.rayVoxels().extentVoxels;
    for (const auto& volume : plan.further) {
        const Selection& own = volume->plan.layer().selection;
        result.further.push_back({own.finest(), own.counts, volume->ram.limitBytes(), volume->ram.peakBytes(),
                                  volume->gpu.limitBytes(), volume->gpu.peakBytes()});
        for (std::size_t level = 0; level < own.counts.size(); ++level)
            result.bricksOfLevel[level] += own.counts[level];
        result.level = std::min(result.level, own.finest());
        result.selectionPages += pagesFor(own.counts);
        result.atlasPages += std::min(volume->plan.chosen.atlasPages, pagesFor(own.counts));
        result.residentBricks += own.shownBricks();
        result.emptyBricks += own.counts[Selection::kEmpty];
    }
}

} // namespace tessera
