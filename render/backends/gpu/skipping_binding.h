// render/backends/gpu/skipping_binding.h: uploads and binds the distance map that shaders/march_skipping.glsl
// reads.
#pragma once

#include "core/scene/transfer_function.h"
#include "render/backends/gpu/bindings.h" // kSkippingUnit
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"
#include "render/contract/optics.h"
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

inline void setSkippingUniforms(const VolumeUniforms& program, const Occupancy& occupancy) {
    program.set("uSkipping", static_cast<int>(unitOf(program, kSkippingUnit)));
    program.set("uSkippingLast", occupancy.extentVoxels() - 1);
    program.set("uSkippingShift", boxShift(occupancy.scale()));
}

// The blocks of 2^3 voxels of an occupied cell that can show anything, as bits of the distance map
// (distance_map.h). The device finds them from the samples it holds. Rays then take few samples that show
// nothing. The range of a block is that of the field itself, at the points where trilinear interpolation can
// be extreme: sample centres and the block's faces.

/// GPU memory that refining takes while it runs.
std::size_t refiningBytes(std::size_t tableEntries);

/// True if one picture gains more than refining costs. It compares the times of both on a software device,
/// where a cell costs about as much as sixteen rays gain. A scene that shows most of its volume is better
/// left as it is.
bool refiningPays(const Occupancy& occupancy, std::size_t rays);

/// Writes the bits of all cells where the field is plain interpolation of level 0 (Occupancy::plainCells());
/// elsewhere blocks keep counting as occupied. Needs a map of cells, and the volume in an atlas.
/// @param map  skippingTexture(occupancy)
/// Returns the number of cells that were refined.
std::size_t refineSkipping(const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table,
                           const Optics& optics, std::uint32_t features, const VolumeInfo& info,
                           const FieldSource& source, MemoryBudget& gpu);

} // namespace tessera
