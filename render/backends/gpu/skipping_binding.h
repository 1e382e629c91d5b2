// render/backends/gpu/skipping_binding.h: uploads and binds the distance map
// that shaders/march_skipping.glsl reads.
#pragma once

#include "render/backends/gpu/field_binding.h" // kSkippingUnit
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"
#include "render/empty_space/occupancy.h"

#include <bit>

namespace tessera {

/// @param slices  occupancy.changedSince() of the texture's content
inline void uploadSkipping(GlTexture3d& texture, const Occupancy& occupancy, const ChangedSlices& slices) {
    static_assert(std::endian::native == std::endian::little, "a texel's low word comes first");
    if (!slices.any())
        return;
    const glm::ivec3 grid = occupancy.grid();
    texture.upload({0, 0, slices.first}, {grid.x, grid.y, slices.end - slices.first}, GL_RG_INTEGER,
                   GL_UNSIGNED_INT, occupancy.map().data() + linearIndex({0, 0, slices.first}, grid));
}

inline void setSkippingUniforms(const GlProgram& program, const Occupancy& occupancy) {
    program.set("uSkipping", static_cast<int>(kSkippingUnit));
    program.set("uSkippingLast", occupancy.extentVoxels() - 1);
    program.set("uSkippingShift", boxShift(occupancy.scale()));
}

} // namespace tessera
