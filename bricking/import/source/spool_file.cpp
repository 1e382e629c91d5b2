// bricking/import/source/spool_file.cpp: see spool_file.h.
#include "bricking/import/source/spool_file.h"

#include "core/base/error.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <unistd.h>

namespace tessera {

SpoolFile::SpoolFile(const std::filesystem::path& folder)
    : folder_(folder.empty() ? std::filesystem::temp_directory_path() : folder) {
    // Without a name from the start, where the file system can: a process that dies leaves nothing.
    descriptor_ = ::open(folder_.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (descriptor_ >= 0)
        return;
    std::string name = (folder_ / "tessera-spool-XXXXXX").string();
    descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0)
        throw Error(folder_.string() + ": cannot make a temporary file: " + std::strerror(errno));
    ::unlink(name.c_str());
}

SpoolFile::~SpoolFile() {
    ::close(descriptor_);
}

void SpoolFile::append(std::span<const std::byte> bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t put = ::pwrite(descriptor_, bytes.data() + done, bytes.size() - done,
                                     static_cast<off_t>(sizeBytes_ + done));
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            throw Error(folder_.string() + ": cannot write a temporary file: " + std::strerror(errno));
        done += static_cast<std::size_t>(put);
    }
    sizeBytes_ += bytes.size();
}

void SpoolFile::readAt(std::uint64_t offset, std::span<std::byte> out) const {
    std::size_t done = 0;
    while (done < out.size()) {
        const ssize_t got =
            ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            throw Error(folder_.string() + ": cannot read a temporary file: " +
                        (got == 0 ? "it is too short" : std::strerror(errno)));
        done += static_cast<std::size_t>(got);
    }
}

} // namespace tessera
