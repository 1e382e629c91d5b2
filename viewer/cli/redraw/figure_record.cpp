// viewer/cli/redraw/figure_record.cpp: see figure_record.h.
#include "viewer/cli/redraw/figure_record.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace tessera {
namespace {

using nlohmann::json;

constexpr const char* kExpected = "the manifest of a picture that tessera made";

json partOf(const json& whole, const char* key) {
    return whole.is_object() ? whole.value(key, json::object()) : json::object();
}

/// What was chosen among source files, by the keys of a scene's volume.
SourceChoice sourceOf(const json& chosen, const std::string& where) {
    json volume = chosen;
    volume["path"] = "source";
    const json scene = {{"tesseraScene", 1}, {"volumes", {volume}}};
    return parseScene(scene.dump(), {}, where).volumes.front().source;
}

/// 0: none
int tilesOf(const json& options, const FigureRecord& record) {
    constexpr std::int64_t kLeast = 64, kMost = 16384; // as --tiles
    const json side =
        options.contains("tile") ? options["tile"] : partOf(record.manifest, "tiles").value("side", json(0));
    const auto pixels = side.is_number_integer() ? side.get<std::int64_t>() : -1;
    if (pixels != 0 && (pixels < kLeast || pixels > kMost))
        throw badFile(record.figure.string(), "tiles of 64 to 16384 pixels", side.dump());
    return static_cast<int>(pixels);
}

FigureRecord recordOf(const json& manifest, const std::filesystem::path& figure) {
    FigureRecord record;
    record.figure = figure;
    record.manifest = manifest;
    if (manifest.contains("unfolded"))
        throw badFile(figure.string(), "a picture by a camera",
                      "an unfolded wall, whose path its manifest does not hold; tessera render --unfold");
    if (manifest.contains("reformation"))
        throw badFile(figure.string(), "a picture by a camera",
                      "a reformation, whose path its manifest does not hold; tessera render --straighten or "
                      "--curved");
    if (!manifest.contains("scene"))
        throw badFile(figure.string(), kExpected, "one without a scene");
    record.scene = parseScene(manifest["scene"].dump(), figure.parent_path(), figure.string());
    record.data = dataOfManifest(manifest, record.scene, figure.string());
    record.sources.resize(record.scene.volumes.size());
    try {
        const json budgets = partOf(manifest, "budgets");
        record.ramBytes = partOf(budgets, "ram").value("limitBytes", std::size_t{0});
        record.gpuBytes = partOf(budgets, "gpuMemory").value("limitBytes", std::size_t{0});
        const json sources = partOf(manifest, "options").value("sources", json::array());
        for (std::size_t n = 0; n < std::min(sources.size(), record.sources.size()); ++n)
            record.sources[n] = sourceOf(sources.at(n), figure.string());
    } catch (const json::exception&) {
        throw badFile(figure.string(), kExpected, "another");
    }
    return record;
}

} // namespace

json manifestJsonOf(const std::filesystem::path& picture) {
    const std::string text = manifestOf(picture);
    if (text.empty())
        throw badFile(picture.string(), "a picture that tessera made", "one without its manifest");
    json manifest = parseStrictJson(text, picture.string());
    if (!manifest.is_object() || !manifest.contains("tesseraManifest"))
        throw badFile(picture.string(), "a picture that tessera made", "one with another description");
    return manifest;
}

std::vector<FigureRecord> readFigure(const std::filesystem::path& figure) {
    const json manifest = manifestJsonOf(figure);
    if (manifest["tesseraManifest"] != 1)
        throw badFile(figure.string(), "a manifest of version 1", manifest["tesseraManifest"].dump());
    if (!manifest.contains("panels"))
        return {recordOf(manifest, figure)};
    if (!manifest["panels"].is_array() || manifest["panels"].empty())
        throw badFile(figure.string(), kExpected, "one without panels");
    std::vector<FigureRecord> panels;
    for (const json& panel : manifest["panels"])
        panels.push_back(recordOf(panel, figure));
    return panels;
}

std::string verifyOfManifest(const json& manifest) {
    if (const json options = partOf(manifest, "options"); options.contains("verify"))
        return options["verify"].get<std::string>();
    return partOf(partOf(manifest, "errors"), "measured").value("mode", "none");
}

RenderArguments argumentsOf(const FigureRecord& record) {
    const json options = partOf(record.manifest, "options");
    RenderArguments arguments;
    try {
        arguments.engine = record.manifest.at("engine").get<std::string>();
        arguments.device = options.value("glDevice", "auto");
        arguments.verify = verifyOfManifest(record.manifest);
        arguments.tiles = tilesOf(options, record);
        arguments.layers = record.manifest.value("layers", std::vector<std::string>());
        arguments.allowDamaged = options.value("allowDamaged", false);
    } catch (const json::exception&) {
        throw badFile(record.figure.string(), kExpected, "another");
    }
    if (record.ramBytes > 0)
        arguments.ram = std::to_string(record.ramBytes);
    if (record.gpuBytes > 0)
        arguments.gpuMemory = std::to_string(record.gpuBytes);
    return arguments;
}

} // namespace tessera
