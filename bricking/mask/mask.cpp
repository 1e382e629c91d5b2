// bricking/mask/mask.cpp: see mask.h.
#include "bricking/mask/mask.h"

#include "bricking/store/pyramid.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera {

std::size_t Mask::bytes(const glm::ivec3& extentVoxels, int level) {
    std::size_t bytes = 0;
    for (int l = level; l < kLevelCount; ++l)
        bytes += cellCount(levelExtent(extentVoxels, l));
    return bytes;
}

Mask::Mask(const glm::ivec3& extentVoxels, int level, std::vector<std::uint8_t> shares, MemoryBudget& ram)
    : level_(level), charge_(ram.charge(bytes(extentVoxels, level), "the mask")) {
    TESSERA_CHECK(level >= 0 && level < kLevelCount);
    for (int l = 0; l < kLevelCount; ++l)
        extents_[static_cast<std::size_t>(l)] = levelExtent(extentVoxels, l);
    TESSERA_CHECK(shares.size() == cellCount(extents_[static_cast<std::size_t>(level)]));
    shares_[static_cast<std::size_t>(level)] = std::move(shares);
    for (int l = level + 1; l < kLevelCount; ++l) {
        const auto at = static_cast<std::size_t>(l);
        shares_[at].resize(cellCount(extents_[at]));
        reduceByTwo(ValueType::u8, extents_[at - 1], std::as_bytes(std::span(shares_[at - 1])),
                    std::as_writable_bytes(std::span(shares_[at])), 1);
    }
}

Mask::Part Mask::of(const glm::ivec3& low, const glm::ivec3& high) const {
    const glm::ivec3& extent = extents_[static_cast<std::size_t>(level_)];
    // The samples on either side of any place of the box.
    const glm::ivec3 first = glm::max((low >> level_) - 1, glm::ivec3(0));
    const glm::ivec3 end = glm::min(((high - 1) >> level_) + 2, extent);
    std::uint8_t least = 255, most = 0;
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y) {
            const std::uint8_t* row = shares().data() + linearIndex({0, y, z}, extent);
            for (int x = first.x; x < end.x; ++x) {
                least = std::min(least, row[x]);
                most = std::max(most, row[x]);
            }
        }
    return most == 0 ? Part::none : least == 255 ? Part::all : Part::some;
}

namespace {

/// Two samples of a row beside a place, and the weight of the second.
struct Between {
    int first = 0, second = 0;
    float weight = 0;
};
/// @param sample  of a level that is `finer` levels finer than the row
Between between(int sample, int finer, int samples) {
    const float place = (static_cast<float>(sample) + 0.5f) / static_cast<float>(1 << finer) - 0.5f;
    const float floor = std::floor(place);
    const int first = static_cast<int>(floor);
    return {std::clamp(first, 0, samples - 1), std::clamp(first + 1, 0, samples - 1), place - floor};
}

} // namespace

void Mask::read(int level, const glm::ivec3& first, const glm::ivec3& count, std::span<float> out) const {
    TESSERA_CHECK(out.size() >= cellCount(count));
    const int from = std::max(level, level_), finer = from - level;
    const std::vector<std::uint8_t>& shares = sharesOf(from);
    const glm::ivec3& extent = extents_[static_cast<std::size_t>(from)];
    std::vector<Between> along(static_cast<std::size_t>(count.x));
    for (int x = 0; x < count.x; ++x)
        along[static_cast<std::size_t>(x)] = between(first.x + x, finer, extent.x);
    const int low = along.front().first, samples = along.back().second + 1 - low; // of the mask's rows
    for (Between& each : along)
        each.first -= low, each.second -= low;
    std::vector<float> row(static_cast<std::size_t>(samples));
    constexpr float kWhole = 1.0f / 255;
    float* to = out.data();
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y, to += count.x) {
            const Between k = between(first.z + z, finer, extent.z),
                          j = between(first.y + y, finer, extent.y);
            const auto rowAt = [&](int v, int w) { return shares.data() + linearIndex({low, v, w}, extent); };
            const std::uint8_t* const r00 = rowAt(j.first, k.first);
            const std::uint8_t* const r01 = rowAt(j.second, k.first);
            const std::uint8_t* const r10 = rowAt(j.first, k.second);
            const std::uint8_t* const r11 = rowAt(j.second, k.second);
            float least = 1, most = 0;
            for (int i = 0; i < samples; ++i) {
                const auto a = static_cast<float>(r00[i]), b = static_cast<float>(r01[i]);
                const auto c = static_cast<float>(r10[i]), d = static_cast<float>(r11[i]);
                const float lower = a + j.weight * (b - a), upper = c + j.weight * (d - c);
                const float share =
                    std::min(std::max((lower + k.weight * (upper - lower)) * kWhole, 0.0f), 1.0f);
                row[static_cast<std::size_t>(i)] = share;
                least = std::min(least, share);
                most = std::max(most, share);
            }
            if (least == most) {
                std::fill_n(to, count.x, least);
                continue;
            }
            for (int x = 0; x < count.x; ++x) {
                const Between& i = along[static_cast<std::size_t>(x)];
                const float a = row[static_cast<std::size_t>(i.first)];
                to[x] = a + i.weight * (row[static_cast<std::size_t>(i.second)] - a);
            }
        }
}

} // namespace tessera
