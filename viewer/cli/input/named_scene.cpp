// viewer/cli/input/named_scene.cpp: see named_scene.h.
#include "viewer/cli/input/named_scene.h"

#include <string>
#include <variant>

namespace tessera {

Scene sceneOf(const std::filesystem::path& path) {
    if (isSceneFile(path))
        return loadScene(path);
    Scene scene;
    scene.quality.automaticStep = true;
    scene.volumes.push_back({path, std::string()});
    return scene;
}

void nameFunction(SceneVolume& volume, const VolumeInfo& info) {
    if (const auto* name = std::get_if<std::string>(&volume.transferFunction); name && name->empty())
        volume.transferFunction = std::string(info.unit == "HU" || volume.unit == "HU" ? "bone-1" : "auto");
}

} // namespace tessera
