// tests/bench/lod/hierarchy_report.cpp: the cost of flat and hierarchical selections under one criterion:
// table 2.1 of the course notes on advanced volume ray casting, and real scans in three dimensions.
#include "tests/bench/lod/experiments.h"
#include "tests/bench/lod/hierarchy.h"

#include <algorithm>
#include <array>

namespace tessera::bench {
namespace {

struct Scheme {
    const char* name;
    SelectionCost (*cost)(const BlockGrid&);
};
constexpr std::array<Scheme, 3> kSchemes = {
    {{"hierarchy 1", [](const BlockGrid& grid) { return hierarchyCost(grid, true); }},
     {"hierarchy 2", [](const BlockGrid& grid) { return hierarchyCost(grid, false); }},
     {"flat", flatCost}}};

double reduction(const BlockGrid& grid, std::size_t samples) {
    return static_cast<double>(fullSamples(grid)) / static_cast<double>(std::max<std::size_t>(samples, 1));
}

/// Boundary: a point of the function's opacity lies within the brick's range, so that what it shows bends
/// there; outside: it shows nothing; interior: all others.
BlockGrid gridOfScan(const SceneBench& scene) {
    const FramePlan& p = scene.prepared();
    const VolumeInfo& info = scene.info();
    BlockGrid grid{3, scene.culled().bricks, kBrickExtent, {}};
    for (std::size_t brick = 0; brick < scene.shows().size(); ++brick) {
        const double a = info.rescaleSlope * static_cast<double>(p.layer().statistics.brickMin[brick]) +
                         info.rescaleIntercept;
        const double b = info.rescaleSlope * static_cast<double>(p.layer().statistics.brickMax[brick]) +
                         info.rescaleIntercept;
        const auto& points = p.layer().function.opacityPoints();
        const bool bends = std::any_of(points.begin(), points.end(), [&](const OpacityPoint& point) {
            return point.value > std::min(a, b) && point.value < std::max(a, b);
        });
        grid.needs.push_back(!scene.shows()[brick] ? Need::outside : bends ? Need::boundary : Need::interior);
    }
    return grid;
}

Table levelTable(const BlockGrid& grid) {
    Table table{"hierarchy-shape",
                "A shape with the counts of the source's figure, in 64 x 64 samples, "
                "blocks of 8 x 8; levels as the source numbers them, 0 the coarsest; "
                "a byte a sample. The source has 2560, 2240 and 1462 bytes, reductions 1.60, 1.83 and 2.80:",
                {"level"},
                {},
                true};
    std::vector<SelectionCost> costs;
    for (const Scheme& scheme : kSchemes) {
        costs.push_back(scheme.cost(grid));
        table.columns.push_back(std::string(scheme.name) + " blocks");
        table.columns.push_back(std::string(scheme.name) + " bytes");
    }
    const auto row = [&](const std::string& name, const auto& blocks, const auto& bytes) {
        std::vector<Cell> cells = {name};
        for (const SelectionCost& cost : costs) {
            cells.push_back(blocks(cost));
            cells.push_back(bytes(cost));
        }
        table.rows.push_back(std::move(cells));
    };
    const auto nothing = [](const SelectionCost&) { return Cell(std::string()); };
    for (std::size_t level = 0; level < costs[0].levels.size(); ++level)
        row(
            std::to_string(level),
            [&](const SelectionCost& c) { return Cell(static_cast<double>(c.levels[level].blocks)); },
            [&](const SelectionCost& c) { return Cell(static_cast<double>(c.levels[level].samples)); });
    row(
        "total",
        [](const SelectionCost& c) {
            std::size_t blocks = 0;
            for (const LevelCost& level : c.levels)
                blocks += level.blocks;
            return Cell(static_cast<double>(blocks));
        },
        [](const SelectionCost& c) { return Cell(static_cast<double>(c.samples)); });
    row("reduction", nothing, [&](const SelectionCost& c) { return Cell(reduction(grid, c.samples)); });
    row("total without the outside", nothing,
        [](const SelectionCost& c) { return Cell(static_cast<double>(c.samples - c.ignored)); });
    row("reduction without the outside", nothing,
        [&](const SelectionCost& c) { return Cell(reduction(grid, c.samples - c.ignored)); });
    return table;
}

} // namespace

Report hierarchyReport(const Workbench& bench) {
    Report report;
    report.name = "hierarchy";
    report.title = "Flat and hierarchical selections (table 2.1)";
    report.text = {
        "The same criterion for all: blocks on an object's boundary at the finest level, blocks in its "
        "interior at "
        "the second coarsest, blocks outside are ignored. *Hierarchy 1* replaces a node by all its children; "
        "*hierarchy 2* takes only the children it needs, and the node stands for the others. Flat blocks "
        "outside "
        "cost one sample each as in the source, and nothing in the product: both are given."};
    Table scans{
        "hierarchy-scans",
        "Bricks of 32^3 of volumes under transfer functions. Boundary: a point of the function lies within "
        "the brick's range of values; interior: it shows something, but the function does not bend there; "
        "outside: it shows nothing:",
        {"volume, function", "boundary", "interior", "outside", "hierarchy 1", "hierarchy 2", "flat",
         "hierarchy 1 without the outside", "hierarchy 2 without the outside", "flat without the outside"},
        {},
        true};
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets) {
            const SceneBench scene(bench, volume, preset, "anterior");
            const BlockGrid grid = gridOfScan(scene);
            const auto count = [&](Need need) {
                return static_cast<double>(std::count(grid.needs.begin(), grid.needs.end(), need));
            };
            std::vector<Cell> row = {volume.name + ", " + preset, count(Need::boundary),
                                     count(Need::interior), count(Need::outside)};
            std::vector<Cell> without;
            for (const Scheme& scheme : kSchemes) {
                const SelectionCost cost = scheme.cost(grid);
                row.emplace_back(reduction(grid, cost.samples));
                without.emplace_back(reduction(grid, cost.samples - cost.ignored));
            }
            row.insert(row.end(), without.begin(), without.end());
            scans.rows.push_back(std::move(row));
        }
    report.tables = {levelTable(table21Grid()), std::move(scans)};
    return report;
}

} // namespace tessera::bench
