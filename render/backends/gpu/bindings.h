// render/backends/gpu/bindings.h: what programs read, bound to them: a volume, and the tables of a transfer
// function.
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/volume.h"
#include "render/backends/gpu/atlas.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"
#include "render/contract/level_map.h"
#include "render/contract/optics.h"
#include "render/residency/texels.h"

#include <cmath>

namespace tessera {

// Binds a volume to a program: the uniforms and textures of shaders/sampler_field.glsl.

// Of textures and of images alike; of several volumes each has as many.
constexpr GLuint kVoxelUnit = 0, kIndexUnit = 1, kSkippingUnit = 2, kCornerUnit = 3, kFactsUnit = 4,
                 kSurfaceMapUnit = 5, kExtinctionUnit = 6, kColourUnit = 7, kSumsUnit = 8, kLightUnit = 9,
                 kStandingLightUnit = 10, kLabelUnit = 11, // four, of two atlases
    kMostUnits = 15;
static_assert(kMostUnits == kLabelUnit + 4, "those of the next volume begin there");
inline GLuint unitOf(const VolumeUniforms& uniforms, GLuint unit) {
    return unit + (uniforms.number() < 0 ? 0 : kMostUnits * static_cast<GLuint>(uniforms.number()));
}

/// The level map as the shaders read it.
struct LevelTextures {
    GlTexture3d corners, facts;
    LevelTextures(const LevelMap& map, MemoryBudget& gpu)
        : corners(GL_RG32UI, map.cornerGrid(), 8, GL_NEAREST, gpu, "the level map"),
          facts(GL_R32UI, map.bricks, 4, GL_NEAREST, gpu, "the level map") {
        static_assert(sizeof(BrickCorner) == 8, "two words a texel");
        upload(map);
    }
    /// Of the same volume.
    void upload(const LevelMap& map) {
        corners.upload(glm::ivec3(0), map.cornerGrid(), GL_RG_INTEGER, GL_UNSIGNED_INT, map.corners.data());
        facts.upload(glm::ivec3(0), map.bricks, GL_RED_INTEGER, GL_UNSIGNED_INT, map.facts.data());
    }
};

/// The inputs of a field: bricks in an atlas; of mixed levels, with their level map. The objects that it
/// points to must outlive the dispatches.
struct FieldSource {
    const Atlas* atlas = nullptr;
    int level = 0;                           // unless kFeatureMixed
    const LevelMap* map = nullptr;           // kFeatureMixed only
    const LevelTextures* textures = nullptr; // kFeatureMixed only: of map
    const LightAtlas* light = nullptr;       // kFeatureVoxelLight only
    const LabelAtlas* labels = nullptr;      // kFeatureLabels only; of several volumes not all have them
};

inline void bindField(const VolumeUniforms& program, std::uint32_t features, const VolumeInfo& info,
                      const FieldSource& source) {
    const auto unit = [&](GLuint of) { return unitOf(program, of); };
    const auto number = [&](GLuint of) { return static_cast<int>(unit(of)); };
    const bool mixed = (features & kFeatureMixed) != 0;
    TESSERA_CHECK(source.atlas && (!mixed || (source.map && source.textures)));
    source.atlas->values.bind(unit(kVoxelUnit), unit(kIndexUnit));
    program.set("uVoxels", number(kVoxelUnit));
    program.set("uTexels", number(kVoxelUnit));
    program.set("uIndex", number(kIndexUnit));
    program.set("uStoredAsFloats", texelFormat(info.type).normalised ? 0 : 1);
    program.set("uTexelSize", 1.0f / glm::vec3(source.atlas->values.extentTexels()));
    program.set("uLevelExtent", levelExtent(info.extentVoxels, source.level));
    program.set("uSamplesPerVoxel", std::ldexp(1.0f, -source.level));
    program.set("uVoxelsPerSample", std::ldexp(1.0f, source.level));
    program.set("uBrickShift", 5 - source.level);
    program.set("uStoredBias", texelFormat(info.type).bias);
    if ((features & kFeatureVoxelLight) != 0) {
        TESSERA_CHECK(source.light || program.number() >= 0);
        if (source.light)
            source.light->channels().bind(unit(kLightUnit), unit(kStandingLightUnit));
        program.set("uLightTexels", number(kLightUnit));
        program.set("uLightStanding", number(kStandingLightUnit));
    }
    if ((features & kFeatureLabels) != 0) {
        TESSERA_CHECK(source.labels || program.number() >= 0);
        if (source.labels) {
            source.labels->first().bind(unit(kLabelUnit), unit(kLabelUnit + 1));
            source.labels->second().bind(unit(kLabelUnit + 2), unit(kLabelUnit + 3));
        }
        program.set("uLabelTexels", number(kLabelUnit));
        program.set("uLabelStanding", number(kLabelUnit + 1));
        program.set("uMoreLabelTexels", number(kLabelUnit + 2));
        program.set("uMoreLabelStanding", number(kLabelUnit + 3));
    }
    if (!mixed)
        return;
    source.textures->corners.bind(unit(kCornerUnit));
    source.textures->facts.bind(unit(kFactsUnit));
    program.set("uCorners", number(kCornerUnit));
    program.set("uFacts", number(kFactsUnit));
    program.set("uBricks", source.map->bricks);
    program.set("uExtentVoxels", source.map->extentVoxels);
    program.set("uEdgeFunction", static_cast<int>(source.map->edgeFunction));
    program.set("uFinest", static_cast<int>(source.map->finest));
    program.set("uMostStride", source.map->mostStride);
}

// A transfer function's tables on the device, as shaders/march_optics.glsl and march_segment.glsl read them:
// of kFeatureFused in one, for each volume takes textures, else in two.

class FunctionTables {
  public:
    /// Instead of those before, which go first, so that two are never charged.
    /// @param features  kFeaturePreintegrated: those of pre-integration too
    void set(const Optics& optics, std::uint32_t features, MemoryBudget& gpu);
    void bind(const VolumeUniforms& program) const;

  private:
    GlTexelBuffer both_, extinctions_, colours_, sums_;
};

} // namespace tessera
