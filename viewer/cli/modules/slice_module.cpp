// viewer/cli/modules/slice_module.cpp: the table of functions of tessera_slices.so.
#include "viewer/cli/modules/slice_module.h"

extern "C" const tessera::SliceModule tesseraModule;
const tessera::SliceModule tesseraModule = {{TESSERA_VERSION}, tessera::openPictureRows};
