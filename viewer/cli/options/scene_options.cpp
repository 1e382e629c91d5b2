// viewer/cli/options/scene_options.cpp: see scene_options.h.
#include "viewer/cli/options/scene_options.h"

#include "core/base/decimal.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene_fields.h"
#include "viewer/cli/options/scene_words.h"
#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

using nlohmann::json;

/// A decimal number, whole where it is; else the word.
json numberOrWord(const std::string& text) {
    constexpr double kExact = 9007199254740992; // 2^53: as whole numbers all doubles below are exact
    const std::optional<double> number = decimalNumber(text);
    if (!number)
        return text;
    if (*number == std::floor(*number) && std::abs(*number) < kExact)
        return static_cast<std::int64_t>(*number);
    return *number;
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

/// An option whose mere name turns off what its key means: --no-shading.
bool turnsOff(const KeyRow& row) {
    return isOf(row, "boolean") && row.preset == "true" && !row.option.name.empty();
}

/// Options are about the first volume: "volumes[].unit" is "volumes[0].unit".
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
        if (equals == std::string::npos || equals == 0)
            throw badFile("--set", "KEY=VALUE, a key of scenes and its value in JSON, or a word",
                          "\"" + said.substr(0, 60) + "\"");
        const std::string name = said.substr(0, equals), text = said.substr(equals + 1);
        const std::string where = "--set " + name, key = keyNamed(name);
        if (setByWord(scene, name, text, where))
            continue;
        if (key.empty() && !keyInPlaceOf(name).empty())
            throw badFile(where, "a key of scenes", "\"" + name + "\"" + keyHint(name));
        if (!key.empty() && key != name) // an option's name
            setKeyFromText(scene, key, text, where);
        else
            setSceneKey(scene, name, valueOf(text), where);
    }
}

namespace {

/// "isosurfaces[2].opacity" as the table of keys has it: "isosurfaces[].opacity".
std::string withoutNumbers(const std::string& key) {
    std::string text;
    bool inside = false;
    for (const char c : key) {
        inside = inside && c != ']';
        if (!inside)
            text += c;
        inside = inside || c == '[';
    }
    return text;
}

const KeyRow* rowOf(const std::string& key) {
    const std::string path = withoutNumbers(key);
    const auto& rows = sceneKeys();
    const auto row = std::ranges::find(rows, path, &KeyRow::path);
    return row == rows.end() ? nullptr : &*row;
}

/// A list, a side or a camera that holds keys.
bool holdsKeys(const std::string& key) {
    const std::string path = withoutNumbers(key);
    return !path.empty() && std::ranges::any_of(sceneKeys(), [&](const KeyRow& row) {
        return row.path.starts_with(path) && row.path.size() > path.size() &&
               (row.path[path.size()] == '.' || row.path[path.size()] == '[');
    });
}

/// A value of a key as a user types it.
json typedValue(const std::string& key, const std::string& text, const std::string& where) {
    const KeyRow* const row = rowOf(key);
    const bool isStructured = text.starts_with('[') || text.starts_with('{');
    if (!row || (isStructured && !isOf(*row, "string") && json::accept(text)))
        return json::accept(text) ? parseStrictJson(text, where) : numberOrWord(text);
    if (const std::optional<bool> truth = truthOf(text); truth && isOf(*row, "boolean"))
        return *truth;
    if (isOf(*row, "number") || isOf(*row, "integer")) {
        if (hasDecimalComma(text))
            throw badFile(where, "a number with a decimal point",
                          "\"" + text.substr(0, 60) + "\"; a decimal comma is not read");
        return numberOrWord(text);
    }
    const bool isQuoted = text.size() > 1 && text.front() == '"' && json::accept(text);
    if (!isQuoted && (isOf(*row, "string") || !row->option.name.empty()))
        return text;
    return json::accept(text) ? parseStrictJson(text, where) : numberOrWord(text);
}

} // namespace

std::string keyNamed(const std::string& name) {
    if (name.empty() || name.find_first_of(" \t") != std::string::npos)
        return {};
    if (const std::string word = wordOf(name); !word.empty())
        return keyOfWord(word).empty() ? word : keyOfWord(word);
    const std::string option = name.starts_with("--") ? name : "--" + name;
    for (const KeyRow& row : sceneKeys())
        if (row.option.name == option && name != row.path && !turnsOff(row))
            return keyOf(row);
    return rowOf(name) || holdsKeys(name) ? name : std::string();
}

std::string keyHint(const std::string& name) {
    if (const std::string key = keyInPlaceOf(name); !key.empty())
        return "; nearest: \"" + key + "\"";
    const std::string word = name.starts_with("--") ? name.substr(2) : name;
    std::vector<std::string> names = sceneWords();
    for (const KeyRow& row : sceneKeys()) {
        if (turnsOff(row) && row.option.name == "--" + word)
            return "; nearest: \"" + keyOf(row) + "\"";
        names.push_back(keyOf(row));
        if (!row.option.name.empty() && !turnsOff(row))
            names.push_back(row.option.name.substr(2));
    }
    const auto away = [&](const std::string& one) {
        const std::string last = one.substr(one.rfind('.') + 1);
        return std::pair(std::min(editDistance(word, one), editDistance(word, last)), one.size());
    };
    const std::string nearest = *std::ranges::min_element(names, {}, away);
    constexpr std::size_t kSlips = 2; // letters swapped, or two keys beside the right ones
    return away(nearest).first <= std::max(kSlips, word.size() / 3) && word.size() > kSlips
               ? "; nearest: \"" + nearest + "\""
               : std::string();
}

void setKeyFromText(Scene& scene, const std::string& key, const std::string& text, const std::string& where) {
    const std::string word = wordOfKey(key);
    if (setByWord(scene, word.empty() ? key : word, text, where))
        return;
    if (const auto* free = std::get_if<Camera>(&scene.camera); free && key == "camera.view") {
        FittedView view;
        view.projection = free->projection;
        view.named = true;
        Scene seen = scene; // stays as it was where the value is refused
        seen.camera = view;
        setSceneKey(seen, key, typedValue(key, text, where), where);
        scene = std::move(seen);
        return;
    }
    const auto* const free = std::get_if<Camera>(&scene.camera);
    const std::optional<Camera> before = free ? std::optional(*free) : std::nullopt;
    setSceneKey(scene, key, typedValue(key, text, where), where);
    if (before && key == "camera.parallelProjection") { // of the same size at the focal point
        auto& camera = std::get<Camera>(scene.camera);
        camera = projectedBy(*before, camera.projection);
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
            added.flagMeans = !turnsOff(row);
            command.flag(added.option, added.flag, about);
            continue;
        }
        Option option = command.option(added.option, added.text, about);
        if (!row.names.empty())
            option.offers(row.names);
        added.isNumber = isOf(row, "number") || isOf(row, "integer");
        if (!added.isNumber)
            continue;
        option.takes(isOf(row, "integer") ? "INT" : "FLOAT");
        checkNumber(row, option);
    }
    TESSERA_CHECK(known);
}

namespace {
constexpr const char* kSameFrame = "--same-frame";
} // namespace

std::string KeyOptions::textOf(const std::string& option) const {
    for (const Row& row : rows_)
        if (row.option == option)
            return row.text;
    return {};
}

bool KeyOptions::takesAnyFrame() const {
    return std::any_of(rows_.begin(), rows_.end(),
                       [](const Row& row) { return row.option == kSameFrame && row.flag; });
}

void KeyOptions::checkFrames(const Scene& scene) const {
    const bool isOfSomething =
        std::ranges::any_of(scene.volumes, [](const auto& v) { return !v.labels.path.empty(); }) ||
        std::ranges::any_of(scene.meshes, [](const SceneMesh& mesh) { return !mesh.path.empty(); });
    if (takesAnyFrame() && !isOfSomething)
        throw badFile(kSameFrame, "labels (--labels) or a structure set (--mesh)", "none");
}

void takeAnyFrame(Scene& scene) {
    for (SceneVolume& volume : scene.volumes)
        volume.labels.sameFrame = volume.labels.sameFrame || !volume.labels.path.empty();
    for (SceneMesh& mesh : scene.meshes)
        mesh.sameFrame = mesh.sameFrame || !mesh.path.empty();
}

bool KeyOptions::says(const std::string& key) const {
    for (const Row& row : rows_)
        if (row.key == key && (row.flag || !row.text.empty()))
            return true;
    for (const std::string& said : sets_) {
        const std::string name = said.substr(0, said.find('=')), named = keyNamed(name);
        const std::string set = named.empty() ? name : named;
        if (key == set || key.starts_with(set + "."))
            return true;
    }
    return false;
}

void KeyOptions::apply(Scene& scene) const {
    const bool hasLabels = !scene.volumes.front().labels.path.empty() || !textOf("--labels").empty();
    for (const Row& row : rows_)
        if (!hasLabels && !row.text.empty() && row.key.starts_with("volumes[0].labels."))
            throw badFile(row.option, "labels beside the volume (--labels)", "none");
    for (const Row& row : rows_)
        if (row.flag && row.option == kSameFrame)
            takeAnyFrame(scene);
        else if (row.flag)
            setSceneKey(scene, row.key, row.flagMeans, row.option);
        else if (!row.text.empty())
            setSceneKey(scene, row.key, row.isNumber ? numberOrWord(row.text) : json(row.text), row.option);
}

namespace {

constexpr char kPlaneForm[] = "X,Y,Z,NX,NY,NZ";

void applyCuts(const ModeOptions& options, Cuts& cuts) {
    const std::size_t named = options.boxes.size() + options.boxesInVoxels.size() + options.planes.size();
    Keep keep = Keep::inside;
    if (!options.keep.empty()) {
        if (options.keep != "inside" && options.keep != "outside")
            throw badFile("--keep", "inside or outside", "\"" + options.keep.substr(0, 40) + "\"");
        if (named == 0)
            throw badFile("--keep", "--crop, --crop-voxels or --cut-plane, of which it keeps one side",
                          "none");
        keep = options.keep == "outside" ? Keep::outside : Keep::inside;
    }
    if (options.cutVolume >= 0 && named == 0)
        throw badFile("--cut-volume", "--crop, --crop-voxels or --cut-plane, which cut it", "none");
    const auto addBox = [&](const std::string& text, const char* option, CropBox::Space space) {
        const bool patient = space == CropBox::Space::patient;
        cuts.boxes.push_back(cropBoxOf(text, option, space, patient ? kCropForms : kBoxForm));
        cuts.boxes.back().keep = keep;
    };
    for (const std::string& text : options.boxes)
        if (text != ModeOptions::kBody) // found in the volume, once there is one
            addBox(text, "--crop", CropBox::Space::patient);
    for (const std::string& text : options.boxesInVoxels)
        addBox(text, "--crop-voxels", CropBox::Space::voxels);
    for (const std::string& text : options.planes) {
        const std::vector<double> n = parseNumbers(text, 6, "--cut-plane", kPlaneForm);
        cuts.planes.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, keep});
        checkPlane(cuts.planes.back(), "--cut-plane");
    }
    if (cuts.boxes.size() > Cuts::kMostOfAKind || cuts.planes.size() > Cuts::kMostOfAKind)
        throw badFile(cuts.boxes.size() > Cuts::kMostOfAKind ? "--crop" : "--cut-plane",
                      "at most " + std::to_string(Cuts::kMostOfAKind) + " of a kind", "more");
}

} // namespace

CropBox cropBoxOf(const std::string& text, const std::string& option, CropBox::Space space,
                  const char* forms) {
    const std::vector<double> n = parseNumbers(text, 6, option, forms);
    const CropBox box{{n[0], n[2], n[4]}, {n[1], n[3], n[5]}, space, Keep::inside};
    checkBox(box, option);
    return box;
}

void addModeOptions(Command& command, ModeOptions& options) {
    command.option("--slice", options.slice,
                   std::string("a plane: ") + kSliceForm +
                       " (default: the volume's middle); implies --mode slice");
    command.option("--slab", options.slab,
                   std::string("thickness of the slice and its reduction: ") + kSlabForm +
                       " (default: 0, a plane)");
    command.option("--crop", options.boxes,
                   std::string("draw only the inside of a box along the patient's axes, mm: ") + kBoxForm +
                       ", or body: the patient's, without the table (CT); of several, their intersection");
    command.option("--crop-voxels", options.boxesInVoxels,
                   std::string("the same along the volume's axes, in voxels from 0: ") + kBoxForm);
    command.option("--cut-plane", options.planes,
                   std::string("draw only the side that the normal points to: ") + kPlaneForm +
                       " (a point and a normal, mm); of several, their intersection");
    command.option(
        "--keep", options.keep,
        "side of --crop, --crop-voxels and --cut-plane that is drawn: inside or outside (default: inside)");
    command
        .option("--cut-volume", options.cutVolume,
                "the one volume that --crop, --crop-voxels and --cut-plane cut: 0 is X, 1 the first of --add "
                "(default: all volumes)")
        .check(wholeNumberFrom(0));
}

Cuts& cutsOf(const ModeOptions& options, Scene& scene) {
    if (options.cutVolume < 0)
        return scene.cuts;
    const auto number = static_cast<std::size_t>(options.cutVolume);
    if (number >= scene.volumes.size())
        throw badFile("--cut-volume",
                      "a volume of the picture, 0 to " + std::to_string(scene.volumes.size() - 1),
                      std::to_string(number));
    return scene.volumes[number].cuts;
}

void applyModeOptions(const ModeOptions& options, const KeyOptions& keys, Scene& scene) {
    if (!options.slice.empty()) {
        scene.slice = parseSlice(options.slice, "--slice", scene.slice);
        if (const std::string text = keys.textOf("--mode"); !text.empty() && scene.mode != Mode::slice)
            throw badFile("--slice", "--mode slice", "--mode " + text);
        scene.mode = Mode::slice;
    }
    if (!options.slab.empty())
        parseSlab(options.slab, scene.slice, "--slab");
    applyCuts(options, cutsOf(options, scene));
}

std::optional<InputError> refusalByMode(const ModeOptions& options, const KeyOptions& keys,
                                        const Scene& scene) {
    const std::string mode = "mode " + nameOf(scene.mode);
    if (!options.slab.empty() && scene.mode != Mode::slice)
        return badFile("--slab", "a slice (--slice)", mode);
    for (const char* option : {"--window", "--value-colour"})
        if (!keys.textOf(option).empty() && reductionOf(scene) == Reduction::composite)
            return badFile(option,
                           "a mode that shows single values or sums (--mode maximum, minimum, average, "
                           "slice, emission, absorption or radiograph)",
                           mode);
    return std::nullopt;
}

} // namespace tessera
