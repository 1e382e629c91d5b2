// render/skipping_binding.h: the map of empty space as shaders/march_skipping.glsl reads it.
#pragma once

#include "render/field_binding.h" // kSkippingUnit
#include "render/gl/objects.h"
#include "render/gl/program.h"
#include "render/occupancy.h"

#include <bit>

namespace tessera {

inline GlTexture3d skippingTexture(const Occupancy& occupancy, Ledger& gpu) {
    GlTexture3d texture(GL_RG32UI, occupancy.grid(), sizeof(SkippingTexel), GL_NEAREST, gpu,
                        "the map of empty space");
    static_assert(std::endian::native == std::endian::little, "a texel's low word comes first");
    texture.upload(glm::ivec3(0), occupancy.grid(), GL_RG_INTEGER, GL_UNSIGNED_INT, occupancy.map().data());
    return texture;
}

inline void setSkippingUniforms(const GlProgram& program, const Occupancy& occupancy) {
    program.set("uSkipping", static_cast<int>(kSkippingUnit));
    program.set("uSkippingLast", occupancy.extentVoxels() - 1);
    program.set("uSkippingShift", boxShift(occupancy.scale()));
}

} // namespace tessera
