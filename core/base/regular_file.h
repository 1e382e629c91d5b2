// core/base/regular_file.h: refuses pipes and devices before they are opened: reading one may block or never
// end.
#pragma once

#include "core/base/error.h"

#include <filesystem>
#include <system_error>

namespace tessera {

/// True if path is a pipe, a socket or a device. Links are followed.
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
