// bricking/analysis/surface/surface_mesh.cpp: see surface_mesh.h.
#include "bricking/analysis/surface/surface_mesh.h"

#include "bricking/analysis/surface/cell_cases.h"
#include "bricking/analysis/surface/lattice_values.h"
#include "bricking/analysis/surface/point_numbers.h"
#include "bricking/cache/brick_cache.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <vector>

namespace tessera {
namespace {

/// The first cells of parts of an axis, and behind them the number of its cells. Parts end at samples whose
/// number is a multiple of the extent.
std::vector<int> partsOf(const std::vector<LatticePlane>& planes, int extent) {
    std::vector<int> first{0};
    const int count = static_cast<int>(planes.size());
    for (int p = 3; p + 2 < count; ++p)
        if (planes[static_cast<std::size_t>(p)].low % extent == 0)
            first.push_back(p);
    first.push_back(count - 1);
    return first;
}

int longestOf(const std::vector<int>& parts) {
    int longest = 0;
    for (std::size_t i = 1; i < parts.size(); ++i)
        longest = std::max(longest, parts[i] - parts[i - 1]);
    return longest;
}

glm::ivec3 blockPlanes(const SurfaceLattice& lattice, int extent) {
    glm::ivec3 planes(0);
    for (int axis = 0; axis < 3; ++axis)
        planes[axis] = longestOf(partsOf(lattice.planes(axis), extent)) + 1;
    return planes;
}

/// Memory of the values of a tile, as samples and on the lattice, and of the sides of its corners.
std::size_t tileBytes(const glm::ivec3& planes) {
    return cellCount(planes + 2) * (2 * sizeof(double) + 1);
}

class Extraction {
  public:
    Extraction(const ChunkSource& source, const SurfaceLattice& lattice, const CellRanges& ranges,
               const SurfaceRequest& request, MemoryBudget& ram, MeshSink& sink)
        : info_(source.info()), lattice_(lattice), ranges_(ranges), request_(request), sink_(sink),
          scratch_(
              ram.charge(tileBytes(blockPlanes(lattice, std::max(request.tileExtent, request.blockExtent))),
                         "values of a surface's cells")),
          numbers_(lattice.extent(), blockPlanes(lattice, request.blockExtent), ram),
          cache_(source, ram, cacheBytes(info_, ram, request.threads), request.threads),
          values_(cache_, info_, lattice, request.value),
          mirrored_(glm::determinant(glm::dmat3(info_.patientFromVoxel)) < 0) {
        for (int axis = 0; axis < 3; ++axis) {
            blocks_[static_cast<std::size_t>(axis)] = partsOf(lattice.planes(axis), request.blockExtent);
            tiles_[static_cast<std::size_t>(axis)] = partsOf(lattice.planes(axis), request.tileExtent);
        }
        counts_.lowMm = glm::dvec3(std::numeric_limits<double>::infinity());
        counts_.highMm = -counts_.lowMm;
        counts_.cells = cellCount(lattice.extent() - 1);
        originMm_ = glm::dvec3(info_.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info_.extentVoxels), 1));
    }

    SurfaceCounts run(const ShareDone& progress) {
        const auto partsAlong = [&](int axis) { return blocks_[static_cast<std::size_t>(axis)].size() - 1; };
        for (std::size_t k = 0; k < partsAlong(2); ++k)
            for (std::size_t j = 0; j < partsAlong(1); ++j) {
                if (progress)
                    progress(static_cast<double>(k * partsAlong(1) + j) /
                             static_cast<double>(partsAlong(1) * partsAlong(2)));
                for (std::size_t i = 0; i < partsAlong(0); ++i) {
                    checkInterrupted();
                    visitBlock({blocks_[0][i], blocks_[1][j], blocks_[2][k]},
                               {blocks_[0][i + 1], blocks_[1][j + 1], blocks_[2][k + 1]});
                }
            }
        counts_.chunksDecoded = cache_.counters().misses;
        return counts_;
    }

  private:
    static std::size_t cacheBytes(const VolumeInfo& info, const MemoryBudget& ram, int threads) {
        const std::size_t floor = BrickCache::floorBytes(info, threads);
        return std::max(floor, ram.freeBytes() / 2);
    }

    /// True if the surface can meet the cells [low, high).
    bool canMeet(const glm::ivec3& low, const glm::ivec3& high) const {
        glm::ivec3 first(0), last(0);
        bool atFace = false;
        for (int axis = 0; axis < 3; ++axis) {
            const auto& planes = lattice_.planes(axis);
            const int pitch = 1 << lattice_.level();
            const int voxel = planes[static_cast<std::size_t>(low[axis])].low * pitch,
                      end = std::min((planes[static_cast<std::size_t>(high[axis])].high + 1) * pitch,
                                     info_.extentVoxels[axis]);
            const int most = ranges_.cells[axis] - 1;
            first[axis] = std::clamp((voxel + ranges_.layer) / kCellExtent, 0, most);
            last[axis] = std::clamp((end - 1 - ranges_.layer) / kCellExtent, first[axis], most);
            atFace = atFace || low[axis] == 0 || high[axis] + 1 == static_cast<int>(planes.size());
        }
        float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
        for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
                for (int x = first.x; x <= last.x; ++x) {
                    const std::size_t cell = linearIndex({x, y, z}, ranges_.cells);
                    lowest = std::min(lowest, ranges_.low[cell]);
                    highest = std::max(highest, ranges_.high[cell]);
                }
        if (lattice_.level() > 0) { // means are rounded
            constexpr float kRounding = 1e-6f;
            lowest -= kRounding * std::abs(lowest), highest += kRounding * std::abs(highest);
        }
        const double a = values_.of(lowest), b = values_.of(highest);
        return std::max(a, b) >= 0 && (atFace || std::min(a, b) < 0);
    }

    /// The parts of [low, high) of an axis that are tiles.
    std::vector<int> tilesWithin(int axis, int low, int high) const {
        std::vector<int> first{low};
        for (const int at : tiles_[static_cast<std::size_t>(axis)])
            if (at > low && at < high)
                first.push_back(at);
        first.push_back(high);
        return first;
    }

    void visitBlock(const glm::ivec3& low, const glm::ivec3& high) {
        const std::vector<int> xs = tilesWithin(0, low.x, high.x), ys = tilesWithin(1, low.y, high.y),
                               zs = tilesWithin(2, low.z, high.z);
        bool begun = false;
        for (std::size_t k = 0; k + 1 < zs.size(); ++k)
            for (std::size_t j = 0; j + 1 < ys.size(); ++j)
                for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
                    const glm::ivec3 first(xs[i], ys[j], zs[k]), end(xs[i + 1], ys[j + 1], zs[k + 1]);
                    if (!canMeet(first, end))
                        continue;
                    if (!begun)
                        numbers_.begin(low, high);
                    begun = true;
                    visitTile(first, end);
                }
        if (begun)
            numbers_.end();
        else
            numbers_.skip(low, high);
    }

    void visitTile(const glm::ivec3& low, const glm::ivec3& end) {
        values_.read(low, end, field_);
        const glm::ivec3 count = end - low + 1;
        sides_.resize(field_.size());
        std::transform(field_.begin(), field_.end(), sides_.begin(),
                       [](double v) { return static_cast<std::uint8_t>(!(v < 0)); });
        counts_.cellsSeen += cellCount(end - low);
        std::array<std::size_t, 8> corner{};
        for (std::size_t c = 0; c < corner.size(); ++c)
            corner[c] = linearIndex({c & 1, c >> 1 & 1, c >> 2}, count);
        for (int z = low.z; z < end.z; ++z)
            for (int y = low.y; y < end.y; ++y) {
                std::size_t at = linearIndex(glm::ivec3(low.x, y, z) - low, count);
                for (int x = low.x; x < end.x; ++x, ++at) {
                    unsigned inside = 0;
                    for (unsigned c = 0; c < 8; ++c)
                        inside |= static_cast<unsigned>(sides_[at + corner[c]]) << c;
                    if (inside == 0 || inside == 255)
                        continue;
                    for (std::size_t c = 0; c < 8; ++c)
                        cell_[c] = field_[at + corner[c]];
                    visitCell({x, y, z}, static_cast<std::uint8_t>(inside));
                }
            }
    }

    /// Faces of those that are ambiguous on which what is inside is joined.
    std::uint8_t joinedFaces(std::uint8_t inside, std::uint8_t ambiguous) const {
        unsigned joined = 0;
        for (int face = 0; face < 6; ++face) {
            if (!(ambiguous >> face & 1))
                continue;
            const std::array<int, 4> c = cornersOf(face);
            const auto v = [&](std::size_t i) { return cell_[static_cast<std::size_t>(c[i])]; };
            // Products of the same two numbers in both cells of the face, so the same in both.
            const double even = v(0) * v(2), odd = v(1) * v(3);
            const bool evenInside = inside >> c[0] & 1;
            joined |= static_cast<unsigned>(evenInside ? even >= odd : odd >= even) << face;
        }
        return static_cast<std::uint8_t>(joined);
    }

    std::uint32_t newPoint(const glm::dvec3& mm) {
        if (counts_.points >= request_.mostPoints)
            throw InputError(
                "the surface has more than " + std::to_string(request_.mostPoints) +
                " points, which numbers of 32 bits do not tell apart: a coarser --level or a box "
                "has fewer");
        counts_.lowMm = glm::min(counts_.lowMm, mm);
        counts_.highMm = glm::max(counts_.highMm, mm);
        sink_.point(mm);
        return static_cast<std::uint32_t>(counts_.points++);
    }

    void visitCell(const glm::ivec3& at, std::uint8_t inside) {
        const std::uint8_t ambiguous = ambiguousFaces(inside);
        const CellCase found = cellCase(inside, ambiguous ? joinedFaces(inside, ambiguous) : std::uint8_t{0});
        unsigned known = 0; // edges whose points are in numbers and places
        std::array<std::uint32_t, kCellEdges + 4> numbers{};
        std::array<glm::dvec3, kCellEdges + 4> places;
        const auto need = [&](int edge) {
            if (known >> edge & 1)
                return;
            known |= 1u << edge;
            const int low = lowCornerOf(edge), axis = edge / 4;
            const glm::ivec3 from = at + glm::ivec3(low & 1, low >> 1 & 1, low >> 2 & 1);
            const auto e = static_cast<std::size_t>(edge);
            places[e] = lattice_.crossing(from, axis, cell_[static_cast<std::size_t>(low)],
                                          cell_[static_cast<std::size_t>(low | 1 << axis)]);
            std::uint32_t& number = numbers_.at(from, axis);
            if (number == PointNumbers::kNone)
                number = newPoint(places[e]);
            numbers[e] = number;
        };
        for (const std::uint8_t corner : found.corners)
            if (corner < kCellEdges)
                need(corner);
        for (std::size_t m = 0; m < found.middles.size(); ++m) {
            const LoopMiddle& middle = found.middles[m];
            glm::dvec3 sum(0);
            for (std::size_t i = 0; i < middle.count; ++i)
                sum += places[middle.edges[i]];
            places[kCellEdges + m] = sum / static_cast<double>(middle.count);
            numbers[kCellEdges + m] = newPoint(places[kCellEdges + m]);
        }
        for (std::size_t t = 0; t < found.corners.size(); t += 3) {
            const std::size_t a = found.corners[t], b = found.corners[t + (mirrored_ ? 2 : 1)],
                              c = found.corners[t + (mirrored_ ? 1 : 2)];
            const glm::dvec3 p = places[a] - originMm_, q = places[b] - originMm_, r = places[c] - originMm_;
            counts_.volumeMm3 += glm::dot(p, glm::cross(q, r)) / 6;
            counts_.areaMm2 += glm::length(glm::cross(q - p, r - p)) / 2;
            ++counts_.triangles;
            sink_.triangle({numbers[a], numbers[b], numbers[c]}, {places[a], places[b], places[c]});
        }
    }

    const VolumeInfo& info_;
    const SurfaceLattice& lattice_;
    const CellRanges& ranges_;
    const SurfaceRequest& request_;
    MeshSink& sink_;
    Charge scratch_;
    PointNumbers numbers_;
    BrickCache cache_;
    LatticeValues values_;
    bool mirrored_;
    glm::dvec3 originMm_{0};
    std::array<std::vector<int>, 3> blocks_, tiles_;
    std::vector<double> field_;       // of a tile, [z][y][x]
    std::vector<std::uint8_t> sides_; // 1: inside
    std::array<double, 8> cell_{};    // of a cell's corners
    SurfaceCounts counts_;
};

} // namespace

std::size_t surfaceFloorBytes(const VolumeInfo& info, const SurfaceLattice& lattice, int threads) {
    const glm::ivec3 block = blockPlanes(lattice, kChunkExtent);
    return tileBytes(block) + PointNumbers::bytes(lattice.extent(), block) +
           BrickCache::floorBytes(info, threads);
}

SurfaceCounts extractSurface(const ChunkSource& source, const SurfaceLattice& lattice,
                             const CellRanges& ranges, const SurfaceRequest& request, MemoryBudget& ram,
                             MeshSink& sink, const ShareDone& progress) {
    TESSERA_CHECK(ranges.low.size() == cellCount(ranges.cells) && ranges.high.size() == ranges.low.size());
    return Extraction(source, lattice, ranges, request, ram, sink).run(progress);
}

} // namespace tessera
