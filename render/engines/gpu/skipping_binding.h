// render/engines/gpu/skipping_binding.h: the map of empty space as shaders/march_skipping.glsl reads it.
#pragma once

#include "render/empty_space/occupancy.h"
#include "render/engines/gpu/field_binding.h" // kSkippingUnit
#include "render/engines/gpu/gl/objects.h"
#include "render/engines/gpu/gl/program.h"

#include <bit>

namespace tessera {

/// @param slices  occupancy.changedSince() of what the texture holds
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
    program.set("uSkippingGrid", occupancy.grid());
    program.set("uSkippingShift", boxShift(occupancy.scale()));
}

/// Which sub-blocks of 1/2 x 1/2 x 1/4 voxel of a cell's blocks can show anything. A cell whose blocks do not
/// all show everywhere has a place: a run of entries of four words, one of each of its occupied blocks, in
/// the order of their bits in the map's texel. Bit x + 4y + 16z of an entry, x fastest, is the sub-block's.
struct SubBlocks {
    GlBuffer places; // a word of each cell after the first: 1 + its first entry; 0: every sub-block counts
    GlBuffer masks;
    std::size_t entries = 0;

    SubBlocks() = default;
    /// Every sub-block counts, until refineSkipping() (fine_mask.h). Needs a map of cells.
    SubBlocks(const Occupancy& occupancy, Ledger& gpu)
        : places(placesBytes(occupancy), {}, gpu, "the places of sub-blocks"),
          masks(kEntryBytes, {}, gpu, "the sub-blocks") {}
    std::size_t bytes() const { return places.bytes() + masks.bytes(); }

    static constexpr std::size_t kEntryBytes = 4 * sizeof(std::uint32_t);
    static std::size_t placesBytes(const Occupancy& occupancy) {
        return sizeof(std::uint32_t) * (1 + occupancy.map().size());
    }
};

} // namespace tessera
