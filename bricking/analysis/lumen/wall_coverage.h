// bricking/analysis/lumen/wall_coverage.h: the share of a lumen's wall that the cameras of a flight see, and
// the unseen patches. A window calls it on a thread of its own, with a Progress that it polls and a
// Cancellation.
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
    std::vector<CentreLine> lines; ///< all known lines: wall that is nearest to the route belongs to it
    Flight flight;                 ///< the route, and the part of it that counts
    Lumen lumen;                   ///< of the lines
    std::vector<Camera> cameras;   ///< in perspective; flightCameras() makes them
    double aspect = 4.0 / 3;       ///< of the pictures, width / height
    double farthestMm =
        std::numeric_limits<double>::infinity(); ///< from the eye; wall further away is not seen
    double smallestPatchMm2 = 25;                ///< smaller patches are not listed
    std::string where = "the path";              ///< in messages
};

/// The flight's cameras, evenly spaced, at most everyMm apart, both ends included; with the view directions
/// of keyframes.
/// @param bothWays  there and back; else in the flight's direction
std::vector<Camera> flightCameras(const Path& path, double everyMm, bool bothWays);

/// The wall is the set of faces between voxels of the lumen and others, level 0; the volume's border is no
/// wall. A face's area is its projection along the wall's normal, from the voxels within 2.5 of it. So an
/// oblique wall has its own area, not that of its steps. A face counts if its nearest point on all lines is
/// on the flown part of the route, beside it and not beyond its ends. It lies no further away than 1.5 times
/// the largest radius and a voxel's diagonal. A camera sees a face if it is on the face's front side, and the
/// face's centre is in its picture and not hidden. The line from the eye to a point half a voxel above that
/// centre must cross only voxels of the lumen. The same for any number of threads. Throws InputError naming
/// request.where for lines outside this volume or its lumen, and naming the budget's option if the lumen's
/// bits and faces do not fit. Throws Cancelled, Interrupted, and as reading chunks does.
WallCoverage measureWallCoverage(const ChunkSource& source, const CoverageRequest& request, MemoryBudget& ram,
                                 Progress& progress, int threads = 0);

} // namespace tessera
