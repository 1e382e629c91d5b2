// core/scene/mesh_fields.cpp: the keys of meshes: see scene_fields.h.
#include "core/base/error.h"
#include "core/scene/scene_fields.h"

namespace tessera {
namespace {

constexpr double kMostMeshMm = 1e6;

Kind<glm::dvec3> placeKind() {
    return numbersWithin<glm::dvec3>(-kMostMeshMm, kMostMeshMm, "[x, y, z], mm", &glm::dvec3::x,
                                     &glm::dvec3::y, &glm::dvec3::z);
}

const Fields<Tube>& tubeFields() {
    static const Fields<Tube> fields = [] {
        Fields<Tube> f("tube");
        f.add("points", &Tube::points,
              listOf(placeKind(), 1, Tube::kMostPoints, "1 to 65536 points [x, y, z], mm"),
              "Points of its line, in patient space (LPS), mm.")
            .required();
        f.add("radius", &Tube::radiusMm, numberIn(1e-3, 1e4), "Radius, mm.").required();
        return f;
    }();
    return fields;
}

} // namespace

template <> const NameTable<MeshSpace>& namesOf<MeshSpace>() {
    static const NameTable<MeshSpace> names{{{MeshSpace::lps, "lps"}, {MeshSpace::ras, "ras"}}};
    return names;
}

template <> const NameTable<ContourStyle>& namesOf<ContourStyle>() {
    static const NameTable<ContourStyle> names{
        {{ContourStyle::lines, "lines"}, {ContourStyle::surface, "surface"}}};
    return names;
}

const Fields<SceneMesh>& meshFields() {
    static const Fields<SceneMesh> fields = [] {
        Fields<SceneMesh> f("mesh");
        f.add("path", &SceneMesh::path,
              anyText()
                  .checked([](const std::string& path, const JsonValue& value) {
                      if (path.empty())
                          value.refuse("the path of a mesh");
                  })
                  .described({{"minLength", 1}}),
              "Path of a file of triangles (.ply, .stl, .obj, .gltf, .glb), of points alone (.ply without "
              "faces), "
              "or of a DICOM structure set, relative to the scene's file; its coordinates are mm in patient "
              "space.")
            .writtenIf([](const SceneMesh& m) { return !m.path.empty(); })
            .withoutDefault();
        f.add("tube", &SceneMesh::tube, objectOf(tubeFields()), "In place of a file: a tube around a line.");
        f.add("rois", &SceneMesh::rois, listOf(anyText(), SceneMesh::kMostPatterns, "patterns"),
              "Structures of a DICOM structure set that are drawn (default: all): names with * and ?, or "
              "numbers.")
            .writtenIf([](const SceneMesh& m) { return !m.rois.empty(); })
            .withoutDefault();
        f.add("lineRadius", &SceneMesh::lineRadiusMm, numberIn(1e-3, 1e4),
              "Radius of the tubes around a structure set's contours, and of points, mm.")
            .unlessDefault();
        f.add("contours", &SceneMesh::contours, named<ContourStyle>(),
              "A structure set's contours: lines, as tubes; surface, joined from plane to plane and closed.")
            .unlessDefault();
        f.add("surfaceStep", &SceneMesh::surfaceStepMm, numberIn(0, 1e3),
              "Step of the grid on which contours become a surface, mm (0: 0.25 to 1, by their size and "
              "--ram).")
            .unlessDefault();
        f.add("surfaceGap", &SceneMesh::surfaceGapMm, numberIn(0, 1e5),
              "Largest distance of planes of contours that a surface joins, mm (0: 3.5 times the median).")
            .unlessDefault();
        f.add("rgb", &SceneMesh::colour, colourKind(),
              "Colour, linear light (default: light grey, 0.8; structures have display colours of their "
              "own).");
        f.add("opacity", &SceneMesh::opacity, numberIn(0, 1), "Opacity of the surface, at any angle.");
        f.add("material", &SceneMesh::material, objectOf(responseFields()),
              "What it makes of light (default: as shading).");
        f.add("space", &SceneMesh::space, named<MeshSpace>(),
              "Axes of the file's coordinates: lps, as DICOM; ras, as 3D Slicer's own.")
            .unlessDefault();
        f.add("sameFrame", &SceneMesh::sameFrame, trueOrFalse(),
              "A structure set is taken though its frame of reference is another than the volume's.")
            .unlessDefault();
        f.add("show", &SceneMesh::show, trueOrFalse(), "It is drawn.").unlessDefault();
        f.add("clipped", &SceneMesh::clipped, trueOrFalse(), "The scene's cuts cut it, too.").unlessDefault();
        f.describe({{"anyOf", {{{"required", {"path"}}}, {{"required", {"tube"}}}}}});
        f.rule([](const JsonValue& whole, const SceneMesh& mesh) {
            if (mesh.path.empty() == !mesh.tube)
                throw badFile(whole.place(), "\"path\" or \"tube\"", mesh.tube ? "both" : "neither");
        });
        return f;
    }();
    return fields;
}

} // namespace tessera
