// render/skipping_binding.h: the map of empty space as shaders/march_skipping.glsl reads it.
#pragma once

#include "render/field_binding.h" // kSkippingUnit
#include "render/gl/objects.h"
#include "render/gl/program.h"
#include "render/occupancy.h"

#include <bit>

namespace tessera {

inline void uploadSkipping(GlTexture3d& texture, const Occupancy& occupancy) {
    static_assert(std::endian::native == std::endian::little, "a texel's low word comes first");
    texture.upload(glm::ivec3(0), occupancy.grid(), GL_RG_INTEGER, GL_UNSIGNED_INT, occupancy.map().data());
}

inline void setSkippingUniforms(const GlProgram& program, const Occupancy& occupancy) {
    program.set("uSkipping", static_cast<int>(kSkippingUnit));
    program.set("uSkippingLast", occupancy.extentVoxels() - 1);
    program.set("uSkippingShift", boxShift(occupancy.scale()));
}

} // namespace tessera
