// render/labels/set_reader.cpp: see set_reader.h.
#include "render/labels/set_reader.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace tessera {
namespace {

constexpr int kPartBits = 12; // a place counts in parts of 1/4096 voxel

} // namespace

SetReader::SetReader(BrickCache& cache, const VolumeInfo& info, int level, LabelBorders borders,
                     std::span<const std::uint16_t> shown)
    : samples_(cache, info, level, nullptr), level_(level), nearest_(borders == LabelBorders::nearest),
      extent_(info.extentVoxels), shown_(shown) {}

std::uint16_t SetReader::shownAt(double stored) const {
    return shown_[std::min(static_cast<std::size_t>(stored), shown_.size() - 1)];
}

void SetReader::read(const glm::ivec3& first) {
    if (first == first_)
        return;
    first_ = glm::ivec3(INT32_MIN); // until they are read
    std::array<double, 8> stored;
    if (nearest_)
        stored.fill(samples_.at(glm::clamp(first, glm::ivec3(0), samples_.extent() - 1)));
    else
        samples_.cube<2>(first, stored.data());
    std::transform(stored.begin(), stored.end(), sets_.begin(), [this](double v) { return shownAt(v); });
    isOne_ = std::all_of(sets_.begin(), sets_.end(), [this](std::uint16_t set) { return set == sets_[0]; });
    first_ = first;
}

std::uint16_t SetReader::at(const glm::dvec3& place) {
    const int bits = kPartBits + level_; // of a sample
    const std::int64_t unit = std::int64_t{1} << bits;
    Place parts;
    for (int axis = 0; axis < 3; ++axis) {
        // One voxel beyond the volume reads as its outermost; what is no number too.
        const double held = place[axis] > -1 ? std::min(place[axis], extent_[axis] + 1) : -1;
        parts[axis] = std::llround(std::ldexp(held, kPartBits)) - (nearest_ ? 0 : unit / 2);
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
