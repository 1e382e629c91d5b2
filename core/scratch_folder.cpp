// core/scratch_folder.cpp: see scratch_folder.h.
#include "core/scratch_folder.h"

#include "core/error.h"

#include <cerrno>
#include <cstdlib> // mkdtemp, of POSIX: chooses the name and makes the folder in one step
#include <cstring>

namespace tessera {

ScratchFolder::ScratchFolder() {
    std::error_code error;
    const std::filesystem::path place = std::filesystem::temp_directory_path(error);
    if (error)
        throw Error("temporary folder (TMPDIR): " + error.message());
    std::string name = (place / "tessera-XXXXXX").string();
    if (!::mkdtemp(name.data()))
        throw Error(place.string() + ": cannot make a temporary folder: " + std::strerror(errno));
    path_ = name;
    unfinished_.emplace(path_);
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

} // namespace tessera
