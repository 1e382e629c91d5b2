// render/backends/gpu/marched_volume.h: a volume of the GPU ray caster, one or several in a program: its maps
// of empty space and its function's tables on the device, and its uniforms (OF_VOLUME in the shaders).
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "render/backends/gpu/bindings.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"
#include "render/contract/optics.h"
#include "render/empty_space/occupancy.h"
#include "render/empty_space/value_bounds.h"

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <span>

namespace tessera {

/// What rays go through. All outlives the march.
struct VolumeToMarch {
    const VolumeInfo* info = nullptr;
    const Optics* optics = nullptr;
    const Occupancy* occupancy = nullptr; // null: nothing is skipped, or bounds say what (March::setBounds())
    MemoryBudget* gpu = nullptr;          // for its maps and tables
    glm::dmat4 fromLattice{1};            // of several: its voxels from places of the rays' lattice
    double unitMm = 1;                    // of several: unit distance of its function
    std::span<const leaf::CutSlab> cuts = {}; // of several: of it alone
};

class MarchedVolume {
  public:
    explicit MarchedVolume(const VolumeToMarch& of);

    const VolumeToMarch& of() const { return of_; }
    std::size_t bricks() const;

    /// Once a program is compiled: all that stays as it is.
    /// @param firstWanted, firstCut  of several: the place of its bricks, and slabs, among those of all
    void introduce(const VolumeUniforms& uniforms, std::size_t firstWanted, std::size_t firstCut) const;
    /// The function's tables and numbers; the tables before go first.
    void setFunction(const VolumeUniforms& uniforms, std::uint32_t features, const Optics& optics);
    /// The lights' numbers, of kFeatureLights.
    static void setLights(const VolumeUniforms& uniforms, const Optics& optics);

    /// The occupancy that this was made with changed.
    void takeOccupancy(const Occupancy& occupancy);
    void setSurfaceMap(const Occupancy& surfaces);
    void setBounds(const ValueBounds& bounds);
    const GlTexture3d& skippingMap() const { return skipping_; }
    const GlTexture3d& surfaceMap() const { return surfaceMap_; }

    /// Before rays are cast: all textures.
    void bind(const VolumeUniforms& uniforms, std::uint32_t features, const FieldSource& source) const;

  private:
    VolumeToMarch of_;
    FunctionTables tables_;
    GlTexture3d skipping_, surfaceMap_, brickBounds_, cellBounds_;
    bool boundsOfCells_ = false;        // cells have some too
    std::uint64_t skippingVersion_ = 0; // of the occupancy that the texture holds; 0: none
};

} // namespace tessera
