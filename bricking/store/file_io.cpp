// bricking/store/file_io.cpp: see file_io.h.
#include "bricking/store/file_io.h"

#include "core/base/error.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tessera {
namespace {

std::string reason() {
    return std::strerror(errno);
}

Error writeFailed(const std::filesystem::path& path, const char* what) {
    return Error(path.string() + ": could not " + what + ": " + reason());
}

} // namespace

FileHandle openFolder(const std::filesystem::path& path) {
    FileHandle folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.descriptor() < 0)
        throw badFile(path.string(), "a folder that can be opened", reason());
    return folder;
}

std::optional<FileHandle> openIn(const FileHandle& folder, std::string_view relative,
                                 const std::filesystem::path& shown) {
    FileHandle at;
    int parent = folder.descriptor();
    std::string_view rest = relative;
    while (true) {
        const std::size_t slash = rest.find('/');
        const std::string name(rest.substr(0, slash));
        const bool last = slash == std::string_view::npos;
        TESSERA_CHECK(!name.empty() && name != "." && name != "..");
        // O_NONBLOCK: opening a FIFO must not wait for its writer.
        const int flags = O_RDONLY | O_CLOEXEC | O_NOFOLLOW | (last ? O_NONBLOCK : O_DIRECTORY);
        FileHandle next(::openat(parent, name.c_str(), flags));
        if (next.descriptor() < 0) {
            if (errno == ENOENT)
                return std::nullopt;
            const std::string found = errno == ELOOP ? "a symbolic link" : reason();
            throw badFile((shown / relative).string(), "a regular file in regular folders", found);
        }
        at = std::move(next);
        if (last)
            break;
        parent = at.descriptor();
        rest.remove_prefix(slash + 1);
    }
    struct stat facts {};
    if (::fstat(at.descriptor(), &facts) != 0 || !S_ISREG(facts.st_mode))
        throw badFile((shown / relative).string(), "a regular file", "something else");
    return at;
}

std::uint64_t fileSize(const FileHandle& file, const std::string& shown) {
    struct stat facts {};
    if (::fstat(file.descriptor(), &facts) != 0)
        throw badFile(shown, "a readable file", reason());
    return static_cast<std::uint64_t>(facts.st_size);
}

void readAt(const FileHandle& file, std::uint64_t offset, std::span<std::byte> out,
            const std::string& shown) {
    while (!out.empty()) {
        const ssize_t got = ::pread(file.descriptor(), out.data(), out.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw badFile(shown, "a readable file", reason());
        if (got == 0)
            throw badFile(shown,
                          std::to_string(out.size()) + " more bytes at offset " + std::to_string(offset),
                          "the end of the file");
        offset += static_cast<std::uint64_t>(got);
        out = out.subspan(static_cast<std::size_t>(got));
    }
}

std::optional<std::string> readText(const FileHandle& folder, std::string_view relative,
                                    const std::filesystem::path& shown, std::uint64_t limitBytes) {
    const std::optional<FileHandle> file = openIn(folder, relative, shown);
    if (!file)
        return std::nullopt;
    const std::string name = (shown / relative).string();
    const std::uint64_t size = fileSize(*file, name);
    if (size > limitBytes)
        throw badFile(name, "at most " + std::to_string(limitBytes) + " bytes", std::to_string(size));
    std::string text(static_cast<std::size_t>(size), '\0');
    readAt(*file, 0, std::as_writable_bytes(std::span(text)), name);
    return text;
}

FileHandle openForWriting(const std::filesystem::path& path) {
    FileHandle file(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (file.descriptor() < 0)
        throw writeFailed(path, "write");
    return file;
}

void writeAt(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
             const std::filesystem::path& shown) {
    while (!bytes.empty()) {
        const ssize_t put =
            ::pwrite(file.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            throw writeFailed(shown, "write");
        offset += static_cast<std::uint64_t>(put);
        bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
}

void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    FileHandle file = openForWriting(path);
    writeAt(file, 0, bytes, path);
    file.close(path.string());
}

void writeFile(const std::filesystem::path& path, std::string_view text) {
    writeFile(path, std::as_bytes(std::span(text)));
}

void syncAll(const std::filesystem::path& folder) {
    if (::syncfs(openFolder(folder).descriptor()) != 0)
        throw writeFailed(folder, "make durable");
}

void syncFolder(const std::filesystem::path& folder) {
    // Some file systems refuse fsync on folders (EINVAL); they order names by themselves.
    if (::fsync(openFolder(folder).descriptor()) != 0 && errno != EINVAL)
        throw writeFailed(folder, "make durable");
}

} // namespace tessera
