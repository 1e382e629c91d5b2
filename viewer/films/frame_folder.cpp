// viewer/films/frame_folder.cpp: see frame_folder.h.
#include "viewer/films/frame_folder.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/output_file.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kFilmFile[] = "film.json";

bool isFrame(const std::string& name) {
    constexpr std::string_view kBegin = "frame-", kEnd = ".png";
    return name.size() > kBegin.size() + kEnd.size() && name.starts_with(kBegin) && name.ends_with(kEnd) &&
           name.find_first_not_of("0123456789", kBegin.size()) == name.size() - kEnd.size();
}
const std::string kOwnFilm = ".film-"; // a process's own film file before it is published

bool isClaim(const std::string& name) { // of a frame
    const std::optional<std::string> frame = Claims::nameOf(name);
    return frame && isFrame(*frame);
}

std::string textOf(const fs::path& path) {
    refusePipeOrDevice(path);
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The first thing that two films differ in, as a person would say it.
std::string difference(const json& found, const json& expected, const std::string& name, json& a, json& b) {
    if (found.is_object() && expected.is_object()) {
        for (const auto* one : {&expected, &found})
            for (const auto& [key, value] : one->items()) {
                const json x = found.value(key, json()), y = expected.value(key, json());
                if (x != y)
                    return difference(x, y, name.empty() ? key : name + "." + key, a, b);
            }
    }
    if (found.is_array() && expected.is_array() && found.size() == expected.size())
        for (std::size_t i = 0; i < found.size(); ++i)
            if (found[i] != expected[i])
                return difference(found[i], expected[i], name + "[" + std::to_string(i) + "]", a, b);
    a = found, b = expected;
    return name;
}
std::string shortText(const json& value) {
    const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

} // namespace

FrameFolder::FrameFolder(const fs::path& folder, const json& film)
    : FrameFolder(folder, film, ClaimKind::lock, 0) {
    if (!locksProve(folder_))
        claims_ = Claims(folder_, ClaimKind::lease);
}

FrameFolder::FrameFolder(const fs::path& folder, const json& film, ClaimKind kind, double leaseSeconds)
    : folder_(folder), claims_(folder, kind, leaseSeconds) {
    std::error_code failed;
    if (fs::exists(folder_) && !fs::is_directory(folder_))
        throw badFile(folder_.string(), "a folder for frames", "a file");
    fs::create_directories(folder_, failed);
    if (failed)
        throw Error(printable(folder_.string()) + ": cannot be made: " + failed.message());
    if (::access(folder_.c_str(), W_OK | X_OK) != 0)
        throw badFile(folder_.string(), "a folder that may be written in", std::strerror(errno));
    constexpr int kTries = 100; // another process may be removing the folder's film meanwhile
    for (int i = 0; i < kTries; ++i) {
        adopt(film);
        if (LockTry lock = tryLock(folder_ / kFilmFile, LockKind::shared); lock.locked) {
            open_ = std::move(lock.file);
            removeUselessClaims();
            return;
        } else if (!lock.busy && fs::exists(folder_ / kFilmFile)) { // the file system has no locks
            claims_ = Claims(folder_, ClaimKind::lease, leaseSeconds);
            removeUselessClaims();
            return;
        }
        fs::create_directories(folder_, failed);
    }
    throw Error(printable(folder_.string()) + ": another process keeps removing its frames");
}

FrameFolder::~FrameFolder() = default;

/// Writes the film file if there is none; otherwise the existing one must be equal.
void FrameFolder::adopt(const json& film) {
    const fs::path file = folder_ / kFilmFile;
    const std::string text = film.dump(1, ' ', true, json::error_handler_t::replace) + "\n";
    if (!fs::exists(file)) {
        for (const auto& entry : fs::directory_iterator(folder_))
            if (isFrame(entry.path().filename().string()) && !fs::exists(file))
                throw badFile(folder_.string(),
                              "an empty folder, or one with this film's frames and its film.json",
                              entry.path().filename().string() + " without a film.json");
        // link() publishes a whole file at once and replaces nothing: if it fails, another process's file is
        // there. (Not named like a leftover of OutputFile, which other processes remove.)
        static std::atomic<int> folders{0}; // number within this process: several may begin at once
        const fs::path own =
            folder_ / (kOwnFilm + std::to_string(::getpid()) + "-" + std::to_string(folders++) + ".json");
        writeOutputFile(own, text);
        const TemporaryPath unfinished(own);
        const bool linked = ::link(own.c_str(), file.c_str()) == 0;
        const int why = errno;
        if (!linked && why != EEXIST && !fs::exists(file)) // no links to be had
            fs::rename(own, file);
        std::error_code ignored;
        fs::remove(own, ignored);
    }
    const std::string there = textOf(file);
    const json found = json::parse(there, nullptr, false);
    if (found == json::parse(text))
        return;
    if (!found.is_object())
        throw badFile(file.string(), "what film the folder holds", "something else");
    json a, b;
    const std::string what = difference(found, film, "", a, b);
    throw badFile(folder_.string(), "frames of this film (" + what + ": " + shortText(b) + ")",
                  "those of another (" + shortText(a) + "); choose another folder, or remove this one");
}

/// Removes lock files of finished frames. A process that was killed between writing a frame and removing its
/// lock file leaves one, and that frame is not requested again. Also removes unpublished film files of killed
/// processes, since the film file exists.
void FrameFolder::removeUselessClaims() {
    std::error_code ignored;
    std::vector<fs::path> useless;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
        const std::string name = entry.path().filename().string();
        if (isClaim(name) && fs::exists(folder_ / *Claims::nameOf(name), ignored))
            useless.push_back(entry.path());
        if (name.starts_with(kOwnFilm) && fs::exists(folder_ / kFilmFile, ignored))
            useless.push_back(entry.path());
    }
    for (const fs::path& path : useless)
        fs::remove(path, ignored);
}

std::string FrameFolder::nameOf(std::size_t frame) {
    char name[32];
    std::snprintf(name, sizeof name, "frame-%06zu.png", frame);
    return name;
}

bool FrameFolder::has(std::size_t frame) const {
    std::error_code ignored;
    return fs::exists(pathOf(frame), ignored);
}

std::unique_ptr<Claim> FrameFolder::claim(std::size_t frame) {
    if (has(frame))
        return nullptr;
    std::unique_ptr<Claim> claim = claims_.claim(nameOf(frame));
    if (claim && has(frame)) // the earlier holder has finished
        return nullptr;
    return claim;
}

void FrameFolder::removeIfAlone() {
    std::error_code ignored;
    if (claims_.kind() != ClaimKind::lock)
        return;
    open_ = FileHandle();
    const LockTry alone = tryLock(folder_ / kFilmFile, LockKind::exclusive);
    if (!alone.locked)
        return;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
        const std::string name = entry.path().filename().string();
        if (isFrame(name) || isClaim(name))
            fs::remove(entry.path(), ignored);
    }
    fs::remove(folder_ / kFilmFile, ignored);
    fs::remove(folder_, ignored); // only if it is empty
}

} // namespace tessera
