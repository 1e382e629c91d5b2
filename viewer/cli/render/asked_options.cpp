// viewer/cli/render/asked_options.cpp: see asked_options.h.
#include "viewer/cli/render/asked_options.h"

#include "core/base/threads.h"
#include "render/pixels/kept_samples.h" // fingerprint
#include "render/verify/verify_plan.h"  // verifyNames
#include "viewer/cli/manifest/manifest.h"

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

namespace tessera {
using nlohmann::json;

std::string requestOf(const Scene& asked) {
    Scene scene = asked;
    const auto forget = [](std::filesystem::path& path) {
        if (!path.empty() && path != Labels::kTotalSegmentator)
            path = "data";
    };
    for (SceneVolume& volume : scene.volumes) {
        forget(volume.path);
        forget(volume.labels.path);
        forget(volume.labels.names);
    }
    for (SceneMesh& mesh : scene.meshes)
        forget(mesh.path);
    if (auto& sky = scene.lighting.environment)
        forget(sky->file.path);
    const std::string text = sceneJson(scene);
    return fingerprint(std::as_bytes(std::span(text)));
}

json optionsJson(const RenderArguments& arguments, const LayerChoice& layers, const std::string& request) {
    json options = {{"engine", arguments.engine},
                    {"glDevice", arguments.device},
                    {"verify", verifyNames()[static_cast<std::size_t>(verifyOf(arguments))]},
                    {"processors", arguments.threads > 0 ? arguments.threads : defaultThreads()}};
    if (arguments.tellsRequest)
        options["request"] = request;
    if (arguments.allowDamaged)
        options["allowDamaged"] = true;
    if (!arguments.keepState.empty())
        options["keepState"] = true;
    if (arguments.tiles > 0)
        options["tile"] = arguments.tiles;
    if (layers.any())
        options["layers"] = layers.names();
    return options;
}

json optionsJson(const RenderTask& task) {
    json options = optionsJson(task.arguments, task.layers, task.request);
    if (json sources = sourcesJson(task.sources); !sources.empty())
        options["sources"] = std::move(sources);
    return options;
}

} // namespace tessera
