// tests/bench/lod/adaptive_sampling.cpp: full, limited and naive sampling of mixed levels: table 2.2 of
// the course notes on advanced volume ray casting, with the error that each costs.
#include "tests/bench/lod/experiments.h"
#include "tests/bench/report/page.h" // loadAverage

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tessera::bench {
namespace {

constexpr std::array<Sampling, 3> kSamplings = {Sampling::full, Sampling::limited, Sampling::naive};
constexpr double kSamplingReductions[] = {11, 30}; // as in the source

struct SamplingRow {
    Sampling sampling = Sampling::full;
    Work work;
    double ms = 0; // least of the repeats
    ImageDifference toFull;
};

/// The three samplings of one selection; timed in turns, so that a disturbance hits all of them.
std::array<SamplingRow, 3> compareSamplings(SceneBench& scene, const Selection& selection, bool skipping,
                                            int repeats) {
    std::array<SamplingRow, 3> rows;
    Drawn full;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        Setting setting;
        setting.sampling = rows[i].sampling = kSamplings[i];
        setting.skipping = skipping;
        Drawn drawn = scene.draw(selection, setting);
        rows[i].work = drawn.work;
        rows[i].ms = std::numeric_limits<double>::infinity();
        if (i == 0)
            full = std::move(drawn);
        else
            rows[i].toFull = SceneBench::difference(drawn, full);
    }
    for (int repeat = 0; repeat < repeats; ++repeat)
        for (std::size_t n = 0; n < rows.size(); ++n) {
            SamplingRow& row = rows[repeat % 2 ? rows.size() - 1 - n : n];
            Setting setting;
            setting.sampling = row.sampling;
            setting.skipping = skipping;
            setting.counting = false;
            row.ms = std::min(row.ms, scene.draw(selection, setting).work.marchMs);
        }
    return rows;
}

} // namespace

Report samplingReport(const Workbench& bench) {
    const int repeats = bench.quick ? 1 : 2;
    Report report;
    report.name = "sampling";
    report.title = "Adaptive sampling along rays (table 2.2)";
    report.text = {
        "Levels are chosen for a data reduction, then the same selection is drawn with every segment taken "
        "(full), with strides as the finest brick that has weight allows (limited), and as the brick at hand "
        "allows (naive). The reduction is voxels of the volume to texels of the pages. The source expects "
        "the "
        "cube root of the reduction as speed-up. It knows no skipping, so that strides save work in empty "
        "bricks too; with skipping on, only bricks that show something are left to save in, and the cube "
        "root "
        "of *their* reduction is the yardstick. Errors are L*u*v* distances to full sampling of the same "
        "levels. Times are the march's alone, least of " +
        std::to_string(repeats) + " interleaved repeats; counters were compiled out."};
    Table table{"sampling",
                "Pictures of " + std::to_string(bench.fewerPixels()) + "^2 pixels, half a voxel a segment:",
                {"scene", "reduction", "skipping", "sampling", "segments", "samples", "ms", "speed-up",
                 "fewer segments", "cube root", "mean", "p99"},
                {},
                true};
    for (const BenchVolume& volume : bench.volumes) {
        if (volume.name != "abdomen" && volume.name != "head" && (!bench.quick || volume.isScan))
            continue; // real CT, or the phantom where time is short
        for (const std::string& preset : volume.presets) {
            SceneBench scene(bench, volume, preset, "anterior", bench.fewerPixels());
            const Selection& culled = scene.culled();
            for (const double reduction : kSamplingReductions) {
                const Selection selection = scene.chosenAt(reduction);
                const double reached = scene.reductionOf(selection);
                for (const bool skipping : {false, true}) {
                    const auto rows = compareSamplings(scene, selection, skipping, repeats);
                    const double shown = skipping ? reached / scene.reductionOf(culled) : reached;
                    for (const SamplingRow& row : rows)
                        table.rows.push_back(
                            {scene.name(), reached, skipping ? "on" : "off",
                             samplingNames()[static_cast<std::size_t>(row.sampling)],
                             static_cast<double>(row.work.segments), static_cast<double>(row.work.samples),
                             row.ms, rows[0].ms / row.ms,
                             static_cast<double>(rows[0].work.segments) /
                                 static_cast<double>(std::max<std::uint64_t>(row.work.segments, 1)),
                             std::cbrt(std::max(shown, 1.0)), row.toFull.luvMean, row.toFull.luvP99});
                }
            }
            bench.done(scene.name());
        }
    }
    report.tables = {std::move(table)};
    report.after = {
        "Load average at the end: " + formatCell(loadAverage()) +
        ". Times are worth as much as the machine was quiet; counts of segments do not depend on it."};
    return report;
}

} // namespace tessera::bench
