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

#include "bricking/store/slab_file.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
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

/// Where the slabs of the levels lie while they fill: in memory, or those of the finer levels in files.
struct SlabPlan {
    int bandRows = INT32_MAX; // rows of level 0 that come at once, a multiple of kChunkExtent; more: all
    int firstHeld = 0;        // level from which on slabs are in memory; 0: of all levels
    std::filesystem::path folder = {}; // of the files

    bool isWhole() const { return firstHeld == 0; }
};

/// Takes level 0 in slabs of kChunkExtent slices, z ascending, and passes on finished slabs of every level. A
/// slab starts at a multiple of kChunkExtent, which is even, so no pair of slices is ever split. A slab that
/// has no room in memory comes and goes in bands of rows, y ascending.
class SlabPyramid {
  public:
    struct Slab {
        int level = 0;
        int firstSlice = 0;                // multiple of kChunkExtent
        int slices = 0;                    // kChunkExtent, fewer in the last slab of a level
        int firstRow = 0, rows = 0;        // of the band; of a whole slab 0 and extent.y
        std::span<const std::byte> values; // [slices][rows][extent.x] of this level; valid during the call
    };
    using Sink = std::function<void(const Slab&)>;

    /// Charges bytesNeeded() to ram. Throws InputError when the budget cannot hold them; Error if the disk
    /// has too little room for the slabs in files.
    SlabPyramid(const glm::ivec3& extentVoxels, ValueType type, MemoryBudget& ram, int threads, Sink sink,
                PyramidRule rule = {}, const SlabPlan& plan = {});
    /// One slab per level; of slabs in files a band, and what it is reduced to.
    static std::size_t bytesNeeded(const glm::ivec3& extentVoxels, ValueType type, const SlabPlan& plan = {});
    /// Of the slabs in files.
    static std::uint64_t fileBytes(const glm::ivec3& extentVoxels, ValueType type, const SlabPlan& plan);

    /// Slices that the next slab of level 0 has; 0 when all have come.
    int nextSlices() const;
    /// Rows that come next of that slab.
    int nextFirstRow() const { return row_; }
    int nextRows() const;
    /// Buffer for them, [nextSlices()][nextRows()][x].
    std::span<std::byte> next();
    /// Exchanges that buffer with another of its size at first.
    void swapNext(std::vector<std::byte>& slab);
    /// Processes the buffer of next(); calls the sink for every completed band, of any level.
    void push();

  private:
    struct Level {
        glm::ivec3 extent{0};
        int firstSlice = 0;            // of the slab in the buffer
        int filled = 0;                // slices in the buffer
        int bandRows = 0;              // that are processed at once
        std::vector<std::byte> values; // of level 0 a band
        std::optional<SlabFile> file;  // in place of the values
    };
    std::size_t sliceBytes(const Level& level) const;
    std::size_t rowBytes(const Level& level) const;
    void takeBand(int level, int firstRow, int rows, std::span<const std::byte> values);
    void reduceBand(const Level& level, Level& coarser, int firstRow, int rows,
                    std::span<const std::byte> values);
    void readBand(const Level& level, int firstRow, int rows, std::span<std::byte> out) const;
    void complete(int level);
    void end(int level);

    ValueType type_;
    int threads_;
    Sink sink_;
    PyramidRule rule_;
    Charge charge_;
    std::array<Level, kLevelCount> levels_;
    std::vector<std::byte> reduced_; // of a band, for a file
    int row_ = 0;                    // of level 0, that comes next
};

} // namespace tessera
