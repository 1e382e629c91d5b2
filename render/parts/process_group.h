// render/parts/process_group.h: ProcessGroup: the processes that draw one picture together, each a part of
// its volume. What implements it is in a module (viewer/ranks/): nothing here knows how processes reach one
// another.
#pragma once

#include "render/parts/part_tree.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

/// What a process had of the volume, and what it took.
struct PartReport {
    PartTree::Box box;               // bricks
    std::uint64_t bytesOfBricks = 0; // loaded
    std::uint64_t ramPeak = 0, gpuPeak = 0;
};

/// All processes make the same calls in the same order; each waits for the others.
class ProcessGroup {
  public:
    virtual ~ProcessGroup() = default;

    /// From 0 to below size(). Number 0 writes the picture.
    virtual int rank() const = 0;
    virtual int size() const = 0;
    /// The least of all processes' numbers.
    virtual std::uint64_t least(std::uint64_t mine) = 0;
    /// Makes of every process's pixels their composite: premultiplied colours, over one another.
    /// @param order  the processes, those before others first
    virtual void composite(std::span<glm::vec4> pixels, const glm::ivec2& size,
                           std::span<const int> order) = 0;
    /// Those of all processes, by rank, at number 0; elsewhere none.
    virtual std::vector<PartReport> gather(const PartReport& mine) = 0;
    /// This process ends with an error, and that exit code: then all do, once it has said why.
    virtual void fail(int exitCode) = 0;

    /// True if all have the same number.
    bool agree(std::uint64_t mine) { return least(mine) == ~least(~mine); }
};

/// The part of a plan's volume that this process draws.
struct SharedVolume {
    ProcessGroup& group; // outlives it
    PartTree parts;

    int mine() const { return group.rank(); }
};

} // namespace tessera
