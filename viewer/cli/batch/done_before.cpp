// viewer/cli/batch/done_before.cpp: see done_before.h.
#include "viewer/cli/batch/done_before.h"

#include "bricking/store/store_reader.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/manifest/build_commit.h"
#include "viewer/cli/manifest/picture_data.h"
#include "viewer/cli/render/asked_options.h"
#include "viewer/cli/render/layers.h"
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Null for what is no picture of this program, and for one that is cut off at its end.
json manifestThere(const fs::path& output) {
    std::error_code ignored;
    if (!fs::is_regular_file(output, ignored))
        return {};
    try {
        json manifest = json::parse(manifestOf(output), nullptr, false);
        checkWholePicture(output);
        return manifest.is_object() && manifest.contains("tesseraManifest") ? manifest : json();
    } catch (const InputError&) {
        return {}; // no picture: it is drawn
    }
}

std::string textOf(const json& manifest, const char* key) {
    const json value = manifest.value(key, json());
    return value.is_string() ? value.get<std::string>() : std::string();
}

/// What pixels depend on, of the manifest's "options".
json ofPixels(json options) {
    if (options.is_object())
        for (const char* key : {"processors", "sources"})
            options.erase(key);
    return options;
}

bool isImported(const SceneVolume& volume) {
    if (looksLikeStore(volume.path))
        return true;
    return !isAddress(volume.path) && !volume.source.fileLevel &&
           isCached(volume.path, InputOptions(volume.source).key());
}

} // namespace

bool isDoneBefore(const fs::path& output, const RenderArguments& arguments, DoneCheck check,
                  MemoryBudget& ram, const CommonOptions& common) {
    const json there = manifestThere(output);
    if (there.is_null() || textOf(there, "program") != "tessera " TESSERA_VERSION ||
        textOf(there, "commit") != buildCommit() || there.contains("damagedChunks")) // mended since, perhaps
        return false;
    Scene scene = arguments.scene.value();
    applyArguments(arguments, scene, common);
    const LayerChoice layers = layersOf(arguments, scene);
    if (ofPixels(there.value("options", json())) !=
        ofPixels(optionsJson(arguments, layers, requestOf(scene))))
        return false;
    if (check == DoneCheck::asItIs && !std::ranges::all_of(scene.volumes, isImported))
        return false;
    std::vector<std::unique_ptr<StoreReader>> readers;
    std::vector<const StoreReader*> stores;
    for (SceneVolume& volume : scene.volumes) {
        const fs::path store = storeFor(volume, InputOptions{}, ram, common);
        readers.push_back(std::make_unique<StoreReader>(store, ram, volume.transform));
        stores.push_back(readers.back().get());
        if (check == DoneCheck::asItIs && !volume.labels.path.empty() && !looksLikeStore(volume.labels.path))
            return false;
        importLabelsFor(readers.back()->info(), volume.labels, ram, common);
    }
    return there.value("data", json()) == dataJson(dataOf(scene, stores));
}

} // namespace tessera
