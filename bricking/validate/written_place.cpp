// bricking/validate/written_place.cpp: see written_place.h.
#include "bricking/validate/written_place.h"

#include "core/base/shown_text.h"

namespace tessera {
namespace fs = std::filesystem;

std::string whyNotWritten(const fs::path& store, const fs::path& relative) {
    fs::path at;
    for (const fs::path& name : relative) {
        at /= name;
        std::error_code ignored;
        const fs::file_type type = fs::symlink_status(store / at, ignored).type();
        if (type == fs::file_type::symlink)
            return printable(at.string()) + " is a symbolic link";
        if (type != fs::file_type::regular && type != fs::file_type::directory &&
            type != fs::file_type::not_found)
            return printable(at.string()) + " is neither a file nor a folder";
    }
    return {};
}

} // namespace tessera
