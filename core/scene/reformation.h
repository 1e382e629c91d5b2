// core/scene/reformation.h: a curved planar reformation, row by row: the places of a volume that a picture
// along a line, or across it, shows (docs/reformations.md). core/animation/reformed_line.h makes it of a
// line.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// A straight line through the volume. mm, patient space; directions are unit vectors at right angles.
struct ReformedRow {
    glm::dvec3 at{0};            // where the line meets it
    glm::dvec3 across{1, 0, 0};  // to the right of the picture
    glm::dvec3 towards{0, 0, 1}; // the viewer: along it a slab is thick
    double lineMm = 0;           // from the picture's left edge to `at`
    double alongMm = 0;          // from the line's beginning to `at`, along it
    /// From `at` along `across`: beyond them the row crosses its neighbours.
    double lowMm = -std::numeric_limits<double>::infinity(), highMm = std::numeric_limits<double>::infinity();

    /// @param mm  from the picture's left edge
    glm::dvec3 place(double mm) const { return at + (mm - lineMm) * across; }
    bool folds(double mm) const { return mm - lineMm <= lowMm || mm - lineMm >= highMm; }
};

/// One picture. Pixels are square.
struct Reformation {
    std::vector<ReformedRow> rows; // from top to bottom, in the middle of what they stand for
    int columns = 0;
    int samples = 1; // along either side of a pixel: as many rows a pixel
    double mmPerPixel = 1;
    bool isSection = false; // at right angles to the line
    glm::ivec2 from{0};     // its upper left, in an image of several

    glm::ivec2 size() const { return {columns, static_cast<int>(rows.size()) / samples}; }
};

/// Pixels between pictures that lie side by side.
constexpr int kReformedGap = 8;

} // namespace tessera
