// bricking/import/structures/structure_set.h: contours of a DICOM RT Structure Set (docs/formats.md,
// "Structure sets"; PS3.3, C.8.8.5 and C.8.8.6).
#pragma once

#include "bricking/labels/label_table.h"
#include "core/base/budget.h"

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

enum class ContourForm {
    points, // each by itself
    line,
    ring // the last point is joined to the first one, which is there once
};

struct StructureContour {
    ContourForm form = ContourForm::line;
    std::vector<glm::dvec3> points; // one at least; patient space (LPS), mm
};

struct Structure {
    Label label; // its value is ROINumber, which may be 0
    std::vector<StructureContour> contours;
    /// ReferencedFrameOfReferenceUID (3006,0024), else the only one of the set; "" unknown.
    std::string frameOfReference = {};
};

struct StructureSet {
    std::vector<Structure> structures; // those with contours, ascending by number; one at least
    std::vector<std::string> notes;    // structures without contours, irregular files

    /// Memory of the contours, roughly.
    std::size_t bytes() const {
        constexpr std::size_t kAllocation = 32;
        std::size_t sum = 0;
        for (const Structure& structure : structures)
            for (const StructureContour& contour : structure.contours)
                sum += sizeof contour + kAllocation + contour.points.size() * sizeof(glm::dvec3);
        return sum;
    }
};

/// Reads all structures that have contours.
/// @param ram  is charged for what reading takes and gives, before it is allocated; nothing is left charged
/// Throws InputError naming file, expected and found: for other objects, compressed files, damage,
/// references to structures that are not there, contours whose data are not three finite numbers within
/// 1000000 mm for each of NumberOfContourPoints, no contours at all, too little memory.
StructureSet readStructureSet(const std::filesystem::path& file, MemoryBudget& ram);

} // namespace tessera
