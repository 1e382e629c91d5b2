// bricking/labels/label_cells.h: LabelCells: which sets of labels the voxels of every cell have, and how
// many. Culling and coarse levels read them, so that no thin structure is lost.
#pragma once

#include "core/base/budget.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

struct LabelCells {
    struct Share {
        std::uint16_t set = 0;    // number in LabelTable::sets
        std::uint16_t voxels = 0; // of the cell that have it, at least 1
        bool operator==(const Share&) const = default;
    };
    glm::ivec3 cells{0};              // cellGrid(extent)
    std::vector<std::uint32_t> first; // [z][y][x] over cells, and one more: of `shares`
    std::vector<Share> shares;        // of each cell by ascending set; voxels of the volume alone
    Charge charge;                    // of the table as well

    /// Of a cell, by its linear index.
    std::span<const Share> of(std::size_t cell) const {
        return std::span(shares).subspan(first[cell], first[cell + 1] - first[cell]);
    }
};

} // namespace tessera
