// core/base/files.cpp: see files.h.
#include "core/base/files.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <cerrno>
#include <cstring>
#include <unistd.h>
#include <utility>

namespace tessera {

FileHandle::FileHandle(FileHandle&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileHandle& FileHandle::operator=(FileHandle&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

FileHandle::~FileHandle() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

void FileHandle::close(const std::string& shown) {
    const int descriptor = std::exchange(descriptor_, -1);
    // EINTR: the descriptor is gone all the same, and nothing is known to have failed.
    if (descriptor >= 0 && ::close(descriptor) != 0 && errno != EINTR)
        throw Error(printable(shown) + ": cannot be written: " + std::strerror(errno));
}

} // namespace tessera
