// viewer/cli/modules/mesh_module.cpp: the table of functions of tessera_meshes.so.
#include "viewer/cli/modules/mesh_module.h"

extern "C" const tessera::MeshModule tesseraModule;
const tessera::MeshModule tesseraModule = {{TESSERA_VERSION}, tessera::readMesh, tessera::surfaceOf};
