// viewer/films/movie_file.h: writes frames as one film file, by the program ffmpeg if it is installed.
#pragma once

#include <cstddef>
#include <filesystem>

namespace tessera {

/// .mp4, .mov, .mkv
bool isMovieFile(const std::filesystem::path& path);
/// Early check: throws InputError naming the file without ffmpeg, with what to install, and if no file can be
/// written there.
void checkMovieFile(const std::filesystem::path& path);
/// Writes frames folder/frame-NNNNNN.png from first on as the file, which appears when it is complete. Throws
/// Error with ffmpeg's message.
void writeMovie(const std::filesystem::path& path, const std::filesystem::path& folder, std::size_t first,
                std::size_t count, double framesPerSecond);

} // namespace tessera
