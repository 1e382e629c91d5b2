// bricking/analysis/surface/surface_mesh.h: the surface of one value of a volume as a stream of points and
// triangles, whatever its size.
//
// Cells of the lattice (surface_lattice.h) are visited chunk by chunk; tiles of 8^3 whose range leaves the
// value out are not looked at. Points lie on edges of the lattice, each once: numbers of those on the faces
// of chunks are kept until the chunks behind them have been visited. So the surface is closed, every edge has
// two triangles, and memory depends on the volume's extent alone.
#pragma once

#include "bricking/analysis/surface/surface_lattice.h"
#include "bricking/cache/chunk_source.h"
#include "core/base/budget.h"
#include "core/base/progress.h" // ShareDone

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// Takes a mesh, in the order in which it is found.
class MeshSink {
  public:
    virtual ~MeshSink() = default;
    /// The next point, mm in patient space. Points are numbered from 0.
    virtual void point(const glm::dvec3& mm) = 0;
    /// Points come before their triangles. Seen from outside a triangle turns to the left in LPS.
    /// @param places  of the numbers
    virtual void triangle(const std::array<std::uint32_t, 3>& numbers,
                          const std::array<glm::dvec3, 3>& places) = 0;
};

/// Ranges of the values of cells of kCellExtent^3 voxels, as stored: of all levels that are means.
struct CellRanges {
    glm::ivec3 cells{0};              // cellGrid(extent)
    std::span<const float> low, high; // [z][y][x] over cells
    int layer = 0;                    // voxels around a cell that its range counts as well, 0 or 1
};

struct SurfaceRequest {
    double value = 0;                      // physical units
    std::uint64_t mostPoints = 0xFFFFFFFE; // numbers of points have 32 bits, and the last is no number
    int threads = 0;                       // that decode chunks; 0: all processors
    // Extents of what is visited at once, in samples; others for tests of seams.
    int tileExtent = kCellExtent, blockExtent = kChunkExtent;
};

struct SurfaceCounts {
    std::uint64_t points = 0, triangles = 0;
    std::uint64_t cells = 0, cellsSeen = 0; // of the lattice; of tiles that were looked at
    std::uint64_t chunksDecoded = 0;
    glm::dvec3 lowMm{0}, highMm{0}; // the box of the points
    double volumeMm3 = 0;           // enclosed; cavities do not count
    double areaMm2 = 0;
};

/// Memory that it takes, at least.
std::size_t surfaceFloorBytes(const VolumeInfo& info, const SurfaceLattice& lattice, int threads);

/// Inside is where the value is not below the request's. Normals point to the other side.
/// @param source  of the lattice's volume
/// @param ram     charged for all that is kept; the cache of chunks takes at most half of what is free
/// Throws InputError for too little memory, more points than numbers, and chunks that cannot be read.
SurfaceCounts extractSurface(const ChunkSource& source, const SurfaceLattice& lattice,
                             const CellRanges& ranges, const SurfaceRequest& request, MemoryBudget& ram,
                             MeshSink& sink, const ShareDone& progress = {});

} // namespace tessera
