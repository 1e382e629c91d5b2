// viewer/cli/render/picture_files.h: writes pictures for `tessera render`. A program without picture files
// throws here.
#pragma once

#include "core/image/image.h"

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

namespace tessera {

/// Before the long work: throws InputError naming out for a picture that cannot be written there.
void checkPictureOutput(const std::filesystem::path& out);
/// Throws InputError naming out unless its name is that of a picture or of a page (writeFigure()).
void checkFigureName(const std::filesystem::path& out);
/// checkPictureOutput() for a picture that may be a page.
void checkFigureOutput(const std::filesystem::path& out);
/// The same for a film: a folder for frames, or a file of its own.
void checkFilmOutput(const std::filesystem::path& out);

/// writeImage() (core/image/image_file.h).
/// @param background  that it is put on first, linear; none: nothing
void writePicture(const std::filesystem::path& path, const Image& image,
                  const std::optional<glm::vec3>& background, const std::string& manifest,
                  std::span<const LayerChannel> layers = {});
/// readManifest() (core/image/image_file.h); "" in a program without picture files.
std::string manifestOf(const std::filesystem::path& path);

/// pictureSize() (core/image/image_file.h).
glm::ivec2 sizeOfPicture(const std::filesystem::path& path);
/// checkPictureIsWhole() (core/image/image_file.h).
void checkWholePicture(const std::filesystem::path& path);
/// readImage() (core/image/image_file.h).
Image readPicture(const std::filesystem::path& path);

/// A manifest on stdout, for people and --json.
void printReport(const nlohmann::json& report);

} // namespace tessera
