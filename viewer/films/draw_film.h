// viewer/films/draw_film.h: draws the frames of a film, one after another, into a folder that other processes
// may share, and writes the film as one file.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/animation/film.h"
#include "core/base/budget.h"
#include "render/picture/render_scene.h"
#include "viewer/cli/options/options.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// First and last, both drawn.
struct FrameRange {
    std::size_t first = 0, last = 0;
};
/// "12", "0-249". Throws InputError naming --frames for anything else, and for frames that the film
/// does not have.
FrameRange parseFrames(const std::string& text, std::size_t frames);

struct FilmJob {
    const Film* film = nullptr;
    Scene scene; // the film's, without keyframes; for the record
    FrameRange range;
    std::filesystem::path out; // a folder, or a file that isMovieFile()
    RenderOptions options;
    Stores stores; // of the scene's volumes
    MemoryBudget *ram = nullptr, *gpu = nullptr;
    /// Draws over a frame on its background, and tells its manifest; may be empty.
    std::function<void(const Scene&, const RenderResult&, Image&, nlohmann::json&)> annotate;
    /// Of a film over phases: frame n shows the first volume of phase n, and begins again behind the last.
    struct Phase {
        std::string label, contentHash;
        std::filesystem::path store;
    };
    std::vector<Phase> phases; // empty: all frames show `stores`
    std::function<std::unique_ptr<StoreReader>(const std::filesystem::path&)> open = {}; // of phases
};

struct FilmReport {
    std::size_t frames = 0, drawn = 0, there = 0,
                byOthers = 0; // frames of the range; those that existed before
    std::size_t goneOn = 0;   // drawn with the bricks of the frame before
    std::size_t blank = 0;    // of the drawn frames
    double seconds = 0, preparing = 0, loading = 0, drawing = 0;
    std::vector<double> frameSeconds; // of the drawn frames, in order
    std::filesystem::path folder; // folder of the frames; empty: they were removed after the file was written
};

/// Writes a frame: its picture and its manifest.
using WriteFrame =
    std::function<void(const std::filesystem::path&, const Image&, const std::string& manifest)>;

/// Draws missing frames. It waits for frames of other processes, and draws them if such a process ends
/// without them. After an interruption or a kill the folder has complete frames, and the same command
/// continues. Throws InputError for a folder of another film, and as renderScene() does.
FilmReport drawFilm(const FilmJob& job, const CommonOptions& common, const WriteFrame& write);

} // namespace tessera
