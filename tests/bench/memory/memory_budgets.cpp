// tests/bench/memory/memory_budgets.cpp: one scene at budgets of GPU memory from its minimum to unlimited, in
// one pass and in as many as full quality takes. It reports the charged memory, the resident bricks, and the
// picture's loss.
#include "tests/bench/memory/memory_budgets.h"

#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "render/residency/texels.h"

#include <algorithm>
#include <cstring>
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
    bool bitEqual = false;
};

/// The request: the best of one pass, or full quality in as many passes as the budget needs.
struct Quest {
    const char* name;
    std::optional<double> maxError;
};
constexpr Quest kQuests[] = {{"one pass", std::nullopt}, {"--max-error 0", 0.0}};

Scene sceneOf(const BenchVolume& volume, const Quest& quest, int pixels) {
    Scene scene;
    SceneVolume shown;
    shown.path = volume.store;
    shown.transferFunction = volume.presets.front();
    scene.volumes = {shown};
    scene.imageSize = glm::ivec2(pixels);
    scene.quality.fetch = Fetch::exact; // filtered fetches depend on where a brick's page lies
    scene.quality.maxError = quest.maxError;
    return scene;
}

BudgetRow renderedAt(const std::string& budget, MemoryBudget& gpu, const Workbench& bench,
                     const BenchVolume& volume, const Quest& quest) {
    MemoryBudget ram("RAM", "--ram", bench.ramBytes);
    const StoreReader store(volume.store, ram);
    RenderOptions options;
    options.engine = bench.engine;
    options.device.text = bench.device;
    BudgetRow row;
    row.budget = budget;
    row.limitBytes = gpu.limitBytes();
    row.result = renderScene(sceneOf(volume, quest, bench.fewerPixels()), store, ram, gpu, options);
    row.gpuPeak = gpu.peakBytes();
    row.ramPeak = ram.peakBytes();
    const RenderResult& r = row.result;
    row.seconds = r.secondsPreparing + r.secondsLoading + r.secondsDrawing;
    return row;
}

std::string histogram(const RenderResult& result) {
    std::string text;
    for (const std::size_t count : result.bricksOfLevel)
        text += (text.empty() ? "" : " / ") + std::to_string(count);
    return text;
}

std::vector<BudgetRow> allBudgets(const Workbench& bench, const BenchVolume& volume, const Quest& quest) {
    const std::size_t floor =
        floorNamed([&](MemoryBudget& gpu) { (void)renderedAt("", gpu, bench, volume, quest); });
    MemoryBudget trial("RAM", "--ram", bench.ramBytes);
    const std::size_t page =
        cellCount(glm::ivec3(kBrickExtent)) * texelBytes(StoreReader(volume.store, trial).info().type);
    std::vector<BudgetRow> rows;
    for (const auto& [budget, bytes] : {std::pair<std::string, std::size_t>{"unlimited", kUnlimited},
                                        {"floor", floor},
                                        {"twice the floor", 2 * floor},
                                        {"50 bricks more", floor + 50 * page},
                                        {"200 bricks more", floor + 200 * page}}) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", bytes);
        rows.push_back(renderedAt(budget, gpu, bench, volume, quest));
        const Image &image = rows.back().result.image, &unlimited = rows.front().result.image;
        rows.back().toUnlimited = compare(image, unlimited);
        rows.back().bitEqual = std::memcmp(image.pixels.data(), unlimited.pixels.data(),
                                           image.pixels.size() * sizeof(glm::vec4)) == 0;
    }
    std::sort(rows.begin(), rows.end(),
              [](const BudgetRow& a, const BudgetRow& b) { return a.limitBytes < b.limitBytes; });
    return rows;
}

} // namespace

Report memoryReport(const Workbench& bench) {
    Report report;
    report.name = "memory";
    report.title = "Budgets of GPU memory";
    report.text = {
        "A picture a row, with budgets of its own. *One pass* is what `render` does when nothing more is "
        "said; "
        "`--max-error 0` draws the finest level that a pixel can show in as many passes as the budget needs. "
        "The "
        "floor is what the program names when it is given too little; \"50 bricks more\" is the floor and 50 "
        "pages. Levels are the numbers of bricks at level 0 / 1 / 2 / 3 / 4 / 5 / empty. Errors are CIE "
        "L*u*v* "
        "distances to the picture of unlimited memory; *equal* means bit by bit, in exact fetch mode. "
        "Seconds are "
        "wall time, so they depend on what else the machine did."};
    const std::string size = std::to_string(bench.fewerPixels());
    Table table{"memory",
                "Pictures of " + size + " x " + size + " pixels, camera anterior:",
                {"scene", "asked", "budget", "bytes", "GPU peak", "within", "RAM peak", "RAM within",
                 "levels", "pages at once", "passes", "predicted p99", "mean", "p99", "equal", "seconds"},
                {},
                true};
    bool kept = true;
    for (const BenchVolume& volume : bench.volumes) {
        if (volume.name != "torso" && volume.name != "abdomen")
            continue;
        for (const Quest& quest : kQuests)
            for (const BudgetRow& row : allBudgets(bench, volume, quest)) {
                const RenderResult& r = row.result;
                const bool gpuKept = row.gpuPeak <= row.limitBytes, ramKept = row.ramPeak <= bench.ramBytes;
                kept = kept && gpuKept && ramKept;
                table.rows.push_back({volume.name + ", " + volume.presets.front(), quest.name, row.budget,
                                      formatBytes(row.limitBytes), formatBytes(row.gpuPeak),
                                      gpuKept ? "yes" : "NO", formatBytes(row.ramPeak),
                                      ramKept ? "yes" : "NO", histogram(r), static_cast<double>(r.atlasPages),
                                      static_cast<double>(r.passes),
                                      r.predictedError ? Cell(r.predictedError->p99) : Cell("unknown"),
                                      row.toUnlimited.luvMean, row.toUnlimited.luvP99,
                                      row.bitEqual ? "yes" : "no", row.seconds});
            }
        bench.done(volume.name);
    }
    report.tables = {std::move(table)};
    report.after = {kept ? "No budget was over its budget." : "A BUDGET WAS EXCEEDED."};
    return report;
}

} // namespace tessera::bench
