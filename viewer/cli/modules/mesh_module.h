// viewer/cli/modules/mesh_module.h: the function of bricking/import/meshes/mesh_file.h, as the table of a
// module.
#pragma once

#include "bricking/import/meshes/mesh_file.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct MeshModule {
    ModuleHead head;
    decltype(&readMesh) read;
};

} // namespace tessera
