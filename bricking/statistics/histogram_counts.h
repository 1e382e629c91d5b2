// bricking/statistics/histogram_counts.h: the local histograms of one sample: places of values among bins, a
// chunk with its surroundings, counts and shares (docs/sampling.md, "Occlusion by histograms"). For
// local_histograms.cpp alone. Counts are whole numbers, so the results depend neither on the number of
// threads nor on the order of chunks.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/statistics/local_histograms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <type_traits>
#include <vector>

namespace tessera::local_histograms {

inline constexpr int kPlaceOne = 256;             // parts of the way from a bin to the next
inline constexpr std::uint16_t kOutside = 0xFFFF; // the place of what is beyond the volume
inline constexpr int kBins = LocalHistogramSettings::kMostBins;
inline constexpr std::size_t kMostPlaces = 65536; // values of a whole type

/// A value's place among bins, in parts of kPlaceOne.
class BinPlaces {
  public:
    BinPlaces(const std::vector<double>& centres, ValueType type) : centres_(centres) {
        const auto fill = [&](int lowest, int highest) {
            for (int stored = lowest; stored <= highest; ++stored)
                table_.push_back(placeOf(stored));
        };
        if (type == ValueType::u8)
            fill(0, 255);
        else if (type == ValueType::i16)
            fill(-32768, 32767);
        else if (type == ValueType::u16)
            fill(0, 65535);
    }
    template <typename Stored> std::uint16_t of(Stored stored) const {
        if constexpr (std::is_integral_v<Stored>)
            return table_[static_cast<std::size_t>(int(stored) - int(std::numeric_limits<Stored>::min()))];
        else
            return placeOf(static_cast<double>(stored));
    }
    static std::size_t bytes() { return kMostPlaces * sizeof(std::uint16_t); }

  private:
    std::uint16_t placeOf(double value) const {
        if (!(value > centres_.front()))
            return 0;
        if (value >= centres_.back())
            return static_cast<std::uint16_t>((centres_.size() - 1) * kPlaceOne);
        const auto above = static_cast<std::size_t>(
            std::upper_bound(centres_.begin(), centres_.end(), value) - centres_.begin());
        const double part = (value - centres_[above - 1]) / (centres_[above] - centres_[above - 1]);
        return static_cast<std::uint16_t>(std::lround((static_cast<double>(above - 1) + part) * kPlaceOne));
    }

    std::vector<double> centres_;
    std::vector<std::uint16_t> table_;
};

/// A sample's histograms, not yet normalised: values on the rising side, on the other one, and those at right
/// angles, which count for both.
struct Counts {
    std::array<std::array<std::uint32_t, kBins + 1>, 3> bins; // rising, falling, both
};

/// A chunk with its surroundings, by places among bins: the working set of a thread.
class ChunkRoom {
  public:
    ChunkRoom(const ChunkSource& volume, int level, const LocalBall& ball, const BinPlaces& places)
        : volume_(volume), level_(level), ball_(ball), places_(places), size_(kChunkExtent + 2 * ball.reach),
          place_(cellCount(size_)), chunk_(volume.chunkBytes()) {
        for (const LocalBall::Neighbour& n : ball.half)
            steps_.push_back(n.offset.x + size_.x * (n.offset.y + size_.y * n.offset.z));
    }
    static std::size_t bytes(const ChunkSource& volume, const LocalBall& ball) {
        return cellCount(kChunkExtent + 2 * ball.reach) * sizeof(std::uint16_t) + volume.chunkBytes() +
               ball.half.size() * sizeof(int);
    }

    void read(const glm::ivec3& chunk) {
        const glm::ivec3 extent = levelExtent(volume_.info().extentVoxels, level_);
        first_ = chunk * kChunkExtent - ball_.reach;
        const glm::ivec3 low = glm::max(first_, glm::ivec3(0)), high = glm::min(first_ + size_, extent);
        isWhole_ = low == first_ && high == first_ + size_;
        if (!isWhole_)
            std::fill(place_.begin(), place_.end(), kOutside);
        for (int z = low.z >> 5; z <= (high.z - 1) >> 5; ++z)
            for (int y = low.y >> 5; y <= (high.y - 1) >> 5; ++y)
                for (int x = low.x >> 5; x <= (high.x - 1) >> 5; ++x) {
                    volume_.readChunk({level_, x, y, z}, chunk_);
                    const glm::ivec3 corner = glm::ivec3(x, y, z) * kChunkExtent;
                    const glm::ivec3 from = glm::max(low, corner), to = glm::min(high, corner + kChunkExtent);
                    withValueType(volume_.info().type,
                                  [&](auto typed) { copy<decltype(typed)>(corner, from, to); });
                }
    }

    /// Counts around a sample of the chunk.
    void count(const glm::ivec3& sample, Counts& counts) const {
        counts = {};
        const std::size_t at = linearIndex(sample + ball_.reach, size_);
        if (isWhole_)
            add<true>(place_.data() + at, gradientAt(at), counts);
        else
            add<false>(place_.data() + at, gradientAt(at), counts);
    }
    std::uint16_t placeAt(const glm::ivec3& sample) const {
        return place_[linearIndex(sample + ball_.reach, size_)];
    }

  private:
    template <typename Stored>
    void copy(const glm::ivec3& corner, const glm::ivec3& from, const glm::ivec3& to) {
        for (int z = from.z; z < to.z; ++z)
            for (int y = from.y; y < to.y; ++y) {
                std::uint16_t* out = place_.data() + linearIndex(glm::ivec3(from.x, y, z) - first_, size_);
                const std::byte* in =
                    chunk_.data() +
                    linearIndex(glm::ivec3(from.x, y, z) - corner, glm::ivec3(kChunkExtent)) * sizeof(Stored);
                for (int x = from.x; x < to.x; ++x, in += sizeof(Stored)) {
                    Stored value;
                    std::memcpy(&value, in, sizeof value);
                    *out++ = places_.of(value);
                }
            }
    }

    /// Differences of adjacent places; 0 where they are less than a bin: noise has no side.
    glm::ivec3 gradientAt(std::size_t at) const {
        const std::size_t pitch[3] = {1, static_cast<std::size_t>(size_.x),
                                      static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y)};
        glm::ivec3 gradient(0);
        for (int axis = 0; axis < 3; ++axis) {
            int ends[2] = {place_[at - pitch[axis]], place_[at + pitch[axis]]};
            int steps = 2;
            for (int& end : ends)
                if (end == kOutside) {
                    end = place_[at];
                    --steps;
                }
            gradient[axis] = steps == 2 ? ends[1] - ends[0] : 2 * (ends[1] - ends[0]);
        }
        const auto steepest = std::max({std::abs(gradient.x), std::abs(gradient.y), std::abs(gradient.z)});
        return steepest < kPlaceOne ? glm::ivec3(0) : gradient;
    }

    template <bool whole>
    void add(const std::uint16_t* at, const glm::ivec3& gradient, Counts& counts) const {
        const auto put = [](std::array<std::uint32_t, kBins + 1>& bins, std::uint16_t place,
                            std::uint32_t weight) {
            if (!whole && place == kOutside)
                return;
            const std::uint32_t part = place & (kPlaceOne - 1), bin = place / kPlaceOne;
            bins[bin] += weight * (kPlaceOne - part);
            bins[bin + 1] += weight * part;
        };
        // By the sign of the way's part along the gradient, -1 to 1: the sides of a neighbour and of its
        // mirror image.
        std::array<std::uint32_t, kBins + 1>* const sides[3] = {&counts.bins[1], &counts.bins[2],
                                                                &counts.bins[0]};
        for (std::size_t n = 0; n < steps_.size(); ++n) {
            const LocalBall::Neighbour& to = ball_.half[n];
            const int along = to.offset.x * gradient.x + to.offset.y * gradient.y + to.offset.z * gradient.z;
            const int sign = (along > 0) - (along < 0);
            put(*sides[1 + sign], at[steps_[n]], to.weight);
            put(*sides[1 - sign], at[-steps_[n]], to.weight);
        }
    }

    const ChunkSource& volume_;
    int level_;
    const LocalBall& ball_;
    const BinPlaces& places_;
    glm::ivec3 size_, first_{0};
    bool isWhole_ = false;
    std::vector<std::uint16_t> place_;
    std::vector<std::byte> chunk_;
    std::vector<int> steps_;
};

/// Shares of both sides, of LocalHistograms::kWhole, rounded down; a side without samples has the other's.
using Shares = std::array<std::uint32_t, LocalHistograms::kRow>;

inline void normalise(const Counts& counts, std::uint16_t own, Shares& shares) {
    std::array<float, 2> sums{};
    std::array<std::array<std::uint32_t, kBins>, 2> sides;
    for (std::size_t side = 0; side < 2; ++side) {
        std::uint64_t sum = 0;
        for (std::size_t b = 0; b < kBins; ++b) {
            sides[side][b] = 2 * counts.bins[side][b] + counts.bins[2][b];
            sum += sides[side][b];
        }
        sums[side] = static_cast<float>(sum);
    }
    if (sums[0] == 0 && sums[1] == 0) { // nothing around: the sample itself
        sides[0].fill(0);
        sides[0][own / kPlaceOne] = 1;
        sums[0] = 1;
    }
    for (std::size_t side = 0; side < 2; ++side) {
        const std::size_t from = sums[side] > 0 ? side : 1 - side;
        const float scale = static_cast<float>(LocalHistograms::kWhole) / sums[from];
        for (std::size_t b = 0; b < kBins; ++b)
            shares[side * kBins + b] = static_cast<std::uint32_t>(static_cast<float>(sides[from][b]) * scale);
    }
}

} // namespace tessera::local_histograms
