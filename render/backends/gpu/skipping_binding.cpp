// render/backends/gpu/skipping_binding.cpp: see skipping_binding.h.
#include "render/backends/gpu/skipping_binding.h"

#include "core/base/error.h"
#include "render/backends/gpu/composition.h"

#include <algorithm>
#include <span>
#include <vector>

namespace tessera {
namespace {

// Cells of one dispatch: a dispatch stays short on a slow device, and the list small.
constexpr std::size_t kCellsAtATime = 16384;

// The misplacing of a sample by filtered fetches along an axis, voxels: devices filter with eight bits of a
// position.
constexpr float kFilterError = 1.0f / 256;

/// The table's runs of entries that all show something, or that all show nothing: at each entry where its run
/// ends, the first of the next; negative where nothing shows.
std::vector<int> zeroRuns(const TransferTable& table) {
    std::vector<int> runs(table.entries.size());
    int end = static_cast<int>(runs.size());
    for (int i = end - 1; i >= 0; --i) {
        const auto shows = [&](int entry) { return table.shows(static_cast<std::size_t>(entry)); };
        if (i + 1 < static_cast<int>(runs.size()) && shows(i) != shows(i + 1))
            end = i + 1;
        runs[static_cast<std::size_t>(i)] = shows(i) ? end : -end;
    }
    return runs;
}

std::vector<std::uint32_t> plainCells(const Occupancy& occupancy) {
    std::vector<std::uint32_t> cells;
    for (std::size_t c = 0; c < occupancy.map().size(); ++c)
        if (isOccupied(occupancy.map()[c]) && occupancy.isPlain(gridPosition(c, occupancy.grid())))
            cells.push_back(static_cast<std::uint32_t>(c));
    return cells;
}

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
                           const FieldSource& source, MemoryBudget& gpu) {
    TESSERA_CHECK(occupancy.scale() == MapScale::cells && source.atlas);
    // Exact fetches, whatever the ray caster takes: filtered ones are for positions, not for samples.
    const std::uint32_t own = features & kFeatureNormalised;
    const Composition composition(
        {{"RUNS", "the transfer function's zeros"}, {"CELLS", "the cells to refine"}}, own);
    const GlProgram program = composition.program("skipping_masks.comp");
    FieldSource plain;
    plain.atlas = source.atlas;
    bindField(VolumeUniforms(program), own, info, plain);
    program.set("uExtentVoxels", info.extentVoxels);
    program.set("uGrid", occupancy.grid());
    program.set("uTableScale", optics.scale);
    program.set("uTableOffset", optics.offset);
    program.set("uTableLast", static_cast<int>(table.entries.size()) - 1);
    program.set("uFilterError", (features & kFeatureHardware) ? 3 * kFilterError : 0.0f);
    const std::vector<int> runsOfZeros = zeroRuns(table);
    const GlBuffer runs(runsOfZeros.size() * sizeof(int), std::as_bytes(std::span(runsOfZeros)), gpu,
                        "the transfer function's zeros");
    runs.bind(composition.binding("RUNS"));
    map.bindForWriting(kSkippingUnit);
    program.set("uMap", static_cast<int>(kSkippingUnit));
    program.use();
    const std::vector<std::uint32_t> cells = plainCells(occupancy);
    for (std::size_t first = 0; first < cells.size(); first += kCellsAtATime) {
        const auto some = std::span(cells).subspan(first, std::min(kCellsAtATime, cells.size() - first));
        const GlBuffer list(some.size_bytes(), std::as_bytes(some), gpu, "the cells to refine");
        list.bind(composition.binding("CELLS"));
        glDispatchCompute(static_cast<GLuint>(some.size()), 1, 1);
        glMemoryBarrier(GL_ALL_BARRIER_BITS);
        glFinish(); // the list goes
    }
    return cells.size();
}

} // namespace tessera
