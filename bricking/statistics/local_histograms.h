// bricking/statistics/local_histograms.h: which values lie around every sample of a level (course notes 6.2):
// a histogram of the samples of a ball, each weighted by 1/d^2, d its distance in mm. The side towards rising
// values and the other one have a histogram each. They do not depend on a transfer function, so that light
// which follows from them is a table.
//
// Every sample has the number of one of some thousand representatives, found by vector quantisation.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/base/budget.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

namespace tessera {

struct LocalHistogramSettings {
    static constexpr int kMostBins = 64, kMostRepresentatives = 65536;
    double radiusMm = 16;       // of the ball, above 0
    int bins = kMostBins;       // at most; in [2,kMostBins]
    int representatives = 2048; // at most
    bool operator==(const LocalHistogramSettings&) const = default;
};

/// Side of a sample: towards rising values, and the other one.
enum class LocalSide : std::uint8_t { rising, falling };

/// Histograms of the samples of one level. Values are as stored. A value counts for the bins with the centres
/// below and above it, the more the nearer (tents); beyond the outermost centres for these.
struct LocalHistograms {
    static constexpr std::size_t kRow = 2 * std::size_t{LocalHistogramSettings::kMostBins};
    static constexpr std::uint16_t kWhole = 65535; // shares of a side sum to about this

    LocalHistogramSettings settings;
    int level = 0;
    glm::ivec3 extent{0};               // samples of the level
    std::vector<double> centres;        // of bins, ascending; one where all values are equal
    std::vector<std::uint16_t> numbers; // [z][y][x] of extent: the representative of a sample
    std::vector<std::uint16_t> shares;  // [representative][side][bin], kRow each
    Charge charge;                      // of the vectors

    std::size_t representatives() const { return shares.size() / kRow; }
    /// Shares of a representative's side; kMostBins, of which those of the centres count.
    const std::uint16_t* of(std::size_t number, LocalSide side) const {
        return shares.data() + number * kRow + static_cast<std::size_t>(side) * (kRow / 2);
    }
    std::size_t bytes() const;
};

/// The level whose samples have histograms: the finest one above 0 on which the radius is at most 8 samples;
/// kLevelCount: none.
int localHistogramLevel(const VolumeInfo& info, double radiusMm);
/// Memory of histograms, and of making them besides.
std::size_t localHistogramBytes(const VolumeInfo& info, const LocalHistogramSettings& settings);

/// Samples around a sample that count, without itself: those within the radius, and the six beside it.
struct LocalBall {
    struct Neighbour {
        glm::ivec3 offset;    // samples
        std::uint32_t weight; // proportional to 1/d^2
    };
    std::vector<Neighbour> half; // the others are their mirror images
    glm::ivec3 reach{0};         // samples to either side
};
LocalBall localBall(const VolumeInfo& info, int level, double radiusMm);

/// Centres of bins: half of them at equal counts of the level's values above the lowest tenth, half at equal
/// distances over all but the outermost 1/2000 at either end; the range's ends besides.
std::vector<double> localBinCentres(const ChunkSource& volume, const Statistics& statistics, int level,
                                    int bins);

/// Makes the histograms of a volume with a level of them (checked), chunk by chunk.
/// @param statistics  of the volume as it is drawn
/// Throws InputError if ram cannot hold them, or what making them takes.
LocalHistograms makeLocalHistograms(const ChunkSource& volume, const Statistics& statistics,
                                    const LocalHistogramSettings& settings, MemoryBudget& ram, int threads);

/// Those of a store: what is kept in it, else made now, and kept where the store can be written. Missing,
/// damaged or foreign files, or those of other settings, count as none.
/// @param volume  what is drawn of the store: itself, or that without a hidden part
/// @param hidden  tells hidden parts apart; 0: nothing is hidden
/// Throws as makeLocalHistograms().
std::shared_ptr<const LocalHistograms> localHistogramsOf(const StoreReader& store, const ChunkSource& volume,
                                                         std::uint32_t hidden, const Statistics& statistics,
                                                         const LocalHistogramSettings& settings,
                                                         MemoryBudget& ram, int threads);

} // namespace tessera
