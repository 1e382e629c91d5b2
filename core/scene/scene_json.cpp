// core/scene/scene_json.cpp: the part of scene.h that reads and writes scenes, by their table of keys
// (scene_fields.h). Strict: what is not understood is refused, because a scene that is read halfway draws a
// wrong picture.
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <string_view>

namespace tessera {

using nlohmann::json;

namespace {

/// The value below another at the steps of a key (".ambient", "[0].opacity", ""); null if there is none.
json& below(json& value, std::string_view steps, const std::string& where) {
    if (steps.empty())
        return value;
    const bool inList = steps.front() == '[';
    const std::size_t end = std::min(steps.find_first_of(inList ? "]" : ".[", 1), steps.size());
    const std::string step(steps.substr(1, end - 1));
    steps.remove_prefix(std::min(end + (inList ? 1 : 0), steps.size()));
    if (!inList) {
        if (!value.is_object())
            value = json::object();
        return below(value[step], steps, where);
    }
    if (!value.is_array())
        value = json::array();
    constexpr std::size_t kDigits = 6;
    const bool isNumber =
        !step.empty() && step.size() <= kDigits && step.find_first_not_of("0123456789") == std::string::npos;
    const std::size_t at = isNumber ? std::stoul(step) : value.size() + 1;
    if (at > value.size())
        throw badFile(where, "an item from 0 to " + std::to_string(value.size()), "[" + step + "]");
    if (at == value.size())
        value.push_back(nullptr);
    return below(value[at], steps, where);
}

/// The nearest key, by its whole path or its last name alone; of equally near ones the shortest.
std::string nearestKey(const std::string& key) {
    const auto away = [&](const KeyRow& row) {
        const std::string name = row.path.substr(row.path.rfind('.') + 1);
        return std::pair(std::min(editDistance(key, row.path), editDistance(key, name)), row.path.size());
    };
    const std::vector<KeyRow>& keys = sceneKeys();
    return std::min_element(keys.begin(), keys.end(),
                            [&](const KeyRow& a, const KeyRow& b) { return away(a) < away(b); })
        ->path;
}

} // namespace

void setSceneKey(Scene& scene, const std::string& key, const json& value, const std::string& where) {
    constexpr std::ptrdiff_t kDeepest = 16; // steps; more than any key of a scene has
    if (std::count_if(key.begin(), key.end(), [](char c) { return c == '.' || c == '['; }) > kDeepest)
        throw badFile(where.substr(0, 60), "a key of scenes", "\"" + key.substr(0, 60) + "...\"");
    const std::size_t end = std::min(key.find_first_of(".["), key.size());
    const std::string first = key.substr(0, end);
    for (const Field<Scene>& row : sceneFields().rows()) {
        if (row.key != first)
            continue;
        json part = row.write(scene);
        below(part, std::string_view(key).substr(end), where) = value;
        Scene changed = scene; // stays as it was where that is refused
        row.read(JsonValue::typed(part, where), changed);
        scene = std::move(changed);
        return;
    }
    throw badFile(where, "a key of scenes",
                  "\"" + key.substr(0, 60) + "\"; nearest: \"" + nearestKey(key) + "\"");
}

bool isSceneFile(const std::filesystem::path& path) {
    std::error_code ignored;
    if (path.extension() != ".json" || !std::filesystem::is_regular_file(path, ignored))
        return false;
    const json document = json::parse(readTextFile(path.string()), nullptr, false);
    return document.is_discarded() || document.contains("tesseraScene") || document.contains("volumes") ||
           document.contains("camera");
}

Scene parseScene(const std::string& text, const std::filesystem::path& folder, const std::string& where) {
    const json document = parseStrictJson(text, where);
    Scene scene = sceneFields().read({document, where});
    for (SceneVolume& volume : scene.volumes)
        for (std::filesystem::path* path : {&volume.path, &volume.labels.path, &volume.labels.names})
            if (!path->empty() && *path != Labels::kTotalSegmentator)
                *path = absolutePlace(folder, *path);
    for (SceneMesh& mesh : scene.meshes)
        if (!mesh.path.empty())
            mesh.path = absolutePlace(folder, mesh.path);
    if (auto& sky = scene.lighting.environment; sky && !sky->file.path.empty())
        sky->file.path = std::filesystem::absolute(folder / sky->file.path).lexically_normal();
    return scene;
}

Scene loadScene(const std::filesystem::path& file) {
    return parseScene(readTextFile(file.string()), file.parent_path(), file.string());
}

std::string sceneJson(const Scene& scene) {
    return sceneFields().write(scene).dump(-1, ' ', true, json::error_handler_t::replace);
}

const std::vector<KeyRow>& sceneKeys() {
    static const std::vector<KeyRow> keys = keysOf(sceneSchema());
    return keys;
}

const Schema& sceneSchema() {
    static const Schema schema = [] {
        Schema parts = Schema::object();
        Schema root = sceneFields().schema(parts);
        return documentSchema(
            "Tessera scene, version 1",
            "Everything a picture depends on. Keys follow VTK and 3D Slicer where they have one. "
            "Lengths are millimetres in DICOM patient space (LPS), values are physical units (HU "
            "for CT), colours are linear light unless said otherwise.",
            std::move(root), std::move(parts));
    }();
    return schema;
}

} // namespace tessera
