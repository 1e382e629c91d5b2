// bricking/statistics/local_histograms.cpp: see local_histograms.h. Sums are whole numbers, so the results
// depend neither on the number of threads nor on the order of chunks.
#include "bricking/statistics/local_histograms.h"

#include "bricking/statistics/histogram_counts.h"
#include "bricking/statistics/vector_quantiser.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace tessera {
namespace {

using namespace local_histograms;

using ByteVector = VectorQuantiser::Vector;

constexpr double kMostRadius = 8;                // samples
constexpr double kWeightOne = 16384;             // of the nearest neighbours
constexpr std::size_t kLearnt = 100000;          // vectors that representatives are learnt from, at most
constexpr std::size_t kFine = 65536;             // parts of the range that values are counted in
constexpr double kLeftOut = 0.1, kTail = 0.0005; // of the values

static_assert(LocalHistograms::kRow == VectorQuantiser::kLength);

glm::dmat3 mmPerSample(const VolumeInfo& info, int level) {
    return glm::dmat3(info.patientFromVoxel) * std::ldexp(1.0, level);
}

std::size_t workerCount(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}

/// Calls visit(value) for every sample of a level, chunk by chunk.
template <typename Visit> void forEachValue(const ChunkSource& volume, int level, const Visit& visit) {
    const glm::ivec3 extent = levelExtent(volume.info().extentVoxels, level),
                     grid = chunkGrid(volume.info().extentVoxels, level);
    std::vector<std::byte> chunk(volume.chunkBytes());
    for (std::size_t c = 0; c < cellCount(grid); ++c) {
        const glm::ivec3 at = gridPosition(c, grid),
                         count = glm::min(extent - at * kChunkExtent, glm::ivec3(kChunkExtent));
        volume.readChunk({level, at.x, at.y, at.z}, chunk);
        withValueType(volume.info().type, [&](auto typed) {
            using Stored = decltype(typed);
            for (int z = 0; z < count.z; ++z)
                for (int y = 0; y < count.y; ++y)
                    for (int x = 0; x < count.x; ++x) {
                        Stored value;
                        std::memcpy(&value,
                                    chunk.data() +
                                        linearIndex({x, y, z}, glm::ivec3(kChunkExtent)) * sizeof value,
                                    sizeof value);
                        visit(static_cast<double>(value));
                    }
        });
    }
}

/// Cumulative sums of both sides: the distance of two is that of moving one histogram onto the other.
ByteVector cumulative(const Shares& shares) {
    ByteVector vector{};
    for (std::size_t side = 0; side < 2; ++side) {
        std::uint32_t sum = 0;
        for (std::size_t b = side * kBins; b < (side + 1) * kBins; ++b) {
            sum += shares[b];
            vector[b] = static_cast<std::uint8_t>(std::min<std::uint32_t>(255, (sum + 128) / 257));
        }
    }
    return vector;
}

/// An even mixture of bits.
std::uint64_t mixture(std::uint64_t n) {
    n = (n ^ (n >> 30)) * 0xBF58476D1CE4E5B9u;
    n = (n ^ (n >> 27)) * 0x94D049BB133111EBu;
    return n ^ (n >> 31);
}

/// The samples that representatives are learnt from: evenly drawn from bricks that are not constant.
class Learnt {
  public:
    Learnt(const Statistics& statistics, const glm::ivec3& extent, int level)
        : statistics_(statistics), extent_(extent), shift_(5 - level) {
        std::size_t varied = 0;
        for (std::size_t b = 0; b < cellCount(statistics.bricks); ++b) {
            const glm::ivec3 first = gridPosition(b, statistics.bricks) << shift_;
            if (varies(b))
                varied += cellCount(glm::min(glm::ivec3(1 << shift_), extent - first));
        }
        oneOf_ = std::max<std::size_t>(1, (varied + kLearnt - 1) / kLearnt);
    }
    bool has(const glm::ivec3& sample) const {
        return varies(linearIndex(sample >> shift_, statistics_.bricks)) &&
               mixture(linearIndex(sample, extent_)) % oneOf_ == 0;
    }

  private:
    bool varies(std::size_t brick) const { return statistics_.brickMin[brick] < statistics_.brickMax[brick]; }

    const Statistics& statistics_;
    glm::ivec3 extent_;
    int shift_;
    std::size_t oneOf_ = 1;
};

/// Calls body(sample) for the samples of a chunk, relative to it.
template <typename Body>
void forEachSample(const glm::ivec3& chunk, const glm::ivec3& extent, const Body& body) {
    const glm::ivec3 count = glm::min(extent - chunk * kChunkExtent, glm::ivec3(kChunkExtent));
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                body(glm::ivec3(x, y, z));
}

} // namespace

std::size_t LocalHistograms::bytes() const {
    return (numbers.size() + shares.size()) * sizeof(std::uint16_t) + centres.size() * sizeof(double);
}

int localHistogramLevel(const VolumeInfo& info, double radiusMm) {
    for (int level = 1; level < kLevelCount; ++level) {
        const glm::dmat3 mm = mmPerSample(info, level);
        const double pitch = std::min({glm::length(mm[0]), glm::length(mm[1]), glm::length(mm[2])});
        if (radiusMm <= kMostRadius * pitch)
            return level;
    }
    return kLevelCount;
}

std::size_t localHistogramBytes(const VolumeInfo& info, const LocalHistogramSettings& settings) {
    const int level = localHistogramLevel(info, settings.radiusMm);
    if (level >= kLevelCount)
        return 0;
    return cellCount(levelExtent(info.extentVoxels, level)) * sizeof(std::uint16_t) +
           static_cast<std::size_t>(settings.representatives) * LocalHistograms::kRow *
               sizeof(std::uint16_t) +
           kBins * sizeof(double);
}

LocalBall localBall(const VolumeInfo& info, int level, double radiusMm) {
    const glm::dmat3 mm = mmPerSample(info, level), samples = glm::inverse(mm);
    LocalBall ball;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 row(samples[0][axis], samples[1][axis], samples[2][axis]);
        ball.reach[axis] = std::max(1, static_cast<int>(std::floor(radiusMm * glm::length(row) + 1e-9)));
    }
    std::vector<std::pair<glm::ivec3, double>> near;
    double least = std::numeric_limits<double>::max();
    for (int z = 0; z <= ball.reach.z; ++z)
        for (int y = -ball.reach.y; y <= ball.reach.y; ++y)
            for (int x = -ball.reach.x; x <= ball.reach.x; ++x) {
                if (z == 0 && (y < 0 || (y == 0 && x <= 0)))
                    continue; // a mirror image, or the sample itself
                const glm::ivec3 offset(x, y, z);
                const double d = glm::length(mm * glm::dvec3(offset));
                const bool isBeside = std::abs(x) + std::abs(y) + z == 1;
                if (!isBeside && d > radiusMm * (1 + 1e-9))
                    continue;
                near.emplace_back(offset, d);
                least = std::min(least, d);
            }
    for (const auto& [offset, d] : near)
        ball.half.push_back({offset, static_cast<std::uint32_t>(
                                         std::max(1L, std::lround(kWeightOne * (least / d) * (least / d))))});
    return ball;
}

std::vector<double> localBinCentres(const ChunkSource& volume, const Statistics& statistics, int level,
                                    int bins) {
    const double lowest = statistics.lowest, highest = statistics.highest;
    if (!(highest > lowest))
        return {lowest};
    std::vector<std::uint64_t> counts(kFine);
    const double scale = static_cast<double>(kFine - 1) / (highest - lowest);
    std::uint64_t all = 0;
    forEachValue(volume, level, [&](double value) {
        const double place = (value - lowest) * scale;
        ++counts[place > 0 ? std::min(kFine - 1, static_cast<std::size_t>(place)) : 0];
        ++all;
    });
    const auto below = [&](double share) { // the part at which so many values are below
        std::uint64_t sum = 0;
        std::size_t part = 0;
        while (part + 1 < kFine &&
               static_cast<double>(sum + counts[part]) <= share * static_cast<double>(all))
            sum += counts[part++];
        return part;
    };
    const std::size_t low = below(kTail), high = std::max(low + 1, below(1 - kTail)),
                      counted = below(kLeftOut);
    std::uint64_t most = 0;
    for (std::size_t part = counted; part < kFine; ++part)
        most += counts[part];
    std::vector<double> centres{lowest};
    double sum = 0; // of both halves, up to 1
    int next = 1;
    for (std::size_t part = 0; part < kFine; ++part) {
        if (part >= counted)
            sum += 0.5 * static_cast<double>(counts[part]) / static_cast<double>(most);
        if (part >= low && part < high)
            sum += 0.5 / static_cast<double>(high - low);
        bool passes = false;
        for (; next < bins - 1 && sum >= static_cast<double>(next) / (bins - 1); ++next)
            passes = true;
        const double value = lowest + static_cast<double>(part) / scale;
        if (passes && value > centres.back() && value < highest)
            centres.push_back(value);
    }
    centres.push_back(highest);
    return centres;
}

LocalHistograms makeLocalHistograms(const ChunkSource& volume, const Statistics& statistics,
                                    const LocalHistogramSettings& settings, MemoryBudget& ram, int threads) {
    const VolumeInfo& info = volume.info();
    LocalHistograms made;
    made.settings = settings;
    made.level = localHistogramLevel(info, settings.radiusMm);
    TESSERA_CHECK(made.level < kLevelCount && settings.bins >= 2 && settings.bins <= kBins &&
                  settings.representatives >= 1 &&
                  settings.representatives <= LocalHistogramSettings::kMostRepresentatives);
    made.extent = levelExtent(info.extentVoxels, made.level);
    const std::string_view what = "local histograms";
    made.charge = ram.charge(localHistogramBytes(info, settings), what);
    std::optional<Charge> scratch = ram.charge(kFine * sizeof(std::uint64_t) + volume.chunkBytes(),
                                               "counting values for local histograms");
    made.centres = localBinCentres(volume, statistics, made.level, settings.bins);
    scratch.reset();

    const LocalBall ball = localBall(info, made.level, settings.radiusMm);
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, made.level);
    const std::size_t chunks = cellCount(grid), most = static_cast<std::size_t>(settings.representatives);
    // Vectors to learn from, in the order of chunks and of samples in them.
    const Learnt learnt(statistics, made.extent, made.level);
    std::vector<std::size_t> firstOf(chunks + 1);
    for (std::size_t c = 0; c < chunks; ++c) {
        const glm::ivec3 chunk = gridPosition(c, grid);
        firstOf[c + 1] = firstOf[c];
        forEachSample(chunk, made.extent, [&](const glm::ivec3& sample) {
            firstOf[c + 1] += learnt.has(chunk * kChunkExtent + sample) ? 1 : 0;
        });
    }
    const std::size_t count = std::max<std::size_t>(1, firstOf.back());
    const Charge learning = ram.charge(count * sizeof(ByteVector) + VectorQuantiser::bytes(count, most) +
                                           chunks * sizeof(std::size_t) + BinPlaces::bytes(),
                                       "learning local histograms");
    const BinPlaces places(made.centres, info.type);
    // A thread has a room and sums of its own.
    struct Worker {
        ChunkRoom room;
        std::vector<std::uint64_t> sums, counts;
    };
    const std::size_t each =
        ChunkRoom::bytes(volume, ball) + most * (LocalHistograms::kRow + 1) * sizeof(std::uint64_t);
    const std::size_t workers = std::clamp(ram.freeBytes() / each, std::size_t{1}, workerCount(threads));
    const Charge working = ram.charge(workers * each, "making local histograms");
    std::mutex mutex;
    std::vector<std::unique_ptr<Worker>> idle, all;
    for (std::size_t n = 0; n < workers; ++n)
        idle.push_back(std::make_unique<Worker>(Worker{ChunkRoom(volume, made.level, ball, places), {}, {}}));
    const auto forEachChunk = [&](const std::function<void(std::size_t, const glm::ivec3&, Worker&)>& body) {
        parallelFor(chunks, static_cast<int>(workers), [&](std::size_t c) {
            std::unique_ptr<Worker> worker;
            {
                const std::lock_guard lock(mutex);
                worker = std::move(idle.back());
                idle.pop_back();
            }
            body(c, gridPosition(c, grid), *worker);
            const std::lock_guard lock(mutex);
            idle.push_back(std::move(worker));
        });
    };

    std::vector<ByteVector> vectors(count);
    forEachChunk([&](std::size_t c, const glm::ivec3& chunk, Worker& worker) {
        if (firstOf[c] == firstOf[c + 1])
            return;
        worker.room.read(chunk);
        ByteVector* next = vectors.data() + firstOf[c];
        Counts counts;
        Shares shares;
        forEachSample(chunk, made.extent, [&](const glm::ivec3& sample) {
            if (!learnt.has(chunk * kChunkExtent + sample))
                return;
            worker.room.count(sample, counts);
            normalise(counts, worker.room.placeAt(sample), shares);
            *next++ = cumulative(shares);
        });
    });
    if (firstOf.back() == 0) { // one value everywhere
        idle.front()->room.read(glm::ivec3(0));
        Counts counts;
        Shares shares;
        idle.front()->room.count(glm::ivec3(0), counts);
        normalise(counts, idle.front()->room.placeAt(glm::ivec3(0)), shares);
        vectors.front() = cumulative(shares);
    }
    const VectorQuantiser quantiser(vectors, most, threads);
    std::vector<ByteVector>().swap(vectors);

    for (const auto& worker : idle) {
        worker->sums.resize(quantiser.size() * LocalHistograms::kRow);
        worker->counts.resize(quantiser.size());
    }
    made.numbers.resize(cellCount(made.extent));
    forEachChunk([&](std::size_t, const glm::ivec3& chunk, Worker& worker) {
        worker.room.read(chunk);
        Counts counts;
        Shares shares;
        ByteVector vector{}, before{};
        std::optional<std::uint16_t> number; // of the vector before
        forEachSample(chunk, made.extent, [&](const glm::ivec3& sample) {
            worker.room.count(sample, counts);
            normalise(counts, worker.room.placeAt(sample), shares);
            vector = cumulative(shares);
            if (!number || vector != before) {
                number = quantiser.nearest(vector);
                before = vector;
            }
            made.numbers[linearIndex(chunk * kChunkExtent + sample, made.extent)] = *number;
            std::uint64_t* const sums = worker.sums.data() + *number * LocalHistograms::kRow;
            for (std::size_t i = 0; i < shares.size(); ++i)
                sums[i] += shares[i];
            ++worker.counts[*number];
        });
    });
    // A representative is the mean of all samples that have its number.
    made.shares.resize(quantiser.size() * LocalHistograms::kRow);
    for (std::size_t r = 0; r < quantiser.size(); ++r) {
        std::uint64_t samples = 0;
        for (const auto& worker : idle)
            samples += worker->counts[r];
        for (std::size_t i = 0; i < LocalHistograms::kRow; ++i) {
            std::uint64_t sum = 0;
            for (const auto& worker : idle)
                sum += worker->sums[r * LocalHistograms::kRow + i];
            const std::uint64_t none = i % kBins == 0 ? LocalHistograms::kWhole : 0;
            made.shares[r * LocalHistograms::kRow + i] =
                static_cast<std::uint16_t>(samples == 0 ? none : (sum + samples / 2) / samples);
        }
    }
    return made;
}

} // namespace tessera
