// render/field_binding.h: gives a program the volume: the uniforms and textures of
// shaders/sampler_field.glsl.
#pragma once

#include "core/brick.h"
#include "core/error.h"
#include "core/volume.h"
#include "render/atlas.h"
#include "render/features.h"
#include "render/gl/program.h"

#include <cmath>

namespace tessera {

constexpr GLuint kVoxelUnit = 0, kIndexUnit = 1, kDistanceUnit = 2;

/// Exactly one of atlas (kFeatureBricked) and wholeLevel is read; it must outlive the dispatches.
inline void bindField(const GlProgram& program, std::uint32_t features, const VolumeInfo& info, int level,
                      const Atlas* atlas, const GlTexture3d* wholeLevel) {
    const bool bricked = (features & kFeatureBricked) != 0;
    TESSERA_CHECK(bricked ? atlas != nullptr : wholeLevel != nullptr);
    if (bricked)
        atlas->bind(kVoxelUnit, kIndexUnit);
    else
        wholeLevel->bind(kVoxelUnit);
    program.set("uVoxels", static_cast<int>(kVoxelUnit));
    program.set("uIndex", static_cast<int>(kIndexUnit));
    program.set("uTexelSize", 1.0f / glm::vec3(bricked ? atlas->extentTexels() : wholeLevel->extent()));
    program.set("uLevelExtent", levelExtent(info.extentVoxels, level));
    program.set("uSamplesPerVoxel", std::ldexp(1.0f, -level));
    program.set("uVoxelsPerSample", std::ldexp(1.0f, level));
    program.set("uBrickShift", 5 - level);
    program.set("uStoredBias", texelFormat(info.type).bias);
}

} // namespace tessera
