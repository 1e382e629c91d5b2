// viewer/cli/modules/vtk_image_module.cpp: the table of functions of tessera_vtk_images.so.
#include "viewer/cli/modules/vtk_image_module.h"

extern "C" const tessera::VtkImageModule tesseraModule;
const tessera::VtkImageModule tesseraModule = {{TESSERA_VERSION}, tessera::openVtkImage};
