// viewer/cli/render/film_of_path.cpp: see film_of_path.h.
#include "viewer/cli/render/film_of_path.h"

#include "core/animation/film.h"
#include "core/base/output_file.h"
#include "core/scene/preset.h"
#include "viewer/cli/render/path_of_arguments.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/films/draw_film.h"

#include <nlohmann/json.hpp>
#include <optional>

namespace tessera {

void renderFilm(const RenderTask& task) {
    const RenderArguments& arguments = task.arguments;
    const Scene& scene = task.scene;
    const auto presets = [&](const std::string& preset) {
        const Statistics statistics = loadStatistics(task.store, task.ram, task.options.threads);
        return presetFunction(preset, summarise(statistics, task.store.info(), scene.volumes.front().unit));
    };
    const bool turns = arguments.turn.has_value();
    const Film film(turns ? turnOf(task) : pathOf(task), scene, presets, turns ? "--turn" : arguments.path);
    FilmJob job;
    job.film = &film;
    job.scene = scene;
    job.range = arguments.frames.empty() || turns ? FrameRange{0, film.frames() - 1}
                                                  : parseFrames(arguments.frames, film.frames());
    job.out = arguments.out;
    job.options = task.options;
    job.store = &task.store;
    job.ram = &task.ram;
    job.gpu = &task.gpu;
    const FilmReport report =
        drawFilm(job, task.common,
                 [](const std::filesystem::path& path, const Image& image, const std::string& manifest) {
                     writePicture(path, image, std::nullopt, manifest);
                 });
    if (report.blank > 0 && report.blank == report.drawn)
        printProblem("all frames are blank: the path's cameras see nothing that is shown");
    if (arguments.json) {
        const nlohmann::json out = {{"output", arguments.out},
                                    {"frames", report.frames},
                                    {"first", job.range.first},
                                    {"drawn", report.drawn},
                                    {"there", report.there},
                                    {"byOthers", report.byOthers},
                                    {"withBricksOfTheOneBefore", report.goneOn},
                                    {"blank", report.blank},
                                    {"framesPerSecond", film.path().framesPerSecond},
                                    {"seconds",
                                     {{"all", report.seconds},
                                      {"preparing", report.preparing},
                                      {"loading", report.loading},
                                      {"drawing", report.drawing},
                                      {"ofFrames", report.frameSeconds}}}};
        printReport(out);
    }
    finishStandardOutput();
    task.common.note(
        "wrote " + arguments.out + ": " + std::to_string(report.frames) + " frames of " +
        std::to_string(scene.imageSize.x) + " x " + std::to_string(scene.imageSize.y) + ", " +
        formatNumber(static_cast<double>(report.frames) / film.path().framesPerSecond, 3) + " s at " +
        formatNumber(film.path().framesPerSecond, 4) + " frames/s" +
        (report.there > 0 ? "; " + std::to_string(report.there) + " were there" : std::string()));
}

} // namespace tessera
