// tests/bench/lod/occlusion_cost.cpp: the cost and the errors of ambient occlusion where data are reduced:
// table 6.1 of the course notes on advanced volume ray casting, whose reductions these are.
#include "tests/bench/lod/experiments.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace tessera::bench {
namespace {

constexpr double kOcclusionReductions[] = {8.9, 14.8, 22.1, 35.2}; // as in the source
constexpr double kMiB = 1024.0 * 1024.0;

/// A selection of levels, and its pictures without occlusion and with.
struct Reduced {
    Selection selection;
    double reduction = 0;
    Drawn plain;
};

/// Light is computed as often as asked; the least time counts.
Drawn drawnLit(SceneBench& scene, const Selection& selection, int times) {
    Drawn best = scene.draw(selection);
    for (int n = 1; n < times; ++n) {
        Drawn again = scene.draw(selection);
        if (again.light->seconds < best.light->seconds)
            best = std::move(again);
    }
    return best;
}

void addScene(const Workbench& bench, const BenchVolume& volume, const std::string& preset, Table& table) {
    std::vector<Reduced> all;
    std::string name;
    {
        SceneBench scene(bench, volume, preset, "anterior", bench.fewerPixels());
        name = scene.name();
        all.push_back({scene.culled(), scene.reductionOf(scene.culled()), scene.draw(scene.culled())});
        for (const double wanted : kOcclusionReductions) {
            if (wanted <= all.front().reduction)
                continue; // leaving out what shows nothing does more than that
            Selection selection = scene.chosenAt(wanted);
            const double reduction = scene.reductionOf(selection);
            Drawn picture = scene.draw(selection);
            all.push_back({std::move(selection), reduction, std::move(picture)});
        }
    }
    Lighting lighting;
    lighting.occlusion = Occlusion{};
    SceneBench scene(bench, volume, preset, "anterior", bench.fewerPixels(), lighting);
    std::optional<Drawn> truth;
    double wholeSeconds = 0;
    for (const Reduced& reduced : all) {
        Drawn lit = drawnLit(scene, reduced.selection, bench.quick ? 1 : 3);
        if (!truth) {
            truth = lit;
            wholeSeconds = lit.light->seconds;
        }
        const ImageDifference withLight = SceneBench::difference(lit, *truth),
                              without = SceneBench::difference(reduced.plain, all.front().plain);
        table.rows.push_back({name, &reduced == &all.front() ? Cell("culling alone") : Cell("levels"),
                              reduced.reduction, lit.light->seconds,
                              wholeSeconds / std::max(lit.light->seconds, 1e-9),
                              static_cast<double>(lit.light->planeBytes) / kMiB, withLight.luvMean,
                              withLight.luvP99, without.luvMean, without.luvP99});
    }
    bench.done(name);
}

} // namespace

Report occlusionReport(const Workbench& bench) {
    const Occlusion occlusion;
    Report report;
    report.name = "occlusion";
    report.title = "Occlusion by data reduction (table 6.1)";
    report.text = {
        "Ambient occlusion is computed for the samples that are drawn, each brick's at its own level: less "
        "data, "
        "less of it. " +
        std::to_string(occlusion.rays) + " rays of " + formatCell(occlusion.radiusMm) +
        " mm from each sample near which anything shows; the source's reductions, where they are more than "
        "*culling alone*, which leaves out bricks that show nothing and keeps the rest at level 0; levels "
        "chosen by "
        "the product. *s*: computing all light on all processors and handing it to the device" +
        std::string(bench.quick ? "" : ", the least of three") +
        "; *MiB*: what is kept of it beside the bricks, free places of pages included. Errors: CIE L*u*v*, "
        "mean and "
        "99th percentile over pixels with alpha above 1/255, against the picture of the finest bricks with "
        "their own "
        "occlusion; *levels'*: the same without any occlusion, which is what the levels themselves err by."};
    Table table{"occlusion",
                "Time, memory and error of occlusion by data reduction:",
                {"scene", "by", "reduction", "s", "times as fast", "MiB", "mean", "p99", "levels' mean",
                 "levels' p99"},
                {},
                true};
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets)
            addScene(bench, volume, preset, table);
    report.tables = {std::move(table)};
    return report;
}

} // namespace tessera::bench
