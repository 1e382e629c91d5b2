// viewer/python/scene.cpp: the scenes of picture.h.
#include "core/scene/scene.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/scene/preset.h"
#include "core/scene/scene_fields.h"
#include "core/scene/scene_presets.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/python/picture.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <string>
#include <vector>

namespace tessera::python {
namespace {

/// Sets a key to a value as JSON text. Messages name the key.
void setKey(Scene& scene, const std::string& key, const std::string& value) {
    setSceneKey(scene, key, parseStrictJson(value, key), key);
}

py::list keysOfScenes() {
    py::list keys;
    for (const KeyRow& row : sceneKeys()) {
        py::dict about;
        about["key"] = row.path;
        about["about"] = row.about;
        about["value"] = row.value;
        about["default"] = row.preset;
        about["names"] = row.names;
        about["option"] = row.option.name;
        keys.append(about);
    }
    return keys;
}

} // namespace

void addScenes(py::module_& module) {
    py::class_<Scene>(module, "Scene")
        .def_static("of", [](const std::string& path) { return sceneOf(path); })
        .def_static("parse", [](const std::string& text, const std::string& folder,
                                const std::string& where) { return parseScene(text, folder, where); })
        .def("copy", [](const Scene& scene) { return Scene(scene); })
        .def("set", &setKey)
        .def("json", [](const Scene& scene) { return sceneJson(scene); });
    module.def("is_scene_file", [](const std::string& path) { return isSceneFile(path); });
    module.def("scene_keys", &keysOfScenes);
    module.def("presets", [] { return presetNames(); });
    module.def("looks", [] { return lookNames(); });
    module.def("views", [] { return viewNames(); });
}

} // namespace tessera::python
