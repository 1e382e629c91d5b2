// core/scene/scene_presets.cpp: see scene_presets.h. A preset's keys are read and written like a scene's: by
// way of a scene.
#include "core/scene/scene_presets.h"

#include "core/base/embedded.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/scene/preset.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

const std::vector<std::string> kUnits = {"", "HU", "share of range",
                                         "share of object"}; // in the order of PresetUnit

/// A scene of defaults and a preset's keys.
Scene sceneOf(const json& look, const std::string& where) {
    json document = look;
    document["tesseraScene"] = Scene::kVersion;
    document["volumes"] = {{{"path", "/volume"}}};
    return parseScene(document.dump(), {}, where);
}

} // namespace

const std::vector<std::string>& lookKeys() {
    static const std::vector<std::string> keys = {"mode",    "window",   "valueColour", "slice",
                                                  "shading", "lighting", "isosurfaces", "cuts"};
    return keys;
}

Preset parsePreset(const std::string& text, const std::string& name, const std::string& where) {
    const json document = parseStrictJson(text, where);
    const JsonValue root(document, where);
    std::vector<std::string> keys = transferFields().keys();
    keys.insert(keys.end(), {"tesseraPreset", "description", "unit"});
    keys.insert(keys.end(), lookKeys().begin(), lookKeys().end());
    root.requireKeys(keys);
    root.at("tesseraPreset").integer(1, 1);
    Preset preset;
    preset.name = name;
    if (root.has("description"))
        preset.description = root.at("description").text();
    if (root.has("unit")) {
        const std::string unit = root.at("unit").oneOf(kUnits);
        preset.unit = static_cast<PresetUnit>(std::find(kUnits.begin(), kUnits.end(), unit) - kUnits.begin());
    }
    preset.function = parseTransfer(root);
    json look = json::object();
    for (const std::string& key : lookKeys())
        if (document.contains(key))
            look[key] = document[key];
    sceneOf(look, where);
    preset.look = look.dump();
    return preset;
}

std::string presetJson(const Preset& preset) {
    json out = transferJson(preset.function);
    out["tesseraPreset"] = 1;
    out["description"] = preset.description;
    out["unit"] = kUnits[static_cast<std::size_t>(preset.unit)];
    out.update(json::parse(preset.look));
    return out.dump(2, ' ', true, json::error_handler_t::replace) + "\n";
}

Preset presetOf(const Scene& scene, const std::string& name) {
    const auto* const function = std::get_if<TransferFunction>(&scene.volumes.front().transferFunction);
    if (!function)
        throw badFile("preset", "a transfer function that is spelled out",
                      "the name \"" + std::get<std::string>(scene.volumes.front().transferFunction) + "\"");
    Preset preset;
    preset.name = name;
    preset.unit = scene.volumes.front().unit == "HU" ? PresetUnit::hu : PresetUnit::any;
    preset.function = *function;
    // Defaults are written here, unlike in scenes, because they replace values of another scene.
    const json whole = json::parse(sceneJson(scene));
    json look = {{"mode", nameOf(scene.mode)},
                 {"valueColour", nameOf(scene.valueColour)},
                 {"window", "auto"},
                 {"lighting", json::object()}};
    for (const std::string& key : lookKeys())
        if (whole.contains(key))
            look[key] = whole[key];
    preset.look = look.dump();
    return preset;
}

void applyPreset(const Preset& preset, Scene& scene) {
    const std::string where = "preset " + preset.name;
    if (overShares(preset))
        throw InputError(where + ": expected a function of values, found one over shares of a range, 0 to 1 "
                                 "(tessera preset FILE --range LOW,HIGH -o NEW.json says which range)");
    const json look = json::parse(preset.look);
    const Scene looked = sceneOf(look, where);
    const auto take = [&](const char* key, auto Scene::*member) {
        if (look.contains(key))
            scene.*member = looked.*member;
    };
    take("mode", &Scene::mode);
    take("window", &Scene::window);
    take("valueColour", &Scene::valueColour);
    take("slice", &Scene::slice);
    take("shading", &Scene::shading);
    take("lighting", &Scene::lighting);
    take("isosurfaces", &Scene::surfaces);
    take("cuts", &Scene::cuts);
    scene.volumes.front().transferFunction = preset.function;
}

void applyBuiltInPreset(const std::string& name, const TransferChoice& function, Scene& scene) {
    Preset preset = builtInPreset(name);
    preset.unit = PresetUnit::any; // the function is explicit
    const auto putAway = [&](const char* key, auto Scene::*member) {
        const Scene plain;
        if (scene.*member == plain.*member)
            return;
        for (const std::string& other : presetNames()) {
            const json look = json::parse(builtInPreset(other).look);
            if (look.contains(key) && sceneOf(look, "preset " + other).*member == scene.*member) {
                scene.*member = plain.*member;
                return;
            }
        }
    };
    putAway("window", &Scene::window);
    putAway("valueColour", &Scene::valueColour);
    putAway("slice", &Scene::slice);
    putAway("shading", &Scene::shading);
    scene.mode = Mode::composite;
    applyPreset(preset, scene);
    scene.volumes.front().transferFunction = function;
}

std::vector<std::string> lookSaysOf(const Preset& preset) {
    // Both are written in full as by presetOf(), so that a written default is no difference.
    const auto spelled = [](Scene scene) {
        scene.volumes.front().transferFunction = TransferFunction();
        return json::parse(presetOf(scene, "").look);
    };
    const json said = spelled(sceneOf(json::parse(preset.look), "preset " + preset.name)),
               plain = spelled(sceneOf(json::object(), "preset"));
    std::vector<std::string> keys;
    for (const auto& [key, value] : said.items())
        if (!plain.contains(key) || plain[key] != value)
            keys.push_back(key);
    return keys;
}

bool overShares(const Preset& preset) {
    return preset.unit == PresetUnit::share || preset.unit == PresetUnit::object;
}

Preset overRange(Preset preset, double lowest, double highest) {
    if (!(std::isfinite(lowest) && std::isfinite(highest) && lowest < highest))
        throw badFile("preset " + preset.name, "a range of values, the lowest first",
                      std::to_string(lowest) + " to " + std::to_string(highest));
    if (!overShares(preset))
        return preset;
    const auto valueAt = [&](double share) { return lowest + share * (highest - lowest); };
    std::vector<OpacityPoint> opacity = preset.function.opacityPoints();
    for (OpacityPoint& point : opacity)
        point.value = valueAt(point.value);
    std::vector<ColourPoint> colour = preset.function.colourPoints();
    for (ColourPoint& point : colour)
        point.value = valueAt(point.value);
    TransferFunction ranged =
        TransferFunction::fromOpacity(opacity, colour, preset.function.referenceLengthMm());
    std::vector<GradientPoint> lengths = preset.function.gradientOpacity().points();
    for (GradientPoint& point : lengths)
        point.length *= highest - lowest;
    std::vector<Tissue> tissues = preset.function.tissues();
    for (Tissue& tissue : tissues)
        tissue.from = valueAt(tissue.from), tissue.to = valueAt(tissue.to);
    ranged.setTissues(std::move(tissues));
    std::vector<Material> materials = preset.function.materials();
    for (Material& material : materials)
        material.from = valueAt(material.from), material.to = valueAt(material.to);
    ranged.setMaterials(std::move(materials));
    ranged.setGradientOpacity(
        GradientOpacity::fromPoints(std::move(lengths), preset.function.gradientOpacity().per()));
    preset.function = std::move(ranged);
    preset.unit = PresetUnit::any;
    return preset;
}

namespace looks {
const EmbeddedFiles& embeddedFiles(); // generated from core/scene/looks/*.json
}

const std::vector<std::string>& lookNames() {
    static const std::vector<std::string> names = {"plain",     "studio",   "soft", "dramatic", "endoscope",
                                                   "cinematic", "daylight", "rim",  "soft-1"};
    return names;
}

void applyLook(const std::string& name, Scene& scene) {
    const std::vector<std::string>& names = lookNames();
    if (std::find(names.begin(), names.end(), name) == names.end())
        throw badFile("light", "one of " + joinNames(names),
                      "\"" + name.substr(0, 40) + "\"; nearest: \"" + nearestName(name, names) + "\"");
    const std::string where = "look " + name;
    const auto document = parseStrictJson(std::string(looks::embeddedFiles().at(name + ".json")), where);
    const JsonValue root(document, where);
    root.requireKeys({"tesseraLook", "description", "shading", "lighting"});
    root.at("tesseraLook").integer(1, 1);
    Shading shading; // defaults for keys that a preset does not name
    if (root.has("shading"))
        shading = shadingFields().read(root.at("shading"));
    shading.on = scene.shading.on;
    shading.gradient = scene.shading.gradient;
    scene.shading = shading;
    scene.lighting = root.has("lighting") ? lightingFields().read(root.at("lighting")) : Lighting{};
}

} // namespace tessera
