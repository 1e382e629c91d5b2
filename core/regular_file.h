// core/regular_file.h: reading a pipe or a device may wait for ever, or give no end: such files are refused
// before they are opened.
#pragma once

#include "core/error.h"

#include <filesystem>
#include <system_error>

namespace tessera {

/// Whether something is there and is a pipe, a socket or a device. Links are followed.
inline bool isPipeOrDevice(const std::filesystem::path& path) {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(path, ignored);
    return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
           !std::filesystem::is_directory(status);
}

/// Throws InputError naming a pipe, a socket or a device.
inline void refusePipeOrDevice(const std::filesystem::path& path) {
    if (isPipeOrDevice(path))
        throw badFile(path.string(), "a regular file", "a pipe, a socket or a device");
}

} // namespace tessera
