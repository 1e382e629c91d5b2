// bricking/import/source/voxel_tally.cpp: see voxel_tally.h.
#include "bricking/import/source/voxel_tally.h"

#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace tessera {
namespace {

constexpr int kDigits = 2; // of a change
constexpr std::size_t kMostLabels = 256;
constexpr double kMostEdges = 0.35;          // of the voxels with a label; noise has edges nearly everywhere
constexpr std::uint64_t kLeastVoxels = 4096; // fewer are inconclusive

} // namespace

void LabelTally::see(double value) {
    const auto at = std::lower_bound(values.begin(), values.end(), value);
    if (at != values.end() && *at == value)
        return;
    if (values.size() == kMostLabels || value < 0 || value != std::floor(value)) {
        isOther = true;
        return;
    }
    values.insert(at, value);
}

void LabelTally::add(std::span<const std::byte> stored, ValueType type, std::size_t rowValues) {
    const std::size_t rowBytes = rowValues * bytesPerValue(type);
    for (std::size_t row = 0; row < stored.size() && !isOther; row += rowBytes) {
        double before = storedValue(type, stored.data() + row);
        see(before);
        ++voxels;
        for (std::size_t at = row + bytesPerValue(type); at < row + rowBytes && !isOther;
             at += bytesPerValue(type)) {
            const double value = storedValue(type, stored.data() + at);
            const bool isEdge = value != before;
            if (isEdge)
                see(value);
            ++voxels;
            inside += value > 0;
            edges += value > 0 && isEdge;
            before = value;
        }
    }
}

void LabelTally::add(const LabelTally& part) {
    isOther = isOther || part.isOther;
    for (std::size_t i = 0; i < part.values.size() && !isOther; ++i)
        see(part.values[i]);
    voxels += part.voxels;
    inside += part.inside;
    edges += part.edges;
}

std::string LabelTally::remark() const {
    if (isOther || values.size() < 2 || voxels < kLeastVoxels ||
        static_cast<double>(edges) >= kMostEdges * static_cast<double>(inside)) // also of rows of one voxel
        return "";
    char text[240];
    std::snprintf(text, sizeof text,
                  "%s (%zu whole values, %.0f to %.0f): drawn as one continuous scale, on which neighbouring "
                  "labels look alike; --isosurface 0.5 shows the outside of all",
                  kLabelMapRemark, values.size(), values.front(), values.back());
    return text;
}

void RoundingTally::add(const RoundingTally& part) {
    whole += part.whole;
    real += part.real;
    most = std::max(most, part.most);
    mostPart = std::max(mostPart, part.mostPart);
}

std::string RoundingTally::note() const {
    constexpr double kRounding = 1.0 / (1 << 24); // the largest share, but of values near 0
    if (!any())
        return "";
    std::string text = whole > 0
                           ? std::to_string(whole) +
                                 " whole numbers beyond 2^24 rounded to float32: labels may have become one"
                           : "values are kept as float32, which changed " + std::to_string(real) + " of them";
    text += std::string(whole > 0 ? "; " : ": ") + "the largest change is " + numberText(most, kDigits);
    if (mostPart <= kRounding)
        text += ", 1 in 2^" + std::to_string(static_cast<int>(std::floor(-std::log2(mostPart)))) +
                " of the value";
    return text;
}

void VoxelTally::add(const VoxelTally& part) {
    labels.add(part.labels);
    rounded.add(part.rounded);
}

std::vector<std::string> VoxelTally::notes() const {
    std::vector<std::string> lines;
    if (std::string remark = labels.remark(); !remark.empty())
        lines.push_back(std::move(remark));
    if (std::string loss = rounded.note(); !loss.empty())
        lines.push_back(std::move(loss));
    return lines;
}

} // namespace tessera
