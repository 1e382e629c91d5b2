// viewer/cli/redraw/run_redraw.cpp: see run_redraw.h.
#include "viewer/cli/redraw/run_redraw.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/program_folders.h"
#include "core/base/shown_text.h"
#include "viewer/cli/options/scene_options.h"
#include "viewer/cli/redraw/differences.h"
#include "viewer/cli/redraw/figure_record.h"
#include "viewer/cli/redraw/find_data.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/run_render.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kWithOption = "--with";

/// Applies --with.
void change(const std::vector<std::string>& changes, Scene& scene) {
    for (const std::string& said : changes) {
        const std::size_t equals = said.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == said.size())
            throw badFile(kWithOption, "KEY=VALUE, a key of scenes and its value",
                          "\"" + said.substr(0, 60) + "\"");
        const std::string name = said.substr(0, equals), key = keyNamed(name);
        const std::string where = std::string(kWithOption) + " " + name.substr(0, 60);
        if (key.empty())
            throw badFile(kWithOption, "a key of scenes",
                          "\"" + name.substr(0, 60) + "\"; nearest: \"" + nearestKeyName(name) + "\"");
        const Scene before = scene;
        setKeyFromText(scene, key, said.substr(equals + 1), where);
        // What names data is --data's.
        bool isData =
            before.volumes.size() != scene.volumes.size() || before.meshes.size() != scene.meshes.size();
        for (std::size_t n = 0; !isData && n < scene.volumes.size(); ++n)
            isData = before.volumes[n].path != scene.volumes[n].path ||
                     before.volumes[n].labels.path != scene.volumes[n].labels.path ||
                     before.volumes[n].labels.names != scene.volumes[n].labels.names;
        for (std::size_t n = 0; !isData && n < scene.meshes.size(); ++n)
            isData = before.meshes[n].path != scene.meshes[n].path;
        const auto skyOf = [](const Scene& of) {
            return of.lighting.environment ? of.lighting.environment->file.path : fs::path();
        };
        if (isData || skyOf(before) != skyOf(scene))
            throw badFile(where, "a key of the picture's look; --data names its data", "one of its data");
    }
}

struct Report {
    std::vector<FoundData> data;
    ManifestDifferences differences;
    PixelDifferences pixels;

    bool isDataAnother() const {
        for (const FoundData& found : data)
            if (isAnother(found))
                return true;
        return false;
    }
    static bool isAnother(const FoundData& found) {
        return !found.wanted.contentHash.empty() && found.contentHash != found.wanted.contentHash;
    }
    bool isKnownToDiffer() const {
        return isDataAnother() || !differences.program.empty() || !differences.device.empty() ||
               !differences.settings.empty();
    }
};

void printLines(const char* what, const std::vector<Difference>& differences, const std::string& same) {
    if (differences.empty())
        std::printf("%-9s the same%s\n", (std::string(what) + ":").c_str(),
                    same.empty() ? "" : (" (" + printable(same) + ")").c_str());
    for (const Difference& one : differences)
        std::printf("%-9s %s: %s, now %s\n", (std::string(what) + ":").c_str(), printable(one.key).c_str(),
                    printable(one.before).c_str(), printable(one.now).c_str());
}

void printReport(const Report& report, const json& now) {
    for (const FoundData& found : report.data) {
        const std::string name = nameOf(found.wanted) + ", " + found.where;
        if (found.wanted.contentHash.empty())
            std::printf("data:     not known to be the same (%s; now %s)\n", name.c_str(),
                        found.contentHash.c_str());
        else if (Report::isAnother(found))
            std::printf("data:     %s: content %s, now %s\n", name.c_str(), found.wanted.contentHash.c_str(),
                        found.contentHash.empty() ? "unknown" : found.contentHash.c_str());
        else
            std::printf("data:     the same (%s; content %s)\n", name.c_str(), found.contentHash.c_str());
    }
    const std::string commit = now.value("commit", "");
    printLines("program", report.differences.program,
               now.value("program", "") + (commit.empty() ? "" : ", commit " + commit));
    printLines("device", report.differences.device,
               now.value("engine", "") + " engine, " + now.value("device", ""));
    printLines("settings", report.differences.settings, "");
    const PixelDifferences& pixels = report.pixels;
    const std::string size = std::to_string(pixels.size.x) + " x " + std::to_string(pixels.size.y);
    if (!pixels.notCompared.empty())
        std::printf("pixels:   not compared: %s\n", pixels.notCompared.c_str());
    else if (pixels.differing == 0)
        std::printf("pixels:   equal (%s)\n", size.c_str());
    else
        std::printf("pixels:   %zu of %zu differ, rms %s\n", pixels.differing, pixels.pixels,
                    numberText(pixels.rms).c_str());
}

json reportJson(const RedrawArguments& arguments, const Report& report) {
    const auto list = [](const std::vector<Difference>& differences) {
        json rows = json::array();
        for (const Difference& one : differences)
            rows.push_back({{"key", one.key}, {"before", one.before}, {"now", one.now}});
        return rows;
    };
    json out = {{"figure", arguments.figure},
                {"output", arguments.out},
                {"program", list(report.differences.program)},
                {"device", list(report.differences.device)},
                {"settings", list(report.differences.settings)}};
    for (const FoundData& found : report.data)
        out["data"].push_back({{"name", nameOf(found.wanted)},
                               {"before", found.wanted.contentHash},
                               {"now", found.contentHash},
                               {"where", found.where}});
    const PixelDifferences& pixels = report.pixels;
    out["pixels"] = pixels.notCompared.empty() ? json{{"equal", pixels.differing == 0},
                                                      {"differing", pixels.differing},
                                                      {"of", pixels.pixels},
                                                      {"rms", pixels.rms}}
                                               : json{{"notCompared", pixels.notCompared}};
    return out;
}

} // namespace

void runRedraw(const RedrawArguments& arguments, const CommonOptions& common) {
    const fs::path figure = arguments.figure;
    FigureRecord record = readFigure(figure);
    std::optional<ScratchFolder> scratch;
    fs::path out = arguments.out;
    if (out.empty()) {
        scratch.emplace();
        out = *scratch / ("redrawn" + figure.extension().string());
    }
    checkPictureOutput(out);
    if (outputTarget(out) == outputTarget(figure))
        throw badFile("-o", "another file than the picture that is drawn again", arguments.out);
    change(arguments.changes, record.scene);

    RenderArguments render = argumentsOf(record);
    for (const auto& [given, to] : {std::pair{&arguments.engine, &render.engine},
                                    {&arguments.device, &render.device},
                                    {&arguments.ram, &render.ram},
                                    {&arguments.gpuMemory, &render.gpuMemory}})
        if (!given->empty())
            *to = *given;
    render.in = arguments.figure;
    render.out = out.string();
    Report report;
    {
        MemoryBudget ram("RAM", "--ram", budgetBytes(render.ram, "--ram", common));
        report.data =
            findData(figure, record.data, record.sources, arguments.data, record.scene, ram, common);
    }
    render.scene = record.scene;
    CommonOptions drawing = common;
    drawing.quiet = common.quiet || scratch.has_value(); // of a picture that nobody gets
    runRender(render, drawing);

    common.progress->stage("comparing the pictures");
    const json now = manifestJsonOf(out);
    report.differences = compareManifests(record.manifest, now);
    MemoryBudget ram("RAM", "--ram", budgetBytes(render.ram, "--ram", common));
    report.pixels = comparePixels(figure, out, record.scene.imageSize, ram);
    common.progress->end();
    if (arguments.json)
        tessera::printReport(reportJson(arguments, report));
    else
        printReport(report, now);
    finishStandardOutput();
    if (report.pixels.notCompared.empty() && report.pixels.differing > 0 && !report.isKnownToDiffer())
        throw Error(figure.string() + ": its pixels differ, though nothing that is known does");
}

} // namespace tessera
