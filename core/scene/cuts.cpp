// core/scene/cuts.cpp: see cuts.h.
#include "core/scene/cuts.h"

#include "core/base/error.h"
#include "core/base/magnitude.h"

#include <cmath>

namespace tessera {

/// Of a picture's width or height: beyond, edges of an outline run along one another.
constexpr double kFarthestShare = 1e9;

void checkBox(const CropBox& box, const std::string& where) {
    checkPlace(box.low, "a box's lower end", where);
    checkPlace(box.high, "a box's upper end", where);
    for (int axis = 0; axis < 3; ++axis)
        if (!(box.low[axis] < box.high[axis]))
            throw badFile(where, "a box whose lower end lies below its upper end along every axis",
                          shownNumber(box.low[axis]) + " to " + shownNumber(box.high[axis]));
}

void checkPlane(const CutPlane& plane, const std::string& where) {
    checkPlace(plane.point, "a point", where);
    checkDirection(plane.normal, "a normal", where);
}

void checkScissors(const Scissors& scissors, const std::string& where) {
    scissors.camera.validate(where);
    if (!(scissors.aspect > 1 / kFarthestShare && scissors.aspect < kFarthestShare))
        throw badFile(where, "a positive aspect, width / height", shownNumber(scissors.aspect));
    if (scissors.outline.size() < 3 || scissors.outline.size() > Cuts::kMostPoints)
        throw badFile(where, "an outline of 3 to " + std::to_string(Cuts::kMostPoints) + " points",
                      std::to_string(scissors.outline.size()));
    for (const glm::dvec2& p : scissors.outline)
        if (!(std::abs(p.x) < kFarthestShare && std::abs(p.y) < kFarthestShare))
            throw badFile(where, "an outline within 1e9 widths of the picture", "one that is not");
}

} // namespace tessera
