// viewer/cli/redraw/run_redraw.cpp: see run_redraw.h.
#include "viewer/cli/redraw/run_redraw.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/program_folders.h"
#include "viewer/cli/options/scene_options.h"
#include "viewer/cli/redraw/differences.h"
#include "viewer/cli/redraw/figure_record.h"
#include "viewer/cli/redraw/find_data.h"
#include "viewer/cli/redraw/redraw_report.h"
#include "viewer/cli/render/panel_figure.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/run_render.h"
#include "viewer/paths/path_file.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kWithOption = "--with";

/// Applies --with.
void change(const std::vector<std::string>& changes, Scene& scene) {
    for (const std::string& said : changes) {
        const std::size_t equals = said.find('=');
        if (equals == std::string::npos || equals == 0)
            throw badFile(kWithOption, "KEY=VALUE, a key of scenes and its value",
                          "\"" + said.substr(0, 60) + "\"");
        const std::string name = said.substr(0, equals), key = keyNamed(name);
        const std::string where = std::string(kWithOption) + " " + name.substr(0, 60);
        if (key.empty())
            throw badFile(kWithOption, "a key of scenes", "\"" + name.substr(0, 60) + "\"" + keyHint(name));
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

/// True if --with changes that key of scenes, or an object with it.
bool isChanged(const RedrawArguments& arguments, const std::string& key) {
    return std::ranges::any_of(arguments.changes, [&](const std::string& said) {
        const std::string changed = keyNamed(said.substr(0, said.find('=')));
        return changed == key || key.starts_with(changed + ".");
    });
}

/// Pictures along a line: --path takes the place of theirs. Throws InputError naming the option where nothing
/// lies along a line, and --with for what a reformation has from its line.
void setPath(const RedrawArguments& arguments, FigureRecord& record) {
    const bool alongLine = isAlongLine(record.manifest);
    if (!arguments.path.empty() && !alongLine)
        throw badFile("--path", "an unfolded wall or a reformation, which lie along a line",
                      "another picture");
    if (!arguments.path.empty())
        record.path = loadPathFile(arguments.path);
    if (alongLine && record.manifest.contains("reformation"))
        for (const char* key : {"mode", "image.size"})
            if (isChanged(arguments, key))
                throw badFile(
                    kWithOption,
                    "neither mode nor image.size of a reformation, which shows values in its line's "
                    "size",
                    key);
}

/// What draws a picture of the figure again.
RenderArguments drawingOf(const FigureRecord& record, const RedrawArguments& arguments, const fs::path& out) {
    RenderArguments render = argumentsOf(record);
    for (const auto& [given, to] : {std::pair{&arguments.engine, &render.engine},
                                    {&arguments.device, &render.device},
                                    {&arguments.ram, &render.ram},
                                    {&arguments.gpuMemory, &render.gpuMemory}})
        if (!given->empty())
            *to = *given;
    render.in = arguments.figure;
    render.out = out.string();
    return render;
}

/// The memory of another machine is not taken: budgets are those of manifests, or the default if that is
/// less.
void limitBudgets(std::vector<FigureRecord>& records, const RedrawArguments& arguments,
                  const CommonOptions& common) {
    const auto limit = [&](std::size_t FigureRecord::*bytes, const std::string& given, const char* option) {
        const std::size_t most = budgetBytes("", option, common);
        std::size_t asked = 0;
        for (FigureRecord& record : records) {
            asked = std::max(asked, record.*bytes);
            record.*bytes = std::min(record.*bytes, most);
        }
        if (asked > most && given.empty())
            common.note("the picture had " + formatBytes(asked) + " of " + option + "; it is drawn with " +
                        formatBytes(most) + ", the default, unless " + option + " is given");
    };
    limit(&FigureRecord::ramBytes, arguments.ram, "--ram");
    limit(&FigureRecord::gpuBytes, arguments.gpuMemory, "--gpu-memory");
}

/// Finds the data of all pictures, and sets the paths of their scenes. What several have is told once.
std::vector<FoundData> findAll(std::vector<FigureRecord>& records, const RedrawArguments& arguments,
                               const std::string& ramText, const CommonOptions& common) {
    MemoryBudget ram("RAM", "--ram", budgetBytes(ramText, "--ram", common));
    std::vector<PictureData> all; // of all pictures, each once
    const auto indexOf = [&all](const PictureData& data) {
        std::size_t n = 0;
        while (n < all.size() && !(all[n].kind == data.kind && all[n].contentHash == data.contentHash &&
                                   (!data.contentHash.empty() || all[n].number == data.number)))
            ++n;
        return n;
    };
    for (const FigureRecord& record : records)
        for (const PictureData& data : record.data)
            if (indexOf(data) == all.size())
                all.push_back(data);
    const std::vector<std::string> named = assignData(all, arguments.data, ram);
    std::vector<FoundData> found(all.size());
    for (FigureRecord& record : records) {
        std::vector<std::string> paths;
        for (const PictureData& data : record.data)
            paths.push_back(named[indexOf(data)]);
        for (FoundData& one :
             findData(arguments.figure, record.data, record.sources, paths, record.scene, ram, common))
            found[indexOf(one.wanted)] = std::move(one);
    }
    return found;
}

/// What --with changes of the words that panels share. True: they may need other room.
bool changeWords(PanelFigure& figure, const RedrawArguments& arguments, const Annotations& changed) {
    bool any = false;
    for (const auto& [key, words] : {std::pair{"annotations.title", &Annotations::title},
                                     {"annotations.caption", &Annotations::caption}})
        if (isChanged(arguments, key)) {
            figure.layout.words.*words = changed.*words;
            for (FittedPanel& panel : figure.panels)
                (panel.annotations.*words).clear();
            any = true;
        }
    for (const auto& [key, number] : {std::pair{"annotations.textPoints", &Annotations::textPoints},
                                      {"annotations.dpi", &Annotations::dpi}})
        if (isChanged(arguments, key)) {
            figure.layout.words.*number = changed.*number;
            any = true;
        }
    return any;
}

/// Draws the panels of a figure again.
void redrawPanels(const json& before, const std::vector<FigureRecord>& records,
                  const RedrawArguments& arguments, const fs::path& out, const CommonOptions& common) {
    PanelFigure figure;
    figure.layout = layoutOfJson(before.value("figure", json::object()), static_cast<int>(records.size()),
                                 arguments.figure);
    PanelGrid& grid = figure.layout.grid;
    const bool resized = grid.panelSize != records.front().scene.imageSize;
    grid.panelSize = records.front().scene.imageSize;
    for (const FigureRecord& record : records) {
        if (record.scene.imageSize != grid.panelSize)
            throw badFile(arguments.figure, "panels of one size", "others");
        RenderArguments render = drawingOf(record, arguments, out);
        render.scene = record.scene;
        figure.panels.push_back({std::move(render), std::nullopt, record.scene.annotations});
    }
    checkSize(grid, kPanelOption);
    if (std::ranges::any_of(arguments.changes, [](const std::string& said) {
            return keyNamed(said.substr(0, said.find('='))).starts_with("camera");
        }))
        fitPanels(figure, common, withRenderTask);
    const bool otherWords = changeWords(figure, arguments, records.front().scene.annotations);
    const Strips fitted = grid.strips;
    if (!arguments.changes.empty())
        fitStrips(figure, common, withRenderTask);
    if (otherWords || resized || grid.strips != fitted)
        makeRoomForWords(figure.layout, kPanelOption);
    const std::size_t bytes = bytesOf(grid);
    std::size_t limit = budgetBytes(arguments.ram, "--ram", common);
    if (const std::size_t ofPanel = records.front().ramBytes; arguments.ram.empty() && ofPanel > 0)
        limit = std::min(limit, ofPanel + bytes); // that of a panel is what the figure left of --ram
    MemoryBudget ram("RAM", "--ram", limit);
    const Charge charge = ram.charge(bytes, "the figure");
    for (FittedPanel& panel : figure.panels)
        panel.arguments.ram = std::to_string(std::max<std::size_t>(1, limit - bytes));
    RenderArguments whole;
    whole.out = out.string();
    drawPanels(figure, whole, common, ram, withRenderTask);
}

/// Of all pictures; those of a panel with its number.
ManifestDifferences compareAll(const json& before, const json& now) {
    if (!before.contains("panels") || !now.contains("panels"))
        return compareManifests(before, now);
    const auto sharedOf = [](const json& manifest) { // as keys of a scene
        return json::object({{"scene", manifest.value("figure", json::object())}});
    };
    ManifestDifferences all = compareManifests(sharedOf(before), sharedOf(now));
    for (Difference& difference : all.settings)
        difference.key = "figure, " + difference.key;
    for (std::size_t n = 0; n < std::min(before["panels"].size(), now["panels"].size()); ++n) {
        const ManifestDifferences one = compareManifests(before["panels"][n], now["panels"][n]);
        const auto add = [n](const std::vector<Difference>& from, std::vector<Difference>& to) {
            for (Difference difference : from) {
                difference.key = "panel " + std::to_string(n + 1) + ", " + difference.key;
                to.push_back(std::move(difference));
            }
        };
        add(one.program, all.program);
        add(one.device, all.device);
        add(one.settings, all.settings);
    }
    return all;
}

} // namespace

void runRedraw(const RedrawArguments& arguments, const CommonOptions& common) {
    const fs::path figure = arguments.figure;
    const json before = manifestJsonOf(figure);
    std::vector<FigureRecord> records = readFigure(figure);
    std::optional<ScratchFolder> scratch;
    fs::path out = arguments.out;
    if (out.empty()) {
        scratch.emplace();
        out = *scratch / ("redrawn" + figure.extension().string());
    }
    checkFigureOutput(out);
    if (outputTarget(out) == outputTarget(figure))
        throw badFile("-o", "another file than the picture that is drawn again", arguments.out);
    for (FigureRecord& record : records)
        change(arguments.changes, record.scene);
    for (FigureRecord& record : records)
        setPath(arguments, record);
    limitBudgets(records, arguments, common);

    RenderArguments render = drawingOf(records.front(), arguments, out);
    RedrawReport report;
    report.data = findAll(records, arguments, render.ram, common);
    CommonOptions drawing = common;
    drawing.quiet = common.quiet || scratch.has_value(); // of a picture that nobody gets
    if (before.contains("panels")) {
        redrawPanels(before, records, arguments, out, drawing);
    } else {
        render.scene = records.front().scene;
        runRender(render, drawing);
    }

    common.progress->stage("comparing the pictures");
    const json now = manifestJsonOf(out);
    report.differences = compareAll(before, now);
    MemoryBudget ram("RAM", "--ram", budgetBytes(render.ram, "--ram", common));
    report.pixels = comparePixels(figure, out, ram);
    common.progress->end();
    if (arguments.json)
        tessera::printReport(reportJson(arguments, report));
    else
        printReport(report, now.contains("panels") ? now["panels"][0] : now);
    finishStandardOutput();
    if (report.pixels.notCompared.empty() && report.pixels.differing > 0 && !report.isKnownToDiffer())
        throw Error(figure.string() + ": its pixels differ, though nothing that is known does");
}

} // namespace tessera
