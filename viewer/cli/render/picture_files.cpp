// viewer/cli/render/picture_files.cpp: see picture_files.h.
#include "viewer/cli/render/picture_files.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/films/movie_file.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/image/image_file.h"
#endif

#include <cstdio>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

namespace fs = std::filesystem;

#if !TESSERA_WITH_IMAGE_FILES
void checkImagePath(const fs::path&) {
    throw InputError("render: this program was built without picture files");
}
void writeImage(const fs::path&, const Image&, const std::string&, std::span<const LayerChannel>) {}
std::string readManifest(const fs::path&) {
    return {};
}
Image readImage(const fs::path&) {
    return {};
}
glm::ivec2 pictureSize(const fs::path&) {
    return {};
}
void checkPictureIsWhole(const fs::path&) {}
#endif

} // namespace

void checkPictureOutput(const fs::path& out) {
    checkImagePath(out);
    checkOutputFile(out);
}

void checkFigureName(const fs::path& out) {
#if TESSERA_WITH_IMAGE_FILES
    checkFigurePath(out);
#else
    checkImagePath(out);
#endif
}

void checkFigureOutput(const fs::path& out) {
    checkFigureName(out);
    checkOutputFile(out);
}

void checkFilmOutput(const fs::path& out) {
    if (isMovieFile(out)) {
        checkMovieFile(out);
        return;
    }
    const std::string extension = out.extension().string();
    if (extension == ".png" || extension == ".exr" || extension == ".tif" || extension == ".tiff" ||
        extension == ".pdf" || extension == ".svg")
        throw badFile(out.string(), "a folder for frames (-o frames/) or a film (.mp4, .mov, .mkv)",
                      "a picture");
    if (extension == ".zarr" || (out.filename().empty() && out.parent_path().extension() == ".zarr"))
        throw badFile(out.string(), "a folder for frames (-o frames/) or a film (.mp4, .mov, .mkv)",
                      "a store");
    checkImagePath("frame.png");
}

void writePicture(const fs::path& path, const Image& image, const std::optional<glm::vec3>& background,
                  const std::string& manifest, std::span<const LayerChannel> layers) {
    writeImage(path, background ? overBackground(image, *background) : image, manifest, layers);
}

std::string manifestOf(const fs::path& path) {
    return readManifest(path);
}

glm::ivec2 sizeOfPicture(const fs::path& path) {
    return pictureSize(path);
}

void checkWholePicture(const fs::path& path) {
    checkPictureIsWhole(path);
}

Image readPicture(const fs::path& path) {
    return readImage(path);
}

void printReport(const nlohmann::json& report) {
    std::printf("%s\n", report.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
}

} // namespace tessera
