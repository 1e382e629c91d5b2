// viewer/cli/modules/meshes_on_demand.cpp: bricking/import/meshes/mesh_file.h and
// structures/structure_surface.h for programs: the first mesh of a file loads what reads it.
#include "viewer/cli/modules/mesh_module.h"

namespace tessera {

namespace {
const MeshModule& meshModule() {
    static const auto* const table = static_cast<const MeshModule*>(loadModule("tessera_meshes"));
    return *table;
}
} // namespace

TriangleMesh readMesh(const std::filesystem::path& file, MemoryBudget& ram) {
    return meshModule().read(file, ram);
}
StructureSurface surfaceOf(const Structure& structure, const SurfaceOptions& options, MemoryBudget& ram) {
    return meshModule().ofStructure(structure, options, ram);
}

} // namespace tessera
