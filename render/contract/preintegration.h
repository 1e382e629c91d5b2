// render/contract/preintegration.h: integrals of a transfer table that segments of a ray need beside its
// entries. Sums from the first entry on give means over any values. Mean colours include attenuation inside
// the segment, by the values at its two ends. "Place" is a value in units of the table's entries,
// 0 the first.
#pragma once

#include "core/scene/transfer_function.h"

#include <cstddef>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

/// Per bin between two entries, one before the first (number 0) and one after the last, where values are
/// constant. It holds extinction at its start, its rise over the bin, and the integral of extinction from the
/// first entry to the bin's start. The integral is a number and the remainder that float cannot hold of it,
/// so that differences keep their precision.
std::vector<glm::vec4> extinctionBins(const std::vector<glm::vec4>& table);
/// Integrals over places from the first entry to each: rgb of extinction times colour, a of extinction; two
/// vec4 an entry, the number and the remainder that float cannot hold. One more entry at either end.
std::vector<glm::vec4> colourSums(const std::vector<glm::vec4>& table);

/// The mean colour of a segment along which the value goes linearly from one place to another. It is C /
/// alpha with the attenuation inside the segment, for segments of a few lengths. For segments that show
/// nothing it is the limit for no extinction.
class Preintegration2d {
  public:
    static constexpr int kEdge = 256; // places per axis, evenly over the table

    /// No table.
    Preintegration2d() = default;
    /// @param length  of a segment, in the unit of 1 / extinction; layer k is for 2^k of these
    Preintegration2d(const std::vector<glm::vec4>& table, double length, int firstLayer, int layers);

    /// The same for another table. If it has the size of the one before, only pairs of places are computed
    /// between which entries changed; the result is the same but for rounding. Returns how many, of all
    /// layers.
    std::size_t update(const std::vector<glm::vec4>& table);

    int firstLayer() const { return firstLayer_; }
    int layers() const { return layers_; }
    double length() const { return length_; }
    /// [layer][back][front]; rgb.
    const std::vector<glm::vec4>& colours() const { return colours_; }
    static std::size_t bytes(int layers) {
        return static_cast<std::size_t>(layers) * kEdge * kEdge * sizeof(glm::vec4);
    }

  private:
    std::vector<glm::vec4> table_, colours_;
    double length_ = 1;
    int firstLayer_ = 0, layers_ = 0;
};

/// Exact integrals of a table in double, the arbiter of the above.
class TableIntegral {
  public:
    explicit TableIntegral(const std::vector<glm::vec4>& table);
    /// From the first entry to a place of the table: rgb of extinction times colour, a of extinction.
    glm::dvec4 upTo(double place) const;
    /// The place at which the integral of extinction is this; the lowest where there are several.
    double placeOfDepth(double depth) const;
    glm::dvec3 colour(double place) const;

  private:
    const std::vector<glm::vec4>& table_; // outlives this
    std::vector<glm::dvec4> sums_;
};

/// The mean colour that is seen of a segment along which the value goes linearly from one place of the table
/// to another.
glm::dvec3 preintegratedColour(const TableIntegral& integral, double front, double back, double length);

} // namespace tessera
