// render/backends/gpu/atlas.h: bricks on the GPU: the atlas of values and that of their light.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/light/light_plane.h"
#include "render/residency/brick_residency.h"
#include "render/residency/pages.h"
#include "render/residency/plane.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

namespace tessera {

// Values of bricks on the GPU: pages in one 3D texture without duplicated border voxels. The index texture
// holds the entries of residency/brick_residency.h.

/// OpenGL's name of texels of a type.
struct GlTexels {
    GLenum internal, external, type;
};
GlTexels glTexels(ValueType type);

class AtlasPlane : public Plane {
  public:
    /// Allocates pages and the index.
    AtlasPlane(const VolumeInfo& info, std::size_t pages, const TextureLimits& limits, MemoryBudget& gpu,
               MemoryBudget& ram);

    void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
    void finish() override;
    void publish(std::span<const BrickEntry> entries) override;

    void bind(GLuint voxelUnit, GLuint indexUnit) const;
    const glm::ivec3& extentTexels() const { return voxels_.extent(); }

  private:
    ValueType type_;
    MemoryBudget& ram_;
    GlTexture3d voxels_, index_;
    Charge stagingCharge_; // one brick as texels, while bricks come
    std::vector<std::byte> staging_;
};

/// Bricks on the GPU: the plane of their values, and who is where.
struct Atlas {
    AtlasPlane values;
    BrickResidency bricks;
    /// @param beside  planes that hold more of the bricks; they outlive this
    Atlas(const VolumeInfo& info, const Selection& selection, std::size_t pages, const TextureLimits& limits,
          MemoryBudget& gpu, MemoryBudget& ram, std::vector<Plane*> beside = {})
        : values(info, pages, limits, gpu, ram),
          bricks(info, selection, pages, limits, with(values, std::move(beside)), ram) {}

  private:
    static std::vector<Plane*> with(Plane& values, std::vector<Plane*> planes) {
        planes.insert(planes.begin(), &values);
        return planes;
    }
};

// The light of bricks' samples on the GPU. One texture is like the atlas of values, with a component a
// channel. Another has the light of bricks that stand as one value.

class LightAtlas {
  public:
    /// @param pages, limits  as the atlas of values has them
    /// The scene outlives it, and does not move.
    LightAtlas(const FramePlan& scene, std::size_t pages, const TextureLimits& limits, int threads,
               MemoryBudget& gpu);

    /// For the BrickResidency.
    LightPlane& plane() { return plane_; }
    /// Light as things are; before rays are drawn.
    void settle(Work& work) { plane_.settle(work); }
    SceneLight& light() { return light_; }
    LightReport report() const { return light_.report(texels_.bytes() + standing_.bytes()); }
    void bind(GLuint lightUnit, GLuint standingUnit) const;

  private:
    /// Takes one component of texels; the last one sends them.
    class Channel : public Plane {
      public:
        Channel(LightAtlas& atlas, int number) : atlas_(atlas), number_(number) {}
        void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
        void publish(std::span<const BrickEntry> entries) override;

      private:
        LightAtlas& atlas_;
        int number_;
    };
    std::vector<Plane*> makeChannels();

    SceneLight light_;
    int components_; // of texels
    GlTexture3d texels_, standing_;
    std::vector<std::uint16_t> staging_, standingStaging_;
    std::vector<std::unique_ptr<Channel>> channels_;
    LightPlane plane_;
};

} // namespace tessera
