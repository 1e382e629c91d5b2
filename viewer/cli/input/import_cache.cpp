// viewer/cli/input/import_cache.cpp: see import_cache.h.
#include "viewer/cli/input/import_cache.h"

#include "bricking/import/importer.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h" // isStore
#include "bricking/store/work_folder.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"
#include "core/base/ownership.h"
#include "core/base/program_folders.h"
#include "viewer/cli/input/source_facts.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <tuple>
#include <unistd.h>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uint64_t kDefaultLimitBytes = std::uint64_t{20} << 30;
constexpr std::uint64_t kLargestNoteBytes = 1 << 20; // of HASH.json; ours have less than 8 KiB

/// Of a store in the cache. What is found at first use and kept in it (bricking/analysis/body/kept_table.h)
/// has a checksum of its own, and does not make it another store.
std::string factsOfStore(const fs::path& store) {
    return factsOf(store, "stats/table/");
}

/// The three paths of an entry.
struct Entry {
    Entry(const fs::path& folder, const std::string& hash)
        : store(folder / (hash + ".zarr")), note(folder / (hash + ".json")), lock(folder / (hash + ".lock")) {
    }
    fs::path store, note, lock;
};

/// The content of HASH.json; null if it is missing or invalid.
json readNote(const Entry& entry) {
    try {
        const auto text = readText(openFolder(entry.note.parent_path()), entry.note.filename().string(),
                                   entry.note.parent_path(), kLargestNoteBytes);
        json note = json::parse(text.value_or(""), nullptr, false);
        return note.is_object() ? note : json();
    } catch (const InputError&) {
        return {};
    }
}

std::string textOf(const json& note, const char* key) {
    return note.is_object() && note.contains(key) && note[key].is_string() ? note[key].get<std::string>()
                                                                           : std::string();
}

bool isWhole(const Entry& entry, const std::string& check) {
    const json note = readNote(entry);
    return textOf(note, "check") == check && isStore(entry.store) &&
           textOf(note, "store") == hexHash(factsOfStore(entry.store));
}

/// The folders of unfinished imports to a store.
std::vector<fs::path> unfinishedOf(const fs::path& store) {
    std::vector<fs::path> found;
    std::error_code ignored;
    for (fs::directory_iterator at(store.parent_path(), ignored), end; !ignored && at != end;
         at.increment(ignored))
        if (WorkFolder::nameOf(at->path().filename().string()) == store.filename().string())
            found.push_back(at->path());
    return found;
}

/// Under the entry's lock. The note goes first: a store without one is no entry.
/// @param keptKey  of an unfinished import that stays; "": none does
void discard(const Entry& entry, const std::string& keptKey = {}) {
    std::error_code ignored;
    fs::remove(entry.note, ignored);
    const fs::path aside =
        entry.store.parent_path() / temporaryName(entry.store.filename().string(), "importing", 0);
    fs::rename(entry.store, aside, ignored);
    fs::remove_all(aside, ignored);
    fs::remove_all(entry.store, ignored);
    WorkFolder::sweepOf(entry.store, keptKey);
}

/// Makes the folder, readable by its owner only.
/// @return why it cannot be used; "" when it can
std::string prepare(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
        return std::strerror(errno);
    struct stat facts {};
    if (::stat(folder.c_str(), &facts) != 0 || !S_ISDIR(facts.st_mode))
        return "no folder";
    if (facts.st_uid != ::geteuid())
        return "it belongs to another user";
    constexpr mode_t kOthers = 077;
    if ((facts.st_mode & kOthers) != 0 && fs::is_symlink(folder))
        return "a link to a folder that is open to others";
    if ((facts.st_mode & kOthers) != 0 && ::chmod(folder.c_str(), 0700) != 0)
        return std::string("it cannot be closed to others: ") + std::strerror(errno);
    return "";
}

/// One line about a store, from the whitelist of core/base/volume.h.
std::string about(const fs::path& store) {
    constexpr std::size_t kEnoughBytes = std::size_t{64} << 20;
    MemoryBudget ram("RAM", "--ram", kEnoughBytes);
    const VolumeInfo info = StoreReader(store, ram).info();
    const Acquisition& a = info.acquisition;
    return (a.modality.empty() ? "" : a.modality + ", ") + formatExtent(info.extentVoxels) + " voxels" +
           (a.kernel.empty() ? "" : ", kernel " + a.kernel);
}

/// Imports into an entry that is locked for it.
/// @param facts  of the source, when its key was made
void makeEntry(const Entry& entry, const fs::path& given, const std::string& facts, json note,
               const MakeStore& make) {
    StoreToMake wanted{.store = entry.store,
                       .key = entry.store.stem().string() + note["check"].get<std::string>()};
    wanted.checkSource = [&] {
        if (factsOfSource(given) != facts)
            throw badFile(given.string(), "files that do not change during the import", "files that changed");
    };
    discard(entry, wanted.key);
    make(wanted);
    try {
        wanted.checkSource();
    } catch (const InputError&) {
        discard(entry);
        throw;
    }
    note["about"] = about(entry.store);
    note["store"] = hexHash(factsOfStore(entry.store));
    note["bytes"] = bytesBelow(entry.store);
    writeOutputFile(entry.note, note.dump(1, ' ', true, json::error_handler_t::replace) + "\n");
    std::error_code ignored;
    fs::permissions(entry.note, fs::perms::owner_read | fs::perms::owner_write, ignored);
}

/// Discards entries of the same source and options whose files have changed since: none but a figure asks for
/// them again, so the last used one stays.
void discardOutdated(const fs::path& folder, const Entry& current, const json& note) {
    bool stays = true;
    for (const CacheEntry& other : listCache(folder)) { // the last used first
        if (other.store == current.store)
            continue;
        const Entry entry(folder, other.store.stem().string());
        const json theirs = readNote(entry);
        if (textOf(theirs, "source") != textOf(note, "source") ||
            textOf(theirs, "options") != textOf(note, "options") ||
            (!other.isUnfinished && std::exchange(stays, false)))
            continue;
        const LockTry lock = tryLock(entry.lock, LockKind::exclusive, true);
        if (lock.locked) {
            discard(entry);
            std::error_code ignored;
            fs::remove(entry.lock, ignored);
        }
    }
}

fs::path scratchStore(const std::string& why, const CommonOptions& common, const MakeStore& make) {
    common.note("the cache of imports " + cacheFolder().string() + " cannot be used (" + why +
                "); importing to a temporary folder");
    const auto scratch = std::make_shared<ScratchFolder>();
    common.keep(scratch);
    const fs::path store = scratch->path() / "import.zarr";
    make({.store = store, .durable = false});
    return store;
}

} // namespace

fs::path cacheFolder() {
    const char* const cache = std::getenv("XDG_CACHE_HOME");
    if (cache && *cache)
        return fs::path(cache) / "tessera";
    const char* const home = std::getenv("HOME");
    if (home && *home)
        return fs::path(home) / ".cache" / "tessera";
    return fs::temp_directory_path() / ("tessera-cache-" + std::to_string(::geteuid()));
}

fs::path remoteBlockFolder() {
    return cacheFolder() / "remote";
}

std::uint64_t bytesBelow(const fs::path& folder) {
    std::uint64_t bytes = 0;
    std::error_code ignored;
    if (fs::is_symlink(folder, ignored))
        return 0;
    for (fs::recursive_directory_iterator entry(folder, ignored), end; !ignored && entry != end;
         entry.increment(ignored))
        if (std::error_code none; fs::is_regular_file(entry->symlink_status(none)))
            bytes += entry->file_size(none);
    return bytes;
}

std::uint64_t cacheLimitBytes() {
    const char* const text = std::getenv("TESSERA_CACHE_SIZE");
    return text && *text ? parseBytes(text, "TESSERA_CACHE_SIZE") : kDefaultLimitBytes;
}

namespace {
fs::path placeOf(const fs::path& given) {
    return isAddress(given) ? keptPlace(given) : fs::canonical(given);
}
std::string keyOf(const fs::path& source, const std::string& options, const std::string& facts) {
    return std::to_string(kImportVersion) + "\n" + options + "\n" + source.string() + "\n" + facts;
}
} // namespace

bool isCached(const fs::path& given, const std::string& options) {
    const std::string key = keyOf(placeOf(given), options, factsOfSource(given));
    return isWhole(Entry(cacheFolder(), hexHash(key)), hexCheck(key));
}

fs::path cachedStore(const fs::path& given, const std::string& options, const CommonOptions& common,
                     const MakeStore& make) {
    constexpr std::chrono::milliseconds kBetweenLooks{20};
    const std::uint64_t limit = cacheLimitBytes();
    const fs::path folder = cacheFolder();
    if (const std::string why = prepare(folder); !why.empty())
        return scratchStore(why, common, make);
    const fs::path source = placeOf(given);
    const std::string facts = factsOfSource(given), key = keyOf(source, options, facts);
    const Entry entry(folder, hexHash(key));
    const std::string check = hexCheck(key);
    // A hash instead of the path: folders may carry patients' names, and the cache must not.
    const json note = {{"source", hexHash(source.string())}, {"options", options}, {"check", check}};
    bool told = false, made = false;
    for (;;) {
        LockTry reading = tryLock(entry.lock, LockKind::shared, true);
        if (!reading.locked && !reading.busy)
            return scratchStore(::access(folder.c_str(), W_OK) == 0 ? "its file system has no locks"
                                                                    : std::strerror(errno),
                                common, make); // errno: of access()
        if (reading.locked && (isWhole(entry, check) || made)) {
            if (!made && isAddress(given))
                common.note("reusing the import of " + source.string() +
                            ": the server tells the same versions as then");
            else if (!made)
                common.detail("reusing the import in " + entry.store.string());
            ::futimens(reading.file.descriptor(), nullptr); // the last use
            common.keep(std::make_shared<FileHandle>(std::move(reading.file)));
            if (made)
                shrinkCache(folder, std::max<std::uint64_t>(
                                        1, limit - std::min(limit, bytesBelow(remoteBlockFolder()))));
            return entry.store;
        }
        reading = {};
        LockTry writing = tryLock(entry.lock, LockKind::exclusive);
        if (writing.locked && !isWhole(entry, check)) {
            if (::access(folder.c_str(), W_OK) != 0)
                return scratchStore(std::strerror(errno), common, make);
            recoverFolders(folder);
            try {
                makeEntry(entry, given, facts, note, make);
            } catch (const InputError&) {
                throw;                     // the input files are faulty
            } catch (const Error& error) { // for example a full disk; temporary files may lie on another one
                discard(entry);
                return scratchStore(error.what(), common, make);
            }
            discardOutdated(folder, entry, note);
            made = true;
        } else if (!writing.locked) {
            if (!told)
                common.note("waiting for another process that imports " + source.string());
            told = true;
            checkInterrupted();
            std::this_thread::sleep_for(kBetweenLooks);
        }
    }
}

std::vector<CacheEntry> listCache(const fs::path& folder) {
    std::vector<CacheEntry> entries;
    std::set<std::string> hashes;
    std::error_code ignored;
    for (fs::directory_iterator at(folder, ignored), end; !ignored && at != end; at.increment(ignored)) {
        const std::string name = at->path().filename().string();
        const fs::path store = WorkFolder::nameOf(name).value_or(name);
        const std::string hash = store.stem().string();
        if (store.extension() == ".zarr" && hash.size() == kHashDigits &&
            hash.find_first_not_of("0123456789abcdef") == std::string::npos)
            hashes.insert(hash);
    }
    for (const std::string& hash : hashes) {
        const Entry entry(folder, hash);
        const json note = readNote(entry);
        CacheEntry listed;
        listed.store = entry.store;
        listed.about = textOf(note, "about");
        const bool known = note.is_object() && note.contains("bytes") && note["bytes"].is_number_unsigned();
        std::error_code none;
        const bool link = fs::is_symlink(entry.store, none);
        listed.bytes = known && !link ? note["bytes"].get<std::uint64_t>() : bytesBelow(entry.store);
        listed.isUnfinished = !fs::exists(fs::symlink_status(entry.store, none));
        for (const fs::path& unfinished : unfinishedOf(entry.store))
            listed.bytes += bytesBelow(unfinished);
        struct stat facts {};
        if (::stat(entry.lock.c_str(), &facts) == 0 || ::stat(entry.store.c_str(), &facts) == 0)
            listed.lastUse = facts.st_mtim.tv_sec, listed.lastUseNanoseconds = facts.st_mtim.tv_nsec;
        listed.inUse = tryLock(entry.lock, LockKind::exclusive).busy;
        entries.push_back(std::move(listed));
    }
    std::sort(entries.begin(), entries.end(), [](const CacheEntry& a, const CacheEntry& b) {
        return std::tie(b.lastUse, b.lastUseNanoseconds, a.store) <
               std::tie(a.lastUse, a.lastUseNanoseconds, b.store);
    });
    return entries;
}

std::optional<fs::path> cachedContent(const std::string& contentHash, const CommonOptions& common) {
    constexpr std::size_t kEnoughBytes = std::size_t{64} << 20;
    const fs::path folder = cacheFolder();
    for (const CacheEntry& listed : listCache(folder)) {
        const Entry entry(folder, listed.store.stem().string());
        LockTry reading = tryLock(entry.lock, LockKind::shared);
        if (listed.isUnfinished || !reading.locked || textOf(readNote(entry), "check").empty())
            continue;
        try {
            MemoryBudget ram("RAM", "--ram", kEnoughBytes);
            if (StoreReader(entry.store, ram).contentHash() != contentHash)
                continue;
        } catch (const InputError&) {
            continue; // a damaged entry, which is made again when its source is asked for
        }
        ::futimens(reading.file.descriptor(), nullptr); // the last use
        common.keep(std::make_shared<FileHandle>(std::move(reading.file)));
        return entry.store;
    }
    return std::nullopt;
}

std::vector<CacheEntry> shrinkCache(const fs::path& folder, std::uint64_t bytes) {
    std::vector<CacheEntry> entries = listCache(folder), removed;
    std::uint64_t left = 0;
    for (const CacheEntry& entry : entries)
        left += entry.bytes;
    for (auto last = entries.rbegin(); last != entries.rend() && (bytes == 0 || left > bytes); ++last) {
        const Entry entry(folder, last->store.stem().string());
        const LockTry lock = tryLock(entry.lock, LockKind::exclusive, true);
        if (!lock.locked)
            continue;
        discard(entry);
        std::error_code ignored;
        fs::remove(entry.lock,
                   ignored); // while held: a waiting process sees that the file is gone and makes another
        left -= last->bytes;
        removed.push_back(*last);
    }
    return removed;
}

} // namespace tessera
