// core/scene/look.cpp: see look.h.
#include "core/scene/look.h"

#include "core/base/embedded.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {
namespace looks {
const EmbeddedFiles& embeddedFiles(); // generated from core/scene/looks/*.json
}

const std::vector<std::string>& lookNames() {
    static const std::vector<std::string> names = {"plain",    "studio",    "soft",
                                                   "dramatic", "endoscope", "soft-1"};
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
