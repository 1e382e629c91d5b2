// render/backends/gpu/light_atlas.h: the light of bricks' samples on the GPU. One texture is like the atlas
// of values, with a component a channel. Another has the light of bricks that stand as one value.
#pragma once

#include "core/base/budget.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/light/light_plane.h"
#include "render/residency/pages.h"
#include "render/residency/plane.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace tessera {

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
