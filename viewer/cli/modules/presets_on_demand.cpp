// viewer/cli/modules/presets_on_demand.cpp: viewer/presets/foreign_preset.h for programs: the first function
// of another program loads what reads them.
#include "viewer/cli/modules/preset_module.h"

namespace tessera {
namespace {

const PresetModule& presetModule() {
    static const auto* const table = static_cast<const PresetModule*>(loadModule("tessera_presets"));
    return *table;
}

} // namespace

std::vector<ForeignPreset> readForeignPresets(const std::string& text, PresetFormat format,
                                              const std::string& where) {
    return presetModule().read(text, format, where);
}
ForeignText writeForeignPreset(const Preset& preset, PresetFormat format) {
    return presetModule().write(preset, format);
}

} // namespace tessera
