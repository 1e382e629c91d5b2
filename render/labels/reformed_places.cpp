// render/labels/reformed_places.cpp: see reformed_places.h.
#include "render/labels/reformed_places.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

ReformedPlaces::ReformedPlaces(const Reformation& picture, const VolumeInfo& info)
    : picture_(picture), voxelFromPatient_(glm::inverse(info.patientFromVoxel)) {
    size = picture.size();
}

std::optional<glm::dvec3> ReformedPlaces::at(const glm::dvec2& pixel) const {
    const std::vector<ReformedRow>& rows = picture_.rows;
    const double mm = pixel.x * picture_.mmPerPixel, last = static_cast<double>(rows.size()) - 1,
                 y = pixel.y * picture_.samples - 0.5; // rows
    const auto above = static_cast<std::size_t>(std::clamp(std::floor(y), 0.0, std::max(last - 1, 0.0)));
    const ReformedRow &upper = rows[above], &lower = rows[std::min(above + 1, rows.size() - 1)];
    const double share = y - static_cast<double>(above); // beyond the first and the last row they go on
    if ((share < 0.5 ? upper : lower).folds(mm))
        return std::nullopt;
    const glm::dvec3 place = glm::mix(upper.place(mm), lower.place(mm), share);
    return glm::dvec3(voxelFromPatient_ * glm::dvec4(place, 1));
}

} // namespace tessera
