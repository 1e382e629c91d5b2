// bricking/import/structures/structure_surface.cpp: see structure_surface.h.
#include "bricking/import/structures/structure_surface.h"

#include "bricking/import/structures/plane_distance.h"
#include "bricking/import/structures/plane_stack.h"
#include "bricking/import/structures/structure_planes.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostGridPoints = std::size_t{1} << 28; // 1 GiB of distances
constexpr double kCoarser = 1.25, kCoarsestMm = 1000;

std::string nameOfStructure(const Structure& structure) {
    return "structure " + std::to_string(structure.label.value) + " \"" + structure.label.name + "\"";
}

void leaveAsLines(const Structure& structure, const std::string& why, StructureSurface& out) {
    out.otherContours.resize(structure.contours.size());
    std::iota(out.otherContours.begin(), out.otherContours.end(), std::size_t{0});
    out.notes.push_back(nameOfStructure(structure) + ": contours " + why + ", and are drawn as lines");
}

/// Runs of planes without a gap: first and one past the last.
std::vector<std::pair<std::size_t, std::size_t>> piecesOf(const StructurePlanes& planes, double gapMm) {
    std::vector<std::pair<std::size_t, std::size_t>> pieces;
    for (std::size_t i = 0; i < planes.planes.size(); ++i) {
        if (i == 0 || planes.planes[i].at - planes.planes[i - 1].at > gapMm)
            pieces.push_back({i, i});
        pieces.back().second = i + 1;
    }
    return pieces;
}

void noteGaps(const StructurePlanes& planes, double gapMm, const std::string& name,
              std::vector<std::string>& notes) {
    constexpr double kMissing = 1.5;
    double bridged = 0, left = 0;
    int bridges = 0, gaps = 0;
    for (std::size_t i = 1; i < planes.planes.size(); ++i) {
        const double apart = planes.planes[i].at - planes.planes[i - 1].at;
        if (apart > gapMm) {
            left = std::max(left, apart);
            ++gaps;
        } else if (apart > kMissing * planes.spacingMm) {
            bridged = std::max(bridged, apart);
            ++bridges;
        }
    }
    if (bridges > 0)
        notes.push_back(name + ": " + std::to_string(bridges) + (bridges == 1 ? " gap" : " gaps") +
                        " of up to " + mmText(bridged) + " between contours (median " +
                        mmText(planes.spacingMm) + ") joined by the surface");
    if (gaps > 0)
        notes.push_back(name + ": " + std::to_string(gaps + 1) + " pieces, as planes of contours are up to " +
                        mmText(left) + " apart (meshes[].surfaceGap: " + mmText(gapMm) + ")");
}

void append(TriangleMesh& to, const TriangleMesh& piece) {
    const auto first = static_cast<std::uint32_t>(to.points.size());
    to.points.insert(to.points.end(), piece.points.begin(), piece.points.end());
    to.normals.insert(to.normals.end(), piece.normals.begin(), piece.normals.end());
    for (const glm::uvec3& triangle : piece.triangles)
        to.triangles.push_back(triangle + first);
}

/// False: the triangles do not fit.
bool makePieces(const StructurePlanes& planes, const std::vector<std::pair<std::size_t, std::size_t>>& pieces,
                double step, bool mustFit, MemoryBudget& ram, const std::string& what, TriangleMesh& mesh) {
    mesh = {};
    std::vector<Charge> made;
    for (const auto& [first, end] : pieces) {
        const auto piece = PlaneStack(planes, first, end, step).surface(ram, what, mustFit);
        if (!piece || (!mustFit && piece->bytes() > ram.freeBytes()))
            return false;
        made.push_back(ram.charge(piece->bytes(), what));
        append(mesh, *piece);
    }
    return true;
}

} // namespace

StructureSurface surfaceOf(const Structure& structure, const SurfaceOptions& options, MemoryBudget& ram) {
    const std::string name = nameOfStructure(structure);
    StructureSurface out;
    const StructurePlanes planes = planesOf(structure, ram);
    if (planes.planes.size() < 2) {
        leaveAsLines(structure,
                     planes.planes.empty() ? "in no plane have no surface"
                                           : "in one plane alone have no surface",
                     out);
        return out;
    }
    out.otherContours = planes.otherContours;
    if (!out.otherContours.empty())
        out.notes.push_back(name + ": " + std::to_string(out.otherContours.size()) +
                            " contours that are open, not planar or in planes of another direction are drawn "
                            "as lines");
    const double gap = options.gapMm > 0 ? options.gapMm : kJoinedSpacings * planes.spacingMm;
    noteGaps(planes, gap, name, out.notes);
    const double wanted = std::clamp(planes.widthMm / 4, kFinestStepMm, kSurfaceStepMm);
    double step = options.stepMm > 0 ? options.stepMm : wanted;
    const auto pieces = piecesOf(planes, gap);
    const auto neededBy = [&](double tried) {
        std::size_t most = 0;
        for (const auto& [first, end] : pieces) {
            const PlaneStack stack(planes, first, end, tried);
            if (stack.points() > kMostGridPoints)
                return std::numeric_limits<std::size_t>::max();
            most = std::max(most, stack.gridBytes());
        }
        return most;
    };
    const bool isFree = options.stepMm <= 0;
    const auto isTooMuch = [&](double tried) { return neededBy(tried) > ram.freeBytes(); };
    while (isFree && isTooMuch(step) && step < kCoarsestMm)
        step *= kCoarser;
    if (neededBy(step) == std::numeric_limits<std::size_t>::max())
        throw badFile(name, "a grid of at most " + std::to_string(kMostGridPoints) + " points",
                      "more (meshes[].surfaceStep is " + numberText(step) + " mm)");
    while (!makePieces(planes, pieces, step, !isFree || step >= kCoarsestMm, ram, "the surface of " + name,
                       out.mesh))
        step *= kCoarser; // triangles are counted when the grid is there
    if (out.mesh.triangles.empty()) {
        leaveAsLines(structure, "enclose no point of the grid of " + numberText(step, 3) + " mm", out);
        return out;
    }
    if (isFree && step > wanted)
        out.notes.push_back(name + ": its surface is made on a grid of " + numberText(step, 3) +
                            " mm, the finest within --ram");
    return out;
}

} // namespace tessera
