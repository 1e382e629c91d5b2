// bricking/analysis/lumen/centreline.h: centre-lines from seeds in a hollow organ, for a volume of any size:
// threshold, lumen, path, centring (docs/centrelines.md). A window calls it on a thread of its own, with a
// Progress that it polls and a Cancellation.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/animation/path.h"
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// A point that the user gave.
struct CentrelineSeed {
    glm::dvec3 mm{0};       ///< patient space
    std::string name;       ///< in messages: "--from", "the first click"
    bool mayBridge = false; ///< a gap in the lumen beside this seed is bridged; the seed may lie in the gap
};

struct CentrelineRequest {
    /// In order along the line: its beginning, points between, its end. With one seed the end is the furthest
    /// point of the lumen.
    std::vector<CentrelineSeed> seeds;
    std::optional<double> threshold; ///< physical units; none: from the values around the seeds
    bool mayLeak = false;            ///< the threshold is kept even if the lumen leaks
    bool tree = false;               ///< all branches beyond the first seed, which is the only one
    int mostGenerations = 12;        ///< of a tree: most forks between the seed and a branch
    double spacingMm = 1;            ///< of the points, at most
};

struct CentrelineBridge {
    glm::dvec3 fromMm{0}, toMm{0};
};

/// The evidence for and against the lumen.
struct LumenEvidence {
    double lumen = 0, wall = 0;    ///< values around the first seed, physical units; with
                                   ///< a given threshold the wall's is as far beyond it
    double noise = 0;              ///< of the volume's values there, standard deviation
    double noiseLeft = 0;          ///< of the denoised values; the same if they were not denoised
    bool given = false;            ///< the threshold was given by the user
    std::optional<double> leaksAt; ///< the given or chosen threshold at which the lumen leaks
    bool leaks = false;            ///< that threshold was kept: a tighter one separates the seeds
    /// True if a threshold is well above the noise in the lumen.
    bool clear(double threshold) const;
};

struct Centrelines {
    std::vector<CentreLine> lines; ///< one line; of a tree one per branch, each after its parent
    std::vector<int> generations;  ///< of each line: forks between the seed and it
    Lumen lumen;                   ///< the values that count as lumen
    LumenEvidence evidence;
    std::vector<CentrelineBridge> bridges;
    double leastTurnMm = 0;        ///< radius of the tightest turn
    std::uint64_t lumenVoxels = 0; ///< of level 0
    int blockVoxels = 0;           ///< edge of the blocks of the path search
};

/// The threshold of the lumen, its basis and its reliability: one line for people.
/// @param unit  of the values
std::string lumenText(const Centrelines& found, const std::string& unit);

/// Throws InputError naming a seed that is outside the volume or the lumen, or has no wall around it. Throws
/// it naming the gap if an end cannot be reached: where the two parts come nearest, and how near. Throws it
/// naming ram's option if the lumen does not fit. Throws Cancelled, Interrupted, and as reading chunks does.
/// @param threads  that decode and measure; 0: all processors
Centrelines findCentrelines(const ChunkSource& source, const CentrelineRequest& request, MemoryBudget& ram,
                            Progress& progress, int threads = 0);

} // namespace tessera
