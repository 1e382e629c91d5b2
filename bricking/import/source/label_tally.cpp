// bricking/import/source/label_tally.cpp: see label_tally.h.
#include "bricking/import/source/label_tally.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tessera {
namespace {

constexpr double kMostEdges = 0.35;          // of the voxels with a label; noise has edges nearly everywhere
constexpr std::uint64_t kLeastVoxels = 4096; // fewer are inconclusive

} // namespace

void LabelTally::see(double value) {
    const auto end = values_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto at = std::lower_bound(values_.begin(), end, value);
    if (at != end && *at == value)
        return;
    if (count_ == kMostLabels || value < 0 || value != std::floor(value)) {
        isOther_ = true;
        return;
    }
    std::copy_backward(at, end, end + 1);
    *at = value;
    ++count_;
}

void LabelTally::add(std::span<const std::byte> stored, ValueType type) {
    if (isOther_)
        return;
    withValueType(type, [&](auto typed) {
        for (std::size_t at = 0; at < stored.size() && !isOther_; at += sizeof typed) {
            const double value = storedValue(type, stored.data() + at);
            const bool isEdge = value != before_;
            if (isEdge || voxels_ == 0)
                see(value);
            ++voxels_;
            inside_ += value > 0;
            edges_ += value > 0 && isEdge;
            before_ = value;
        }
    });
}

std::string LabelTally::remark() const {
    if (isOther_ || count_ < 2 || voxels_ < kLeastVoxels ||
        static_cast<double>(edges_) > kMostEdges * static_cast<double>(inside_))
        return "";
    char text[240];
    std::snprintf(text, sizeof text,
                  "%s (%zu whole values, %.0f to %.0f): drawn as one continuous scale, on which neighbouring "
                  "labels look alike; --isosurface 0.5 shows the outside of all",
                  kLabelMapRemark, count_, values_[0], values_[count_ - 1]);
    return text;
}

} // namespace tessera
