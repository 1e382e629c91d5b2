// viewer/cli/input/structure_input.cpp: see structure_input.h.
#include "viewer/cli/input/structure_input.h"

#if TESSERA_WITH_IMPORT
#include "bricking/import/structures/structure_lines.h"
#include "bricking/import/structures/structure_surface.h"
#include "bricking/labels/label_names.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/shape_group.h"
#include "render/geometry/tube_shape.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

namespace tessera {
namespace {

/// Whether each structure is drawn.
std::vector<bool> chosenStructures(const StructureSet& set, const SceneMesh& mesh) {
    std::vector<bool> chosen(set.structures.size(), mesh.rois.empty());
    if (mesh.rois.empty())
        return chosen;
    LabelTable table;
    for (const Structure& structure : set.structures)
        table.labels.push_back(structure.label);
    const LabelMatcher matcher(table.labels);
    for (const std::string& pattern : mesh.rois) {
        if (matcher.forEach(pattern, [&](std::size_t number) { chosen[number] = true; }))
            continue;
        std::string near;
        for (const std::string& name : nearestNames(table, pattern))
            near += (near.empty() ? "; near to it: " : ", ") + name;
        throw badFile(mesh.path.string(), "structures with contours that are named as meshes[].rois says",
                      "none for \"" + printable(pattern.substr(0, 100)) + "\"" + near);
    }
    return chosen;
}

std::unique_ptr<const Shape> tubesOf(const Structure& structure, double radiusMm, MemoryBudget& ram) {
    StructureLines lines = linesOf(structure, ram);
    return std::make_unique<const TubeShape>(Tube{std::move(lines.points), radiusMm}, lines.ends, ram);
}

/// @param frames  of the picture; none: unknown
void requireFrame(const Structure& structure, const std::vector<std::string>& frames, const SceneMesh& mesh) {
    const std::string& own = structure.frameOfReference;
    if (own.empty() || frames.empty() || std::find(frames.begin(), frames.end(), own) != frames.end())
        return;
    throw badFile(mesh.path.string(), "the volume's frame of reference, " + frames.front(),
                  own + " of structure " + std::to_string(structure.label.value) + " \"" +
                      structure.label.name +
                      "\": its positions may be of another patient or study; --same-frame "
                      "(meshes[].sameFrame) takes it for the volume's");
}

Structure onlyContours(const Structure& structure, const std::vector<std::size_t>& numbers) {
    Structure out{structure.label, {}};
    for (const std::size_t number : numbers)
        out.contours.push_back(structure.contours[number]);
    return out;
}

/// The surface of a structure, and tubes around what is no part of it.
void addSurface(const Structure& structure, const SceneMesh& mesh, const glm::dvec3& colour,
                MemoryBudget& ram, std::vector<ShapeGroup::Member>& members,
                std::vector<std::string>& notes) {
    StructureSurface made = surfaceOf(structure, {mesh.surfaceStepMm, mesh.surfaceGapMm}, ram);
    notes.insert(notes.end(), made.notes.begin(), made.notes.end());
    if (!made.mesh.triangles.empty())
        members.push_back({std::make_unique<const MeshShape>(std::move(made.mesh), ram,
                                                             "the surface of " + structure.label.name),
                           colour});
    if (!made.otherContours.empty())
        members.push_back(
            {tubesOf(onlyContours(structure, made.otherContours), mesh.lineRadiusMm, ram), colour});
}

} // namespace

bool beginsAsDicom(const std::filesystem::path& file) {
    std::array<char, 132> head{};
    std::ifstream in(file, std::ios::binary);
    return in.read(head.data(), head.size()) && std::string_view(head.data() + 128, 4) == "DICM";
}

std::shared_ptr<const Shape> shapeOfStructures(const SceneMesh& mesh, const std::vector<std::string>& frames,
                                               MemoryBudget& ram, std::vector<std::string>& notes) {
    if (mesh.space != MeshSpace::lps)
        throw badFile(mesh.path.string(), "coordinates in lps, as every DICOM structure set has them",
                      "space " + nameOf(mesh.space));
    const StructureSet set = readStructureSet(mesh.path, ram);
    const Charge charge = ram.charge(set.bytes(), "contours");
    notes.insert(notes.end(), set.notes.begin(), set.notes.end());
    const std::vector<bool> chosen = chosenStructures(set, mesh);
    for (std::size_t n = 0; n < chosen.size() && !mesh.sameFrame; ++n)
        if (chosen[n])
            requireFrame(set.structures[n], frames, mesh);
    std::vector<ShapeGroup::Member> members;
    for (std::size_t n = 0; n < chosen.size(); ++n)
        if (chosen[n]) {
            const Label& label = set.structures[n].label;
            const glm::dvec3 colour(label.colour.value_or(labelColour(label.value)));
            if (mesh.contours == ContourStyle::surface)
                addSurface(set.structures[n], mesh, colour, ram, members, notes);
            else
                members.push_back({tubesOf(set.structures[n], mesh.lineRadiusMm, ram), colour});
        }
    return std::make_shared<const ShapeGroup>(std::move(members));
}

} // namespace tessera
#endif
