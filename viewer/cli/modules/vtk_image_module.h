// viewer/cli/modules/vtk_image_module.h: the function of bricking/import/vtk/vtk_image.h, as the table of a
// module.
#pragma once

#include "bricking/import/vtk/vtk_image.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct VtkImageModule {
    ModuleHead head;
    decltype(&openVtkImage) open;
};

} // namespace tessera
