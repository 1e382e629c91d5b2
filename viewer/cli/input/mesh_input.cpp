// viewer/cli/input/mesh_input.cpp: see mesh_input.h.
#include "viewer/cli/input/mesh_input.h"

#include "core/base/error.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/tube_shape.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/meshes/mesh_file.h"
#endif

#include <algorithm>

namespace tessera {
namespace {

std::shared_ptr<const Shape> shapeOfFile(const SceneMesh& mesh, MemoryBudget& ram) {
#if TESSERA_WITH_IMPORT
    TriangleMesh triangles = readMesh(mesh.path, ram);
    if (mesh.space == MeshSpace::ras) // x to the left, y to the back
        for (std::vector<glm::vec3>* list : {&triangles.points, &triangles.normals})
            for (glm::vec3& v : *list)
                v = {-v.x, -v.y, v.z};
    return std::make_shared<const MeshShape>(std::move(triangles), ram, mesh.path.filename().string());
#else
    (void)ram;
    throw InputError(mesh.path.string() + ": this program was built without importers");
#endif
}

using KeptBudget = std::shared_ptr<MemoryBudget>;

/// @param kept  of the shapes' memory, or null
void read(Scene& scene, MemoryBudget& ram, const KeptBudget& kept) {
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
            return other.shape && other.path == mesh.path && other.space == mesh.space;
        });
        mesh.shape = same != scene.meshes.end() ? same->shape : keep(shapeOfFile(mesh, ram));
    }
}

} // namespace

void readMeshes(Scene& scene, MemoryBudget& ram) {
    read(scene, ram, nullptr);
}

void adoptShapes(std::span<const SceneMesh> from, Scene& to) {
    for (SceneMesh& mesh : to.meshes) {
        if (mesh.shape)
            continue;
        const auto same = std::find_if(from.begin(), from.end(), [&](const SceneMesh& other) {
            return other.path == mesh.path && other.space == mesh.space && other.tube == mesh.tube;
        });
        if (same != from.end())
            mesh.shape = same->shape;
    }
}

Charge readMeshesApart(Scene& scene, MemoryBudget& ram) {
    if (!drawsMeshes(scene))
        return {};
    const auto own =
        std::make_shared<MemoryBudget>(ram.name(), ram.option(), std::max<std::size_t>(1, ram.freeBytes()));
    read(scene, *own, own);
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
