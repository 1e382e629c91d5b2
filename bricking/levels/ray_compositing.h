// bricking/levels/ray_compositing.h: compositing of sampled rays (brick_rays.h) under a transfer function:
// gradient opacity, tables of segments, and narrow functions.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "core/base/volume.h"
#include "core/scene/transfer_function.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

// Gradient opacity of sampled rays (brick_rays.h). A ray has the change of the value along itself at every
// level. The change across the ray is assumed equal, as in the mean over directions. So predicted errors
// include gradients that coarser levels lose.

/// Factors of a ray's segments.
/// @param perMm  its points, per mm
/// @param codes  of the segments' middles at the level
/// @param valuePerCode  physical units, not negative
void gradedFactors(const GradientOpacity& perMm, std::span<const std::uint8_t> codes, int level,
                   double valuePerCode, double segmentMm, std::span<double> factors);

// Tables of the contribution of a sampled ray's segment (brick_rays.h) under a transfer function, by nearest
// lookup of its value. There is one table for each of the few lengths of segments.

/// Number of segments of a composited ray. Fields of levels 2 to 5 are nearly linear between their few
/// samples, so segments between are interpolated. The function may change faster than the field, and levels
/// are comparable only with equal segments. Coarse levels with their large errors need that less.
constexpr std::array<int, kLevelCount> kSegments = {16, 16, 16, 8, 8, 8};

/// Length of a segment of a row, in mm.
/// @param border  in the last brick along the axis
inline double segmentMm(const VolumeInfo& info, int axis, bool border, int level) {
    const int rest = info.extentVoxels[axis] % kBrickExtent;
    const int voxels = border && rest > 0 ? rest : kBrickExtent;
    return info.spacingMm()[axis] * voxels / kSegments[static_cast<std::size_t>(level)];
}

/// The contribution of a segment of one length: colour times opacity, and transmittance. Also any four
/// numbers.
using Added = float __attribute__((vector_size(16)));

/// The function, resampled for nearest lookups. For the usual tables of 256 and 512 entries, 4096 entries are
/// at most an eighth of the table's step. Larger tables keep their size, up to what stays in a cache.
class SegmentTables {
  public:
    static constexpr std::size_t kMostEntries = 16384;
    static constexpr std::size_t kMostBytes = 18 * kMostEntries * sizeof(Added); // 3 axes, 2 rests, 3 lengths
    SegmentTables(const TransferTable& table, const VolumeInfo& info)
        : size_(std::clamp<std::size_t>(std::bit_ceil(table.entries.size()), 4096, kMostEntries)) {
        const double entries = static_cast<double>(table.entries.size() - 1);
        const double first = table.firstValue, span = entries / static_cast<double>(table.entriesPerValue);
        // index = round((slope * stored + intercept - first) / span * (size - 1))
        const double scale = static_cast<double>(size_ - 1) / span;
        perStored_ = info.rescaleSlope * scale;
        atZero_ = (info.rescaleIntercept - first) * scale;
        for (int axis = 0; axis < 3; ++axis)
            for (const bool border : {false, true})
                for (int level = 0; level < kLevelCount; ++level)
                    tables_[slot(axis, border, level)] =
                        tableFor(table, segmentMm(info, axis, border, level));
    }
    /// Index of a value in any of the tables, before rounding and clamping: a * stored + b.
    double perStored() const { return perStored_; }
    double atZero() const { return atZero_; }
    std::size_t size() const { return size_; }
    const Added* at(int axis, bool border, int level) const {
        return made_[tables_[slot(axis, border, level)]].data();
    }

  private:
    static std::size_t slot(int axis, bool border, int level) {
        return static_cast<std::size_t>((axis * 2 + (border ? 1 : 0)) * kLevelCount + level);
    }
    /// Index of the table of a length; equal lengths share one.
    std::size_t tableFor(const TransferTable& table, double lengthMm) {
        for (std::size_t i = 0; i < lengths_.size(); ++i)
            if (std::abs(lengths_[i] - lengthMm) <= 1e-9 * lengthMm)
                return i;
        std::vector<Added> made(size_);
        for (std::size_t i = 0; i < size_; ++i) {
            const double at = static_cast<double>(i) * static_cast<double>(table.entries.size() - 1) /
                              static_cast<double>(size_ - 1);
            const std::size_t left = std::min(static_cast<std::size_t>(at), table.entries.size() - 2);
            const glm::vec4 a = table.entries[left], b = table.entries[left + 1];
            const glm::vec4 e = a + static_cast<float>(at - static_cast<double>(left)) * (b - a);
            const float alpha = static_cast<float>(-std::expm1(-static_cast<double>(e.a) * lengthMm));
            made[i] = Added{e.r * alpha, e.g * alpha, e.b * alpha, 1 - alpha};
        }
        lengths_.push_back(lengthMm);
        made_.push_back(std::move(made));
        return made_.size() - 1;
    }

    std::size_t size_;
    double perStored_ = 0, atZero_ = 0;
    std::array<std::size_t, std::size_t{6 * kLevelCount}> tables_{};
    std::vector<double> lengths_;
    std::vector<std::vector<Added>> made_;
};

// Compositing of sampled rays (brick_rays.h) under narrow transfer functions: features narrower than the
// change of the value between samples. Lookups at samples would miss them, and levels would seem to make no
// difference. Here the value changes linearly between samples. A segment gets the function's mean over the
// values that it passes, so no feature is too narrow. This is pre-integration (K. Engel, M. Kraus, T. Ertl,
// High-Quality Pre-Integrated Volume Rendering, 2001) without attenuation inside the segment. It costs
// several times as much as lookups, so only such functions use it.

/// A function's integral over values, in units of table entries from the first one; constant beyond the
/// outermost entries.
class FunctionSums {
  public:
    explicit FunctionSums(const TransferTable& table); // which must outlive it
    explicit FunctionSums(TransferTable&& table) = delete;
    /// rgb: colour times extinction; a: extinction, 1/mm.
    glm::dvec4 at(double place) const;
    /// From place 0; linear between entries.
    glm::dvec4 upTo(double place) const;
    double lastPlace() const { return static_cast<double>(upTo_.size() - 1); }

  private:
    glm::dvec4 entry(std::size_t i) const {
        const glm::vec4& e = table_.entries[i];
        return {glm::dvec3(e) * static_cast<double>(e.a), static_cast<double>(e.a)};
    }

    const TransferTable& table_;
    std::vector<glm::dvec4> upTo_;
};

/// Share of the function's extinction that moves when the function is averaged over `width` entries. It is 0
/// for one that changes little over that width, up to 2 for far narrower features. 0 for an invisible
/// function.
double narrowness(const FunctionSums& sums, double width);

/// True if lookups at samples are too sparse: the mean narrowness over bricks with rays, at 1/64 of the range
/// of a brick's samples, is above a quarter.
/// @param ranges  hi - lo of parts of rays, stored units
bool isNarrow(const FunctionSums& sums, const TransferTable& table, const VolumeInfo& info,
              std::span<const float> ranges);

/// Composites rays of one part.
class NarrowCompositor {
  public:
    /// sums must outlive this.
    NarrowCompositor(const FunctionSums& sums, const TransferTable& table, const VolumeInfo& info);
    void setPart(const BrickRayPart& part);
    /// Colour on black, and transmittance as the last component.
    /// @param codes  of the segments' middles, front to back
    /// @param factors  on their extinctions; none: 1
    glm::dvec4 composite(std::span<const std::uint8_t> codes, double segmentMm,
                         std::span<const double> factors = {}) const;

  private:
    static constexpr int kPlaces = 2 * 255 + 1; // half codes
    glm::dvec4 mean(int from, int to) const;    // half codes

    const FunctionSums& sums_;
    double perStored_ = 0, atZero_ = 0; // place = perStored_ * stored + atZero_
    std::array<double, kPlaces> places_{};
    std::array<glm::dvec4, kPlaces> upTo_{};
};

} // namespace tessera
