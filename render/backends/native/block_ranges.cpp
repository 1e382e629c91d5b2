// render/backends/native/block_ranges.cpp: see block_ranges.h.
#include "render/backends/native/block_ranges.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace tessera {
namespace {

using native::CellRanges;
using native::PacketBrick;

constexpr int kBlocks = 4; // of a cell along an axis
constexpr int kBlockExtent = kCellExtent / kBlocks;
constexpr int kCellSamples = 10; // along a cell: its 8 of level 0, and one on both sides
constexpr int kPoints = 9;       // planes between voxels along a cell, both its faces included
constexpr int kRow = 12;         // floats of a row of points

/// Samples of a level that the field in a cell is made of, along one axis.
struct Window {
    int first, count;
    Window(int firstVoxel, int level) {
        const int extent = 1 << level; // voxels of a sample
        first = (2 * firstVoxel - extent) >> (level + 1);
        count = ((2 * (firstVoxel + kCellExtent) - extent) >> (level + 1)) + 2 - first;
    }
};

/// Places of the planes between a cell's voxels in a window of samples of a coarser level, in samples.
struct PointsAlong {
    int low[kPoints];
    float part[kPoints];
    PointsAlong(int firstVoxel, int level) {
        const float perVoxel = 1.0f / static_cast<float>(1 << level);
        const auto first = static_cast<float>(Window(firstVoxel, level).first);
        for (int n = 0; n < kPoints; ++n) {
            const float at = static_cast<float>(firstVoxel + n) * perVoxel - 0.5f - first;
            low[n] = static_cast<int>(at); // not negative, so this is floor
            part[n] = at - static_cast<float>(low[n]);
        }
    }
};

/// From a sample of a brick to the next along an axis, samples.
std::int64_t pitchAlong(const HostPlane& plane, int level, int axis) {
    return axis == 0 ? 1 : axis == 1 ? plane.rowPitch(level) : plane.slicePitch(level);
}

using PointRow = float[kRow];
void mixRows(const float* a, const float* b, float part, PointRow& to) {
    for (int x = 0; x < kRow; ++x)
        to[x] = a[x] + (b[x] - a[x]) * part;
}

/// Least and largest of three points that follow one another, for each block, along all axes.
void rangesOfPoints(const PointRow (&points)[kPoints][kPoints], CellRanges& out) {
    for (int k = 0; k < kBlocks; ++k) {
        PointRow low[kPoints], high[kPoints];
        for (int y = 0; y < kPoints; ++y)
            for (int x = 0; x < kRow; ++x) {
                const float a = points[2 * k][y][x], b = points[2 * k + 1][y][x], c = points[2 * k + 2][y][x];
                low[y][x] = std::min(std::min(a, b), c);
                high[y][x] = std::max(std::max(a, b), c);
            }
        for (int j = 0; j < kBlocks; ++j) {
            PointRow least, most;
            for (int x = 0; x < kRow; ++x) {
                least[x] = std::min(std::min(low[2 * j][x], low[2 * j + 1][x]), low[2 * j + 2][x]);
                most[x] = std::max(std::max(high[2 * j][x], high[2 * j + 1][x]), high[2 * j + 2][x]);
            }
            for (int i = 0; i < kBlocks; ++i) {
                const int block = i + kBlocks * (j + kBlocks * k);
                out.blockLow[block] = std::min(std::min(least[2 * i], least[2 * i + 1]), least[2 * i + 2]);
                out.blockHigh[block] = std::max(std::max(most[2 * i], most[2 * i + 1]), most[2 * i + 2]);
            }
        }
    }
    out.low = *std::min_element(std::begin(out.blockLow), std::end(out.blockLow));
    out.high = *std::max_element(std::begin(out.blockHigh), std::end(out.blockHigh));
}

} // namespace

const PacketBrick& BlockRanges::brickAt(const glm::ivec3& brick) const {
    return plane_.bricks()[linearIndex(brick, plane_.grid())];
}

/// From samples_.
void BlockRanges::rangesOfSamples(int level, const glm::ivec3& firstVoxel, CellRanges& out) {
    if (level == 0) { // extreme at samples, too, which lie between the planes of voxels
        target_.cellRanges(samples_, out);
        return;
    }
    // Samples of coarser levels lie in planes between voxels.
    const PointsAlong xs(firstVoxel.x, level), ys(firstVoxel.y, level), zs(firstVoxel.z, level);
    PointRow alongX[kCellSamples][kCellSamples], alongY[kCellSamples][kPoints], points[kPoints][kPoints];
    const int rows = Window(firstVoxel.y, level).count, slices = Window(firstVoxel.z, level).count;
    for (int z = 0; z < slices; ++z) {
        for (int y = 0; y < rows; ++y) {
            const float* const from = samples_.rows[z * kCellSamples + y];
            for (int x = 0; x < kPoints; ++x) {
                const float a = from[xs.low[x]], b = from[xs.low[x] + 1];
                alongX[z][y][x] = a + (b - a) * xs.part[x];
            }
            std::fill(alongX[z][y] + kPoints, std::end(alongX[z][y]), from[0]);
        }
        for (int y = 0; y < kPoints; ++y)
            mixRows(alongX[z][ys.low[y]], alongX[z][ys.low[y] + 1], ys.part[y], alongY[z][y]);
    }
    for (int z = 0; z < kPoints; ++z)
        for (int y = 0; y < kPoints; ++y)
            mixRows(alongY[zs.low[z]][y], alongY[zs.low[z] + 1][y], zs.part[z], points[z][y]);
    rangesOfPoints(points, out);
}

/// The range of one brick in a cell, of its own or beyond its faces: clamped to its own samples and its ghost
/// layer's.
void BlockRanges::rangesOfBrick(const glm::ivec3& at, const glm::ivec3& firstVoxel, CellRanges& out) {
    const PacketBrick& brick = brickAt(at);
    const std::uint32_t state = brick.low >> 24;
    if (state == PacketBrick::kValue) {
        out.low = out.high = brick.mean * scale_ + offset_;
        std::fill(std::begin(out.blockLow), std::end(out.blockLow), out.low);
        std::fill(std::begin(out.blockHigh), std::end(out.blockHigh), out.low);
        return;
    }
    TESSERA_CHECK(state < PacketBrick::kValue);
    const auto level = static_cast<int>(state);
    const int edge = kBrickExtent >> level;
    glm::ivec3 least(0),
        last = glm::min(glm::ivec3(edge), levelExtent(plane_.info().extentVoxels, level) - at * edge) - 1;
    if (brick.low == HostPlane::kLowWithGhost) {
        least = glm::ivec3(-kGhostBefore);
        last = glm::ivec3(kBrickExtent + kGhostBehind - 1);
    }
    std::int64_t offsets[3][kCellSamples];
    glm::ivec3 count(0);
    for (int axis = 0; axis < 3; ++axis) {
        const Window window(firstVoxel[axis], level);
        count[axis] = window.count;
        const std::int64_t pitch = pitchAlong(plane_, level, axis);
        for (int n = 0; n < window.count; ++n)
            offsets[axis][n] =
                pitch * std::clamp(window.first + n - at[axis] * edge, least[axis], last[axis]);
    }
    const std::int64_t* const xs = offsets[0];
    native::CellRows rows;
    rows.first = static_cast<int>(std::upper_bound(xs, xs + count.x, xs[0]) - xs) - 1;
    rows.last = static_cast<int>(std::lower_bound(xs, xs + count.x, xs[count.x - 1]) - xs);
    if (rows.first > rows.last) // beside the brick
        rows.first = rows.last = 0;
    rows.endY = count.y, rows.endZ = count.z;
    std::copy_n(offsets[1], count.y, rows.alongY);
    for (int z = 0; z < count.z; ++z)
        rows.alongZ[z] = offsets[2][z] + xs[rows.first] - rows.first;
    rows.scale = scale_, rows.offset = offset_;
    target_.cellSamples(plane_.samplesOf(brick), plane_.kind(), rows, samples_);
    rangesOfSamples(level, firstVoxel, out);
}

/// Of the samples of one level, whichever bricks have them; empty ones read as their mean.
void BlockRanges::rangesOfLevel(int level, const glm::ivec3& firstVoxel, CellRanges& out) {
    const int edge = kBrickExtent >> level, last = edge - 1, shift = 5 - level;
    const glm::ivec3 end = levelExtent(plane_.info().extentVoxels, level) - 1;
    std::int64_t bricks[3][kCellSamples], offsets[3][kCellSamples];
    glm::ivec3 count(0);
    bool one = true;
    for (int axis = 0; axis < 3; ++axis) {
        const Window window(firstVoxel[axis], level);
        count[axis] = window.count;
        const std::int64_t pitch = pitchAlong(plane_, level, axis);
        const std::int64_t ofBricks = axis == 0   ? 1
                                      : axis == 1 ? plane_.grid().x
                                                  : plane_.grid().x * plane_.grid().y;
        for (int n = 0; n < window.count; ++n) {
            const int i = std::clamp(window.first + n, 0, end[axis]);
            bricks[axis][n] = ofBricks * (i >> shift);
            offsets[axis][n] = pitch * (i & last);
            one = one && bricks[axis][n] == bricks[axis][0];
        }
    }
    if (one) // it clamps at the volume's end, too
        return rangesOfBrick(firstVoxel / kBrickExtent, firstVoxel, out);
    const std::int64_t* const xs = offsets[0];
    // Part by part: one brick's part of the window.
    const auto part = [&](int axis, int from) {
        int end = from + 1;
        while (end < count[axis] && bricks[axis][end] == bricks[axis][from])
            ++end;
        return end;
    };
    native::CellRows rows;
    rows.alone = false;
    rows.scale = scale_, rows.offset = offset_;
    std::copy_n(offsets[1], count.y, rows.alongY);
    for (rows.firstZ = 0; rows.firstZ < count.z; rows.firstZ = rows.endZ) {
        rows.endZ = part(2, rows.firstZ);
        for (rows.firstY = 0; rows.firstY < count.y; rows.firstY = rows.endY) {
            rows.endY = part(1, rows.firstY);
            for (rows.first = 0; rows.first < count.x; rows.first = rows.last + 1) {
                rows.last = part(0, rows.first) - 1;
                // At the volume's end numbers repeat its last sample: one by one.
                if (xs[rows.last] - xs[rows.first] != rows.last - rows.first)
                    rows.last = rows.first;
                const PacketBrick& brick = plane_.bricks()[static_cast<std::size_t>(
                    bricks[2][rows.firstZ] + bricks[1][rows.firstY] + bricks[0][rows.first])];
                const std::uint32_t state = brick.low >> 24;
                TESSERA_CHECK(state != PacketBrick::kAbsent);
                if (state == PacketBrick::kValue) {
                    fill(rows, brick.mean * scale_ + offset_);
                    continue;
                }
                for (int z = rows.firstZ; z < rows.endZ; ++z)
                    rows.alongZ[z] = offsets[2][z] + xs[rows.first] - rows.first;
                target_.cellSamples(plane_.samplesOf(brick), plane_.kind(), rows, samples_);
            }
        }
    }
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y) {
            auto& row = samples_.rows[z * kCellSamples + y];
            std::fill(row + count.x, std::end(row), row[0]);
        }
    rangesOfSamples(level, firstVoxel, out);
}

/// All samples of a part.
void BlockRanges::fill(const native::CellRows& part, float value) {
    for (int z = part.firstZ; z < part.endZ; ++z)
        for (int y = part.firstY; y < part.endY; ++y) {
            auto& row = samples_.rows[z * kCellSamples + y];
            std::fill(row + part.first, row + part.last + 1, value);
        }
}

/// Adds the ranges of other bricks in the blocks where they have weight.
void BlockRanges::addNeighbours(const glm::ivec3& cell, const BrickCorner& corner) {
    const glm::ivec3 brick = cell / kCellsPerBrick, inBrick = cell - brick * kCellsPerBrick;
    const glm::ivec3 upper(glm::greaterThanEqual(inBrick, glm::ivec3(kCellsPerBrick / 2)));
    glm::ivec3 layers(0); // of blocks, from the side that faces the corner
    for (int axis = 0; axis < 3; ++axis) {
        float reach = 0;
        if (corner.reachCode(axis) != BrickCorner::kNoReach)
            reach = halfSample<float>(corner.reachCode(axis));
        else if (map_->edgeFunction == EdgeFunction::nearest)
            reach = 1; // values jump there, and blocks that touch are to share one
        const int cellsBetween = upper[axis] ? kCellsPerBrick - 1 - inBrick[axis] : inBrick[axis];
        const float into = reach - static_cast<float>(cellsBetween * kCellExtent);
        layers[axis] = std::clamp(static_cast<int>(std::ceil(into / kBlockExtent)), 0, kBlocks);
    }
    for (int side = 1; side < 8; ++side) {
        const glm::ivec3 across(side & 1, (side >> 1) & 1, side >> 2);
        const glm::ivec3 other = brick + across * (2 * upper - 1);
        if (glm::any(glm::lessThan(other, glm::ivec3(0))) ||
            glm::any(glm::greaterThanEqual(other, plane_.grid())))
            continue;
        const glm::ivec3 near = across * layers + (1 - across) * kBlocks;
        const glm::ivec3 low = across * upper * (kBlocks - near), high = low + near;
        if (glm::any(glm::equal(near, glm::ivec3(0))))
            continue;
        rangesOfBrick(other, cell * kCellExtent, others_);
        for (int z = low.z; z < high.z; ++z)
            for (int y = low.y; y < high.y; ++y)
                for (int x = low.x; x < high.x; ++x) {
                    const int block = x + kBlocks * (y + kBlocks * z);
                    ranges_.blockLow[block] = std::min(ranges_.blockLow[block], others_.blockLow[block]);
                    ranges_.blockHigh[block] = std::max(ranges_.blockHigh[block], others_.blockHigh[block]);
                }
        ranges_.low = std::min(ranges_.low, others_.low);
        ranges_.high = std::max(ranges_.high, others_.high);
    }
}

const CellRanges& BlockRanges::of(const glm::ivec3& cell) {
    const glm::ivec3 brick = cell / kCellsPerBrick, firstVoxel = cell * kCellExtent;
    if (brickAt(brick).low == HostPlane::kLowWithGhost) {
        rangesOfBrick(brick, firstVoxel, ranges_);
        return ranges_;
    }
    const glm::ivec3 nearest = (cell + kCellsPerBrick / 2) / kCellsPerBrick;
    const BrickCorner* const corner = map_ ? &map_->at(nearest) : nullptr;
    if (!corner || corner->agree()) {
        rangesOfLevel(corner ? corner->commonLevel() : level_, firstVoxel, ranges_);
        return ranges_;
    }
    rangesOfBrick(brick, firstVoxel, ranges_);
    addNeighbours(cell, *corner);
    return ranges_;
}

} // namespace tessera
