// bricking/store/slab_file.cpp: see slab_file.h.
#include "bricking/store/slab_file.h"

#include "bricking/store/store_files.h"
#include "core/base/budget.h" // formatBytes
#include "core/base/error.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <system_error>
#include <unistd.h>

namespace tessera {
namespace {

FileHandle openNameless(const std::filesystem::path& folder) {
    // Without a name from the start, where the file system can.
    if (const int made = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600); made >= 0)
        return FileHandle(made);
    std::string name = (folder / ".slab-XXXXXX").string();
    const int made = ::mkostemp(name.data(), O_CLOEXEC);
    if (made < 0)
        throw Error(folder.string() + ": cannot make a temporary file: " + std::strerror(errno));
    ::unlink(name.c_str());
    return FileHandle(made);
}

} // namespace

void requireDiskRoom(const std::filesystem::path& folder, std::uint64_t bytes, std::string_view what) {
    std::error_code unknown;
    const std::filesystem::space_info space = std::filesystem::space(folder, unknown);
    if (!unknown && space.available < bytes)
        throw Error(folder.string() + ": expected room for " + formatBytes(bytes) + " (" + std::string(what) +
                    "; with more --ram they need none), found " + formatBytes(space.available));
}

SlabFile::SlabFile(const std::filesystem::path& folder) : folder_(folder), file_(openNameless(folder)) {}

void SlabFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
    writeAt(file_, offset, bytes, folder_ / "(a temporary file)");
}

void SlabFile::read(std::uint64_t offset, std::span<std::byte> out) const {
    while (!out.empty()) {
        const ssize_t got = ::pread(file_.descriptor(), out.data(), out.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            throw Error(folder_.string() + ": cannot read a temporary file: " +
                        (got < 0 ? std::strerror(errno) : "it is too short"));
        offset += static_cast<std::uint64_t>(got);
        out = out.subspan(static_cast<std::size_t>(got));
    }
}

} // namespace tessera
