// viewer/cli/redraw/figure_record.cpp: see figure_record.h.
#include "viewer/cli/redraw/figure_record.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/magnitude.h"
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
        record.lineHash = lineHashOf(manifest);
    } catch (const json::exception&) {
        throw badFile(figure.string(), kExpected, "another");
    }
    if (isAlongLine(manifest) && manifest.contains("path"))
        record.path = parsePath(manifest["path"].dump(), figure.string() + ": its path");
    return record;
}

/// A number of a reformation within what its option takes.
double numberOf(const FigureRecord& record, const json& number, double least, double most) {
    if (!number.is_number() || !(number.get<double>() >= least && number.get<double>() <= most))
        throw badFile(record.figure.string(),
                      "a number from " + formatNumber(least) + " to " + formatNumber(most) +
                          " in its reformation",
                      number.dump().substr(0, 40));
    return number.get<double>();
}

/// What draws a reformation, as options of `tessera render` say it.
void setReformation(const FigureRecord& record, RenderArguments& arguments) {
    constexpr double kMostMm = 1e5, kMostDegrees = 4000;
    constexpr std::size_t kMostAngles = 180, kMostSections = 200;
    const json& about = record.manifest.at("reformation");
    arguments.widthMm = numberOf(record, about.at("widthMm"), 0.01, kMostMm);
    arguments.mmPerPixel = numberOf(record, about.at("mmPerPixel"), kLeastMmPerPixel, kMostMmPerPixel);
    const json sections = about.value("sectionsMm", json::array());
    if (!sections.is_array() || sections.size() > kMostSections)
        throw badFile(record.figure.string(), "up to 200 cross-sections in its reformation", "others");
    arguments.sections = static_cast<int>(sections.size());
    arguments.straighten = about.at("form") == "straightened";
    arguments.curved = about.at("form") == "stretched";
    if (arguments.straighten || arguments.sections > 0) {
        const json& angles = about.at("anglesDegrees");
        if (!angles.is_array() || angles.empty() || angles.size() > kMostAngles)
            throw badFile(record.figure.string(), "up to 180 angles in its reformation", "others");
        if (angles.size() > 1)
            arguments.angles = static_cast<int>(angles.size());
        else
            arguments.angle = numberOf(record, angles.front(), -kMostDegrees, kMostDegrees);
    }
    if (!arguments.curved && !arguments.straighten && arguments.sections == 0)
        throw badFile(record.figure.string(), "a form of reformations", "another");
    if (!arguments.curved || about.value("directionBy", "") == "view") // the scene's camera has it
        return;
    for (const json& number : about.at("direction"))
        arguments.direction += (arguments.direction.empty() ? "" : ",") +
                               json(numberOf(record, number, -kFarthestPlaceMm, kFarthestPlaceMm)).dump();
}

} // namespace

bool isAlongLine(const json& manifest) {
    return manifest.contains("unfolded") || manifest.contains("reformation");
}

std::string lineHashOf(const json& manifest) {
    for (const char* key : {"unfolded", "reformation"})
        if (manifest.contains(key))
            return partOf(manifest, key).value("lineHash", "");
    return {};
}

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
        if (isAlongLine(record.manifest)) {
            if (!record.path)
                throw badFile(record.figure.string(),
                              "--path with the path of its line, which is too long for its manifest or older "
                              "than that",
                              "none");
            arguments.path = record.figure.string();
            arguments.givenPath = record.path;
            arguments.verify.clear(); // pictures along lines are not measured
            arguments.unfold = arguments.mayLeak = record.manifest.contains("unfolded");
            if (!arguments.unfold) {
                arguments.engine = "auto"; // without rays
                setReformation(record, arguments);
            }
        }
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
