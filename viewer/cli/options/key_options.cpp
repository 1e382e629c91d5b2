// viewer/cli/options/key_options.cpp: see key_options.h.
#include "viewer/cli/options/key_options.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

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

bool isOf(const KeyRow& row, const char* type) {
    return row.schema.value("type", "") == type;
}

std::string withWord(std::string text, const std::string& mark, const std::string& word) {
    if (const std::size_t at = text.find(mark); at != std::string::npos)
        text.replace(at, mark.size(), word);
    return text;
}

std::string aboutOf(const KeyRow& row, const std::map<std::string, std::string>& words) {
    const bool isName = json::accept(row.preset) && json::parse(row.preset).is_string();
    std::string text = withWord(row.option.about, "{names}", joinNames(row.names));
    text = withWord(text, "{default}", isName ? json::parse(row.preset).get<std::string>() : row.preset);
    for (const auto& [mark, word] : words)
        text = withWord(text, mark, word);
    return text;
}

/// Checks a number where the option has words of its own for its range; else its key does when it is set.
void checkNumber(const KeyRow& row, Option& option) {
    constexpr double kMost = std::numeric_limits<double>::max();
    const double lowest = row.schema.value("minimum", -kMost), highest = row.schema.value("maximum", kMost);
    if (isOf(row, "integer") && highest == std::numeric_limits<int>::max())
        option.check(wholeNumberFrom(static_cast<int>(lowest))); // without naming that end
    else if (!row.option.range.empty())
        option.check(numberWithin(lowest, highest, row.option.range));
}

/// "volumes[].unit": a scene has one volume.
std::string keyOf(const KeyRow& row) {
    return withWord(row.path, "[]", "[0]");
}

} // namespace

Option addSetOption(Command& command, std::vector<std::string>& sets, const std::string& of,
                    const std::string& more) {
    return command
        .option("--set", sets,
                "KEY=VALUE: a key of " + of +
                    ", such as shading.ambient=0.4, window=[40,400] or isosurfaces[0].opacity=0.5" + more +
                    "; may be repeated")
        .oneValueEach();
}

void applySets(const std::vector<std::string>& sets, Scene& scene) {
    for (const std::string& said : sets) {
        const std::size_t equals = said.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == said.size())
            throw badFile("--set", "KEY=VALUE, a key of scenes and its value in JSON, or a word",
                          "\"" + said.substr(0, 60) + "\"");
        const std::string key = said.substr(0, equals);
        setSceneKey(scene, key, valueOf(said.substr(equals + 1)), "--set " + key);
    }
}

void KeyOptions::add(Command& command, const std::vector<std::string>& keys) {
    for (const std::string& key : keys)
        addOf(command, key);
}

void KeyOptions::addOf(Command& command, const std::string& key) {
    const auto isThere = [&](const KeyRow& row) {
        return std::any_of(rows_.begin(), rows_.end(),
                           [&](const Row& added) { return added.option == row.option.name; });
    };
    bool known = key.empty();
    for (const KeyRow& row : sceneKeys()) {
        const bool isMeant = key.empty() || row.path == key || row.path.starts_with(key + ".");
        known = known || isMeant;
        if (!isMeant || row.option.name.empty() || isThere(row))
            continue;
        const std::string about = aboutOf(row, words_);
        Row& added = rows_.emplace_back(Row{row.option.name, keyOf(row)});
        if (isOf(row, "boolean")) {
            added.flagMeans = row.preset != "true";
            command.flag(added.option, added.flag, about);
            continue;
        }
        Option option = command.option(added.option, added.text, about);
        added.isNumber = isOf(row, "number") || isOf(row, "integer");
        if (!added.isNumber)
            continue;
        option.takes(isOf(row, "integer") ? "INT" : "FLOAT");
        checkNumber(row, option);
    }
    TESSERA_CHECK(known);
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
            setSceneKey(scene, row.key, row.flagMeans, row.option);
        else if (!row.text.empty())
            setSceneKey(scene, row.key, row.isNumber ? numberOrWord(row.text) : json(row.text), row.option);
}

} // namespace tessera
