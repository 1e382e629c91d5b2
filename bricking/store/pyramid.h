// bricking/store/pyramid.h: the levels of a volume, computed from slabs as they stream by.
//
// The rule: extent_l = ceil(extent_(l-1) / 2) along each axis. Sample (i,j,k) of level l is the mean of the
// eight samples (2i+a, 2j+b, 2k+c), a, b, c in {0,1}, of level l-1. Each coordinate is clamped to the last
// sample of level l-1: at an odd edge the missing neighbour is the edge sample again. Integers: the exact sum
// of eight, divided by 8, halves to even. Float: the terms added in double, c slowest, b, a fastest, times
// 1/8, rounded to float. A level comes from the level before it, never from level 0 directly: the results
// differ, and this one can be streamed.
//
// Volumes whose values name things have another rule, with the same extents and the same repeated edges.
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// The rule above, as metadata.multiscales and attributes.tessera name it.
constexpr const char* kPyramidRule =
    "2x2x2 mean, level by level, halves to even, edge samples repeated at odd extents";

/// The rule of levels of names, whose means say nothing.
constexpr const char* kMajorityRule =
    "2x2x2 majority, level by level, ties to the value that is rarer at level 0, then to the lower one, edge "
    "samples repeated at odd extents";

/// How the samples of a level become those of the next one.
struct PyramidRule {
    const char* name = kPyramidRule; // kPyramidRule or kMajorityRule: what the metadata says
    /// As reduceByTwo(), over any slab that starts at an even slice. Empty: reduceByTwo().
    std::function<void(ValueType type, const glm::ivec3& extent, std::span<const std::byte> in,
                       std::span<std::byte> out, int threads)>
        reduce = {};
};

/// Means: one level from the one above it, over a whole box.
/// @param extent  of in, each at least 1; out has ceil(extent / 2) samples. Both [z][y][x].
void reduceByTwo(ValueType type, const glm::ivec3& extent, std::span<const std::byte> in,
                 std::span<std::byte> out, int threads);

/// Takes level 0 in slabs of kChunkExtent slices, z ascending, and passes on finished slabs of every level. A
/// slab starts at a multiple of kChunkExtent, which is even, so no pair of slices is ever split.
class SlabPyramid {
  public:
    struct Slab {
        int level = 0;
        int firstSlice = 0; // multiple of kChunkExtent
        int slices = 0;     // kChunkExtent, fewer in the last slab of a level
        std::span<const std::byte>
            values; // [slices][extent.y][extent.x] of this level; valid during the call
    };
    using Sink = std::function<void(const Slab&)>;

    /// Charges one slab per level to ram. Throws InputError when the budget cannot hold them.
    SlabPyramid(const glm::ivec3& extentVoxels, ValueType type, MemoryBudget& ram, int threads, Sink sink,
                PyramidRule rule = {});
    static std::size_t bytesNeeded(const glm::ivec3& extentVoxels, ValueType type);

    /// Slices that the next slab of level 0 has; 0 when all have come.
    int nextSlices() const;
    /// Buffer for the next slab of level 0, [nextSlices()][y][x].
    std::span<std::byte> next();
    /// Exchanges that buffer with another of its size at first.
    void swapNext(std::vector<std::byte>& slab);
    /// Processes the buffer of next(); calls the sink for every completed slab, of any level.
    void push();

  private:
    struct Level {
        glm::ivec3 extent{0};
        int firstSlice = 0; // of the slab in the buffer
        int filled = 0;     // slices in the buffer
        std::vector<std::byte> values;
    };
    std::size_t sliceBytes(const Level& level) const;
    void complete(int level);

    ValueType type_;
    int threads_;
    Sink sink_;
    PyramidRule rule_;
    Charge charge_;
    std::array<Level, kLevelCount> levels_;
};

} // namespace tessera
