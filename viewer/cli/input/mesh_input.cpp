// viewer/cli/input/mesh_input.cpp: see mesh_input.h.
#include "viewer/cli/input/mesh_input.h"

#include "core/base/address.h"
#include "core/base/error.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/point_shape.h"
#include "render/geometry/tube_shape.h"
#include "viewer/cli/input/fetched_file.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/meshes/mesh_file.h"
#include "viewer/cli/input/structure_input.h"
#endif

#include <algorithm>

namespace tessera {
namespace {

using Frames = std::vector<std::string>; // of reference

std::shared_ptr<const Shape> shapeOfFile(const SceneMesh& mesh, const Frames& frames, MemoryBudget& ram,
                                         std::vector<std::string>& notes) {
#if TESSERA_WITH_IMPORT
    if (isAddress(mesh.path)) {
        SceneMesh here = mesh;
        const FetchedFile file(mesh.path, "triangles or contours in one file");
        here.path = file.path();
        return file.reading([&] { return shapeOfFile(here, frames, ram, notes); });
    }
    if (beginsAsDicom(mesh.path))
        return shapeOfStructures(mesh, frames, ram, notes);
    if (!mesh.rois.empty() || mesh.contours != ContourStyle::lines)
        throw badFile(mesh.path.string(),
                      std::string("a DICOM structure set, which meshes[].") +
                          (mesh.rois.empty() ? "contours" : "rois") + " is of",
                      "another file");
    TriangleMesh triangles = readMesh(mesh.path, ram);
    if (mesh.space == MeshSpace::ras) // x to the left, y to the back
        for (std::vector<glm::vec3>* list : {&triangles.points, &triangles.normals})
            for (glm::vec3& v : *list)
                v = {-v.x, -v.y, v.z};
    if (triangles.triangles.empty()) {
        const Charge points = ram.charge(
            triangles.points.size() * (sizeof(glm::dvec3) + 2 * sizeof(std::uint32_t)), "reading points");
        return std::make_shared<const PointShape>(triangles.points, mesh.lineRadiusMm, ram);
    }
    return std::make_shared<const MeshShape>(std::move(triangles), ram, mesh.path.filename().string());
#else
    (void)ram;
    (void)frames;
    (void)notes;
    throw InputError(mesh.path.string() + ": this program was built without importers");
#endif
}

using KeptBudget = std::shared_ptr<MemoryBudget>;

/// @param kept  of the shapes' memory, or null
std::vector<std::string> read(Scene& scene, const Frames& frames, MemoryBudget& ram, const KeptBudget& kept) {
    std::vector<std::string> notes;
    const auto keep = [&](std::shared_ptr<const Shape> shape) {
        struct Both {
            KeptBudget budget; // goes last
            std::shared_ptr<const Shape> shape;
        };
        if (!kept)
            return shape;
        const auto both = std::make_shared<const Both>(Both{kept, std::move(shape)});
        return std::shared_ptr<const Shape>(both, both->shape.get());
    };
    for (SceneMesh& mesh : scene.meshes) {
        if (!mesh.isDrawn() || mesh.shape)
            continue;
        if (mesh.tube) {
            mesh.shape = keep(std::make_shared<const TubeShape>(*mesh.tube, ram));
            continue;
        }
        const auto same = std::find_if(scene.meshes.begin(), scene.meshes.end(), [&](const SceneMesh& other) {
            return other.shape && other.isSameShape(mesh);
        });
        mesh.shape = same != scene.meshes.end() ? same->shape : keep(shapeOfFile(mesh, frames, ram, notes));
    }
    return notes;
}

} // namespace

std::vector<std::string> readMeshes(Scene& scene, const Frames& frames, MemoryBudget& ram) {
    return read(scene, frames, ram, nullptr);
}

void adoptShapes(std::span<const SceneMesh> from, Scene& to) {
    for (SceneMesh& mesh : to.meshes) {
        if (mesh.shape)
            continue;
        const auto same = std::find_if(from.begin(), from.end(),
                                       [&](const SceneMesh& other) { return other.isSameShape(mesh); });
        if (same != from.end())
            mesh.shape = same->shape;
    }
}

Charge readMeshesApart(Scene& scene, const Frames& frames, MemoryBudget& ram) {
    if (!drawsMeshes(scene))
        return {};
    const auto own =
        std::make_shared<MemoryBudget>(ram.name(), ram.option(), std::max<std::size_t>(1, ram.freeBytes()));
    read(scene, frames, *own, own);
    std::vector<const Shape*> counted;
    std::size_t bytes = 0;
    for (const SceneMesh& mesh : scene.meshes)
        if (mesh.shape && std::find(counted.begin(), counted.end(), mesh.shape.get()) == counted.end()) {
            counted.push_back(mesh.shape.get());
            bytes += mesh.shape->bytes();
        }
    return ram.charge(bytes, "meshes");
}

} // namespace tessera
