// viewer/cli/render/kept_state.cpp: see kept_state.h.
#include "viewer/cli/render/kept_state.h"

#include "core/base/error.h"
#include "core/base/json_reader.h" // readTextFile
#include "core/base/output_file.h"
#include "core/scene/scene.h"
#include "viewer/cli/manifest/manifest.h"

#include <nlohmann/json.hpp>
#include <string>

namespace tessera {
namespace {

constexpr const char* kStateOption = "--keep-state";

/// Values by the names of their keys; long ones by their fingerprints.
void addParts(const nlohmann::json& value, const std::string& name, KeptSamples::Parts& parts) {
    constexpr std::size_t kLongest = 60, kItems = 16;
    if (value.is_object()) {
        for (const auto& [key, of] : value.items())
            addParts(of, name.empty() ? key : name + "." + key, parts);
        return;
    }
    if (value.is_array() && value.size() <= kItems && !value.empty() && value.front().is_object()) {
        for (std::size_t n = 0; n < value.size(); ++n)
            addParts(value[n], name + "[" + std::to_string(n) + "]", parts);
        return;
    }
    std::string text = value.dump(-1, ' ', true);
    if (text.size() > kLongest)
        text = fingerprint(std::as_bytes(std::span(text)));
    parts[name] = text;
}

/// All of the scene that samples depend on.
KeptSamples::Parts partsOf(const RenderTask& task) {
    Scene scene = withoutPaths(task.scene, task.stores);
    scene.background.reset();
    scene.quality.pixels.samples = 2;
    scene.quality.pixels.noise = 0;
    scene.quality.pixels.denoise = false;
    std::string labels;
    for (std::size_t n = 0; n < scene.volumes.size(); ++n) {
        const Labels& read = task.scene.volumes[n].labels;
        Labels& named = scene.volumes[n].labels;
        if (read.path.empty())
            continue;
        labels += StoreReader(read.store, task.ram).contentHash() + " ";
        named.path = "labels"; // names of files may be those of patients
        if (!read.names.empty() && read.names != Labels::kTotalSegmentator) {
            labels += readTextFile(read.names.string());
            named.names = "names";
        }
    }
    nlohmann::json json = nlohmann::json::parse(sceneJson(scene));
    KeptSamples::Parts parts;
    addParts(json, "", parts);
    parts["labels' file"] = fingerprint(std::as_bytes(std::span(labels)));
    parts["layers of paths"] = task.layers.ofPaths() ? "true" : "false";
    return parts;
}

} // namespace

void checkKeptState(const RenderArguments& arguments, const Scene& scene) {
    if (arguments.keepState.empty())
        return;
    if (arguments.isFilm() || !arguments.pathPicture().empty())
        throw badFile(kStateOption, "one picture", arguments.isFilm() ? "a film" : arguments.pathPicture());
    if (!scene.lighting.transport || reductionOf(scene) != Reduction::composite)
        throw badFile(kStateOption, "paths of light (--light cinematic, or lighting.transport)",
                      "a scene without");
    if (const int samples = scene.quality.pixels.samples; samples < 2)
        throw badFile(kStateOption, "a number of samples from 2 on (--samples)", samples == 1 ? "1" : "auto");
    checkOutputFile(arguments.keepState);
    if (outputTarget(arguments.keepState) == outputTarget(arguments.out))
        throw badFile(kStateOption, "another file than the picture", arguments.keepState);
}

std::unique_ptr<KeptSamples> keptStateOf(const RenderTask& task) {
    return task.arguments.keepState.empty()
               ? nullptr
               : std::make_unique<KeptSamples>(task.arguments.keepState, partsOf(task));
}

} // namespace tessera
