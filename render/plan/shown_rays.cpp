// render/plan/shown_rays.cpp: see shown_rays.h.
#include "render/plan/shown_rays.h"

#include "core/base/brick.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/vector_relational.hpp>
#include <limits>
#include <set>

namespace tessera {
namespace {

constexpr double kStepVoxels = 0.5;
constexpr std::size_t kSumEvery = 16; // entries: so the sums of the largest table take 32 KiB

/// The field of the finest level.
double valueAt(LatticeReader& samples, const glm::dvec3& p) {
    const glm::dvec3 cell = glm::floor(p - 0.5), part = p - 0.5 - cell;
    double v[8];
    samples.cube<2>(glm::ivec3(cell), v);
    const auto row = [&](int n) { return v[n] + part.x * (v[n + 1] - v[n]); };
    const double low = row(0) + part.y * (row(2) - row(0)), high = row(4) + part.y * (row(6) - row(4));
    return low + part.z * (high - low);
}

/// The exit of a line from a box.
double endOfBox(const RayLine<double>& line, const glm::ivec3& first, int edge) {
    double end = std::numeric_limits<double>::max();
    for (int axis = 0; axis < 3; ++axis)
        if (const double d = line.direction[axis]; d != 0)
            end = std::min(end, (first[axis] + (d > 0 ? edge : 0) - line.base[axis]) / d);
    return end;
}

} // namespace

ShownRays::ShownRays(BrickCache& cache, const VolumeInfo& info, const Statistics& statistics,
                     const TransferTable& table, const ViewSpace& space, const DrawnPart* part,
                     LabelBricks* labels, double leastOpacity, int threads)
    : cache_(cache), info_(info), bricks_(statistics.bricks), table_(table), space_(space), part_(part),
      labels_(labels), leastDepth_(-std::log1p(-leastOpacity)) {
    for (const SurfaceValue& surface : table.surfaces)
        surfaces_.push_back({surface.value, -std::log1p(-std::min(surface.opacity, 0.999))});
    double sum = 0;
    for (std::size_t i = 0; i < table.entries.size(); ++i) {
        if (i > 0)
            sum +=
                0.5 * (static_cast<double>(table.entries[i - 1].a) + static_cast<double>(table.entries[i].a));
        if (i % kSumEvery == 0)
            sums_.push_back(sum);
    }
    shownCells_.resize(cellCount(bricks_));
    parallelFor(shownCells_.size(), threads, [&](std::size_t b) {
        const auto isEmpty = [&](std::uint8_t shows, float lowest, float highest) {
            return (shows & kShowsMedium) == 0 && (shows == 0 || emptyOver(lowest, highest));
        };
        if (isEmpty(statistics.showsOfBrick(b, 1), statistics.brickMin[b], statistics.brickMax[b]))
            return;
        const glm::ivec3 first = gridPosition(b, bricks_) * kCellsPerBrick;
        for (int bit = 0; bit < 64; ++bit) {
            const glm::ivec3 cell = first + cellOfBit(bit);
            if (glm::any(glm::greaterThanEqual(cell, statistics.cells)))
                continue;
            const glm::dvec3 low(cell * kCellExtent);
            if (part_ && !part_->meets(low, low + static_cast<double>(kCellExtent)))
                continue;
            const std::size_t at = linearIndex(cell, statistics.cells);
            if (!isEmpty(statistics.showsOfCell(at), statistics.cellMin[at], statistics.cellMax[at]))
                shownCells_[b] |= std::uint64_t{1} << bit;
        }
    });
}

std::size_t ShownRays::bytes(const VolumeInfo& info) {
    return cellCount(brickGrid(info.extentVoxels)) * sizeof(std::uint64_t) +
           (TransferTable::kMaxEntries / kSumEvery + 1) * sizeof(double);
}

struct ShownRays::NearLabels {
    std::size_t brick = SIZE_MAX;
    LabelBricks::Texels texels;
};

/// At level 0, of the voxel alone.
ShownRays::Labelled ShownRays::labelled(NearLabels& near, const glm::ivec3& voxel) const {
    if (!labels_)
        return {};
    if (const std::size_t brick = linearIndex(voxel / kBrickExtent, bricks_); brick != near.brick)
        near = {brick, labels_->get(brick, 0)};
    const leaf::LabelNumbers& numbers = labels_->labels().numbers();
    const std::size_t at = linearIndex(voxel % kBrickExtent, glm::ivec3(kBrickExtent));
    const auto shares = leaf::labelShares<double>(numbers, [&](int channel) {
        return static_cast<double>((*near.texels)[static_cast<std::size_t>(channel) * kBrickTexels + at]) /
               double{leaf::kLightOne};
    });
    return {leaf::labelledFunction(shares, 1.0), leaf::labelledMedium(shares, double{numbers.density})};
}

void ShownRays::strengths(LatticeReader& samples, const glm::ivec3& first,
                          std::array<double, kCellVoxels>& out) const {
    samples.cube<kCellExtent>(first, out.data());
    NearLabels near;
    for (std::size_t n = 0; n < out.size(); ++n) {
        const glm::ivec3 voxel = first + gridPosition(n, glm::ivec3(kCellExtent));
        out[n] = glm::any(glm::greaterThanEqual(voxel, info_.extentVoxels)) || !drawn(glm::dvec3(voxel) + 0.5)
                     ? 0
                     : strength(samples, near, voxel, physical(out[n]));
    }
}

double ShownRays::strength(LatticeReader& samples, NearLabels& near, const glm::ivec3& voxel,
                           double value) const {
    double most = extinctionOf(labelled(near, voxel), lookUp(entryOf(value)));
    for (const Surface& surface : surfaces_)
        for (int face = 0; face < 6; ++face) {
            glm::ivec3 next = voxel;
            next[face / 2] += face % 2 == 0 ? -1 : 1;
            next = glm::clamp(next, glm::ivec3(0), info_.extentVoxels - 1);
            if ((value < surface.value) != (physical(samples.at(next)) < surface.value))
                most = std::max(most, surface.depth);
        }
    return most;
}

void ShownRays::tell(std::span<const glm::dvec3> places, const glm::dvec3& direction) const {
    constexpr int kStepsNearby = 4;
    const glm::dvec3 along = glm::dmat3(space_.voxelFromPatient) * (space_.patientFromView * direction);
    const glm::dvec3 step =
        along * (0.5 * kBrickExtent / std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)}));
    std::vector<ChunkKey> keys;
    std::set<std::size_t> told;
    const auto add = [&](const glm::dvec3& at) {
        if (glm::any(glm::lessThan(at, glm::dvec3(0))) ||
            glm::any(glm::greaterThanEqual(at, glm::dvec3(info_.extentVoxels))))
            return;
        const glm::ivec3 brick = glm::ivec3(at) / kBrickExtent;
        if (const std::size_t number = linearIndex(brick, bricks_);
            shownCells_[number] != 0 && told.insert(number).second)
            keys.push_back({0, brick.x, brick.y, brick.z});
    };
    for (int n = 0; n <= kStepsNearby; ++n) // the places first
        for (const glm::dvec3& place : places)
            for (const double way : {1.0, -1.0})
                for (int corner = 0; corner < 8; ++corner) // of a cell, and what is read around it
                    add(place + way * n * step +
                        (kCellExtent / 2 + 1.0) *
                            (2.0 * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) - 1.0));
    cache_.tell(keys);
}

bool ShownRays::onRay(LatticeReader& samples, const glm::dvec3& place, const glm::dvec3& direction) const {
    const glm::dvec3 perMm = glm::dmat3(space_.voxelFromPatient) * (space_.patientFromView * direction);
    const double mmPerVoxel = 1 / glm::length(perMm);
    // From the point in both directions: it is most often visible there.
    double depth = 0;
    return reaches(samples, place, perMm * mmPerVoxel, mmPerVoxel, depth) ||
           reaches(samples, place, -perMm * mmPerVoxel, mmPerVoxel, depth);
}

/// Adds the depth from a point along a unit direction, in voxels: true once it is enough.
bool ShownRays::reaches(LatticeReader& samples, const glm::dvec3& place, const glm::dvec3& direction,
                        double mmPerVoxel, double& depth) const {
    RayLine<double> line;
    line.base = place;
    line.direction = direction;
    double t0 = 0, t1 = 0; // the line's nearest is the place
    if (!clipToBox(line, glm::dvec3(info_.extentVoxels), t0, t1))
        return false;
    double before = std::numeric_limits<double>::quiet_NaN();
    NearLabels near;
    for (double t = std::ceil(t0 / kStepVoxels) * kStepVoxels; t <= t1; t += kStepVoxels) {
        const glm::dvec3 p = line.base + t * line.direction;
        const glm::ivec3 voxel = glm::clamp(glm::ivec3(p), glm::ivec3(0), info_.extentVoxels - 1);
        const std::uint64_t cells = shownCells_[linearIndex(voxel / kBrickExtent, bricks_)];
        const glm::ivec3 cell = voxel % kBrickExtent / kCellExtent;
        if ((cells >> (cell.x + 4 * cell.y + 16 * cell.z) & 1) == 0) { // on to the last sample of the box
            before = std::numeric_limits<double>::quiet_NaN();
            const int edge = cells == 0 ? kBrickExtent : kCellExtent;
            const double end = endOfBox(line, voxel / edge * edge, edge);
            t = std::max(t, std::floor(end / kStepVoxels) * kStepVoxels);
            continue;
        }
        if (!drawn(p)) {
            before = std::numeric_limits<double>::quiet_NaN();
            continue;
        }
        const double value = physical(valueAt(samples, p));
        if (!std::isnan(before))
            depth +=
                extinctionOf(labelled(near, voxel), meanExtinction(before, value)) * kStepVoxels * mmPerVoxel;
        for (const Surface& surface : surfaces_)
            if (!std::isnan(before) && (before < surface.value) != (value < surface.value))
                depth += surface.depth;
        if (depth > leastDepth_)
            return true;
        before = value;
    }
    return false;
}

bool ShownRays::emptyOver(float lowest, float highest) const {
    const double a = physical(static_cast<double>(lowest)), b = physical(static_cast<double>(highest));
    return table_.emptyOver(std::min(a, b), std::max(a, b));
}

/// The table's extinction, linear between entries.
double ShownRays::lookUp(double entry) const {
    const double last = static_cast<double>(table_.entries.size() - 1), x = std::clamp(entry, 0.0, last);
    const auto i = static_cast<std::size_t>(std::min(x, last - 1));
    const double a = static_cast<double>(table_.entries[i].a);
    const double b = static_cast<double>(table_.entries[i + 1].a);
    return a + (x - static_cast<double>(i)) * (b - a);
}

/// Integral of the table from its first entry on; beyond its ends, where it is constant, linear.
double ShownRays::sumTo(double entry) const {
    const double last = static_cast<double>(table_.entries.size() - 1), x = std::clamp(entry, 0.0, last);
    const auto i = static_cast<std::size_t>(x);
    double sum = sums_[i / kSumEvery];
    for (std::size_t n = i / kSumEvery * kSumEvery; n < i; ++n)
        sum +=
            0.5 * (static_cast<double>(table_.entries[n].a) + static_cast<double>(table_.entries[n + 1].a));
    const double inside = x - static_cast<double>(i);
    return sum + 0.5 * inside * (static_cast<double>(table_.entries[i].a) + lookUp(x)) +
           (entry - x) * lookUp(x);
}

double ShownRays::meanExtinction(double a, double b) const {
    const double from = entryOf(a), to = entryOf(b);
    return std::abs(to - from) < 1e-3 ? lookUp(0.5 * (from + to)) : (sumTo(to) - sumTo(from)) / (to - from);
}

} // namespace tessera
