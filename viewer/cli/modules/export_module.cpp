// viewer/cli/modules/export_module.cpp: the table of functions of tessera_exporters.so.
#include "viewer/cli/modules/export_module.h"

extern "C" const tessera::ExportModule tesseraModule;
const tessera::ExportModule tesseraModule = {{TESSERA_VERSION},    tessera::writeNrrd, tessera::writeNifti,
                                             tessera::writeNifti2, tessera::writeVti,  tessera::writeTiff};
