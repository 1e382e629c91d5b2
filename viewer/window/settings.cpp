// viewer/window/settings.cpp: see settings.h.
#include "viewer/window/settings.h"

#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/output_file.h"
#include "core/base/program_folders.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace tessera {
namespace fs = std::filesystem;

void Settings::opened(const fs::path& path) {
    const fs::path whole = keptPlace(path);
    std::erase(recent, whole);
    recent.insert(recent.begin(), whole);
    if (recent.size() > kMostRecent)
        recent.resize(kMostRecent);
}

fs::path settingsFile() {
    const fs::path folder = userConfigFolder();
    return folder.empty() ? folder : folder / "window.json";
}

Settings loadSettings(const fs::path& file) {
    Settings settings;
    if (isPipeOrDevice(file))
        return settings;
    std::ifstream stream(file);
    const std::string text((std::istreambuf_iterator<char>(stream)), {});
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object())
        return settings;
    const auto found = [&](const char* key) { return json.contains(key) ? json[key] : nlohmann::json(); };
    if (const auto size = found("windowSize");
        size.is_array() && size.size() == 2 && size[0].is_number_integer() && size[1].is_number_integer())
        settings.windowSize = {std::clamp(size[0].get<int>(), 320, 16384),
                               std::clamp(size[1].get<int>(), 240, 16384)};
    if (const auto recent = found("recent"); recent.is_array())
        for (const auto& path : recent)
            if (path.is_string() && settings.recent.size() < Settings::kMostRecent)
                settings.recent.emplace_back(path.get<std::string>());
    if (const auto folder = found("folder"); folder.is_string())
        settings.folder = folder.get<std::string>();
    if (const auto panels = found("panels"); panels.is_boolean())
        settings.panels = panels.get<bool>();
    return settings;
}

std::string saveSettings(const Settings& settings, const fs::path& file) {
    if (file.empty())
        return {};
    nlohmann::json json = {{"windowSize", {settings.windowSize.x, settings.windowSize.y}},
                           {"panels", settings.panels},
                           {"folder", settings.folder.string()},
                           {"recent", nlohmann::json::array()}};
    for (const fs::path& path : settings.recent)
        json["recent"].push_back(path.string());
    try {
        std::error_code ignored;
        fs::create_directories(file.parent_path(), ignored);
        writeOutputFile(file, json.dump(2, ' ', true, nlohmann::json::error_handler_t::replace) + "\n");
    } catch (const Error& e) {
        return e.what();
    }
    return {};
}

} // namespace tessera
