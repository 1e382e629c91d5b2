// viewer/presets/preset_library.cpp: see preset_library.h.
#include "viewer/presets/preset_library.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/base/program_folders.h"
#include "core/scene/preset.h"
#if TESSERA_WITH_FOREIGN_PRESETS
#include "viewer/presets/foreign_preset.h"
#endif

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr const char* kExtension = ".json";
constexpr std::size_t kLongestName = 64;

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

void checkName(const std::string& name) {
    const auto fits = [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; };
    const bool isName = !name.empty() && name.size() <= kLongestName &&
                        fits(static_cast<unsigned char>(name.front())) &&
                        fits(static_cast<unsigned char>(name.back())) &&
                        std::all_of(name.begin(), name.end(),
                                    [&](unsigned char c) { return fits(c) || c == ' ' || c == '.'; });
    if (!isName)
        throw badFile("preset", "a name of letters, digits, \"-\" and \"_\", blanks and dots inside",
                      "\"" + name.substr(0, kLongestName) + "\"");
    if (const auto names = presetNames(); std::find(names.begin(), names.end(), name) != names.end())
        throw badFile("preset", "a name that is not built in (" + joinNames(names) + ")", "\"" + name + "\"");
}

fs::path ownFile(const std::string& name) {
    return ownPresetsFolder() / (name + kExtension);
}

#if TESSERA_WITH_FOREIGN_PRESETS
/// The format of a file's text, by its beginning and its keys; none: a preset or a scene of ours.
std::optional<PresetFormat> formatOf(const std::string& text, const std::string& where) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    const char first = begin == std::string::npos ? '\0' : text[begin];
    if (first == '<')
        return PresetFormat::slicerXml;
    if (std::isdigit(static_cast<unsigned char>(first)))
        return PresetFormat::slicerText;
    if (first != '{' && first != '[')
        throw badFile(where,
                      "a preset (JSON), a scene, a volume property of 3D Slicer (.vp.json, .vp, MRML) or a "
                      "colour map of ParaView (JSON)",
                      begin == std::string::npos ? "nothing" : "something else");
    const nlohmann::json document = parseStrictJson(text, where);
    if (document.is_array() || document.contains("RGBPoints"))
        return PresetFormat::paraView;
    if (document.contains("volumeProperties"))
        return PresetFormat::slicerJson;
    return std::nullopt;
}

/// The one that is meant: by name, or because there is no other.
ForeignPreset chosenOf(std::vector<ForeignPreset> all, const std::string& name, const std::string& where) {
    std::vector<std::string> names;
    for (const ForeignPreset& one : all)
        names.push_back(one.preset.name);
    if (name.empty()) {
        if (all.size() > 1)
            throw badFile(where, "FILE#NAME, as it holds " + std::to_string(all.size()) + " functions",
                          "no name; there are " + joinNames(names));
        return all.front();
    }
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
        throw badFile(where, "one of " + joinNames(names),
                      "\"" + name.substr(0, 40) + "\"; nearest: \"" + nearestName(name, names) + "\"");
    return all[static_cast<std::size_t>(at - names.begin())];
}

#endif

FoundPreset readPreset(const fs::path& file, const std::string& name) {
    const std::string where = file.string(), text = readTextFile(where);
    const std::string stem = file.stem().string();
#if TESSERA_WITH_FOREIGN_PRESETS
    if (const auto format = formatOf(text, where)) {
        ForeignPreset chosen = chosenOf(readForeignPresets(text, *format, where), name, where);
        if (chosen.preset.name.empty())
            chosen.preset.name = endsWith(stem, ".vp") ? stem.substr(0, stem.size() - 3) : stem;
        return {std::move(chosen.preset), std::move(chosen.leftOut)};
    }
#endif
    if (!name.empty())
        throw badFile(where, "a file of several functions before \"#" + name + "\"", "one function");
    return {isSceneFile(file) ? presetOf(loadScene(file), stem) : parsePreset(text, stem, where), {}};
}

} // namespace

fs::path ownPresetsFolder() {
    const fs::path folder = userConfigFolder();
    return folder.empty() ? folder : folder / "presets";
}

std::vector<std::string> ownPresetNames() {
    std::vector<std::string> names;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(ownPresetsFolder(), ignored))
        if (const std::string name = entry.path().filename().string();
            endsWith(name, kExtension) && name.front() != '.')
            names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

fs::path keepPreset(const Preset& preset) {
    checkName(preset.name);
    if (ownPresetsFolder().empty())
        throw Error("presets cannot be kept: neither XDG_CONFIG_HOME nor HOME names a folder");
    std::error_code ignored;
    fs::create_directories(ownPresetsFolder(), ignored);
    const fs::path file = ownFile(preset.name);
    writeOutputFile(file, presetJson(preset));
    return file;
}

void forgetPreset(const std::string& name) {
    const auto names = ownPresetNames();
    if (std::find(names.begin(), names.end(), name) == names.end())
        throw badFile("preset", "a name that was kept" + (names.empty() ? "" : " (" + joinNames(names) + ")"),
                      "\"" + name + "\"");
    std::error_code failed;
    if (!fs::remove(ownFile(name), failed) || failed)
        throw Error(ownFile(name).string() + ": cannot be removed: " + failed.message());
}

bool isOwnOrFile(const std::string& text) {
    const auto names = presetNames();
    return std::find(names.begin(), names.end(), text) == names.end();
}

FoundPreset findPreset(const std::string& text) {
    const auto own = ownPresetNames();
    if (std::find(own.begin(), own.end(), text) != own.end())
        return readPreset(ownFile(text), "");
    std::error_code ignored;
    if (fs::is_regular_file(text, ignored))
        return readPreset(text, "");
    if (const std::size_t hash = text.rfind('#');
        hash != std::string::npos && fs::is_regular_file(text.substr(0, hash), ignored))
        return readPreset(text.substr(0, hash), text.substr(hash + 1));
    std::vector<std::string> names = presetNames();
    names.insert(names.end(), own.begin(), own.end());
    throw badFile("preset", "one of " + joinNames(names) + ", or a file",
                  "\"" + text.substr(0, 80) + "\"; nearest: \"" + nearestName(text, names) + "\"");
}

const std::vector<std::string>& presetFormatNames() {
    static const std::vector<std::string> names = {"tessera", "slicer", "paraview"};
    return names;
}

std::vector<std::string> writePreset(const Preset& preset, const fs::path& file, const std::string& format) {
    const std::string chosen = !format.empty()                       ? format
                               : endsWith(file.string(), ".vp.json") ? "slicer"
                                                                     : "tessera";
    if (chosen == "tessera") {
        writeOutputFile(file, presetJson(preset));
        return {};
    }
    if (chosen != "slicer" && chosen != "paraview")
        throw badFile("--format", "one of " + joinNames(presetFormatNames()), "\"" + chosen + "\"");
#if TESSERA_WITH_FOREIGN_PRESETS
    const ForeignText out =
        writeForeignPreset(preset, chosen == "slicer" ? PresetFormat::slicerJson : PresetFormat::paraView);
    writeOutputFile(file, out.text);
    return out.leftOut;
#else
    throw badFile("--format", "tessera: this build has no VTK", "\"" + chosen + "\"");
#endif
}

} // namespace tessera
