// bricking/import/structures/structure_lines.h: the contours of a structure as lines through points.
#pragma once

#include "bricking/import/structures/structure_set.h"
#include "core/base/budget.h"

#include <cstdint>
#include <vector>

namespace tessera {

struct StructureLines {
    std::vector<glm::dvec3> points;  // of all lines, one after another; patient space (LPS), mm
    std::vector<std::uint32_t> ends; // of each line: one past its last point
    Charge charge;                   // of the lists
};

/// A ring ends at its first point again, which is there twice then; each of single points is a line.
/// @param ram  is charged for the lists, before they are allocated
inline StructureLines linesOf(const Structure& structure, MemoryBudget& ram) {
    std::size_t count = 0, lines = 0;
    for (const StructureContour& contour : structure.contours) {
        count += contour.points.size() + 1;
        lines += contour.form == ContourForm::points ? contour.points.size() : 1;
    }
    StructureLines out;
    out.charge = ram.charge(count * sizeof(glm::dvec3) + lines * sizeof(std::uint32_t), "contours");
    out.points.reserve(count);
    out.ends.reserve(lines);
    const auto endLine = [&] { out.ends.push_back(static_cast<std::uint32_t>(out.points.size())); };
    for (const StructureContour& contour : structure.contours) {
        for (const glm::dvec3& point : contour.points) {
            out.points.push_back(point);
            if (contour.form == ContourForm::points)
                endLine();
        }
        if (contour.form == ContourForm::ring && contour.points.size() > 2)
            out.points.push_back(contour.points.front());
        if (contour.form != ContourForm::points)
            endLine();
    }
    return out;
}

} // namespace tessera
