// bricking/analysis/body/body_box.h: the box of the patient in a CT, without the table. It is found on a
// coarse level of the store, in a fraction of a second at any size of the volume.
//
// The body is what is above kBodyHu and thick. Its scale is R, the largest distance of a voxel to air. A
// morphological opening with a ball of R/kOfThickness separates shells, cloth and objects that touch at an
// edge. Parts that are somewhere as thick as R/kOfThinnestPart stay (arms beside the trunk). Small pieces
// that the opening removed return if they touch what stays (ears, fingers).
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/base/budget.h"

#include <cstddef>
#include <glm/vec3.hpp>

namespace tessera {

constexpr double kBodyHu = -300;        // fat is above -130, cushions and lungs are below -400
constexpr double kBodyOfThickness = 10; // removes shells thinner than a fifth of R
constexpr double kBodyOfThinnestPart = 5;

struct BodyBox {
    glm::dvec3 low{0}, high{0}; // patient space, mm, in tenths; within the volume's own box
    int level = 0;              // that it was found on
    double litres = 0;          // voxels of the body in the box
    double litresLeftOut = 0;   // voxels above kBodyHu that are not body: table, cushions, cloth
};

/// Independent of the number of threads. Values must be in HU. Reads the finest level of at most 2^21
/// samples, or the coarsest. Throws InputError if nothing is above kBodyHu, and if ram cannot hold
/// bodyBoxBytes().
BodyBox findBody(const ChunkSource& source, MemoryBudget& ram);

/// Memory that it takes while it runs.
std::size_t bodyBoxBytes(const VolumeInfo& info);

} // namespace tessera
