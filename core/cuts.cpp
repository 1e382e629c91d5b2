// core/cuts.cpp: see cuts.h.
#include "core/cuts.h"

#include "core/error.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

bool isFinite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

} // namespace

void checkBox(const CropBox& box, const std::string& where) {
    for (int axis = 0; axis < 3; ++axis)
        if (!isFinite(box.low) || !isFinite(box.high) || !(box.low[axis] < box.high[axis]))
            throw badFile(where, "a box whose lower end lies below its upper end along every axis",
                          std::to_string(box.low[axis]) + " to " + std::to_string(box.high[axis]));
}

void checkPlane(const CutPlane& plane, const std::string& where) {
    const double length = glm::length(plane.normal);
    if (!isFinite(plane.point) || !std::isfinite(length) || !(length > 0))
        throw badFile(where, "a point and a normal that is not 0",
                      "a normal of length " + std::to_string(length));
}

void checkScissors(const Scissors& scissors, const std::string& where) {
    scissors.camera.validate(where);
    if (!(scissors.aspect > 0) || !std::isfinite(scissors.aspect))
        throw badFile(where, "a positive aspect, width / height", std::to_string(scissors.aspect));
    if (scissors.outline.size() < 3 || scissors.outline.size() > Cuts::kMostPoints)
        throw badFile(where, "an outline of 3 to " + std::to_string(Cuts::kMostPoints) + " points",
                      std::to_string(scissors.outline.size()));
    for (const glm::dvec2& p : scissors.outline)
        if (!std::isfinite(p.x) || !std::isfinite(p.y))
            throw badFile(where, "an outline of finite numbers", "one that is not");
}

} // namespace tessera
