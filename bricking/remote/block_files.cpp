// bricking/remote/block_files.cpp: see block_files.h. A block's file has its CRC-32C in front.
#include "bricking/remote/block_files.h"

#include "bricking/store/codec.h"
#include "bricking/store/store_files.h"
#include "core/base/error.h"
#include "core/base/ownership.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kPrefix = 2; // digits of a name that are its folder

} // namespace

/// Two independent hashes of 64 bits (FNV-1a).
std::string BlockFiles::nameOf(const std::string& key) {
    std::string name;
    for (std::uint64_t h : {0xCBF29CE484222325u, 0x9E3779B97F4A7C15u}) {
        for (const char c : key)
            h = (h ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
        char hex[17];
        std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(h));
        name += hex;
    }
    return name;
}

BlockFiles::BlockFiles(fs::path folder, std::uint64_t limitBytes)
    : folder_(std::move(folder)), limit_(limitBytes) {
    std::error_code ignored;
    fs::create_directories(folder_.parent_path(), ignored);
    ::mkdir(folder_.c_str(), 0700);
    struct stat facts {};
    constexpr mode_t kOthers = 077;
    isUsable_ = ::stat(folder_.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) &&
                facts.st_uid == ::geteuid() && (facts.st_mode & kOthers) == 0;
    if (!isUsable_)
        return;
    std::vector<std::pair<fs::file_time_type, Kept>> all;
    for (fs::recursive_directory_iterator at(folder_, ignored), end; !ignored && at != end;
         at.increment(ignored)) {
        std::error_code none;
        if (!at->is_regular_file(none))
            continue;
        const std::string name = at->path().filename().string();
        const fs::file_time_type written = at->last_write_time(none);
        if (!nameOfTemporary(name, "fetching"))
            all.push_back({written, {name, at->file_size(none)}});
        else if (fs::file_time_type::clock::now() - written > std::chrono::hours(1)) // of a dead process
            fs::remove(at->path(), none);
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [time, kept] : all)
        note(kept.name, kept.bytes);
    makeRoom();
}

fs::path BlockFiles::pathOf(const std::string& name) const {
    return folder_ / name.substr(0, kPrefix) / name;
}

/// Under the mutex, or before there are threads.
void BlockFiles::note(const std::string& name, std::uint64_t bytes) {
    if (const auto found = found_.find(name); found != found_.end()) {
        bytes_ -= found->second->bytes;
        kept_.erase(found->second);
    }
    kept_.push_back({name, bytes});
    found_[name] = std::prev(kept_.end());
    bytes_ += bytes;
}

/// Under the mutex.
void BlockFiles::makeRoom() {
    std::error_code ignored;
    while (bytes_ > limit_ && !kept_.empty()) {
        fs::remove(pathOf(kept_.front().name), ignored);
        bytes_ -= kept_.front().bytes;
        found_.erase(kept_.front().name);
        kept_.pop_front();
    }
}

bool BlockFiles::has(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    return found_.contains(nameOf(key));
}

bool BlockFiles::read(const std::string& key, std::span<std::byte> out) {
    if (!isUsable_)
        return false;
    const std::string name = nameOf(key);
    const fs::path path = pathOf(name);
    std::error_code ignored;
    try {
        const StoreFolder folder = openFolder(path.parent_path());
        const auto file = openIn(folder, name, path.parent_path());
        if (!file)
            return false;
        std::uint32_t crc = 0;
        if (fileSize(*file, path.string()) == out.size() + sizeof crc) {
            readAt(*file, 0, std::as_writable_bytes(std::span(&crc, 1)), path.string());
            readAt(*file, sizeof crc, out, path.string());
            if (crc == crc32c(out))
                return true;
        }
    } catch (const InputError&) { // no folder yet, or one that another process removes
        return false;
    }
    fs::remove(path, ignored);
    return false;
}

void BlockFiles::write(const std::string& key, std::span<const std::byte> block) {
    const std::uint64_t bytes = block.size() + sizeof(std::uint32_t);
    if (!isUsable_ || bytes > limit_)
        return;
    const std::string name = nameOf(key);
    const fs::path path = pathOf(name);
    static std::atomic<int> attempts{0};
    const fs::path unfinished = path.parent_path() / temporaryName(name, "fetching", attempts.fetch_add(1));
    std::error_code ignored;
    try {
        fs::create_directory(path.parent_path(), ignored);
        const std::uint32_t crc = crc32c(block);
        FileHandle file = openForWriting(unfinished);
        writeAt(file, 0, std::as_bytes(std::span(&crc, 1)), unfinished);
        writeAt(file, sizeof crc, block, unfinished);
        file.close(unfinished.string());
        if (std::rename(unfinished.c_str(), path.c_str()) != 0)
            throw Error(path.string());
    } catch (const Error&) { // a full disk: blocks are fetched again
        fs::remove(unfinished, ignored);
        return;
    }
    const std::lock_guard lock(mutex_);
    note(name, bytes);
    makeRoom();
}

} // namespace tessera
