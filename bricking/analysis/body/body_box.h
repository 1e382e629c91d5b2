// bricking/analysis/body/body_box.h: the box of the patient in a CT, without the table. It is found on a
// coarse level of the store, so it takes a fraction of a second whatever the volume's size.
//
// Body is what is above kBodyHu and thick. Its scale is R, the largest distance of a voxel to air. An opening
// with a ball of R/kOfThickness parts shells, cloth and what touches by an edge. Of the parts left, those
// stay that are somewhere as thick as R/kOfThinnestPart (arms beside the trunk). What the opening took comes
// back where it is small (ears, fingers) and touches what stays.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/base/budget.h"

#include <cstddef>
#include <glm/vec3.hpp>

namespace tessera {

constexpr double kBodyHu = -300;        // fat is above -130, cushions and lungs are below -400
constexpr double kBodyOfThickness = 10; // a shell that is thinner than a fifth of R goes
constexpr double kBodyOfThinnestPart = 5;

struct BodyBox {
    glm::dvec3 low{0}, high{0}; // patient space, mm, in tenths; within the volume's own box
    int level = 0;              // that it was found on
    double litres = 0;          // of what is in it and body
    double litresLeftOut = 0;   // above kBodyHu and no body: table, cushions, cloth
};

/// The same whatever the threads. Values must be in HU. Reads the finest level of at most 2^21 samples, or
/// the coarsest.
/// Throws InputError where nothing is above kBodyHu, and where ram cannot hold bodyBoxBytes().
BodyBox findBody(const ChunkSource& source, MemoryBudget& ram);

/// Memory that it takes while it lasts.
std::size_t bodyBoxBytes(const VolumeInfo& info);

} // namespace tessera
