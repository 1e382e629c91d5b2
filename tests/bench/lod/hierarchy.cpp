// tests/bench/lod/hierarchy.cpp: see hierarchy.h.
#include "tests/bench/lod/hierarchy.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <bit>
#include <string_view>

namespace tessera::bench {
namespace {

/// Levels below the finest, as many as samples can be halved.
int topOf(const BlockGrid& grid) {
    TESSERA_CHECK(std::has_single_bit(static_cast<unsigned>(grid.blockExtent)) && grid.blockExtent >= 2);
    return std::countr_zero(static_cast<unsigned>(grid.blockExtent));
}
std::size_t power(std::size_t base, int exponent) {
    std::size_t out = 1;
    for (int i = 0; i < exponent; ++i)
        out *= base;
    return out;
}
int levelOf(Need need, int top) {
    return need == Need::boundary ? top : need == Need::interior ? 1 : 0;
}

class Hierarchy {
  public:
    Hierarchy(const BlockGrid& grid, bool allChildren) : grid_(grid), top_(topOf(grid)), all_(allChildren) {
        cost_.levels.resize(static_cast<std::size_t>(top_) + 1);
    }
    SelectionCost run() {
        const int edge = 1 << top_;
        for (int z = 0; z < grid_.blocks.z; z += edge)
            for (int y = 0; y < grid_.blocks.y; y += edge)
                for (int x = 0; x < grid_.blocks.x; x += edge)
                    visit({x, y, z}, 0);
        for (const LevelCost& level : cost_.levels)
            cost_.samples += level.samples;
        return cost_;
    }

  private:
    /// Largest level that a block of the node needs; below 0 when the node lies beyond the grid.
    int needOf(const glm::ivec3& first, int depth) const {
        const glm::ivec3 end = glm::min(first + (1 << (top_ - depth)), grid_.blocks);
        int need = -1;
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x)
                    need = std::max(need, levelOf(grid_.needs[linearIndex({x, y, z}, grid_.blocks)], top_));
        return need;
    }
    void add(const glm::ivec3& first, int depth) {
        LevelCost& level = cost_.levels[static_cast<std::size_t>(depth)];
        const std::size_t samples = power(static_cast<std::size_t>(grid_.blockExtent), grid_.dimensions);
        ++level.blocks;
        level.samples += samples;
        if (needOf(first, depth) <= 0)
            cost_.ignored += samples;
    }
    /// Called for nodes that are in the selection, whether or not children replace them.
    void visit(const glm::ivec3& first, int depth) {
        if (needOf(first, depth) <= depth) {
            add(first, depth);
            return;
        }
        const int half = 1 << (top_ - depth - 1);
        bool replaced = true;
        for (int child = 0; child < 1 << grid_.dimensions; ++child) {
            const glm::ivec3 at = first + glm::ivec3(child & 1, child >> 1 & 1, child >> 2) * half;
            const int need = needOf(at, depth + 1);
            if (need < 0)
                continue; // beyond the grid
            if (all_ || need > depth)
                visit(at, depth + 1);
            else
                replaced = false; // this node stands for it
        }
        if (!replaced)
            add(first, depth);
    }

    const BlockGrid& grid_;
    int top_;
    bool all_;
    SelectionCost cost_;
};

} // namespace

SelectionCost flatCost(const BlockGrid& grid) {
    const int top = topOf(grid);
    SelectionCost cost;
    cost.levels.resize(static_cast<std::size_t>(top) + 1);
    for (const Need need : grid.needs) {
        const int level = levelOf(need, top);
        const std::size_t samples = power(std::size_t{1} << level, grid.dimensions);
        ++cost.levels[static_cast<std::size_t>(level)].blocks;
        cost.levels[static_cast<std::size_t>(level)].samples += samples;
        cost.samples += samples;
        if (need == Need::outside)
            cost.ignored += samples;
    }
    return cost;
}

SelectionCost hierarchyCost(const BlockGrid& grid, bool allChildren) {
    return Hierarchy(grid, allChildren).run();
}

std::size_t fullSamples(const BlockGrid& grid) {
    return cellCount(grid.blocks) * power(static_cast<std::size_t>(grid.blockExtent), grid.dimensions);
}

BlockGrid gridOfShape(int dimensions, const glm::ivec3& blocks, int blockExtent,
                      const std::function<bool(const glm::ivec3&)>& inside) {
    BlockGrid grid{dimensions, blocks, blockExtent, {}};
    const glm::ivec3 size(blockExtent, blockExtent, dimensions == 3 ? blockExtent : 1);
    for (int k = 0; k < blocks.z; ++k)
        for (int j = 0; j < blocks.y; ++j)
            for (int i = 0; i < blocks.x; ++i) {
                std::size_t count = 0;
                for (int z = 0; z < size.z; ++z)
                    for (int y = 0; y < size.y; ++y)
                        for (int x = 0; x < size.x; ++x)
                            count += inside(glm::ivec3(i, j, k) * size + glm::ivec3(x, y, z)) ? 1 : 0;
                grid.needs.push_back(count == 0                 ? Need::outside
                                     : count == cellCount(size) ? Need::interior
                                                                : Need::boundary);
            }
    return grid;
}

BlockGrid table21Grid() {
    BlockGrid grid{2, {8, 8, 1}, 8, {}};
    for (const char c : std::string_view("...bb..."
                                         "..bbbb.."
                                         ".bbiibb."
                                         "bbiibbb."
                                         "bbbb...."
                                         ".bb....."
                                         "..b....."
                                         "........"))
        grid.needs.push_back(c == 'b' ? Need::boundary : c == 'i' ? Need::interior : Need::outside);
    return grid;
}

} // namespace tessera::bench
