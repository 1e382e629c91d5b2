// core/base/coverage.h: the coverage of a hollow organ's wall by the cameras of a flight, and the unseen
// patches. bricking/analysis/lumen/wall_coverage.h measures it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

/// A patch of unseen wall, connected over edges of voxel faces.
struct UnseenPatch {
    glm::dvec3 middleMm{0}; ///< its point on the wall that is nearest to its centre of area, patient space
    double areaMm2 = 0;
    double alongMm = 0;          ///< mean along the route, by area, from the route's first point
    double fromMm = 0, toMm = 0; ///< the part of the route beside it
};

struct WallCoverage {
    double wallMm2 = 0, seenMm2 = 0;
    std::uint64_t faces = 0;          ///< of voxels, that the wall is made of
    std::size_t lines = 1, flown = 1; ///< of the path, and of the flight
    std::uint64_t blind = 0;          ///< cameras outside the lumen: on bridges
    std::vector<UnseenPatch> patches; ///< largest first
    double share() const { return wallMm2 > 0 ? seenMm2 / wallMm2 : 0; }
};

/// One sentence; it says if not all lines were flown.
/// @param smallestMm2  below which patches are not listed
std::string coverageText(const WallCoverage& coverage, double smallestMm2);

} // namespace tessera
