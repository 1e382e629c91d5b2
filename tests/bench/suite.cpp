// tests/bench/suite.cpp: see suite.h.
#include "tests/bench/suite.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"

#include <nlohmann/json.hpp>
#include <sstream>

namespace tessera::bench {

std::string SuitePicture::label() const {
    return name + (scene.shading.on ? "-lit-" : "-plain-") + std::to_string(scene.imageSize.x) + "x" +
           std::to_string(scene.imageSize.y);
}

std::vector<SuitePicture> readSuite(const std::filesystem::path& file,
                                    const std::map<std::string, std::filesystem::path>& stores) {
    const nlohmann::json document = parseStrictJson(readTextFile(file.string()), file.string());
    const JsonValue root(document, file.string());
    root.requireKeys({"tesseraSuite", "rows"});
    root.at("tesseraSuite").integer(1, 1);
    std::vector<SuitePicture> pictures;
    for (const JsonValue& row : root.at("rows").items()) {
        row.requireKeys({"name", "store", "plain", "lit", "sizes", "quick"});
        SuitePicture picture;
        picture.name = row.at("name").text();
        picture.store = row.at("store").text();
        picture.quick = row.has("quick") && row.at("quick").boolean();
        if (const auto given = stores.find(picture.store); given != stores.end())
            picture.storePath = given->second;
        for (const JsonValue& size : row.at("sizes").items()) {
            for (const char* key : {"plain", "lit"}) {
                picture.scene = loadScene(file.parent_path() / row.at(key).text());
                picture.scene.volumes.front().path = picture.storePath;
                for (int axis = 0; axis < 2; ++axis)
                    picture.scene.imageSize[axis] =
                        size.items()[static_cast<std::size_t>(axis)].integer(1, Scene::kMaxImageExtent);
                if (picture.scene.shading.on != (std::string(key) == "lit") ||
                    !picture.scene.surfaces.empty())
                    row.at(key).refuse("a scene without surfaces, " + std::string(key));
                pictures.push_back(picture);
            }
        }
    }
    return pictures;
}

std::map<std::string, std::filesystem::path> parseStores(const std::string& text, const std::string& option) {
    std::map<std::string, std::filesystem::path> stores;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');) {
        const std::size_t equals = part.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == part.size())
            throw InputError(option + ": expected NAME=PATH with commas between, found \"" + text + "\"");
        stores[part.substr(0, equals)] = part.substr(equals + 1);
    }
    return stores;
}

} // namespace tessera::bench
