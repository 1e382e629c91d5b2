// viewer/cli/modules/environment_module.cpp: the table of functions of tessera_environments.so.
#include "viewer/cli/modules/environment_module.h"

extern "C" const tessera::EnvironmentModule tesseraModule;
const tessera::EnvironmentModule tesseraModule = {{TESSERA_VERSION}, tessera::readEnvironment};
