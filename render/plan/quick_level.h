// render/plan/quick_level.h: the level of first pictures.
#pragma once

#include <glm/vec3.hpp>

namespace tessera {

/// The finest level of at most 128 samples along every axis: a picture of it takes about a tenth of the time.
int quickLevel(const glm::ivec3& extentVoxels);

} // namespace tessera
