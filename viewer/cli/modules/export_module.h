// viewer/cli/modules/export_module.h: the writers of bricking/export/volume_writer.h, as the table of a
// module.
#pragma once

#include "bricking/export/volume_writer.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct ExportModule {
    ModuleHead head;
    WriteVolume *nrrd, *nifti, *nifti2, *vti, *tiff;
};

} // namespace tessera
