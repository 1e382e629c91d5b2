// render/labels/set_reader.cpp: see set_reader.h.
#include "render/labels/set_reader.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>

namespace tessera {
namespace {

constexpr int kPartBits = 12; // a place counts in parts of 1/4096 voxel
constexpr double kPartsOfVoxel = 1 << kPartBits;

} // namespace

SetReader::SetReader(BrickCache& cache, const VolumeInfo& info, int level, LabelBorders borders,
                     std::span<const std::uint16_t> shown)
    : cache_(cache), wide_(info.type == ValueType::u16), level_(level),
      nearest_(borders == LabelBorders::nearest), extent_(info.extentVoxels),
      samples_(levelExtent(info.extentVoxels, level)), shown_(shown) {
    TESSERA_CHECK(wide_ || info.type == ValueType::u8);
}

std::uint16_t SetReader::numberAt(const std::byte* chunk, std::size_t at) const {
    if (!wide_)
        return std::to_integer<std::uint16_t>(chunk[at]);
    std::uint16_t number = 0;
    std::memcpy(&number, chunk + at * sizeof number, sizeof number);
    return number;
}

const std::byte* SetReader::chunkOf(const glm::ivec3& sample) {
    const glm::ivec3 place = sample / kChunkExtent;
    Pinned& pinned =
        pinned_[static_cast<std::size_t>((place.x & 1) | (place.y & 1) << 1 | (place.z & 1) << 2)];
    if (!pinned.chunk || pinned.place != place) {
        pinned.chunk.reset(); // before asking: a full cache may need this very chunk's place
        pinned.chunk = cache_.get({level_, place.x, place.y, place.z});
        pinned.place = place;
    }
    return pinned.chunk->bytes.get();
}

/// Of 2^3 samples, x fastest; those beyond the outermost are the outermost.
SetReader::Sets SetReader::numbersAround(const glm::ivec3& first) {
    constexpr glm::ivec3 kWhole(kChunkExtent);
    Sets numbers;
    const auto held = [&](const glm::ivec3& i) { return glm::clamp(i, glm::ivec3(0), samples_ - 1); };
    const glm::ivec3 low = held(first), high = held(first + 1);
    if (low / kChunkExtent == high / kChunkExtent) {
        const std::byte* const chunk = chunkOf(low);
        const glm::ivec3 from = low % kChunkExtent, step = high - low;
        for (int i = 0; i < 8; ++i)
            numbers[static_cast<std::size_t>(i)] =
                numberAt(chunk, linearIndex(from + step * glm::ivec3(i & 1, i >> 1 & 1, i >> 2), kWhole));
        return numbers;
    }
    for (int i = 0; i < 8; ++i) {
        const glm::ivec3 sample = held(first + glm::ivec3(i & 1, i >> 1 & 1, i >> 2));
        numbers[static_cast<std::size_t>(i)] =
            numberAt(chunkOf(sample), linearIndex(sample % kChunkExtent, kWhole));
    }
    return numbers;
}

void SetReader::read(const glm::ivec3& first) {
    if (first == first_)
        return;
    first_ = glm::ivec3(INT32_MIN); // until they are read
    if (nearest_) {
        const glm::ivec3 sample = glm::clamp(first, glm::ivec3(0), samples_ - 1);
        sets_.fill(numberAt(chunkOf(sample), linearIndex(sample % kChunkExtent, glm::ivec3(kChunkExtent))));
    } else {
        sets_ = numbersAround(first);
    }
    isOne_ = true;
    for (std::uint16_t& set : sets_) {
        set = shown_[std::min<std::size_t>(set, shown_.size() - 1)];
        isOne_ = isOne_ && set == sets_[0];
    }
    first_ = first;
}

std::uint16_t SetReader::at(const glm::dvec3& place) {
    const int bits = kPartBits + level_; // of a sample
    const std::int64_t unit = std::int64_t{1} << bits;
    Place parts;
    for (int axis = 0; axis < 3; ++axis) {
        // One voxel beyond the volume reads as its outermost; what is no number too.
        const double held = place[axis] > -1 ? std::min(place[axis], extent_[axis] + 1) : -1;
        parts[axis] =
            static_cast<std::int64_t>(std::floor(held * kPartsOfVoxel + 0.5)) - (nearest_ ? 0 : unit / 2);
    }
    read(glm::ivec3(parts >> Place(bits)));
    if (isOne_)
        return sets_[0];
    const Place above = parts & Place(unit - 1), below = unit - above;
    struct Share {
        std::uint16_t set;
        std::int64_t weight;
    };
    std::array<Share, 8> shares;
    std::size_t count = 0;
    for (int i = 0; i < 8; ++i) {
        const std::int64_t weight =
            (i & 1 ? above.x : below.x) * (i & 2 ? above.y : below.y) * (i & 4 ? above.z : below.z);
        const std::uint16_t set = sets_[static_cast<std::size_t>(i)];
        const auto end = shares.begin() + static_cast<std::ptrdiff_t>(count);
        const auto known = std::find_if(shares.begin(), end, [set](const Share& s) { return s.set == set; });
        if (known != end)
            known->weight += weight;
        else
            shares[count++] = {set, weight};
    }
    const Share& most = *std::max_element(
        shares.begin(), shares.begin() + static_cast<std::ptrdiff_t>(count),
        [](const Share& a, const Share& b) {
            if (a.weight != b.weight)
                return a.weight < b.weight;
            return a.set == 0 || (b.set != 0 && b.set < a.set); // labels before none, then the first
        });
    return most.set;
}

} // namespace tessera
