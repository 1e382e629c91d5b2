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

} // namespace

void readMeshes(Scene& scene, MemoryBudget& ram) {
    for (SceneMesh& mesh : scene.meshes) {
        if (!mesh.isDrawn() || mesh.shape)
            continue;
        if (mesh.tube) {
            mesh.shape = std::make_shared<const TubeShape>(*mesh.tube, ram);
            continue;
        }
        const auto same = std::find_if(scene.meshes.begin(), scene.meshes.end(), [&](const SceneMesh& other) {
            return other.shape && other.path == mesh.path && other.space == mesh.space;
        });
        mesh.shape = same != scene.meshes.end() ? same->shape : shapeOfFile(mesh, ram);
    }
}

} // namespace tessera
