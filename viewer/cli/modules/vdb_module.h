// viewer/cli/modules/vdb_module.h: the writers of OpenVDB files (bricking/export/volume_writer.h), as the
// table of a module.
#pragma once

#include "bricking/export/volume_writer.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct VdbModule {
    ModuleHead head;
    WriteVolume *floats, *halves;
};

} // namespace tessera
