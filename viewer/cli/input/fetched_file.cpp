// viewer/cli/input/fetched_file.cpp: see fetched_file.h.
#include "viewer/cli/input/fetched_file.h"

#include "bricking/store/remote_files.h"
#include "bricking/store/store_files.h"
#include "core/base/address.h"
#include "core/base/budget.h" // formatBytes
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/remote_input.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kPiece = std::uint64_t{8} << 20, kPiecesAhead = 4;

/// The name by which formats tell a file.
std::string nameOf(const fs::path& address) {
    const std::string name = address.filename().string();
    return name.empty() || name.starts_with('.') ? "file" : name;
}

} // namespace

std::uint64_t FetchedFile::mostBytes() {
    return remoteBytesLimit();
}

FetchedFile::FetchedFile(const fs::path& given, const std::string& what)
    : given_(reached(given)), path_(given_) {
    if (!isAddress(given_))
        return;
    const std::optional<RemotePlace> place = remotePlaceOf(given_);
    RemoteFiles& files = *place->files;
    const std::optional<std::uint64_t> size = files.sizeOf(place->below);
    if (!size) {
        const std::string why = files.whyNone();
        throw badFile(given_.string(), what + "; folders at addresses cannot be listed",
                      "nothing there" + (why.empty() ? "" : " (" + why + ")"));
    }
    if (*size > mostBytes())
        throw badFile(given_.string(),
                      what + " of at most " + formatBytes(static_cast<std::size_t>(mostBytes())) +
                          ", a quarter of the cache (TESSERA_CACHE_SIZE); or a copy of it on a disk",
                      formatBytes(static_cast<std::size_t>(*size)));
    folder_.emplace();
    path_ = *folder_ / nameOf(given_);
    FileHandle file = openForWriting(path_);
    std::vector<std::byte> piece(static_cast<std::size_t>(std::min(kPiece, *size)));
    for (std::uint64_t at = 0; at < *size; at += piece.size()) {
        checkInterrupted();
        files.willRead({{place->below, at, kPiecesAhead * kPiece}});
        const auto some = std::span(piece).first(std::min<std::uint64_t>(piece.size(), *size - at));
        files.readAt(place->below, at, some);
        writeAt(file, at, some, path_);
    }
    file.close(path_.string());
}

/// The temporary file is no place that a user knows.
InputError FetchedFile::renamed(const InputError& problem) const {
    std::string text = problem.what();
    const auto replace = [&](const std::string& from, const std::string& to) {
        bool isThere = false;
        for (std::size_t at = text.find(from); at != std::string::npos;
             at = text.find(from, at + to.size())) {
            text.replace(at, from.size(), to);
            isThere = true;
        }
        return isThere;
    };
    replace(path_.string(), given_.string());
    if (replace((folder_->path() / "").string(), (given_.parent_path() / "").string()))
        text += "; files that another one names are not fetched from addresses";
    return InputError(text);
}

} // namespace tessera
