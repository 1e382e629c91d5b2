// viewer/cli/input/import_cache.h: the cache of imports of source files that were rendered directly. An entry
// is a store HASH.zarr, the data to check that it is current, HASH.json, and HASH.lock; in place of the store
// finished parts of an import that was killed (bricking/store/work_folder.h). The lock has one
// writer or any number of readers; its file time is that of the last use.
#pragma once

#include "viewer/cli/input/volume_input.h" // InputOptions
#include "viewer/cli/options/options.h"

#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// ${XDG_CACHE_HOME}/tessera, or ~/.cache/tessera, or a temporary folder of this user.
std::filesystem::path cacheFolder();
/// In it, the blocks of volumes behind addresses (remote_input.h).
std::filesystem::path remoteBlockFolder();
/// The bytes that removing a folder frees. Links are not followed, including the folder itself, because their
/// targets stay.
std::uint64_t bytesBelow(const std::filesystem::path& folder);
/// Of all entries and those blocks: $TESSERA_CACHE_SIZE, or 20 GiB. Throws InputError naming the variable.
std::uint64_t cacheLimitBytes();

struct StoreToMake {
    std::filesystem::path store; // does not exist
    bool durable = true;         // waits for the disk
    std::string key = {};        // ImportOptions::key
    /// ImportOptions::checkSource
    std::function<void()> checkSource = {};
};
using MakeStore = std::function<void(const StoreToMake&)>;
/// The store for source files: a complete cache entry for the same files and options, else made now, from the
/// finished parts of an import that was killed where there are some. It stays until the command ends. If the
/// cache cannot be used, the store is made in a temporary folder, with a note. Waits for another process that
/// makes the same one.
/// @param source  a file or folder, and files that its headers name; or an address, whose metadata count
/// @param options  all that affects the result besides the files
/// Throws what `make` throws, and InputError if the files change meanwhile.
std::filesystem::path cachedStore(const std::filesystem::path& source, const std::string& options,
                                  const CommonOptions& common, const MakeStore& make);

/// True if there is a complete entry for the same files and options.
bool isCached(const std::filesystem::path& source, const std::string& options);

/// A store of the cache with that content (StoreReader::contentHash()). It stays until the command ends.
std::optional<std::filesystem::path> cachedContent(const std::string& contentHash,
                                                   const CommonOptions& common);

struct CacheEntry {
    std::filesystem::path store;
    /// "CT, 512 x 512 x 134 voxels, kernel B30f"; "" unknown. Not a path, which may name a patient.
    std::string about;
    bool isUnfinished = false; // parts of an import that was killed
    std::uint64_t bytes = 0;
    std::time_t lastUse = 0;
    long lastUseNanoseconds = 0; // beyond it
    bool inUse = false;
};
/// All entries, most recently used first.
std::vector<CacheEntry> listCache(const std::filesystem::path& folder);
/// Removes entries that are not in use, least recently used first, until the rest has at most `bytes`.
/// @return the removed entries
std::vector<CacheEntry> shrinkCache(const std::filesystem::path& folder, std::uint64_t bytes);

} // namespace tessera
