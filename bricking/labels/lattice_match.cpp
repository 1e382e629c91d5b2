// bricking/labels/lattice_match.cpp: see lattice_match.h.
#include "bricking/labels/lattice_match.h"

#include "bricking/labels/label_volume.h" // kSameVoxels

#include <cmath>
#include <glm/matrix.hpp>

namespace tessera {

LatticeMatch latticeMatch(const VolumeInfo& layer, const VolumeInfo& scan) {
    const glm::dmat4 layerFromScan = glm::inverse(layer.patientFromVoxel) * scan.patientFromVoxel;
    LatticeMatch match;
    match.isSame = true;
    unsigned seen = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 step(layerFromScan[axis]);
        int main = 0;
        for (int i = 1; i < 3; ++i)
            if (std::abs(step[i]) > std::abs(step[main]))
                main = i;
        seen |= 1u << main;
        match.axis[static_cast<std::size_t>(axis)] = main;
        match.isFlipped[static_cast<std::size_t>(axis)] = step[main] < 0;
        match.isSame = match.isSame && layer.extentVoxels[main] == scan.extentVoxels[axis];
    }
    match.isSame = match.isSame && seen == 7;
    for (int i = 0; match.isSame && i < 8; ++i) {
        const glm::ivec3 corner = glm::ivec3(i & 1, (i >> 1) & 1, (i >> 2) & 1) * scan.extentVoxels;
        const glm::dvec3 at(layerFromScan * glm::dvec4(glm::dvec3(corner), 1));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int own = corner[static_cast<int>(axis)];
            const double expected = match.isFlipped[axis] ? layer.extentVoxels[match.axis[axis]] - own : own;
            match.isSame = match.isSame && std::abs(at[match.axis[axis]] - expected) <= kSameVoxels;
        }
    }
    return match;
}

} // namespace tessera
