// bricking/statistics/statistics.h: statistics of a volume, so that selection and skipping need no voxels.
// They are a cache in the store, made at import and rebuilt if missing. A cell has min/max with a ghost layer
// of one voxel; a brick has its mean, and min/max with two voxels around. The volume has a histogram. Every
// brick has sampled rays, read only for visible bricks (brick_rays.h).
#pragma once

#include "bricking/mask/masked_source.h"
#include "bricking/store/store_reader.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/progress.h" // ShareDone

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tessera {

constexpr int kHistogramBins = 64; // equal bins over [lowest, highest] of the whole volume

/// Bin of a value: floor((value - lowest) * 64 / (highest - lowest)) in double, at most 63; 0 where
/// all are equal.
int histogramBin(double value, double lowest, double highest);

/// What can show of a cell or a brick, whatever its values: the transfer function; something else too, such
/// as the medium of labels.
enum ShownPart : std::uint8_t { kShowsFunction = 1, kShowsMedium = 2 };

/// Fill values: extremes that stand alone, as those of voxels without a measurement do (fill_values.h).
struct FillValues {
    struct Value {
        float value = 0;
        std::uint64_t voxels = 0;
    };
    std::vector<Value> values; // empty: none
    /// Of all other values, where there are some; the histogram has kHistogramBins.
    float lowest = 0, highest = 0;
    std::vector<std::uint64_t> histogram;
};

/// All values as stored (physical = slope * stored + intercept).
struct Statistics {
    glm::ivec3 cells{0};                   // cellGrid(extent)
    std::vector<float> cellMin, cellMax;   // [z][y][x] over cells, ghost layer of one voxel included
    glm::ivec3 bricks{0};                  // brickGrid(extent)
    std::vector<float> brickMean;          // [z][y][x] over bricks: the sample of level kLevelCount-1
    std::vector<float> brickMin, brickMax; // [z][y][x] over bricks, one layer around included
    std::vector<float> wideMin, wideMax;   // the same with two layers around
    float lowest = 0, highest = 0;         // over the whole volume, level 0
    std::vector<std::uint64_t> histogram;  // kHistogramBins, whole volume, level 0
    FillValues fills;                      // of the whole volume, level 0
    /// Parts that can show, where labels decide: of a cell and those that touch it; of bricks with their
    /// layers, 1 and 2. Empty: the function everywhere.
    std::vector<std::uint8_t> cellShows, brickShows, wideShows;
    /// What labels make of each brick's content, for predicted errors.
    struct LabelledBrick {
        float function = 1; // mean share of the transfer function
        float medium = 0;   // mean share of a medium of their own
        float borders = 0;  // share of cells in which something changes
    };
    std::vector<LabelledBrick> labelledBricks;
    Charge charge; // the charge of the vectors above, but for those of labels

    /// No labels decide any more.
    void showFunction() {
        cellShows.clear(), brickShows.clear(), wideShows.clear();
        labelledBricks.clear();
    }
    bool hasLabels() const { return !cellShows.empty(); }
    std::uint8_t showsOfCell(std::size_t cell) const {
        return cellShows.empty() ? std::uint8_t{kShowsFunction} : cellShows[cell];
    }
    /// @param layers  1 or 2
    std::uint8_t showsOfBrick(std::size_t brick, int layers) const {
        const std::vector<std::uint8_t>& shows = layers == 1 ? brickShows : wideShows;
        return shows.empty() ? std::uint8_t{kShowsFunction} : shows[brick];
    }

    /// Range of a brick's voxels and of the layers around it.
    /// @param layers  1 or 2
    void brickRange(const BrickId& brick, int layers, float& lo, float& hi) const;
};

/// Memory for computing the statistics of such a volume, including its reader: held, for pictures.
std::size_t statisticsFloorBytes(const VolumeInfo& info, int threads);
/// For buildStatistics(), which holds few of them where memory is scarce: independent of the slices.
std::size_t buildStatisticsFloorBytes(const VolumeInfo& info, int threads);

/// Computes everything from the chunks (one pass over the store), writing the arrays under STORE/stats.
/// Rays go to disk only. Ranges of cells do, by bands of bricks, where ram has no room for all: then in a
/// file beside the arrays. The arrays do not depend on that.
/// @param progress  gets the share that is done
void buildStatistics(const StoreReader& store, const std::filesystem::path& folder, MemoryBudget& ram,
                     int threads, const ShareDone& progress = {});

/// Loads statistics without rays. Missing or inconsistent ones, or those of another version, are rebuilt in
/// memory (not written).
Statistics loadStatistics(const StoreReader& store, MemoryBudget& ram, int threads);

/// Makes statistics of a volume those of its visible part: ranges of cells and bricks, and means. What is
/// hidden in part keeps its range, which air joins; two layers around a brick count by cells. The range and
/// the histogram of the whole volume stay, so that presets do. Throws InputError where ram has no room or
/// voxels cannot be read; nothing has changed then.
void hideMasked(Statistics& statistics, const MaskedSource& masked, MemoryBudget& ram, int threads);

} // namespace tessera
