// bricking/analysis/lumen/centre_path.h: a smooth line in the middle of a lumen, from a chain of voxels. It
// is evenly spaced and stays inside at full resolution.
#pragma once

#include "bricking/analysis/lumen/lumen_shape.h"

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// A piece of the path: consecutive points, patient space, mm.
struct ChainPiece {
    std::vector<glm::dvec3>
        mm;              ///< each connected to the next by a line in the lumen; on a bridge by any line
    bool bridge = false; ///< crosses tissue outside the lumen
};

struct CentredLine {
    std::vector<glm::dvec3> mm;   ///< evenly spaced
    std::vector<double> radiusMm; ///< distance to the wall; 0 on bridges
    double spacingMm = 0;         ///< between points, along the line
    double leastTurnMm = 0;       ///< radius of the tightest turn
};

struct CentringRules {
    double spacingMm = 1;   ///< of the result, at most
    bool holdFirst = false; ///< the first point stays where it is (a fork)
};

/// Cross-sections of the line are measured by rays. Each point moves to the centre of its cross-section. The
/// line of these centres is smoothed over about the lumen's radius, which is more than folds, pouches and
/// branches, without displacing bends. Turns have at least half the lumen's radius wherever the lumen allows
/// it. Where a smooth line would leave the lumen it is smoothed less, down to the chain itself. Throws
/// Cancelled, Interrupted, and as reading chunks does.
CentredLine centrePath(const LumenShape& shape, const std::vector<ChainPiece>& pieces, LumenValues& values,
                       const LumenRule& rule, const CentringRules& rules);

} // namespace tessera
