// viewer/films/movie_file.h: writes frames as one film file, by ffmpeg's program where it is installed.
#pragma once

#include <cstddef>
#include <filesystem>

namespace tessera {

/// .mp4, .mov, .mkv
bool isMovieFile(const std::filesystem::path& path);
/// Throws InputError naming the file for a machine without ffmpeg, saying what to install, and for a place
/// where no file can be written: long before there are frames.
void checkMovieFile(const std::filesystem::path& path);
/// Frames folder/frame-NNNNNN.png from first on become the file, which appears when it is whole.
/// Throws Error with what ffmpeg said.
void writeMovie(const std::filesystem::path& path, const std::filesystem::path& folder, std::size_t first,
                std::size_t count, double framesPerSecond);

} // namespace tessera
