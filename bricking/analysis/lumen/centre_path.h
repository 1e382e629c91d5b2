// bricking/analysis/lumen/centre_path.h: a smooth line in the middle of a lumen, from a chain of voxels. It
// is evenly spaced and stays inside at full resolution.
#pragma once

#include "bricking/analysis/lumen/lumen_shape.h"

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// A piece of the way: places that follow one another, patient space mm.
struct ChainPiece {
    std::vector<glm::dvec3> mm; ///< each joined to the next by a line in the lumen; at a bridge any line
    bool bridge = false;        ///< through what is not lumen
};

struct CentredLine {
    std::vector<glm::dvec3> mm;   ///< evenly along the line
    std::vector<double> radiusMm; ///< distance to the wall; 0 on bridges
    double spacingMm = 0;         ///< along the line, from a point to the next
    double leastTurnMm = 0;       ///< radius of the tightest turn
};

struct CentringRules {
    double spacingMm = 1;   ///< of the result, at most
    bool holdFirst = false; ///< the first point stays where it is (a fork)
};

/// Sections at right angles to the line are measured by rays. Each point moves to the middle of its section,
/// and the line of these middles is smoothed over about the lumen's radius, without pulling it out of its
/// bends. Folds, pouches and branches reach less far than that. Turns have half the lumen's radius and more
/// wherever the lumen lets them. Where a smooth line would leave the lumen it is smoothed less, down to the
/// chain itself. Throws Cancelled and Interrupted, and what reading throws.
CentredLine centrePath(const LumenShape& shape, const std::vector<ChainPiece>& pieces, LumenValues& values,
                       const LumenRule& rule, const CentringRules& rules);

} // namespace tessera
