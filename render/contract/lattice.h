// render/contract/lattice.h: samples for a CPU renderer, read through the brick cache, so a volume never has
// to fit in memory. Empty bricks read as their mean, exactly as on the GPU. Each thread has a reader of its
// own, which pins the few chunks that a neighbourhood can touch.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "core/base/brick.h"
#include "core/base/threads.h"
#include "core/base/volume.h"
#include "render/contract/level_map.h"
#include "render/contract/sampler.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace tessera {

/// Stored values of samples by level and place, the last few chunks pinned.
class SampleReader {
  public:
    static constexpr std::size_t kPinnedChunks = 8;

    SampleReader(BrickCache& cache, ValueType type)
        : cache_(cache), type_(type), bytesPerValue_(bytesPerValue(type)) {}

    /// Sample i, inside its level.
    double at(int level, const glm::ivec3& i) {
        return storedValue(type_, chunkAt(level, i >> 5) + placeOf(i) * bytesPerValue_);
    }

    /// Edge^3 samples from `first` on, x fastest, all inside their level.
    template <int Edge> void cube(int level, const glm::ivec3& first, double* out) {
        if ((first >> 5) != ((first + (Edge - 1)) >> 5)) {
            for (int z = 0; z < Edge; ++z)
                for (int y = 0; y < Edge; ++y)
                    for (int x = 0; x < Edge; ++x)
                        *out++ = at(level, first + glm::ivec3(x, y, z));
            return;
        }
        const std::byte* start = chunkAt(level, first >> 5) + placeOf(first) * bytesPerValue_;
        withValueType(type_, [&](auto typed) {
            constexpr std::size_t kRow = kChunkExtent, kSlice = kRow * kRow;
            for (std::size_t z = 0; z < Edge; ++z)
                for (std::size_t y = 0; y < Edge; ++y)
                    for (std::size_t x = 0; x < Edge; ++x) {
                        std::memcpy(&typed, start + (z * kSlice + y * kRow + x) * sizeof typed, sizeof typed);
                        *out++ = static_cast<double>(typed);
                    }
        });
    }

  private:
    static std::size_t placeOf(const glm::ivec3& i) {
        return linearIndex(i & (kChunkExtent - 1), glm::ivec3(kChunkExtent));
    }
    /// The chunk's samples.
    const std::byte* chunkAt(int level, const glm::ivec3& chunk) {
        const ChunkKey key{level, chunk.x, chunk.y, chunk.z};
        // Neighbouring chunks differ in some parity, so the eight of a neighbourhood of one level never evict
        // each other.
        Pinned& pinned = pinned_[static_cast<std::size_t>((key.i & 1) | (key.j & 1) << 1 | (key.k & 1) << 2)];
        if (!pinned.data || pinned.key != key) {
            pinned.data.reset(); // before asking: a full cache may need this very chunk's place
            pinned.data = cache_.get(key);
            pinned.key = key;
        }
        return pinned.data->bytes.get();
    }

    struct Pinned {
        ChunkKey key{-1, 0, 0, 0};
        ChunkPointer data;
    };
    BrickCache& cache_;
    ValueType type_;
    std::size_t bytesPerValue_;
    std::array<Pinned, kPinnedChunks> pinned_;
};

/// Samples of one level, for fieldValue().
class LatticeReader {
  public:
    static constexpr std::size_t kPinnedChunks = SampleReader::kPinnedChunks;

    /// @param selection  which bricks stand as their mean; none: every sample is read (the reference)
    LatticeReader(BrickCache& cache, const VolumeInfo& info, int level, const Selection* selection)
        : reader_(cache, info.type), level_(level), extent_(levelExtent(info.extentVoxels, level)),
          selection_(selection) {}

    const glm::ivec3& extent() const { return extent_; }

    /// Stored value of sample i, inside [0,extent).
    double at(const glm::ivec3& i) {
        if (selection_)
            if (const glm::ivec3 brick = i >> (5 - level_); isEmpty(brick))
                return meanOf(brick);
        return reader_.at(level_, i);
    }
    /// Edge^3 samples from `first` on, x fastest; those beyond the outermost are the outermost.
    template <int Edge> void cube(const glm::ivec3& first, double* out) {
        const glm::ivec3 last = first + (Edge - 1);
        if (glm::clamp(first, glm::ivec3(0), extent_ - 1) == first && glm::min(last, extent_ - 1) == last) {
            const glm::ivec3 brick = first >> (5 - level_);
            if (!selection_)
                return reader_.cube<Edge>(level_, first, out);
            if (brick == last >> (5 - level_)) {
                if (isEmpty(brick))
                    return void(std::fill_n(out, Edge * Edge * Edge, meanOf(brick)));
                return reader_.cube<Edge>(level_, first, out);
            }
        }
        for (int z = 0; z < Edge; ++z)
            for (int y = 0; y < Edge; ++y)
                for (int x = 0; x < Edge; ++x)
                    *out++ = at(glm::clamp(first + glm::ivec3(x, y, z), glm::ivec3(0), extent_ - 1));
    }

  private:
    bool isEmpty(const glm::ivec3& brick) const {
        return selection_->levels[linearIndex(brick, selection_->bricks)] == Selection::kEmpty;
    }
    double meanOf(const glm::ivec3& brick) const {
        return static_cast<double>(selection_->means[linearIndex(brick, selection_->bricks)]);
    }

    SampleReader reader_;
    int level_;
    glm::ivec3 extent_;
    const Selection* selection_;
};

/// Samples of a selection of mixed levels, for interblockValue().
class MixedReader {
  public:
    MixedReader(BrickCache& cache, const VolumeInfo& info, const Selection& selection, const LevelMap& map)
        : reader_(cache, info.type), selection_(selection), map_(map) {}

    const LevelMap& map() const { return map_; }
    double at(int level, const glm::ivec3& i) { return reader_.at(level, i); }
    double mean(const glm::ivec3& brick) const {
        return static_cast<double>(selection_.means[linearIndex(brick, selection_.bricks)]);
    }
    bool isEmpty(const glm::ivec3& brick) const {
        return selection_.levels[linearIndex(brick, selection_.bricks)] == Selection::kEmpty;
    }

  private:
    SampleReader reader_;
    const Selection& selection_;
    const LevelMap& map_;
};

/// The smallest cache for so many threads that read samples: each pins the chunks of one neighbourhood while
/// the loaders need one each.
/// @param threads  0: all processors
inline std::size_t latticeCacheFloorBytes(const VolumeInfo& info, int threads) {
    const int used = threads > 0 ? threads : defaultThreads();
    return BrickCache::floorBytes(info, used) + cellCount(glm::ivec3(kChunkExtent)) *
                                                    bytesPerValue(info.type) * SampleReader::kPinnedChunks *
                                                    static_cast<std::size_t>(used - 1);
}

// The field of a selection of bricks, read through the brick cache. For one thread at a time.

template <typename Real> struct UniformField {
    LatticeReader& samples;
    Real samplesPerVoxel;
    Gradient kind;
    Real value(const glm::vec<3, Real>& p) { return fieldValue(samples, p, samplesPerVoxel); }
    Real pitch(const glm::vec<3, Real>&) const { return Real(1) / samplesPerVoxel; }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) { return gradient(p, kind); }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p, Gradient by) {
        return fieldGradient(samples, p, samplesPerVoxel, by);
    }
};

template <typename Real> struct MixedField {
    MixedReader& samples;
    Gradient kind;
    Real value(const glm::vec<3, Real>& p) { return interblockValue(samples, p); }
    /// Of the brick that p lies in.
    Real pitch(const glm::vec<3, Real>& p) {
        const LevelMap& map = samples.map();
        const auto place = cornerPlace(p, glm::vec<3, Real>(map.extentVoxels), map.bricks);
        const std::uint32_t code = map.at(place.corner).code(place.current);
        return static_cast<Real>(1 << (code == BrickCorner::kEmpty ? map.finest : code));
    }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) { return gradient(p, kind); }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p, Gradient by) {
        return interblockGradient(samples, p, by);
    }
};

/// visit(field).
/// @param levels  of mixed levels; null: the selection has one
template <typename Real, typename Visit>
void withCacheField(BrickCache& cache, const VolumeInfo& info, const Selection& selection,
                    const LevelMap* levels, Gradient kind, const Visit& visit) {
    if (levels) {
        MixedReader samples(cache, info, selection, *levels);
        MixedField<Real> field{samples, kind};
        visit(field);
    } else {
        const int level = selection.finest();
        LatticeReader samples(cache, info, level, &selection);
        UniformField<Real> field{samples, Real(1) / static_cast<Real>(1 << level), kind};
        visit(field);
    }
}

} // namespace tessera
