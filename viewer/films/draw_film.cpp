// viewer/films/draw_film.cpp: see draw_film.h.
#include "viewer/films/draw_film.h"

#include "core/base/error.h"
#include "core/base/fnv_hash.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "render/backends/engine_maker.h"
#include "render/picture/frame_renderer.h"
#include "render/picture/render_scene.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/films/frame_folder.h"
#include "viewer/films/movie_file.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

/// Paths are long.
std::string hashOf(const std::string& text) {
    FnvHash hash;
    hash.addBytes(text);
    return hash.digits();
}

/// All inputs that determine the pixels of the frames.
json recordOf(const FilmJob& job, const EngineMaker& engine) {
    Scene scene = job.scene;
    scene.camera = Camera{}; // comes from the path
    json record = recordOfPixels(scene, job.stores, engine);
    record.update({{"tesseraFilm", 1},
                   {"framesPerSecond", job.film->path().framesPerSecond},
                   {"frames", job.film->frames()},
                   {"path", hashOf(pathJson(job.film->path()))},
                   {"budgets", {{"ram", job.ram->limitBytes()}, {"gpuMemory", job.gpu->limitBytes()}}},
                   {"verify", verifyNames()[static_cast<std::size_t>(job.options.verify)]}});
    for (const FilmJob::Phase& phase : job.phases)
        record["phases"].push_back(phase.contentHash);
    return record;
}

fs::path framesFolderOf(const fs::path& out) {
    if (!isMovieFile(out))
        return out;
    fs::path folder = out;
    folder += ".frames";
    return folder;
}

std::string minutes(double seconds) {
    char text[32];
    const auto whole = static_cast<long>(seconds + 0.5);
    std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
    return text;
}

} // namespace

namespace {

/// What draws the frames: with one phase's volume open at a time.
class FrameSource {
  public:
    FrameSource(const FilmJob& job, const RenderOptions& options) : job_(job), options_(options) {}

    RenderResult draw(std::size_t frame, const Scene& scene) {
        if (!renderer_ || phaseOf(frame) != phase_)
            openFor(frame);
        return renderer_->draw(scene);
    }
    /// Of the frame drawn last.
    Stores stores() const { return reader_ ? Stores(&first_, 1) : job_.stores; }
    std::size_t phaseOf(std::size_t frame) const {
        return job_.phases.empty() ? 0 : frame % job_.phases.size();
    }
    void forget() {
        if (renderer_)
            renderer_->forget();
    }
    std::size_t goneOn() const { return goneOn_ + (renderer_ ? renderer_->kept().goneOn : 0); }

  private:
    void openFor(std::size_t frame) {
        goneOn_ = goneOn();
        renderer_.reset(); // before the store, which it reads
        reader_.reset();
        phase_ = phaseOf(frame);
        if (!job_.phases.empty()) {
            reader_ = job_.open(job_.phases[phase_].store);
            first_ = reader_.get();
        }
        renderer_ = std::make_unique<FrameRenderer>(stores(), *job_.ram, *job_.gpu, options_);
    }

    const FilmJob& job_;
    RenderOptions options_;
    std::unique_ptr<StoreReader> reader_; // of a phase
    const StoreReader* first_ = nullptr;
    std::size_t phase_ = 0, goneOn_ = 0;
    std::unique_ptr<FrameRenderer> renderer_; // last: it reads the store
};

} // namespace

FrameRange parseFrames(const std::string& text, std::size_t frames) {
    const auto refuse = [&] {
        return badFile("--frames", "A or A-B, 0 to " + std::to_string(frames - 1),
                       "\"" + text.substr(0, 40) + "\"");
    };
    const auto number = [&](const std::string& word) {
        if (word.empty() || word.size() > 9 || word.find_first_not_of("0123456789") != std::string::npos)
            throw refuse();
        return static_cast<std::size_t>(std::stoul(word));
    };
    const std::size_t dash = text.find('-');
    FrameRange range;
    range.first = number(text.substr(0, dash));
    range.last = dash == std::string::npos ? range.first : number(text.substr(dash + 1));
    if (range.last < range.first || range.last >= frames)
        throw refuse();
    return range;
}

FilmReport drawFilm(const FilmJob& job, const CommonOptions& common, const WriteFrame& write) {
    const bool movie = isMovieFile(job.out);
    if (movie)
        checkMovieFile(job.out);
    const auto start = Clock::now();
    FilmReport report;
    report.frames = job.range.last - job.range.first + 1;
    report.folder = framesFolderOf(job.out);
    RenderOptions options = job.options;
    options.progress = nullptr; // the film's own
    const RenderOptions drawing = optionsFor(job.scene, job.stores, options);
    FrameFolder folder(report.folder,
                       recordOf(job, EngineMaker(drawing.engine, drawing.device, drawing.threads)));
    FrameSource renderer(job, options);

    std::vector<std::uint8_t> seen(report.frames, 0);
    const auto count = [&](std::size_t at, std::size_t& of) {
        seen[at] = 1;
        ++of;
    };
    for (std::size_t at = 0; at < report.frames; ++at)
        if (folder.has(job.range.first + at))
            count(at, report.there);
    const auto tell = [&] {
        const std::size_t done = report.there + report.drawn + report.byOthers;
        common.progress->update(static_cast<double>(done) / static_cast<double>(report.frames));
    };
    common.progress->stage("drawing " + std::to_string(report.frames) + " frames");
    tell();
    const auto draw = [&](std::size_t at) {
        const std::size_t frame = job.range.first + at;
        const auto began = Clock::now();
        Scene scene = job.film->scene(frame);
        if (!job.phases.empty())
            scene.annotations.namePhase(job.phases[renderer.phaseOf(frame)].label);
        const RenderResult result = renderer.draw(frame, scene);
        const Charge pictures =
            job.ram->charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");
        json manifest = makeManifest(scene, renderer.stores(), result, *job.ram, *job.gpu);
        manifest["film"] = {{"frame", frame}, {"seconds", job.film->timeOf(frame)}};
        if (!job.phases.empty()) {
            manifest["film"]["phase"] = renderer.phaseOf(frame) + 1;
            manifest["film"]["phaseLabel"] = job.phases[renderer.phaseOf(frame)].label;
        }
        if (job.film->curve())
            manifest["film"]["placeMm"] = job.film->placeAt(job.film->timeOf(frame));
        Image picture = scene.background ? overBackground(result.image, *scene.background) : result.image;
        if (job.annotate)
            job.annotate(scene, result, picture, manifest);
        write(folder.pathOf(frame), picture, manifest.dump(-1, ' ', true, json::error_handler_t::replace));
        report.preparing += result.secondsPreparing;
        report.loading += result.secondsLoading;
        report.drawing += result.secondsDrawing;
        report.blank += isBlank(result.image) ? 1 : 0;
        report.frameSeconds.push_back(secondsSince(began));
        count(at, report.drawn);
    };
    // Repeat over the missing frames: other processes finish theirs or end without finishing them.
    bool waits = false;
    for (std::size_t left = 1; left > 0;) {
        left = 0;
        bool drew = false;
        for (std::size_t at = 0; at < report.frames; ++at) {
            if (seen[at])
                continue;
            checkInterrupted();
            if (const auto claim = folder.claim(job.range.first + at)) {
                draw(at);
                drew = true;
                tell();
            } else if (folder.has(job.range.first + at)) {
                count(at, report.byOthers);
            } else {
                ++left;
            }
        }
        if (left > 0 && !drew) {
            if (!std::exchange(waits, true)) {
                renderer.forget(); // leaves its memory to the other processes
                common.progress->stage("waiting for frames that other processes draw");
            }
            tell();
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
    }
    report.goneOn = renderer.goneOn();
    report.seconds = secondsSince(start);
    if (movie) {
        common.progress->stage("writing the film");
        writeMovie(job.out, report.folder, job.range.first, report.frames, job.film->path().framesPerSecond);
        folder.removeIfAlone();
        report.folder.clear();
    }
    common.progress->end();
    common.detail("frames: " + std::to_string(report.drawn) + " drawn, " + std::to_string(report.goneOn) +
                  " of them with bricks of the one before; " + minutes(report.seconds) + " min");
    return report;
}

} // namespace tessera
