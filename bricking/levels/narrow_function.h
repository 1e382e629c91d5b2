// bricking/levels/narrow_function.h: compositing of sampled rays (brick_rays.h) under narrow transfer
// functions: features narrower than the change of the value between samples. Lookups at samples would miss
// them, and levels would seem to make no difference. Here the value changes linearly between samples. A
// segment gets the function's mean over the values that it passes, so no feature is too narrow. This is
// pre-integration (K. Engel, M. Kraus, T. Ertl, High-Quality Pre-Integrated Volume Rendering, 2001) without
// attenuation inside the segment. It costs several times as much as lookups, so only such functions use it.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "core/base/volume.h"
#include "core/scene/transfer_function.h"

#include <array>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

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
