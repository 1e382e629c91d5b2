// tests/bench/papers/presence.cpp: presence bits of values beside ranges (course notes on advanced volume ray
// casting, section 2.7.2): what they cull of functions with gaps.
#include "core/base/error.h"
#include "core/base/threads.h"
#include "tests/bench/papers/papers.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace tessera::bench {
namespace {

constexpr int kBins = 64;

/// Values of voxels, and of everything that lies between eight of them, of each cell and each brick.
struct Presence {
    float lowest = 0, highest = 0;
    std::vector<std::uint64_t> cells, bricks; // a bit a bin
    std::vector<std::uint64_t> samples;       // of cells, by their samples alone
    std::vector<std::pair<float, float>> cellRanges, brickRanges;

    int binOf(float value) const { return histogramBin(value, lowest, highest); }
};

glm::ivec3 placeIn(std::size_t number, const glm::ivec3& grid) {
    const auto x = static_cast<std::size_t>(grid.x), y = static_cast<std::size_t>(grid.y);
    return {static_cast<int>(number % x), static_cast<int>(number / x % y), static_cast<int>(number / x / y)};
}

/// Level 0 as floats, as stored.
std::vector<float> voxelsOf(const StoreReader& store) {
    const VolumeInfo& info = store.info();
    const glm::ivec3 extent = info.extentVoxels, chunks = ceilDiv(extent, kChunkExtent);
    std::vector<float> voxels(cellCount(extent));
    parallelFor(cellCount(chunks), 0, [&](std::size_t number) {
        const glm::ivec3 chunk = placeIn(number, chunks);
        std::vector<std::byte> bytes(store.chunkBytes());
        store.readChunk({0, chunk.x, chunk.y, chunk.z}, bytes);
        const glm::ivec3 from = chunk * kChunkExtent, to = glm::min(from + kChunkExtent, extent);
        for (int z = from.z; z < to.z; ++z)
            for (int y = from.y; y < to.y; ++y)
                for (int x = from.x; x < to.x; ++x)
                    voxels[linearIndex({x, y, z}, extent)] = static_cast<float>(
                        storedValue(info.type, bytes.data() + bytesPerValue(info.type) *
                                                                  linearIndex(glm::ivec3(x, y, z) - from,
                                                                              glm::ivec3(kChunkExtent))));
    });
    return voxels;
}

Presence presenceOf(const StoreReader& store) {
    const glm::ivec3 extent = store.info().extentVoxels, cells = cellGrid(extent), bricks = brickGrid(extent);
    const std::vector<float> voxels = voxelsOf(store);
    Presence p;
    const auto [low, high] = std::minmax_element(voxels.begin(), voxels.end());
    p.lowest = *low, p.highest = *high;
    p.cells.assign(cellCount(cells), 0);
    p.samples.assign(cellCount(cells), 0);
    p.cellRanges.assign(cellCount(cells), {p.highest, p.lowest});
    parallelFor(cellCount(cells), 0, [&](std::size_t number) {
        // What eight samples lie around, of which one at least is the cell's.
        const glm::ivec3 first = placeIn(number, cells) * kCellExtent - 1;
        auto& range = p.cellRanges[number];
        for (int z = first.z; z <= first.z + kCellExtent; ++z)
            for (int y = first.y; y <= first.y + kCellExtent; ++y)
                for (int x = first.x; x <= first.x + kCellExtent; ++x) {
                    float lo = p.highest, hi = p.lowest;
                    for (int n = 0; n < 8; ++n) {
                        const glm::ivec3 at =
                            glm::clamp(glm::ivec3(x + (n & 1), y + (n >> 1 & 1), z + (n >> 2)), glm::ivec3(0),
                                       extent - 1);
                        const float value = voxels[linearIndex(at, extent)];
                        lo = std::min(lo, value), hi = std::max(hi, value);
                    }
                    range = {std::min(range.first, lo), std::max(range.second, hi)};
                    const int a = p.binOf(lo), b = p.binOf(hi);
                    p.samples[number] |= std::uint64_t{1} << a | std::uint64_t{1} << b;
                    p.cells[number] |= (~std::uint64_t{0} >> (63 - b)) & (~std::uint64_t{0} << a);
                }
    });
    p.bricks.assign(cellCount(bricks), 0);
    p.brickRanges.assign(cellCount(bricks), {p.highest, p.lowest});
    for (std::size_t n = 0; n < p.cells.size(); ++n) {
        const std::size_t brick = linearIndex(placeIn(n, cells) / kCellsPerBrick, bricks);
        p.bricks[brick] |= p.cells[n];
        auto& range = p.brickRanges[brick];
        range = {std::min(range.first, p.cellRanges[n].first),
                 std::max(range.second, p.cellRanges[n].second)};
    }
    return p;
}

/// Ranges of HU that show, white; nothing shows between them.
TransferFunction bands(const std::vector<std::pair<double, double>>& hu) {
    std::vector<OpacityPoint> points;
    for (const auto& [from, to] : hu) {
        constexpr double kEdge = 5;
        points.insert(points.end(), {{from - kEdge, 0}, {from, 0.1}, {to, 0.1}, {to + kEdge, 0}});
    }
    return TransferFunction::fromExtinction(points, {{0, {1, 1, 1}}});
}

struct Shown {
    std::size_t byRange = 0, byBits = 0;
};
Shown shownOf(const std::vector<std::uint64_t>& bits, const std::vector<std::pair<float, float>>& ranges,
              std::uint64_t visible, const TransferTable& table, const VolumeInfo& info) {
    Shown shown;
    const auto physical = [&](float v) { return info.rescaleSlope * double{v} + info.rescaleIntercept; };
    for (std::size_t n = 0; n < bits.size(); ++n) {
        const double a = physical(ranges[n].first), b = physical(ranges[n].second);
        const bool byRange = !table.emptyOver(std::min(a, b), std::max(a, b));
        shown.byRange += byRange;
        shown.byBits += byRange && (bits[n] & visible) != 0;
    }
    return shown;
}

} // namespace

Report presenceReport(const Workbench& bench) {
    struct Function {
        std::string name;
        TransferFunction function;
    };
    const Function made[] = {{"vessels without bone: 180 to 350 HU", bands({{180, 350}})},
                             {"fat: -120 to -60 HU", bands({{-120, -60}})},
                             {"fat and bone", bands({{-120, -60}, {400, 3000}})},
                             {"lung and bone", bands({{-950, -600}, {400, 3000}})}};
    Report report;
    report.name = "presence";
    report.title = "Presence bits (course notes, 2.7.2)";
    report.text = {"A brick of 32^3 or a cell of 8^3 voxels shows nothing where the function is zero over "
                   "its range [min, max], ghost layer "
                   "included. Presence bits say besides which of 64 equal parts of the volume's range occur. "
                   "An interpolated field is continuous: "
                   "with two values a cell holds all values between, so bits can tell no more than the "
                   "range. Bits of samples alone cull "
                   "more, and all of that shows where rays pass between samples."};
    Table table{
        "presence",
        "Bricks and cells that may show something by ranges, and by bits of interpolated values too; cells "
        "that bits of samples "
        "alone would cull though they show:",
        {"scene", "bricks by range", "by bits", "cells by range", "by bits", "lost by bits of samples"},
        {},
        true};
    bool same = true;
    for (const BenchVolume& volume : bench.volumes) {
        MemoryBudget ram("RAM", "--ram", bench.ramBytes);
        const StoreReader store(volume.store, ram);
        const Charge charge = ram.charge(store.info().voxelCount() * sizeof(float), "voxels");
        const Presence presence = presenceOf(store);
        const VolumeInfo& info = store.info();
        for (const Function& function : made) {
            if (volume.presets.front() == "auto")
                continue; // no HU
            const TransferTable functionTable = makeTable(function.function);
            std::uint64_t visible = 0;
            for (int bin = 0; bin < kBins; ++bin) {
                const double width = (double{presence.highest} - double{presence.lowest}) / kBins;
                const double a = info.rescaleSlope * (presence.lowest + bin * width) + info.rescaleIntercept;
                const double b = a + info.rescaleSlope * width;
                if (!functionTable.emptyOver(std::min(a, b), std::max(a, b)))
                    visible |= std::uint64_t{1} << bin;
            }
            const Shown bricks = shownOf(presence.bricks, presence.brickRanges, visible, functionTable, info);
            const Shown cells = shownOf(presence.cells, presence.cellRanges, visible, functionTable, info);
            const Shown samples =
                shownOf(presence.samples, presence.cellRanges, visible, functionTable, info);
            same = same && bricks.byBits == bricks.byRange && cells.byBits == cells.byRange;
            const auto number = [](std::size_t n) { return Cell(static_cast<double>(n)); };
            table.rows.push_back({volume.name + ", " + function.name, number(bricks.byRange),
                                  number(bricks.byBits), number(cells.byRange), number(cells.byBits),
                                  number(cells.byBits - samples.byBits)});
        }
        bench.done(volume.name);
    }
    report.tables.push_back(std::move(table));
    report.after = {same ? "Bits of interpolated values culled nothing beyond ranges anywhere."
                         : "BITS CULLED SOMETHING BEYOND RANGES."};
    return report;
}

} // namespace tessera::bench
