// render/backends/gpu/atlas_plane.h: values of bricks on the GPU: pages in one 3D texture without duplicated
// border voxels. The index texture holds the entries of residency/brick_residency.h.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/residency/brick_residency.h"
#include "render/residency/pages.h"
#include "render/residency/plane.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

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

} // namespace tessera
