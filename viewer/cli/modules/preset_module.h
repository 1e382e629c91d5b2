// viewer/cli/modules/preset_module.h: the functions of viewer/presets/foreign_preset.h, as the table of a
// module.
#pragma once

#include "viewer/cli/modules/load_module.h"
#include "viewer/presets/foreign_preset.h"

namespace tessera {

struct PresetModule {
    ModuleHead head;
    decltype(&readForeignPresets) read;
    decltype(&writeForeignPreset) write;
};

} // namespace tessera
