// viewer/bench/memory_budgets.cpp: one scene at budgets of GPU memory from its floor to unlimited: what the
// ledgers saw, what was resident, and what the picture lost.
#include "viewer/bench/experiments.h"

#include "core/error.h"
#include "render/renderer.h"

#include <algorithm>
#include <optional>

namespace tessera::bench {
namespace {

constexpr std::size_t kUnlimited = std::size_t{1} << 31;

struct BudgetRow {
    std::string budget;
    std::size_t limitBytes = 0, gpuPeak = 0, ramPeak = 0;
    RenderResult result;
    double seconds = 0;
    ImageDifference toUnlimited;
};

Scene sceneOf(const BenchVolume& volume, int pixels) {
    Scene scene;
    SceneVolume shown;
    shown.path = volume.store;
    shown.transferFunction = volume.presets.front();
    scene.volumes = {shown};
    scene.imageSize = glm::ivec2(pixels);
    return scene;
}

BudgetRow renderedAt(const std::string& budget, std::size_t bytes, const Workbench& bench,
                     const BenchVolume& volume) {
    Ledger ram("RAM", "--ram", bench.ramBytes), gpu("GPU memory", "--gpu-memory", bytes);
    const StoreReader store(volume.store, ram);
    RenderOptions options;
    options.device.text = bench.device;
    BudgetRow row{budget, bytes, 0, 0, renderScene(sceneOf(volume, bench.pixels()), store, ram, gpu, options),
                  0,      {}};
    row.gpuPeak = gpu.peakBytes();
    row.ramPeak = ram.peakBytes();
    const RenderResult& r = row.result;
    row.seconds = r.secondsPreparing + r.secondsLoading + r.secondsDrawing;
    return row;
}

/// The least budget that the product names for the scene; found as a user would: by asking for too little.
std::size_t floorBytes(const Workbench& bench, const BenchVolume& volume) {
    try {
        (void)renderedAt("", 1, bench, volume);
    } catch (const InputError& error) {
        const std::string message = error.what(), before = "needs at least ";
        const std::size_t start = message.find(before);
        if (start == std::string::npos)
            throw;
        const std::size_t number = start + before.size();
        const std::size_t end = message.find_first_of("(,", number);
        std::string text = message.substr(number, end - number);
        while (!text.empty() && text.back() == ' ')
            text.pop_back();
        return parseBytes(text, "the floor that the program names");
    }
    throw Error("a budget of one byte was accepted");
}

std::string histogram(const RenderResult& result) {
    std::string text;
    for (const std::size_t count : result.bricksOfLevel)
        text += (text.empty() ? "" : " / ") + std::to_string(count);
    return text;
}

} // namespace

Report memoryReport(const Workbench& bench) {
    Report report;
    report.name = "memory";
    report.title = "Budgets of GPU memory";
    report.text = {
        "One picture a row, in a process of its own ledgers. The floor is what the program names when "
        "it is given too little; 50 bricks are the floor and 50 pages. Levels are the numbers of bricks "
        "at level 0 / 1 / 2 / 3 / 4 / 5 / empty. Errors are CIE L*u*v* distances to the unlimited "
        "picture. Seconds are wall time, so they depend on what else the machine did."};
    Table table{"memory",
                "Pictures of " + std::to_string(bench.pixels()) + "^2 pixels, camera anterior:",
                {"scene", "budget", "bytes", "GPU peak", "kept", "RAM peak", "RAM kept", "levels", "mean",
                 "p99", "seconds"},
                {},
                true};
    for (const BenchVolume& volume : bench.volumes) {
        if (volume.name != "torso" && volume.name != "abdomen")
            continue;
        const std::size_t floor = floorBytes(bench, volume);
        Ledger trial("RAM", "--ram", bench.ramBytes);
        const std::size_t page =
            cellCount(glm::ivec3(kBrickExtent)) * texelBytes(StoreReader(volume.store, trial).info().type);
        std::vector<BudgetRow> rows;
        for (const auto& [budget, bytes] : {std::pair<std::string, std::size_t>{"unlimited", kUnlimited},
                                            {"floor", floor},
                                            {"twice the floor", 2 * floor},
                                            {"50 bricks", floor + 50 * page},
                                            {"200 bricks", floor + 200 * page},
                                            {"800 bricks", floor + 800 * page}}) {
            rows.push_back(renderedAt(budget, bytes, bench, volume));
            rows.back().toUnlimited = compare(rows.back().result.image, rows.front().result.image);
        }
        std::sort(rows.begin(), rows.end(),
                  [](const BudgetRow& a, const BudgetRow& b) { return a.limitBytes < b.limitBytes; });
        for (const BudgetRow& row : rows)
            table.rows.push_back({volume.name + ", " + volume.presets.front(), row.budget,
                                  formatBytes(row.limitBytes), formatBytes(row.gpuPeak),
                                  row.gpuPeak <= row.limitBytes ? "yes" : "NO", formatBytes(row.ramPeak),
                                  row.ramPeak <= bench.ramBytes ? "yes" : "NO", histogram(row.result),
                                  row.toUnlimited.luvMean, row.toUnlimited.luvP99, row.seconds});
        bench.common.note("memory: " + volume.name + " done");
    }
    report.tables = {std::move(table)};
    return report;
}

} // namespace tessera::bench
