// viewer/presets/foreign_preset.cpp: see foreign_preset.h.
#include "viewer/presets/foreign_preset.h"

#include "core/base/error.h"
#include "viewer/presets/preset_files.h"

namespace tessera {

std::vector<ForeignPreset> readForeignPresets(const std::string& text, PresetFormat format,
                                              const std::string& where) {
    switch (format) {
    case PresetFormat::slicerJson:
        return readSlicerJson(text, where);
    case PresetFormat::slicerText:
        return readSlicerText(text, where);
    case PresetFormat::slicerXml:
        return readSlicerXml(text, where);
    case PresetFormat::paraView:
        break;
    }
    return readParaView(text, where);
}

ForeignText writeForeignPreset(const Preset& preset, PresetFormat format) {
    if (format == PresetFormat::slicerJson)
        return writeSlicerJson(preset);
    if (format == PresetFormat::paraView)
        return writeParaView(preset);
    throw badFile("preset " + preset.name, "Slicer's JSON or ParaView's to write", "another format");
}

} // namespace tessera
