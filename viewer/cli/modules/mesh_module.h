// viewer/cli/modules/mesh_module.h: the functions of bricking/import/meshes/mesh_file.h and
// structures/structure_surface.h, as the table of a module.
#pragma once

#include "bricking/import/meshes/mesh_file.h"
#include "bricking/import/structures/structure_surface.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct MeshModule {
    ModuleHead head;
    decltype(&readMesh) read;
    decltype(&surfaceOf) ofStructure;
};

} // namespace tessera
