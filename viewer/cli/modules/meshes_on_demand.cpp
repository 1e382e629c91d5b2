// viewer/cli/modules/meshes_on_demand.cpp: bricking/import/meshes/mesh_file.h for programs: the first mesh of
// a file loads what reads it.
#include "viewer/cli/modules/mesh_module.h"

namespace tessera {

TriangleMesh readMesh(const std::filesystem::path& file, MemoryBudget& ram) {
    static const auto* const table = static_cast<const MeshModule*>(loadModule("tessera_meshes"));
    return table->read(file, ram);
}

} // namespace tessera
