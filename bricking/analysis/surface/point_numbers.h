// bricking/analysis/surface/point_numbers.h: PointNumbers: the numbers of a surface's points by the edges of
// the lattice that they lie on: of the block that is visited, and of the faces that later blocks share.
#pragma once

#include "core/base/budget.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

class PointNumbers {
  public:
    static constexpr std::uint32_t kNone = 0xFFFFFFFF;
    /// @param planes  of the whole lattice
    /// @param block   most planes of a block along each axis
    /// Blocks are then visited by z, y and x, x fastest. Throws InputError if ram cannot hold bytes().
    PointNumbers(const glm::ivec3& planes, const glm::ivec3& block, MemoryBudget& ram);
    static std::size_t bytes(const glm::ivec3& planes, const glm::ivec3& block);

    /// Begins a block with the planes [low, high] of each axis: its first and last ones are shared.
    void begin(const glm::ivec3& low, const glm::ivec3& high);
    /// Of the edge at a plane, within the block.
    std::uint32_t& at(const glm::ivec3& plane, int axis) { return numbers_[indexOf(plane - low_, axis)]; }
    /// The block is done.
    void end();
    /// A block that has no point, without begin().
    void skip(const glm::ivec3& low, const glm::ivec3& high);

  private:
    std::size_t indexOf(const glm::ivec3& local, int axis) const {
        return 3 * ((static_cast<std::size_t>(local.z) * static_cast<std::size_t>(block_.y) +
                     static_cast<std::size_t>(local.y)) *
                        static_cast<std::size_t>(block_.x) +
                    static_cast<std::size_t>(local.x)) +
               static_cast<std::size_t>(axis);
    }
    /// Visits the two edges of each place of the plane of the block's shared faces along an axis.
    template <typename Visit> void eachShared(int axis, int plane, const Visit& visit);

    glm::ivec3 planes_, block_;
    glm::ivec3 low_{0}, high_{0};
    Charge charge_;
    std::vector<std::uint32_t> numbers_; // [z][y][x][axis]
    std::vector<std::uint32_t>
        shared_[3]; // at right angles to x: [z][y][2], to y: [z][x][2], to z: [y][x][2]
};

} // namespace tessera
