// viewer/cli/options/key_options.cpp: see key_options.h.
#include "viewer/cli/options/key_options.h"

#include "core/base/error.h"
#include "core/base/nearest_name.h"
#include "core/scene/scene_fields.h"

#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

using nlohmann::json;

/// A number as strtod() knows it, whole where it is; else the word.
json numberOrWord(const std::string& text) {
    constexpr double kExact = 9007199254740992; // 2^53: as whole numbers all doubles below are exact
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(number))
        return text;
    if (number == std::floor(number) && std::abs(number) < kExact)
        return static_cast<std::int64_t>(number);
    return number;
}

/// JSON, or a bare word.
json valueOf(const std::string& text) {
    return json::accept(text) ? parseStrictJson(text, "--set") : numberOrWord(text);
}

std::string aboutWith(const std::string& about, const std::string& key) {
    std::string text = about;
    const auto replace = [&text](const std::string& mark, const std::string& by) {
        if (const std::size_t at = text.find(mark); at != std::string::npos)
            text.replace(at, mark.size(), by);
    };
    for (const KeyRow& row : keysOf(sceneSchema()))
        if (row.path == key) {
            replace("{names}", joinNames(row.names));
            replace("{default}", json::accept(row.preset) && json::parse(row.preset).is_string()
                                     ? json::parse(row.preset).get<std::string>()
                                     : row.preset);
        }
    return text;
}

} // namespace

Option KeyOptions::word(Command& command, const std::string& option, const std::string& key,
                        const std::string& about) {
    rows_.push_back({option, key});
    return command.option(option, rows_.back().text, aboutWith(about, key));
}

Option KeyOptions::number(Command& command, const std::string& option, const std::string& key,
                          const std::string& about) {
    rows_.push_back({option, key, true});
    return command.option(option, rows_.back().text, aboutWith(about, key));
}

Option KeyOptions::noFlag(Command& command, const std::string& option, const std::string& key,
                          const std::string& about) {
    rows_.push_back({option, key});
    return command.flag(option, rows_.back().flag, aboutWith(about, key));
}

Option KeyOptions::set(Command& command) {
    return command
        .option("--set", sets_,
                "KEY=VALUE: a key of the scene, such as shading.ambient=0.4, window=[40,400] or "
                "isosurfaces[0].opacity=0.5; overrides other options; may be repeated")
        .oneValueEach();
}

std::string KeyOptions::textOf(const std::string& option) const {
    for (const Row& row : rows_)
        if (row.option == option)
            return row.text;
    return {};
}

bool KeyOptions::says(const std::string& key) const {
    for (const Row& row : rows_)
        if (row.key == key && (row.flag || !row.text.empty()))
            return true;
    for (const std::string& said : sets_) {
        const std::string set = said.substr(0, said.find('='));
        if (key == set || key.starts_with(set + "."))
            return true;
    }
    return false;
}

void KeyOptions::apply(Scene& scene) const {
    for (const Row& row : rows_)
        if (row.flag)
            setSceneKey(scene, row.key, false, row.option);
        else if (!row.text.empty())
            setSceneKey(scene, row.key, row.isNumber ? numberOrWord(row.text) : json(row.text), row.option);
}

void KeyOptions::applySets(Scene& scene) const {
    for (const std::string& said : sets_) {
        const std::size_t equals = said.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == said.size())
            throw badFile("--set", "KEY=VALUE, a key of scenes and its value in JSON, or a word",
                          "\"" + said.substr(0, 60) + "\"");
        const std::string key = said.substr(0, equals);
        setSceneKey(scene, key, valueOf(said.substr(equals + 1)), "--set " + key);
    }
}

} // namespace tessera
