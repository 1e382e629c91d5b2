// render/empty_space/extinction_bounds.cpp: see extinction_bounds.h.
#include "render/empty_space/extinction_bounds.h"

#include "core/base/threads.h"
#include "render/contract/lattice.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

ExtinctionRange joined(const ExtinctionRange& a, const ExtinctionRange& b) {
    return {std::min(a.least, b.least), std::max(a.most, b.most)};
}

/// From this level on samples reach to sides of cells exactly; paths go a little beyond them.
constexpr int kCoarse = 3;
constexpr double kRounding = 1.0 / 64; // of places in the table

/// The least and the greatest factor of gradient opacity.
ExtinctionRange factorsOf(const leaf::GradientNumbers<double>& points) {
    ExtinctionRange range{1, 1};
    for (int n = 0; n < points.count; ++n) {
        const auto factor = static_cast<float>(points.factor[n]);
        range = n == 0 ? ExtinctionRange{factor, factor} : joined(range, {factor, factor});
    }
    return range;
}

} // namespace

float mostExtinctionPerMm(const VolumeInfo& info) {
    const glm::dmat3 linear(info.patientFromVoxel);
    const double mm = std::min({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
    return static_cast<float>(kMostExtinctionPerVoxel / mm);
}

TableExtremes::TableExtremes(const std::vector<glm::vec4>& table) {
    entries_.reserve(table.size());
    for (const glm::vec4& entry : table)
        entries_.push_back(entry.a);
    std::vector<ExtinctionRange> blocks;
    for (std::size_t first = 0; first < entries_.size(); first += kBlock) {
        const auto begin = entries_.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end =
            entries_.begin() + static_cast<std::ptrdiff_t>(std::min(first + kBlock, entries_.size()));
        const auto [least, most] = std::minmax_element(begin, end);
        blocks.push_back({*least, *most});
    }
    rows_.push_back(std::move(blocks));
    for (std::size_t length = 2; length <= rows_.front().size(); length *= 2) {
        const std::vector<ExtinctionRange>& half = rows_.back();
        std::vector<ExtinctionRange> row;
        for (std::size_t n = 0; n + length <= rows_.front().size(); ++n)
            row.push_back(joined(half[n], half[n + length / 2]));
        rows_.push_back(std::move(row));
    }
}

ExtinctionRange TableExtremes::over(std::size_t first, std::size_t last) const {
    ExtinctionRange range{entries_[first], entries_[first]};
    const auto take = [&](std::size_t from, std::size_t to) {
        for (std::size_t n = from; n < to; ++n)
            range = joined(range, {entries_[n], entries_[n]});
    };
    const std::size_t block = first / kBlock + 1, end = last / kBlock; // whole blocks between
    if (block >= end) {
        take(first, last + 1);
        return range;
    }
    take(first, block * kBlock);
    take(end * kBlock, last + 1);
    const auto row = static_cast<std::size_t>(std::bit_width(end - block) - 1);
    range = joined(range, rows_[row][block]);
    return joined(range, rows_[row][end - (std::size_t{1} << row)]);
}

float TableExtremes::at(double place) const {
    const auto n = std::min(static_cast<std::size_t>(place), entries_.size() - 2);
    return entries_[n] + static_cast<float>(place - static_cast<double>(n)) * (entries_[n + 1] - entries_[n]);
}

ExtinctionRange TableExtremes::between(double from, double to) const {
    const double last = static_cast<double>(entries_.size() - 1);
    from = std::clamp(from, 0.0, last), to = std::clamp(to, 0.0, last);
    const float a = at(from), b = at(to);
    const ExtinctionRange ends{std::min(a, b), std::max(a, b)};
    const double first = std::ceil(from), final = std::floor(to);
    return first > final
               ? ends
               : joined(ends, over(static_cast<std::size_t>(first), static_cast<std::size_t>(final)));
}

std::size_t TableExtremes::bytes(std::size_t entries) {
    const std::size_t blocks = (entries + kBlock - 1) / kBlock;
    return entries * sizeof(float) + blocks * static_cast<std::size_t>(std::bit_width(blocks)) *
                                         (sizeof(ExtinctionRange) + sizeof(std::vector<ExtinctionRange>));
}

std::size_t ExtinctionBounds::bytes(const glm::ivec3& extentVoxels, std::size_t entries) {
    const std::size_t cells = cellCount(cellGrid(extentVoxels));
    return cells * sizeof(std::uint32_t) + (hasParts(extentVoxels) ? bytesOfParts(cells) : 0) +
           TableExtremes::bytes(entries);
}

std::uint32_t ExtinctionBounds::packed(const ExtinctionRange& range) {
    const std::uint32_t most = std::bit_cast<std::uint32_t>(range.most);
    const std::uint32_t up = most + ((most & 0xffffu) != 0 ? 0x10000u : 0u);
    return (up & 0xffff0000u) | (std::bit_cast<std::uint32_t>(range.least) >> 16);
}

ExtinctionRange ExtinctionBounds::rangeOf(const TableExtremes& table, const Optics& optics, const Hull& hull,
                                          bool labelled) const {
    // Places are computed in float: they err by a share of what they are made of.
    const double x = double{hull.lo} * double{optics.scale}, y = double{hull.hi} * double{optics.scale};
    const double rounding =
        kRounding + (std::max(std::abs(x), std::abs(y)) + std::abs(double{optics.offset})) * 0x1p-22;
    ExtinctionRange range = table.between(std::min(x, y) + double{optics.offset} - rounding,
                                          std::max(x, y) + double{optics.offset} + rounding);
    const ExtinctionRange factors = factorsOf(optics.gradientOpacity);
    range = {range.least * factors.least, range.most * factors.most};
    if (labelled) { // shares of a label are anything from 0 to 1
        range.least = 0;
        if ((hull.shows & kShowsFunction) == 0)
            range.most = 0;
        if ((hull.shows & kShowsMedium) != 0)
            range.most += optics.labels.density;
    }
    return {std::min(range.least, limit_), std::min(range.most, limit_)};
}

void ExtinctionBounds::refine(const OccupancyInput& input, const Optics& optics, BrickCache& cache,
                              MemoryBudget& ram, int threads) {
    if (!hasParts(extentVoxels_))
        return;
    const std::size_t most = bytesOfParts(ranges_.size());
    partsCharge_ = ram.charge(most, "the bounds of extinction in parts of cells");
    parts_.assign(ranges_.size(), -1);
    std::vector<std::uint32_t> cells; // by their places in the list of all
    const std::vector<glm::vec2> none;
    BrickProof proof(input, none, static_cast<std::uint32_t>(input.selection.finest()));
    for (std::size_t b = 0; b < input.selection.levels.size(); ++b) {
        const glm::ivec3 brick = gridPosition(b, input.selection.bricks), first = brick * kCellsPerBrick;
        const std::uint64_t plain = proof.plainCellsOf(brick);
        for (std::size_t n = 0; plain != 0 && n < 64; ++n) {
            const glm::ivec3 cell = first + gridPosition(n, glm::ivec3(kCellsPerBrick));
            if ((plain >> n & 1u) == 0 || glm::any(glm::greaterThanEqual(cell, grid_)))
                continue;
            const ExtinctionRange range = ofCell(cell);
            if (!(range.most > range.least))
                continue;
            const std::size_t at = linearIndex(cell, grid_);
            parts_[at] = static_cast<std::int32_t>(cells.size());
            cells.push_back(static_cast<std::uint32_t>(at));
        }
    }
    partRanges_.resize(cells.size() * kPartsOfCell);
    const TableExtremes table(optics.table);
    const bool labelled = input.statistics.hasLabels();
    constexpr std::size_t kCellsAtATime = 256;
    parallelFor((cells.size() + kCellsAtATime - 1) / kCellsAtATime, threads, [&](std::size_t turn) {
        LatticeReader samples(cache, input.info, 0, &input.selection);
        constexpr int kEdge = kCellExtent + 2;
        double values[kEdge * kEdge * kEdge];
        for (std::size_t n = turn * kCellsAtATime; n < std::min(cells.size(), (turn + 1) * kCellsAtATime);
             ++n) {
            const glm::ivec3 cell = gridPosition(cells[n], grid_);
            samples.cube<kEdge>(cell * kCellExtent - 1, values);
            const std::uint8_t shows =
                input.statistics.showsOfCell(linearIndex(cell, input.statistics.cells));
            for (int part = 0; part < kPartsOfCell; ++part) {
                const glm::ivec3 first =
                    gridPosition(static_cast<std::size_t>(part), glm::ivec3(kParts)) * (1 << kPartShift);
                Hull hull;
                hull.shows = shows;
                constexpr int kSide = (1 << kPartShift) + 2;
                for (int z = 0; z < kSide; ++z)
                    for (int y = 0; y < kSide; ++y)
                        for (int x = 0; x < kSide; ++x) {
                            const auto value = static_cast<float>(
                                values[linearIndex(first + glm::ivec3(x, y, z), glm::ivec3(kEdge))]);
                            hull.add(value, value);
                        }
                partRanges_[n * kPartsOfCell + static_cast<std::size_t>(part)] =
                    packed(rangeOf(table, optics, hull, labelled));
            }
        }
    });
    partsCharge_ = {};
    partsCharge_ =
        ram.charge(parts_.size() * sizeof(std::int32_t) + partRanges_.size() * sizeof(std::uint32_t),
                   "the bounds of extinction in parts of cells");
}

ExtinctionBounds::ExtinctionBounds(const OccupancyInput& input, const Optics& optics, float limit,
                                   MemoryBudget& ram, int threads)
    : limit_(limit), grid_(cellGrid(input.info.extentVoxels)), extentVoxels_(input.info.extentVoxels) {
    charge_ = ram.charge(cellCount(grid_) * sizeof(std::uint32_t) + TableExtremes::bytes(optics.table.size()),
                         "the bounds of extinction");
    ranges_.assign(cellCount(grid_), 0);
    const TableExtremes table(optics.table);
    const bool labelled = input.statistics.hasLabels();
    const glm::ivec3& bricks = input.selection.bricks;
    const std::vector<glm::vec2> none; // ranges around bricks, which decide nothing here
    constexpr std::size_t kBricksAtATime = 64;
    const std::size_t count = cellCount(bricks);
    parallelFor((count + kBricksAtATime - 1) / kBricksAtATime, threads, [&](std::size_t turn) {
        BrickProof proof(input, none, static_cast<std::uint32_t>(input.selection.finest()));
        BrickProof::CellHulls hulls;
        for (std::size_t b = turn * kBricksAtATime; b < std::min(count, (turn + 1) * kBricksAtATime); ++b) {
            const glm::ivec3 brick = gridPosition(b, bricks), cells = proof.rangesOf(brick, hulls);
            const auto forEachCell = [&](const auto& visit) {
                glm::ivec3 at(0);
                for (at.z = 0; at.z < cells.z; ++at.z)
                    for (at.y = 0; at.y < cells.y; ++at.y)
                        for (at.x = 0; at.x < cells.x; ++at.x)
                            visit(at);
            };
            Hull whole;
            forEachCell([&](const glm::ivec3& at) { whole.add(hulls[cellBit(at)]); });
            const bool coarse = proof.coarsestAround() >= kCoarse;
            forEachCell([&](const glm::ivec3& at) {
                ranges_[linearIndex(kCellsPerBrick * brick + at, grid_)] =
                    packed(rangeOf(table, optics, coarse ? whole : hulls[cellBit(at)], labelled));
            });
        }
    });
}

} // namespace tessera
