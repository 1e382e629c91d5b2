// bricking/analysis/lumen/centreline.h: centre-lines from seeds in a hollow organ, for a volume of any size,
// in one step: threshold, lumen, path, middle (docs/centrelines.md). A window calls it on a thread of its
// own, with a Progress that it polls and a Cancellation to call it off.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/animation/path_text.h"
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// A place that somebody pointed at.
struct CentrelineSeed {
    glm::dvec3 mm{0};       ///< patient space
    std::string name;       ///< in messages: "--from", "the first click"
    bool mayBridge = false; ///< a gap in the lumen beside this seed is bridged; it may lie in the gap itself
};

struct CentrelineRequest {
    /// In their order along the line: its beginning, places on the way, its end. One: its beginning, and the
    /// end is the place of the lumen that is furthest from it.
    std::vector<CentrelineSeed> seeds;
    std::optional<double> threshold; ///< physical units; none: from what lies around the seeds
    bool mayLeak = false;            ///< the threshold is kept where the lumen leaks at it
    bool tree = false;               ///< all branches beyond the first seed, which is the only one
    int mostGenerations = 12;        ///< of a tree: forks between the seed and a branch, at most
    double spacingMm = 1;            ///< of the points, at most
};

struct CentrelineBridge {
    glm::dvec3 fromMm{0}, toMm{0};
};

/// What speaks for and against what was taken to be lumen.
struct LumenEvidence {
    double lumen = 0, wall = 0;    ///< values around the first seed, physical units; the wall's is half way's
                                   ///< other side where the threshold was given
    double noise = 0;              ///< of the volume's values there, standard deviation
    double noiseLeft = 0;          ///< of the values that were decided on; the same where none was taken off
    bool given = false;            ///< the threshold, by who asked
    std::optional<double> leaksAt; ///< the threshold that was given or chosen, where the lumen leaks at it
    bool leaks = false;            ///< and was taken all the same: a tighter one parts the seeds
    /// Whether a threshold stands out of the noise of what is in the lumen.
    bool clear(double threshold) const;
};

struct Centrelines {
    std::vector<CentreLine> lines; ///< one; of a tree one a branch, each after its parent
    std::vector<int> generations;  ///< of each line: forks between the seed and it
    Lumen lumen;                   ///< what was taken to be lumen
    LumenEvidence evidence;
    std::vector<CentrelineBridge> bridges;
    double leastTurnMm = 0;        ///< radius of the tightest turn
    std::uint64_t lumenVoxels = 0; ///< of level 0
    int blockVoxels = 0;           ///< edge of the blocks that the path was searched in
};

/// What was taken to be lumen, why, and how sure that is: one line for people.
/// @param unit  of the values
std::string lumenText(const Centrelines& found, const std::string& unit);

/// Throws InputError naming a seed that is outside the volume or the lumen or has no wall around it; naming
/// the gap where an end cannot be reached (where the two parts come nearest, and how near). Throws it naming
/// ram's option where the lumen does not fit. Cancelled, Interrupted, and what reading throws.
/// @param threads  that decode and measure; 0: all processors
Centrelines findCentrelines(const ChunkSource& source, const CentrelineRequest& request, MemoryBudget& ram,
                            Progress& progress, int threads = 0);

} // namespace tessera
