// viewer/cli/input/remote_input.cpp: see remote_input.h.
#include "viewer/cli/input/remote_input.h"

#include "bricking/remote/http_files.h"
#include "bricking/store/remote_files.h"
#include "core/base/address.h"
#include "core/base/budget.h" // formatBytes
#include "core/base/error.h"
#include "viewer/cli/input/import_cache.h"

#include <mutex>
#include <optional>
#include <set>

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
    static std::set<std::string> known;
    const std::lock_guard lock(mutex);
    if (!known.contains(shown)) {
        makeReachable(
            shown, openRemoteFiles(path.string(), {remoteBlockFolder(), cacheLimitBytes() / kPartOfCache}));
        known.insert(shown);
    }
    return shown;
#else
    throw badFile(shown, "a path", "an address, and this program was built without what reads them");
#endif
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
