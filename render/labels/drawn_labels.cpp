// render/labels/drawn_labels.cpp: see drawn_labels.h.
#include "render/labels/drawn_labels.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr int kCellsLevel = 3; // whose samples are cells
static_assert(1 << kCellsLevel == kCellExtent);
/// A brick of several sets.
constexpr int kSeveral = -1;

std::uint16_t texelOf(double factor) {
    return static_cast<std::uint16_t>(factor * static_cast<double>(leaf::kLightOne) + 0.5);
}

} // namespace

/// Weighted by voxels.
struct DrawnLabels::Sum {
    double voxels = 0, plain = 0, tinted = 0, solid = 0, dense = 0; // solid: voxels with a medium
    glm::dvec3 ofTinted{0}, ofSolid{0};                             // colours times these
    void add(const LabelFactors& f, double count) {
        voxels += count;
        plain += count * static_cast<double>(f.plain);
        tinted += count * static_cast<double>(f.tinted);
        solid += f.solid > 0 ? count : 0;
        dense += count * static_cast<double>(f.solid);
        ofTinted += count * static_cast<double>(f.tinted) * glm::dvec3(f.colour);
        ofSolid += count * static_cast<double>(f.solid) * glm::dvec3(f.colour);
    }
};

DrawnLabels::DrawnLabels(std::unique_ptr<LabelVolume> volume, LabelTable table,
                         std::vector<LabelFactors> bySet, float density, LabelBorders borders)
    : volume_(std::move(volume)), table_(std::move(table)), extent_(volume_->voxels().info().extentVoxels),
      cells_(cellGrid(extent_)), bricks_(brickGrid(extent_)),
      voxelMm_(std::cbrt(std::abs(glm::determinant(glm::dmat3(volume_->voxels().info().patientFromVoxel))))),
      borders_(borders) {
    setFactors(std::move(bySet), density);
}

void DrawnLabels::setFactors(std::vector<LabelFactors> bySet, float density) {
    TESSERA_CHECK(bySet.size() == table_.sets.size());
    bySet_ = std::move(bySet);
    bool plain = false, tinted = false, solid = false, dense = false;
    for (const LabelFactors& f : bySet_) {
        dense = dense || (f.solid > 0 && f.solid < 1);
        plain = plain || f.plain > 0;
        tinted = tinted || f.tinted > 0;
        solid = solid || f.solid > 0;
    }
    numbers_ = {};
    numbers_.density = density;
    numbers_.nearest = borders_ == LabelBorders::nearest;
    const auto channels = [&](bool needed, std::int32_t& first, int count) {
        if (needed || numbers_.count == 0) { // one at least
            first = numbers_.count;
            numbers_.count += count;
        }
    };
    channels(plain, numbers_.plain, 1);
    if (tinted)
        channels(true, numbers_.tinted, 1);
    if (solid)
        channels(true, numbers_.solid, 1);
    if (dense)
        channels(true, numbers_.dense, 1);
    if (tinted || solid)
        channels(true, numbers_.colour, 3);
    texelsBySet_.clear();
    texelsBySet_.resize(bySet_.size() * static_cast<std::size_t>(numbers_.count));
    for (std::size_t set = 0; set < bySet_.size(); ++set) {
        Sum one;
        one.add(bySet_[set], 1);
        put(one, 0, texelsBySet_.data() + set * static_cast<std::size_t>(numbers_.count));
    }
    standing_.resize(cellCount(bricks_) * static_cast<std::size_t>(numbers_.count));
    for (std::size_t b = 0; b < cellCount(bricks_); ++b) {
        const glm::ivec3 low = gridPosition(b, bricks_) * kCellsPerBrick;
        put(sumOf(low, glm::min(low + kCellsPerBrick, cells_)), kLevelCount - 1,
            standing_.data() + b * static_cast<std::size_t>(numbers_.count));
    }
}

std::size_t DrawnLabels::shownLabels() const {
    std::vector<std::uint8_t> shown(table_.labels.size());
    for (std::size_t set = 0; set < table_.sets.size(); ++set)
        for (const std::uint16_t label : table_.sets[set])
            if (bySet_[set].shows())
                shown[label] = 1;
    return static_cast<std::size_t>(std::count(shown.begin(), shown.end(), 1));
}

/// One texel a channel, of a sample of a level. A share of the medium is kept above that of its border, so
/// that whatever is there of it lies inside.
void DrawnLabels::put(const Sum& sum, int level, std::uint16_t* at) const {
    const double border{leaf::kLabelBorder};
    const double share = sum.voxels > 0 ? 1 / sum.voxels : 0;
    double solid = 0;
    if (sum.solid > 0) {
        const double depth = double{numbers_.density} * sum.dense / sum.solid * std::ldexp(voxelMm_, level);
        const double whole = sum.solid * share;
        // Half of the way to an empty coarse sample lies the border, not further out by the pitch.
        const double most = level == 0 ? 1 : 1 + (1 - border / (1 - border)) * std::expm1(-depth);
        solid = border + (1 - border) * most * whole;
    }
    const auto set = [at](std::int32_t channel, double factor) {
        if (channel >= 0)
            at[channel] = texelOf(factor);
    };
    set(numbers_.plain, sum.plain * share);
    set(numbers_.tinted, sum.tinted * share);
    set(numbers_.solid, solid);
    set(numbers_.dense, sum.solid > 0 ? solid * sum.dense / sum.solid : 0);
    // The medium's colour is that of its extinction, and counts as its share does.
    const double perDense = sum.dense > 0 ? solid / sum.dense : 0;
    for (int c = 0; numbers_.colour >= 0 && c < 3; ++c)
        set(numbers_.colour + c, sum.ofTinted[c] * share + sum.ofSolid[c] * perDense);
}

/// Over cells [low, high).
DrawnLabels::Sum DrawnLabels::sumOf(const glm::ivec3& low, const glm::ivec3& high) const {
    Sum sum;
    for (int z = low.z; z < high.z; ++z)
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x)
                for (const LabelCells::Share& share :
                     volume_->cells().of(linearIndex(glm::ivec3(x, y, z), cells_)))
                    sum.add(bySet_[share.set], share.voxels);
    return sum;
}

/// The only set of a brick's voxels, or kSeveral.
int DrawnLabels::onlySetOf(const glm::ivec3& brick) const {
    const glm::ivec3 low = brick * kCellsPerBrick, high = glm::min(low + kCellsPerBrick, cells_);
    int only = kSeveral;
    for (int z = low.z; z < high.z; ++z)
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x) {
                const auto shares = volume_->cells().of(linearIndex(glm::ivec3(x, y, z), cells_));
                if (shares.size() != 1 || (only != kSeveral && shares.front().set != only))
                    return kSeveral;
                only = shares.front().set;
            }
    return only;
}

void DrawnLabels::fill(std::size_t brick, int level, std::span<std::uint16_t> out) const {
    const auto channels = static_cast<std::size_t>(numbers_.count);
    TESSERA_CHECK(out.size() == channels * kBrickTexels);
    const glm::ivec3 at = gridPosition(brick, bricks_);
    if (const int only = onlySetOf(at); only != kSeveral) {
        for (std::size_t c = 0; c < channels; ++c)
            std::fill_n(out.data() + c * kBrickTexels, kBrickTexels,
                        texelsBySet_[static_cast<std::size_t>(only) * channels + c]);
        return;
    }
    if (level < kCellsLevel)
        return fillFromVoxels(at, level, out);
    const int edge = kBrickExtent >> level, cells = 1 << (level - kCellsLevel);
    std::uint16_t texels[leaf::kMostLabelChannels];
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x) {
                const glm::ivec3 low = at * kCellsPerBrick + glm::ivec3(x, y, z) * cells;
                put(sumOf(low, glm::min(low + cells, cells_)), level, texels);
                for (std::size_t c = 0; c < channels; ++c)
                    out[c * kBrickTexels + linearIndex({x, y, z}, glm::ivec3(kBrickExtent))] = texels[c];
            }
}

void DrawnLabels::fillFromVoxels(const glm::ivec3& brick, int level, std::span<std::uint16_t> out) const {
    const auto channels = static_cast<std::size_t>(numbers_.count);
    const StoreReader& voxels = volume_->voxels();
    std::vector<std::byte> chunk(voxels.chunkBytes());
    voxels.readChunk({0, brick.x, brick.y, brick.z}, chunk);
    withValueType(voxels.info().type, [&](auto typed) {
        using Stored = decltype(typed);
        if constexpr (std::is_same_v<Stored, std::uint8_t> || std::is_same_v<Stored, std::uint16_t>) {
            const auto setAt = [&](std::size_t i) {
                Stored set;
                std::memcpy(&set, chunk.data() + i * sizeof set, sizeof set);
                return std::min<std::size_t>(set, bySet_.size() - 1);
            };
            if (level == 0) {
                for (std::size_t i = 0; i < kBrickTexels; ++i) {
                    const std::uint16_t* const of = texelsBySet_.data() + setAt(i) * channels;
                    for (std::size_t c = 0; c < channels; ++c)
                        out[c * kBrickTexels + i] = of[c];
                }
                return;
            }
            const int edge = kBrickExtent >> level, along = 1 << level;
            const glm::ivec3 end = extent_ - brick * kBrickExtent; // of the volume
            std::uint16_t texels[leaf::kMostLabelChannels];
            for (int z = 0; z < edge; ++z)
                for (int y = 0; y < edge; ++y)
                    for (int x = 0; x < edge; ++x) {
                        const glm::ivec3 low = glm::ivec3(x, y, z) * along, high = glm::min(low + along, end);
                        Sum sum;
                        for (int k = low.z; k < high.z; ++k)
                            for (int j = low.y; j < high.y; ++j)
                                for (int i = low.x; i < high.x; ++i)
                                    sum.add(bySet_[setAt(linearIndex({i, j, k}, glm::ivec3(kChunkExtent)))],
                                            1);
                        put(sum, level, texels);
                        for (std::size_t c = 0; c < channels; ++c)
                            out[c * kBrickTexels + linearIndex({x, y, z}, glm::ivec3(kBrickExtent))] =
                                texels[c];
                    }
        }
    });
}

std::uint16_t DrawnLabels::standing(std::size_t brick, int channel) const {
    return standing_[brick * static_cast<std::size_t>(numbers_.count) + static_cast<std::size_t>(channel)];
}

void DrawnLabels::extinctions(const ChunkKey& key, std::span<float> function, std::span<float> medium) const {
    const int edge = kBrickExtent >> key.level, along = 1 << key.level; // samples and number of its bricks
    const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * along;
    const auto channels = static_cast<std::size_t>(numbers_.count);
    std::vector<std::uint16_t> texels(channels * kBrickTexels);
    const auto factor = [&](std::int32_t channel, std::size_t i) {
        return texels[static_cast<std::size_t>(channel) * kBrickTexels + i] * (1 / leaf::kLightOne);
    };
    for (int z = 0; z < along; ++z)
        for (int y = 0; y < along; ++y)
            for (int x = 0; x < along; ++x) {
                const glm::ivec3 brick = first + glm::ivec3(x, y, z);
                if (glm::any(glm::greaterThanEqual(brick, bricks_)))
                    continue;
                if (key.level + 1 < kLevelCount)
                    fill(linearIndex(brick, bricks_), key.level, texels);
                else
                    for (std::size_t c = 0; c < channels; ++c)
                        texels[c * kBrickTexels] = standing(linearIndex(brick, bricks_), static_cast<int>(c));
                for (int k = 0; k < edge; ++k)
                    for (int j = 0; j < edge; ++j)
                        for (int i = 0; i < edge; ++i) {
                            const std::size_t from = linearIndex({i, j, k}, glm::ivec3(kBrickExtent));
                            const std::size_t to = linearIndex(
                                glm::ivec3(x, y, z) * edge + glm::ivec3(i, j, k), glm::ivec3(kChunkExtent));
                            const auto shares = leaf::labelShares<float>(
                                numbers_, [&](int channel) { return factor(channel, from); });
                            function[to] = leaf::labelledFunction(shares, 1.0f);
                            medium[to] = leaf::labelledMedium(shares, numbers_.density);
                        }
            }
}

} // namespace tessera
