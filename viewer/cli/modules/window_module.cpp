// viewer/cli/modules/window_module.cpp: the table of functions of tessera_window.so.
#include "viewer/cli/modules/window_module.h"

extern "C" const tessera::WindowModule tesseraModule;
const tessera::WindowModule tesseraModule = {{TESSERA_VERSION}, tessera::runWindow};
