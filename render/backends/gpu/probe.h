// render/backends/gpu/probe.h: the GPU's field at single points, for tests of the sampler and for picking.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "render/backends/gpu/bindings.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

/// xyz: gradient (stored units per voxel, voxel space), w: value (stored units), per position in voxels.
/// @param features  kFeatureHardware, kFeatureNormalised and kFeatureMixed decide how it is
///     fetched, and those of kGradientFeatures how gradients are taken
std::vector<glm::vec4> probeField(const std::vector<glm::vec3>& positions, std::uint32_t features,
                                  const VolumeInfo& info, const FieldSource& source, MemoryBudget& gpu);

} // namespace tessera
