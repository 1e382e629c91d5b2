// viewer/cli/modules/remote_module.cpp: the table of functions of tessera_remote_files.so.
#include "viewer/cli/modules/remote_module.h"

extern "C" const tessera::RemoteModule tesseraModule;
const tessera::RemoteModule tesseraModule = {{TESSERA_VERSION}, tessera::openRemoteFiles};
