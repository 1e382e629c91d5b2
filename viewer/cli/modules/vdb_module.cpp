// viewer/cli/modules/vdb_module.cpp: the table of functions of tessera_vdb.so.
#include "viewer/cli/modules/vdb_module.h"

extern "C" const tessera::VdbModule tesseraModule;
const tessera::VdbModule tesseraModule = {{TESSERA_VERSION}, tessera::writeVdb, tessera::writeHalfVdb};
