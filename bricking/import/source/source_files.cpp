// bricking/import/source/source_files.cpp: see source_files.h.
#include "bricking/import/source/source_files.h"

#include "core/base/error.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace tessera {
namespace {

/// Bytes read from an offset on: fewer than `out` has only at the end of the file.
/// @param fault  makes what is thrown where reading fails, from the reason
template <typename Fault>
std::size_t readOf(int descriptor, std::uint64_t offset, std::span<std::byte> out, const Fault& fault) {
    std::size_t done = 0;
    while (done < out.size()) {
        const ssize_t got =
            ::pread(descriptor, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw fault(std::strerror(errno));
        if (got == 0)
            break;
        done += static_cast<std::size_t>(got);
    }
    return done;
}

} // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
    // O_NONBLOCK: opening a pipe must not wait for a writer before fstat can refuse it.
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0)
        throw badFile(path_.string(), "a readable file", std::strerror(errno));
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(std::exchange(descriptor_, -1));
        throw badFile(path_.string(), "a regular file", "something else");
    }
    sizeBytes_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), sizeBytes_(other.sizeBytes_),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(sizeBytes_, other.sizeBytes_);
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

InputFile::~InputFile() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

std::size_t InputFile::readSome(std::uint64_t offset, std::span<std::byte> out) const {
    return readOf(descriptor_, offset, out,
                  [this](const char* why) { return Error(path_.string() + ": reading failed: " + why); });
}

void InputFile::readAt(std::uint64_t offset, std::span<std::byte> out) const {
    const std::size_t got = readSome(offset, out);
    if (got < out.size())
        throw badFile(path_.string(),
                      std::to_string(out.size()) + " bytes from byte " + std::to_string(offset) + " on",
                      "the end of the file after " + std::to_string(got) + " of them");
}

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
    const auto fault = [this](const char* why) {
        return Error(folder_.string() + ": cannot read a temporary file: " + why);
    };
    if (readOf(descriptor_, offset, out, fault) < out.size())
        throw fault("it is too short");
}

} // namespace tessera
