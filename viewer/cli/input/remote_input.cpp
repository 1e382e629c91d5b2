// viewer/cli/input/remote_input.cpp: see remote_input.h.
#include "viewer/cli/input/remote_input.h"

#include "bricking/remote/http_files.h"
#include "bricking/store/remote_files.h"
#include "core/base/address.h"
#include "core/base/budget.h" // formatBytes
#include "core/base/error.h"
#include "viewer/cli/input/import_cache.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kPartOfCache = 4;

} // namespace

std::filesystem::path reached(const std::filesystem::path& path) {
    if (!isAddress(path))
        return path;
    std::string shown = withoutSecrets(path.string());
    while (shown.ends_with('/'))
        shown.pop_back();
#if TESSERA_WITH_IMPORT
    static std::mutex mutex;
    static std::map<std::string, std::string> known; // how an address is shown
    static std::map<std::string, int> alike;         // addresses that are shown so
    const std::lock_guard lock(mutex);
    if (std::ranges::any_of(known, [&](const auto& each) { return each.second == path; }))
        return path;
    std::string& place = known[path.string()];
    if (place.empty()) {
        auto files = openRemoteFiles(path.string(), {remoteBlockFolder(), remoteBytesLimit()});
        const int number = ++alike[shown]; // of those that differ in what may be secret
        const std::string unlike = number == 1 ? shown : shown + "#" + std::to_string(number);
        makeReachable(unlike, std::move(files));
        place = unlike;
    }
    return place;
#else
    throw badFile(shown, "a path", "an address, and this program was built without what reads them");
#endif
}

std::uint64_t remoteBytesLimit() {
    return cacheLimitBytes() / kPartOfCache;
}

std::vector<std::string> reachedWords(std::span<char* const> words) {
    std::vector<std::string> all(words.begin(), words.end());
    for (std::string& word : all) {
        const std::size_t begin = word.starts_with("--") ? std::min(word.find('='), word.size() - 1) + 1 : 0;
        if (const std::string value = word.substr(begin); isAddress(value))
            word = word.substr(0, begin) + reached(value).string();
    }
    return all;
}

std::string sayFetched(Stores stores) {
    const std::optional<RemoteFiles::Counters> all = fetchedFor(stores);
    if (!all)
        return "";
    return "fetched " + formatBytes(static_cast<std::size_t>(all->bytesFetched)) + " by " +
           std::to_string(all->requests) + " requests (" + std::to_string(all->retries) +
           " of them again), " + formatBytes(static_cast<std::size_t>(all->bytesFromDisk)) + " from disk";
}

} // namespace tessera
