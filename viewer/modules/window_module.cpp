// viewer/modules/window_module.cpp: what tessera_window.so shows.
#include "viewer/modules/window_module.h"

extern "C" const tessera::WindowModule tesseraModule;
const tessera::WindowModule tesseraModule = {{TESSERA_VERSION}, tessera::runWindow};
