// viewer/cli/render/tiled_picture.cpp: see tiled_picture.h.
#include "viewer/cli/render/tiled_picture.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/scene/reflection.h"
#include "render/backends/engine_maker.h"
#include "render/picture/render_scene.h"
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/annotations/figure_part.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/render/asked_options.h"
#include "viewer/cli/render/picture_files.h" // printReport
#include "viewer/cli/render/picture_notes.h"
#include "viewer/tiles/tile_folder.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kTilesOption = "--tiles";

/// Why a scene's picture needs all of its pixels at once; empty: it does not.
std::string needsAllPixels(const Scene& scene, Verify verify) {
    const PixelSampling& pixels = scene.quality.pixels;
    if (pixels.samples == PixelSampling::kAutomatic)
        return "--samples auto, with which all pixels of a picture share its rays";
    if (pixels.noise > 0)
        return "--noise, which is that of all pixels";
    if (pixels.denoise)
        return "--denoise, whose filter reaches across tiles";
    if (scene.quality.maxError.value_or(0) > 0 && verify != Verify::none)
        return "--max-error, for which whole pictures are drawn until one is good enough";
    if (scene.volumes.size() > 1 && reductionOf(scene) != Reduction::composite)
        return "several volumes in a mode of single values, each of which has a picture of its own";
    if (scene.mode == Mode::slice &&
        std::any_of(scene.volumes.begin(), scene.volumes.end(),
                    [](const SceneVolume& volume) { return !volume.labels.path.empty(); }))
        return "labels over a slice, whose outlines reach across tiles";
    if (std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                    [](const Isosurface& surface) { return surface.transmits(); }))
        return "isosurfaces that refract, whose rays are followed in groups of all pixels";
    return {};
}

std::filesystem::path folderOf(const std::filesystem::path& out) {
    std::filesystem::path folder = out;
    folder += ".tiles";
    return folder;
}

nlohmann::json recordOf(const RenderTask& task, const RenderOptions& options) {
    nlohmann::json record =
        recordOfPixels(task.scene, task.stores, EngineMaker(options.engine, options.device, options.threads));
    record["tesseraTiles"] = 1;
    record["tile"] = task.arguments.tiles;
    return record;
}

nlohmann::json tilesJson(const TileFolder& tiles) {
    const TileFolder::Report& report = tiles.report();
    return {{"side", tiles.side()},  {"tiles", report.tiles},       {"drawn", report.drawn},
            {"there", report.there}, {"byOthers", report.byOthers}, {"drawnAgain", report.damaged}};
}

/// Writes the picture from its tiles.
nlohmann::json writeTiles(const RenderTask& task, const RenderResult& result, TileFolder& tiles) {
    const auto width = static_cast<std::size_t>(task.scene.imageSize.x);
    // Rows as the picture shows them, and as they are stored.
    const Charge rows = task.ram.charge(
        ImageRows::kAtOnce * width * (sizeof(glm::vec4) + 4 * sizeof(std::uint16_t)), "rows of the picture");
    nlohmann::json report = makeManifest(task.scene, task.stores, result, task.ram, task.gpu);
    report["tiles"] = tilesJson(tiles);
    report["options"] = optionsJson(task);
    const Figure figure = figureOf(
        FigureMaker(task.scene, task.stores, task.ram, task.options.threads).part(task.scene, result),
        task.scene.annotations.dpi);
    tellAnnotations(report, figure);
    writeFigureRows(task.arguments.out, tiles.rows(task.scene.background), figure, manifestText(report),
                    task.ram);
    return report;
}

} // namespace

glm::ivec2 pixelsTogether(const RenderArguments& arguments, const Scene& scene) {
    return arguments.tiles > 0 ? glm::min(glm::ivec2(arguments.tiles), scene.imageSize) : scene.imageSize;
}

void checkTiles(const RenderArguments& arguments, const Scene& scene) {
    if (arguments.tiles == 0)
        return;
    if (arguments.isFilm() || !arguments.pathPicture().empty())
        throw badFile(kTilesOption, "one picture", arguments.isFilm() ? "a film" : arguments.pathPicture());
    for (const auto& [said, option] : {std::pair{!arguments.first.empty(), "--first"},
                                       {!arguments.layers.empty(), "--layers"},
                                       {!arguments.keepState.empty(), "--keep-state"},
                                       {arguments.allowDamaged, "--allow-damaged"}})
        if (said)
            throw badFile(kTilesOption, std::string("no ") + option + " with it", option);
    if (const std::string why = needsAllPixels(scene, verifyOf(arguments)); !why.empty())
        throw badFile(kTilesOption, "a picture of pixels that do not depend on one another", why);
}

void renderTiledPicture(const RenderTask& task) {
    const RenderArguments& arguments = task.arguments;
    const CommonOptions& common = task.common;
    RenderOptions options = optionsFor(task.scene, task.stores, task.options);
    options.progress = common.progress.get();
    if (task.scene.annotations.margin != AnnotationMargin::none) // a page that is too large is refused now
        figureOf(FigureMaker(task.scene, task.stores, task.ram, task.options.threads).partToCome(task.scene),
                 task.scene.annotations.dpi);
    TileFolder tiles(folderOf(arguments.out), recordOf(task, options), task.scene.imageSize, arguments.tiles,
                     *common.progress, [&](const std::string& words) { common.note(words); });
    options.tiles = &tiles;
    const RenderResult result = renderScene(task.scene, task.stores, task.ram, task.gpu, options);
    noteTable(task, result);
    noteLeftOut(task, result);
    const bool finishes = tiles.finishes(), blank = tiles.blank();
    nlohmann::json report = {{"tiles", tilesJson(tiles)}};
    if (finishes) {
        common.progress->stage("writing the picture");
        report = writeTiles(task, result, tiles);
    }
    tiles.finish();
    common.progress->end();
    if (const std::string words = leftOutText(report); !words.empty())
        common.note(words);
    if (finishes && blank)
        warnBlank(task, result);
    if (arguments.json) {
        report["output"] = arguments.out;
        report["writtenBy"] = finishes ? "this process" : "another process";
        if (finishes)
            report["blank"] = blank;
        report["seconds"] = {{"preparing", result.secondsPreparing},
                             {"loading", result.secondsLoading},
                             {"drawing", result.secondsDrawing},
                             {"checking", result.secondsChecking}};
        if (arguments.explain && finishes)
            report["explain"] = explain(result, task.scene);
        printReport(report);
    } else if (arguments.explain && finishes) {
        for (const std::string& line : explain(result, task.scene))
            std::printf("%s\n", line.c_str());
    }
    finishStandardOutput();
    const TileFolder::Report& made = tiles.report();
    if (finishes) {
        if (!blank)
            noteMissingSurfaces(task, result);
        noteUnseenSky(task);
        noteWritten(task, task.scene, result,
                    " in " + std::to_string(made.tiles) + " tiles, " + std::to_string(made.drawn) +
                        " of them drawn");
    } else {
        common.note("another process wrote " + arguments.out + "; this one drew " +
                    std::to_string(made.drawn) + " of " + std::to_string(made.tiles) + " tiles");
    }
    common.detail("most charged: RAM " + formatBytes(task.ram.peakBytes()) + " of " +
                  formatBytes(task.ram.limitBytes()) + ", GPU memory " + formatBytes(task.gpu.peakBytes()) +
                  " of " + formatBytes(task.gpu.limitBytes()));
}

} // namespace tessera
