// viewer/cli/modules/preset_module.cpp: the table of functions of tessera_presets.so.
#include "viewer/cli/modules/preset_module.h"

extern "C" const tessera::PresetModule tesseraModule;
const tessera::PresetModule tesseraModule = {
    {TESSERA_VERSION}, tessera::readForeignPresets, tessera::writeForeignPreset};
