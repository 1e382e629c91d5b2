// bricking/analysis/lumen/wall_coverage.h: the share of a lumen's wall that the cameras of a flight have
// seen, and the patches that they have not. A window calls it on a thread of its own, with a Progress that it
// polls and a Cancellation to call it off.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/animation/path.h"
#include "core/base/budget.h"
#include "core/base/coverage.h"
#include "core/base/progress.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <string>
#include <vector>

namespace tessera {

struct CoverageRequest {
    std::vector<CentreLine> lines; ///< all that are known: wall that is nearest to the route is the route's
    Flight flight;                 ///< route and its part that counts, from place to place
    Lumen lumen;                   ///< as the lines were made with it
    std::vector<Camera> cameras;   ///< in perspective; flightCameras() makes them
    double aspect = 4.0 / 3;       ///< of the pictures, width / height
    double farthestMm = std::numeric_limits<double>::infinity(); ///< wall further from the eye is not seen
    double smallestPatchMm2 = 25;                                ///< smaller ones are not listed
    std::string where = "the path";                              ///< in messages
};

/// The flight's cameras, evenly, no more than everyMm apart, both ends included; what keyframes say of where
/// one looks is kept.
/// @param bothWays  there and back, else as the flight says
std::vector<Camera> flightCameras(const Path& path, double everyMm, bool bothWays);

/// The wall is the faces between voxels of the lumen and others, level 0; where the volume ends is no wall. A
/// face's area is its projection along the wall's normal, from the voxels within 2.5 of it. So a slanting
/// wall has its area and not that of its steps. A face counts if its nearest place on all lines is on the
/// part of the route that is flown, beside it and not beyond its ends. It lies no further away than 1.5 times
/// the largest radius and a voxel's diagonal. A camera sees it that has the face's middle in its picture and
/// lies on the side that it faces. Nothing but voxels of the lumen may lie between the eye and a place half a
/// voxel above the middle. The same for any number of threads. Throws InputError naming request.where for
/// lines outside this volume or its lumen; naming the budget's option where the lumen's bits and faces do not
/// fit. Cancelled, Interrupted, and what reading throws.
WallCoverage measureWallCoverage(const ChunkSource& source, const CoverageRequest& request, MemoryBudget& ram,
                                 Progress& progress, int threads = 0);

} // namespace tessera
