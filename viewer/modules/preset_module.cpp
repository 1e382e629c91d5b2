// viewer/modules/preset_module.cpp: what tessera_presets.so shows.
#include "viewer/modules/preset_module.h"

extern "C" const tessera::PresetModule tesseraModule;
const tessera::PresetModule tesseraModule = {
    {TESSERA_VERSION}, tessera::readForeignPresets, tessera::writeForeignPreset};
