// render/fine_mask.cpp: see fine_mask.h.
#include "render/fine_mask.h"

#include "core/error.h"
#include "render/gl/program.h"

#include <bit>
#include <span>
#include <vector>

namespace tessera {
namespace {

// Cells of one dispatch: a dispatch stays short on a slow device, and the list small.
constexpr std::size_t kCellsAtATime = 16384;

} // namespace

std::size_t refiningBytes(std::size_t tableEntries) {
    return tableEntries * sizeof(int) + kCellsAtATime * sizeof(std::uint32_t);
}

bool refiningPays(const Occupancy& occupancy, std::size_t rays) {
    constexpr std::size_t kRaysPerCell = 16;
    return occupancy.scale() == MapScale::cells && rays >= kRaysPerCell * occupancy.plainCells();
}

std::size_t refineSkipping(const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table,
                           const Optics& optics, std::uint32_t features, const VolumeInfo& info,
                           const FieldSource& source, Ledger& gpu) {
    TESSERA_CHECK(occupancy.scale() == MapScale::cells && source.atlas);
    // Exact fetches, whatever the march does: filtered ones are for positions, not for samples.
    const std::uint32_t own = (features & kFeatureNormalised) | kFeatureBricked;
    const GlProgram program("skipping_masks.comp", featureDefines(own));
    const GlBuffer prefix(table.nonZeroUpTo.size() * sizeof(int), std::as_bytes(std::span(table.nonZeroUpTo)),
                          gpu, "the transfer function's zeros");
    FieldSource plain;
    plain.atlas = source.atlas;
    bindField(program, own, info, plain);
    map.bindImage(0, GL_RG32UI);
    program.set("uExtentVoxels", info.extentVoxels);
    program.set("uGrid", occupancy.grid());
    program.set("uTableScale", optics.scale);
    program.set("uTableOffset", optics.offset);
    program.set("uTableLast", static_cast<int>(table.entries.size()) - 1);
    prefix.bind(0);
    std::vector<std::uint32_t> cells;
    std::size_t refined = 0;
    const auto flush = [&] {
        if (cells.empty())
            return;
        const GlBuffer list(cells.size() * sizeof(std::uint32_t), std::as_bytes(std::span(cells)), gpu,
                            "the cells to refine");
        list.bind(1);
        program.use();
        glDispatchCompute(static_cast<GLuint>(cells.size()), 1, 1);
        glFinish(); // the list goes
        refined += cells.size();
        cells.clear();
    };
    const glm::ivec3 grid = occupancy.grid();
    glm::ivec3 at(0);
    for (at.z = 0; at.z < grid.z; ++at.z)
        for (at.y = 0; at.y < grid.y; ++at.y)
            for (at.x = 0; at.x < grid.x; ++at.x)
                if (!occupancy.isEmpty(at) && occupancy.isPlain(at)) {
                    cells.push_back(static_cast<std::uint32_t>(linearIndex(at, grid)));
                    if (cells.size() == kCellsAtATime)
                        flush();
                }
    flush();
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return refined;
}

} // namespace tessera
