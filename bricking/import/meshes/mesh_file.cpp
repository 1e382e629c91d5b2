// bricking/import/meshes/mesh_file.cpp: see mesh_file.h.
#include "bricking/import/meshes/mesh_file.h"

#include "bricking/import/meshes/mesh_walk.h"
#include "bricking/import/vtk/vtk_complaints.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCompositeDataIterator.h>
#include <vtkDataArray.h>
#include <vtkExecutive.h>
#include <vtkGLTFReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>

namespace tessera {
namespace {

/// What VTK takes besides the file, at most, as measured for each format with the largest (docs/formats.md).
constexpr std::size_t kBytesOfVtkPoint = 160, kBytesOfVtkTriangle = 160;

void appendPoints(vtkPolyData& from, const std::string& where, TriangleMesh& to) {
    const std::size_t before = to.points.size(), count = static_cast<std::size_t>(from.GetNumberOfPoints());
    for (std::size_t n = 0; n < count; ++n) {
        double p[3];
        from.GetPoint(static_cast<vtkIdType>(n), p);
        const glm::vec3 point(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
        for (int axis = 0; axis < 3; ++axis)
            if (!(std::abs(point[axis]) <= 1e6f))
                throw badFile(where, "coordinates within 1000000 mm",
                              std::to_string(point[axis]) + " of point " + std::to_string(n));
        to.points.push_back(point);
    }
    vtkDataArray* const normals = from.GetPointData()->GetNormals();
    const bool has = normals && normals->GetNumberOfComponents() == 3 &&
                     static_cast<std::size_t>(normals->GetNumberOfTuples()) == count;
    if (!has || to.normals.size() != before) { // for all of them or for none
        to.normals.clear();
        return;
    }
    for (std::size_t n = 0; n < count; ++n) {
        double v[3];
        normals->GetTuple(static_cast<vtkIdType>(n), v);
        const glm::dvec3 normal(v[0], v[1], v[2]);
        const double length = glm::length(normal);
        to.normals.push_back(length > 0 && std::isfinite(length) ? glm::vec3(normal / length) : glm::vec3(0));
    }
}

/// @param strips  triangles share the two corners before; else a fan around the first
void appendTriangles(vtkCellArray* cells, bool strips, std::size_t firstPoint, const std::string& where,
                     TriangleMesh& to) {
    if (!cells)
        return;
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    for (cells->InitTraversal(); cells->GetNextCell(count, ids);) {
        for (vtkIdType n = 0; n < count; ++n)
            if (ids[n] < 0 || firstPoint + static_cast<std::size_t>(ids[n]) >= to.points.size())
                throw badFile(where,
                              "numbers of points below " + std::to_string(to.points.size() - firstPoint),
                              std::to_string(ids[n]));
        for (vtkIdType n = 2; n < count; ++n) {
            const auto corner = [&](vtkIdType at) {
                return static_cast<std::uint32_t>(firstPoint + static_cast<std::size_t>(ids[at]));
            };
            const bool odd = strips && (n & 1);
            to.triangles.push_back(
                {corner(strips ? n - 2 : 0), corner(odd ? n : n - 1), corner(odd ? n - 1 : n)});
        }
    }
}

void append(vtkPolyData& from, const std::string& where, TriangleMesh& to) {
    const std::size_t before = to.points.size();
    appendPoints(from, where, to);
    appendTriangles(from.GetPolys(), false, before, where, to);
    appendTriangles(from.GetStrips(), true, before, where, to);
}

template <typename Reader> TriangleMesh readBy(Reader& reader, const std::string& where) {
    VtkComplaints complaints(reader);
    reader.SetFileName(where.c_str());
    reader.Update();
    if (const std::string first = complaints.first(); !first.empty())
        throw badFile(where, "triangles that VTK reads without complaint", first);
    TriangleMesh mesh;
    vtkDataObject* const output = reader.GetOutputDataObject(0);
    if (auto* const whole = vtkPolyData::SafeDownCast(output)) {
        append(*whole, where, mesh);
    } else if (auto* const blocks = vtkMultiBlockDataSet::SafeDownCast(output)) {
        const auto at = vtkSmartPointer<vtkCompositeDataIterator>::Take(blocks->NewIterator());
        for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem())
            if (auto* const part = vtkPolyData::SafeDownCast(at->GetCurrentDataObject()))
                append(*part, where, mesh);
    }
    return mesh;
}

TriangleMesh readPly(const std::string& where) {
    vtkNew<vtkPLYReader> reader;
    return readBy(*reader, where);
}
TriangleMesh readStl(const std::string& where) {
    vtkNew<vtkSTLReader> reader;
    reader->MergingOff(); // equal points need no finding: normals are the triangles' own
    return readBy(*reader, where);
}
TriangleMesh readObj(const std::string& where) {
    vtkNew<vtkOBJReader> reader;
    return readBy(*reader, where);
}
TriangleMesh readGltf(const std::string& where) {
    vtkNew<vtkGLTFReader> reader;
    reader->SetFileName(where.c_str());
    return readBy(*reader, where);
}

struct MeshFormat {
    const char* ending;
    MeshCounts (*walk)(const InputFile&);
    TriangleMesh (*read)(const std::string&);
};
constexpr std::array<MeshFormat, 5> kMeshFormats{{{".ply", walkPly, readPly},
                                                  {".stl", walkStl, readStl},
                                                  {".obj", walkObj, readObj},
                                                  {".gltf", walkGltf, readGltf},
                                                  {".glb", walkGltf, readGltf}}};

} // namespace

TriangleMesh readMesh(const std::filesystem::path& path, MemoryBudget& ram) {
    const std::string where = path.string();
    std::string ending = path.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto format = std::find_if(kMeshFormats.begin(), kMeshFormats.end(),
                                     [&](const MeshFormat& f) { return ending == f.ending; });
    if (format == kMeshFormats.end())
        throw badFile(where, "a mesh that ends in .ply, .stl, .obj, .gltf or .glb", "\"" + ending + "\"");
    const InputFile file(path);
    const MeshCounts counts = format->walk(file);
    const bool points = counts.triangles == 0 && counts.points > 0 && format->walk == walkPly;
    if (counts.triangles == 0 && !points)
        throw badFile(where, "triangles", "none");
    constexpr std::uint64_t kMost = std::uint64_t{1} << 30;
    if (counts.triangles > kMost || counts.points > kMost)
        throw badFile(where, "at most 2^30 triangles and points",
                      std::to_string(counts.triangles) + " and " + std::to_string(counts.points));
    const Charge charge =
        ram.charge(counts.points * kBytesOfVtkPoint + counts.triangles * kBytesOfVtkTriangle,
                   "reading " + path.filename().string());
    TriangleMesh mesh = format->read(where);
    if (points && mesh.points.size() != counts.points)
        throw badFile(where, std::to_string(counts.points) + " points",
                      std::to_string(mesh.points.size()) + " as VTK reads it");
    if (mesh.triangles.empty() != points || mesh.triangles.size() > counts.triangles ||
        (counts.exact && mesh.triangles.size() != counts.triangles))
        throw badFile(where, std::to_string(counts.triangles) + " triangles",
                      std::to_string(mesh.triangles.size()) + " as VTK reads it");
    return mesh;
}

} // namespace tessera
