// render/empty_space/extinction_bounds.cpp: see extinction_bounds.h.
#include "render/empty_space/extinction_bounds.h"

#include "core/base/threads.h"

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

std::size_t ExtinctionBounds::bytes(const glm::ivec3& extentVoxels, MapScale scale, std::size_t entries) {
    return cellCount(mapGrid(extentVoxels, scale)) * sizeof(std::uint32_t) + TableExtremes::bytes(entries);
}

std::uint32_t ExtinctionBounds::packed(const ExtinctionRange& range) {
    const std::uint32_t most = std::bit_cast<std::uint32_t>(range.most);
    const std::uint32_t up = most + ((most & 0xffffu) != 0 ? 0x10000u : 0u);
    return (up & 0xffff0000u) | (std::bit_cast<std::uint32_t>(range.least) >> 16);
}

ExtinctionBounds::ExtinctionBounds(const OccupancyInput& input, const Optics& optics, MapScale scale,
                                   float limit, MemoryBudget& ram, int threads)
    : shift_(boxShift(scale)), limit_(limit), grid_(mapGrid(input.info.extentVoxels, scale)),
      extentVoxels_(input.info.extentVoxels) {
    charge_ = ram.charge(bytes(extentVoxels_, scale, optics.table.size()), "the bounds of extinction");
    ranges_.assign(cellCount(grid_), 0);
    const TableExtremes table(optics.table);
    const ExtinctionRange factors = factorsOf(optics.gradientOpacity);
    const bool labelled = input.statistics.hasLabels();
    const auto rangeOf = [&](const Hull& hull) {
        // As placeOf() has them in float.
        const double x = double{hull.lo} * double{optics.scale} + double{optics.offset},
                     y = double{hull.hi} * double{optics.scale} + double{optics.offset};
        ExtinctionRange range = table.between(std::min(x, y) - kRounding, std::max(x, y) + kRounding);
        range = {range.least * factors.least, range.most * factors.most};
        if (labelled) { // shares of a label are anything from 0 to 1
            range.least = 0;
            if ((hull.shows & kShowsFunction) == 0)
                range.most = 0;
            if ((hull.shows & kShowsMedium) != 0)
                range.most += optics.labels.density;
        }
        return ExtinctionRange{std::min(range.least, limit), std::min(range.most, limit)};
    };
    const glm::ivec3& bricks = input.selection.bricks;
    const std::vector<glm::vec2> none; // ranges around bricks, which decide nothing here
    constexpr std::size_t kBricksAtATime = 64;
    const std::size_t count = cellCount(bricks);
    parallelFor((count + kBricksAtATime - 1) / kBricksAtATime, threads, [&](std::size_t turn) {
        BrickProof proof(input, none, static_cast<std::uint32_t>(input.selection.finest()));
        BrickProof::CellHulls hulls;
        for (std::size_t b = turn * kBricksAtATime; b < std::min(count, (turn + 1) * kBricksAtATime); ++b) {
            const glm::ivec3 brick = gridPosition(b, bricks), cells = proof.rangesOf(brick, hulls);
            Hull whole;
            const auto forEachCell = [&](const auto& visit) {
                glm::ivec3 at(0);
                for (at.z = 0; at.z < cells.z; ++at.z)
                    for (at.y = 0; at.y < cells.y; ++at.y)
                        for (at.x = 0; at.x < cells.x; ++at.x)
                            visit(at);
            };
            forEachCell([&](const glm::ivec3& at) { whole.add(hulls[cellBit(at)]); });
            const std::uint32_t all = packed(rangeOf(whole));
            if (scale == MapScale::bricks)
                ranges_[b] = all;
            else
                forEachCell([&](const glm::ivec3& at) {
                    ranges_[linearIndex(kCellsPerBrick * brick + at, grid_)] =
                        proof.coarsestAround() >= kCoarse ? all : packed(rangeOf(hulls[cellBit(at)]));
                });
        }
    });
}

} // namespace tessera
