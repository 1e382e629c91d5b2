// render/light/occlusion_of_others.cpp: the tissue of other volumes that takes a volume's light
// (docs/sampling.md, "Several volumes"): see occlusion.h.
#include "core/base/brick.h"
#include "render/light/occlusion.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <memory>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kChunkSamples = std::size_t{kChunkExtent} * kChunkExtent * kChunkExtent;

glm::dmat4 toOther(const VolumeInfo& own, const VolumeInfo& other) {
    return glm::inverse(other.patientFromVoxel) * own.patientFromVoxel;
}

bool sameLattice(const VolumeInfo& a, const VolumeInfo& b) {
    return a.extentVoxels == b.extentVoxels && a.patientFromVoxel == b.patientFromVoxel;
}

/// The level of another volume whose samples are as far apart as those of a level here, as nearly as may be.
int levelLike(const VolumeInfo& own, int level, const VolumeInfo& other) {
    const double finer = std::cbrt(std::abs(glm::determinant(glm::dmat3(toOther(own, other)))));
    return std::clamp(level + static_cast<int>(std::lround(std::log2(finer))), 0, kLevelCount - 1);
}

/// Samples of a level, from one chunk at a time.
class ExtinctionField {
  public:
    using Shared = std::shared_ptr<const ChunkExtinctions::Samples>;
    ExtinctionField(const VolumeInfo& info, int level, std::function<Shared(const ChunkKey&)> read)
        : level_(level), extentVoxels_(info.extentVoxels), last_(levelExtent(info.extentVoxels, level) - 1),
          read_(std::move(read)) {}

    /// Between the samples, at a place in voxels; 0 outside the volume.
    float at(const glm::dvec3& place) {
        if (glm::any(glm::lessThan(place, glm::dvec3(0))) ||
            glm::any(glm::greaterThanEqual(place, glm::dvec3(extentVoxels_))))
            return 0;
        const glm::dvec3 in =
            glm::clamp(std::ldexp(1.0, -level_) * place - 0.5, glm::dvec3(0), glm::dvec3(last_));
        const glm::ivec3 low(in), high = glm::min(low + 1, last_);
        const glm::vec3 f(in - glm::dvec3(low));
        const auto row = [&](int y, int z) {
            return glm::mix(sample({low.x, y, z}), sample({high.x, y, z}), f.x);
        };
        return glm::mix(glm::mix(row(low.y, low.z), row(high.y, low.z), f.y),
                        glm::mix(row(low.y, high.z), row(high.y, high.z), f.y), f.z);
    }

  private:
    float sample(const glm::ivec3& i) {
        const glm::ivec3 chunk = i >> 5;
        if (chunk != chunk_) {
            chunk_ = chunk;
            samples_ = read_({level_, chunk.x, chunk.y, chunk.z});
        }
        return samples_ && samples_->extinction
                   ? samples_->extinction[linearIndex(i & (kChunkExtent - 1), glm::ivec3(kChunkExtent))]
                   : 0.0f;
    }

    int level_;
    glm::ivec3 extentVoxels_, last_, chunk_{-1};
    std::function<Shared(const ChunkKey&)> read_;
    Shared samples_;
};

} // namespace

void Occluder::setOthers(std::vector<Other> others) {
    others_ = std::move(others);
    withOthers_ = others_.empty() ? nullptr : std::make_unique<ChunkExtinctions>();
}

/// Adds the extinction of another volume at the samples of a chunk.
void Occluder::add(const Other& other, const ChunkKey& key, float* extinction) const {
    const Occluder& tissue = *other.tissue;
    const auto read = [&](const ChunkKey& chunk) {
        return tissue.letsAllThrough(tissue.rangeOf(chunk)) ? nullptr
                                                            : tissue.ownExtinctions(chunk, *other.cache);
    };
    if (sameLattice(info_, tissue.info_)) {
        if (const SharedSamples own = read(key); own && own->extinction)
            for (std::size_t n = 0; n < kChunkSamples; ++n)
                extinction[n] += own->extinction[n];
        return;
    }
    const glm::dmat4 there = toOther(info_, tissue.info_);
    const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * kChunkExtent,
                     size = glm::min(levelExtent(info_.extentVoxels, key.level) - first,
                                     glm::ivec3(kChunkExtent));
    const double pitch = std::ldexp(1.0, key.level);
    ExtinctionField field(tissue.info_, levelLike(info_, key.level, tissue.info_), read);
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const glm::dvec3 place = pitch * (glm::dvec3(first + glm::ivec3(x, y, z)) + 0.5);
                extinction[linearIndex({x, y, z}, glm::ivec3(kChunkExtent))] +=
                    field.at(glm::dvec3(there * glm::dvec4(place, 1)));
            }
}

/// True if no other volume has extinction in a chunk, or between it and the samples around it.
bool Occluder::othersLetThrough(const ChunkKey& chunk) const {
    const double pitch = std::ldexp(1.0, chunk.level);
    const glm::dvec3 low = pitch * (glm::dvec3(chunk.i, chunk.j, chunk.k) * double{kChunkExtent} - 1.0),
                     size = glm::dvec3(pitch * (kChunkExtent + 2));
    return std::all_of(others_.begin(), others_.end(), [&](const Other& other) {
        const Occluder& tissue = *other.tissue;
        const glm::dmat4 there = toOther(info_, tissue.info_);
        glm::dvec3 least(std::numeric_limits<double>::max()), most(std::numeric_limits<double>::lowest());
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 at(
                there * glm::dvec4(low + size * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2), 1));
            least = glm::min(least, at);
            most = glm::max(most, at);
        }
        // A sample of the level that is read there reaches a sample further.
        const int level = levelLike(info_, chunk.level, tissue.info_);
        const glm::dvec3 reach(std::ldexp(1.0, level));
        const glm::dvec3 extent(tissue.info_.extentVoxels);
        const glm::ivec3 from = glm::ivec3(glm::clamp(least - reach, glm::dvec3(0), extent)) / kBrickExtent,
                         to =
                             glm::ivec3(glm::clamp(most + reach, glm::dvec3(0), extent - 1.0)) / kBrickExtent;
        Range range;
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) {
                    const Range one = tissue.rangeOf({0, x, y, z});
                    range.add(one.low, one.high, one.shows);
                }
        return range.low > range.high || tissue.letsAllThrough(range);
    });
}

Occluder::SharedSamples Occluder::extinctionsOf(const ChunkKey& key, BrickCache& cache) const {
    if (!withOthers_)
        return ownExtinctions(key, cache);
    return withOthers_->get(key, [&](ChunkExtinctions::Samples& out) {
        auto all = std::make_unique<float[]>(kChunkSamples);
        if (!letsAllThrough(rangeOf(key)))
            if (const SharedSamples own = ownExtinctions(key, cache); own->extinction)
                std::copy_n(own->extinction.get(), kChunkSamples, all.get());
        for (const Other& other : others_)
            add(other, key, all.get());
        out.rowShows.assign(static_cast<std::size_t>(kChunkExtent * kChunkExtent), 0);
        bool any = false;
        for (std::size_t row = 0; row < out.rowShows.size(); ++row) {
            const float* const first = all.get() + row * kChunkExtent;
            out.rowShows[row] =
                std::any_of(first, first + kChunkExtent, [](float e) { return e > 0; }) ? 1 : 0;
            any = any || out.rowShows[row] != 0;
        }
        if (any)
            out.extinction = std::move(all);
    });
}

} // namespace tessera
