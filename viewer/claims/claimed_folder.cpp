// viewer/claims/claimed_folder.cpp: see claimed_folder.h.
#include "viewer/claims/claimed_folder.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <unistd.h>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What a process's own records begin with before they are published.
std::string ownBegin(const std::string& record) {
    return "." + record.substr(0, record.find('.')) + "-";
}

std::string textOf(const fs::path& path) {
    refusePipeOrDevice(path);
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The first thing that two records differ in, as a person would say it.
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

ClaimedFolder::ClaimedFolder(const fs::path& folder, ClaimedWork work, const json& record)
    : ClaimedFolder(folder, std::move(work), record, ClaimKind::lock, 0) {
    if (!locksProve(folder_))
        claims_ = Claims(folder_, ClaimKind::lease);
}

ClaimedFolder::ClaimedFolder(const fs::path& folder, ClaimedWork work, const json& record, ClaimKind kind,
                             double leaseSeconds)
    : folder_(folder), work_(std::move(work)), claims_(folder, kind, leaseSeconds) {
    std::error_code failed;
    if (fs::exists(folder_) && !fs::is_directory(folder_))
        throw badFile(folder_.string(), "a folder for " + work_.parts, "a file");
    fs::create_directories(folder_, failed);
    if (failed)
        throw Error(printable(folder_.string()) + ": cannot be made: " + failed.message());
    if (::access(folder_.c_str(), W_OK | X_OK) != 0)
        throw badFile(folder_.string(), "a folder that may be written in", std::strerror(errno));
    constexpr int kTries = 100; // another process may be removing the folder's work meanwhile
    for (int i = 0; i < kTries; ++i) {
        adopt(record);
        if (LockTry lock = tryLock(folder_ / work_.record, LockKind::shared); lock.locked) {
            open_ = std::move(lock.file);
            removeUselessClaims();
            return;
        } else if (!lock.busy && fs::exists(folder_ / work_.record)) { // the file system has no locks
            claims_ = Claims(folder_, ClaimKind::lease, leaseSeconds);
            removeUselessClaims();
            return;
        }
        constexpr std::chrono::milliseconds kBetweenTries{50};
        std::this_thread::sleep_for(kBetweenTries);
        fs::create_directories(folder_, failed);
    }
    throw Error(printable(folder_.string()) + ": another process keeps removing its " + work_.parts);
}

ClaimedFolder::~ClaimedFolder() = default;

bool ClaimedFolder::isPart(const std::string& name) const {
    const std::string &begin = work_.begin, &end = work_.end;
    return name.size() > begin.size() + end.size() && name.starts_with(begin) && name.ends_with(end) &&
           name.find_first_not_of("0123456789", begin.size()) == name.size() - end.size();
}

/// Neither a part nor the record.
bool ClaimedFolder::isFurther(const std::string& name) const {
    const std::size_t begin = work_.marks.size();
    return std::find(work_.others.begin(), work_.others.end(), name) != work_.others.end() ||
           (begin > 0 && name.size() > begin && name.starts_with(work_.marks) &&
            name.find_first_not_of("0123456789", begin) == std::string::npos);
}

/// The lock file of a part.
bool ClaimedFolder::isClaim(const std::string& name) const {
    const std::optional<std::string> of = Claims::nameOf(name);
    return of && (of->starts_with(work_.begin) || isFurther(*of));
}

/// A record of a process before it is published.
bool ClaimedFolder::isOwn(const std::string& name) const {
    const auto begins = [&](const std::string& record) { return name.starts_with(ownBegin(record)); };
    return begins(work_.record) || std::any_of(work_.others.begin(), work_.others.end(), begins);
}

/// Writes a record if there is none.
void ClaimedFolder::publish(const std::string& name, const json& record) const {
    const fs::path file = folder_ / name;
    if (fs::exists(file))
        return;
    // link() publishes a whole file at once and replaces nothing: if it fails, another process's file is
    // there. (Not named like a leftover of OutputFile, which other processes remove.)
    static std::atomic<int> folders{0}; // number within this process: several may begin at once
    const fs::path own =
        folder_ / (ownBegin(name) + std::to_string(::getpid()) + "-" + std::to_string(folders++) + ".json");
    writeOutputFile(own, record.dump(1, ' ', true, json::error_handler_t::replace) + "\n");
    const TemporaryPath unfinished(own);
    const bool linked = ::link(own.c_str(), file.c_str()) == 0;
    const int why = errno;
    if (!linked && why != EEXIST && !fs::exists(file)) // no links to be had
        fs::rename(own, file);
    std::error_code ignored;
    fs::remove(own, ignored);
}

/// Throws unless the record that is there is this one.
void ClaimedFolder::compare(const std::string& name, const json& record, const std::string& hint) const {
    const fs::path file = folder_ / name;
    const json found = json::parse(textOf(file), nullptr, false);
    if (found == json::parse(record.dump(-1, ' ', true, json::error_handler_t::replace)))
        return;
    if (!found.is_object())
        throw badFile(file.string(), "what " + work_.work + " the folder holds", "something else");
    json a, b;
    const std::string what = difference(found, record, "", a, b);
    throw badFile(folder_.string(),
                  work_.parts + " of this " + work_.work + " (" + what + ": " + shortText(b) + ")",
                  "those of another (" + shortText(a) + "); " + hint);
}

/// Writes the record if there is none; otherwise the existing one must be equal.
void ClaimedFolder::adopt(const json& record) {
    const fs::path file = folder_ / work_.record;
    if (!fs::exists(file))
        for (const auto& entry : fs::directory_iterator(folder_))
            if (isPart(entry.path().filename().string()) && !fs::exists(file))
                throw badFile(folder_.string(),
                              "an empty folder, or one with this " + work_.work + "'s " + work_.parts +
                                  " and its " + work_.record,
                              entry.path().filename().string() + " without a " + work_.record);
    publish(work_.record, record);
    compare(work_.record, record, work_.hint);
}

void ClaimedFolder::agree(const std::string& name, const json& record, const std::string& hint) {
    publish(name, record);
    compare(name, record, hint);
}

/// Removes lock files of finished parts. A process that was killed between writing a part and removing its
/// lock file leaves one, and that part is not requested again. Also removes unpublished records of killed
/// processes, since the record exists.
void ClaimedFolder::removeUselessClaims() {
    std::error_code ignored;
    std::vector<fs::path> useless;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
        const std::string name = entry.path().filename().string();
        if (isClaim(name) && fs::exists(folder_ / *Claims::nameOf(name), ignored))
            useless.push_back(entry.path());
        if (name.starts_with(ownBegin(work_.record)) && fs::exists(folder_ / work_.record, ignored))
            useless.push_back(entry.path());
    }
    for (const fs::path& path : useless)
        fs::remove(path, ignored);
}

std::string ClaimedFolder::nameOf(const ClaimedWork& work, std::size_t part) {
    char number[24];
    std::snprintf(number, sizeof number, "%06zu", part);
    return work.begin + number + work.end;
}

bool ClaimedFolder::has(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(pathOf(name), ignored);
}

std::string ClaimedFolder::nameOfMark(const ClaimedWork& work, std::size_t number) {
    return work.marks + std::to_string(number);
}

std::unique_ptr<Claim> ClaimedFolder::claim(const std::string& name) {
    if (has(name))
        return nullptr;
    std::unique_ptr<Claim> claim = claims_.claim(name);
    if (claim && has(name)) // the earlier holder of the lock file has finished
        return nullptr;
    return claim;
}

bool ClaimedFolder::removeIfAlone() {
    std::error_code ignored;
    if (claims_.kind() != ClaimKind::lock)
        return false;
    open_ = FileHandle();
    const LockTry alone = tryLock(folder_ / work_.record, LockKind::exclusive);
    if (!alone.locked)
        return !alone.busy;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
        const std::string name = entry.path().filename().string();
        if (isPart(name) || isClaim(name) || isOwn(name) || isFurther(name))
            fs::remove(entry.path(), ignored);
    }
    fs::remove(folder_ / work_.record, ignored);
    fs::remove(folder_, ignored); // only if it is empty
    return true;
}

} // namespace tessera
