// render/geometry/voxel_grid.cpp: see voxel_grid.h.
#include "render/geometry/voxel_grid.h"

#include "render/geometry/shape.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace tessera {
namespace {

/// Faces of boxes that fit the grid lie in the middle of no voxel and between none.
constexpr double kBefore = 2.37;

} // namespace

VoxelGrid gridAround(std::span<const SceneMesh> meshes, int resolution) {
    ShapeBox box;
    for (const SceneMesh& mesh : meshes) {
        box.add(mesh.shape->box().low);
        box.add(mesh.shape->box().high);
    }
    const glm::dvec3 size = box.high - box.low;
    const double longest = std::max({size.x, size.y, size.z});
    VoxelGrid grid;
    if (!(longest >= 0)) // there is nothing
        return grid;
    grid.edgeMm = longest > 0 ? longest / resolution : 1;
    grid.extent = glm::ivec3(glm::ceil(size / grid.edgeMm)) + 5;
    grid.fromPatient = glm::translate(glm::dmat4(1), glm::dvec3(kBefore)) *
                       glm::scale(glm::dmat4(1), glm::dvec3(1 / grid.edgeMm)) *
                       glm::translate(glm::dmat4(1), -box.low);
    return grid;
}

VoxelGrid gridOnLattice(const glm::dmat4& patientFromVoxel, const glm::ivec3& samples, int pitch) {
    return {glm::scale(glm::dmat4(1), glm::dvec3(1.0 / pitch)) * glm::inverse(patientFromVoxel), samples,
            pitch * std::cbrt(std::abs(glm::determinant(glm::dmat3(patientFromVoxel))))};
}

} // namespace tessera
