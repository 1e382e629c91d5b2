// render/backends/gpu/atlas.h: bricks on the GPU: the atlas of values and that of their light.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/labels/label_plane.h"
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

/// Planes of 16-bit samples beside the values, as components of one texture like the atlas of values. Another
/// texture has the samples of bricks that stand as one value.
class ChannelAtlas {
  public:
    /// @param channels  one to four; three take the memory of four
    /// @param pages, limits  as the atlas of values has them
    ChannelAtlas(const VolumeInfo& info, int channels, std::size_t pages, const TextureLimits& limits,
                 const char* what, MemoryBudget& gpu);
    ChannelAtlas(const ChannelAtlas&) = delete;
    ChannelAtlas& operator=(const ChannelAtlas&) = delete;

    /// A plane a channel. All get a brick in order; the last one sends it.
    std::vector<Plane*> planes() const;
    std::size_t bytes() const { return texels_.bytes() + standing_.bytes(); }
    void bind(GLuint unit, GLuint standingUnit) const;

  private:
    class Channel : public Plane {
      public:
        Channel(ChannelAtlas& atlas, int number) : atlas_(atlas), number_(number) {}
        void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
        void publish(std::span<const BrickEntry> entries) override;

      private:
        ChannelAtlas& atlas_;
        int number_;
    };

    int components_; // of texels
    GlTexture3d texels_, standing_;
    std::vector<std::uint16_t> staging_, standingStaging_;
    std::vector<std::unique_ptr<Channel>> channels_;
};

/// The light of bricks' samples on the GPU.
class LightAtlas {
  public:
    /// The scene outlives it, and does not move.
    LightAtlas(const FramePlan& scene, std::size_t pages, const TextureLimits& limits, int threads,
               MemoryBudget& gpu);

    /// For the BrickResidency.
    LightPlane& plane() { return plane_; }
    /// Light as things are; before rays are drawn.
    void settle(Work& work) { plane_.settle(work); }
    SceneLight& light() { return light_; }
    LightReport report() const { return light_.report(channels_.bytes()); }
    const ChannelAtlas& channels() const { return channels_; }

  private:
    SceneLight light_;
    ChannelAtlas channels_;
    LightPlane plane_;
};

/// The labels' factors of bricks' samples on the GPU: the first four channels in one atlas, others in a
/// second.
class LabelAtlas {
  public:
    /// labels outlive it.
    LabelAtlas(const DrawnLabels& labels, const VolumeInfo& info, std::size_t pages,
               const TextureLimits& limits, MemoryBudget& gpu);

    /// For the BrickResidency.
    LabelPlane& plane() { return plane_; }
    const ChannelAtlas& first() const { return first_; }
    /// The first one, where four suffice.
    const ChannelAtlas& second() const { return second_ ? *second_ : first_; }

  private:
    std::vector<Plane*> planes() const;

    ChannelAtlas first_;
    std::unique_ptr<ChannelAtlas> second_;
    LabelPlane plane_;
};

} // namespace tessera
