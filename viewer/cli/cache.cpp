// viewer/cli/cache.cpp: `tessera cache list|clear|path`: the imports that `tessera render` keeps.
#include "bricking/store/store_files.h" // recoverFolders
#include "core/base/budget.h"           // formatBytes
#include "core/base/shown_text.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/import_cache.h"

#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

constexpr const char* kRemote = "blocks of volumes behind addresses";
constexpr const char* kUnfinished = "an unfinished import";

std::string timeText(std::time_t time) {
    std::tm local{};
    char text[32] = "unknown";
    if (::localtime_r(&time, &local))
        std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local);
    return text;
}

std::string sizeText(std::uint64_t bytes) {
    return formatBytes(static_cast<std::size_t>(bytes));
}

void list(bool asJson, const CommonOptions& common) {
    const std::vector<CacheEntry> entries = listCache(cacheFolder());
    std::uint64_t bytes = 0;
    nlohmann::json report = nlohmann::json::array();
    for (const CacheEntry& entry : entries) {
        const std::string name = entry.store.stem().string();
        bytes += entry.bytes;
        if (asJson)
            report.push_back({{"entry", name},
                              {"bytes", entry.bytes},
                              {"lastUse", entry.lastUse},
                              {"inUse", entry.inUse},
                              {"about", entry.isUnfinished ? kUnfinished : entry.about}});
        else
            std::printf("%s  %10s  %s  %s%s\n", name.c_str(), sizeText(entry.bytes).c_str(),
                        timeText(entry.lastUse).c_str(),
                        entry.isUnfinished    ? kUnfinished
                        : entry.about.empty() ? "(unknown)"
                                              : printable(entry.about).c_str(),
                        entry.inUse ? "  (in use)" : "");
    }
    const std::uint64_t fetched = bytesBelow(remoteBlockFolder());
    bytes += fetched;
    if (asJson && fetched > 0)
        report.push_back({{"entry", "remote"}, {"bytes", fetched}, {"about", kRemote}});
    else if (fetched > 0)
        std::printf("%s  %10s  %s\n", "remote", sizeText(fetched).c_str(), kRemote);
    if (asJson)
        std::printf("%s\n", report.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
    common.note(std::to_string(entries.size()) + (entries.size() == 1 ? " import, " : " imports, ") +
                sizeText(bytes) + " of at most " + sizeText(cacheLimitBytes()) + ", in " +
                cacheFolder().string());
}

void clear(const CommonOptions& common) {
    const std::filesystem::path folder = cacheFolder();
    recoverFolders(folder); // what dead imports left
    std::uint64_t bytes = 0;
    const std::vector<CacheEntry> removed = shrinkCache(folder, 0);
    const std::uint64_t fetched = bytesBelow(remoteBlockFolder());
    std::error_code ignored;
    std::filesystem::remove_all(remoteBlockFolder(), ignored); // who reads them fetches them again
    for (const CacheEntry& entry : removed)
        bytes += entry.bytes;
    const std::size_t kept = listCache(folder).size();
    common.note("removed " + std::to_string(removed.size()) +
                (removed.size() == 1 ? " import, " : " imports, ") + sizeText(bytes) +
                (fetched ? " and " + sizeText(fetched) + " of " + kRemote : "") +
                (kept ? "; " + std::to_string(kept) + " in use" + (kept == 1 ? " stays" : " stay") : ""));
}

} // namespace

void addCacheCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command("cache", "The cache of imports of `render`");
    command.needsCommand();
    command.footer("TESSERA_CACHE_SIZE limits it (default: 20GiB); XDG_CACHE_HOME moves it.\nExample:\n  "
                   "tessera cache list");
    auto asJson = std::make_shared<bool>(false);
    Command listing = command.command(
        "list", "List entries with size, last use and kind of volume, most recently used first");
    listing.flag("--json", *asJson, "as JSON");
    listing.whenChosen([asJson, &common, &action] { action = [asJson, &common] { list(*asJson, common); }; });
    command.command("clear", "Remove all imports that no process uses").whenChosen([&common, &action] {
        action = [&common] { clear(common); };
    });
    command.command("path", "Print the folder").whenChosen([&action] {
        action = [] { std::printf("%s\n", printable(cacheFolder().string()).c_str()); };
    });
}

} // namespace tessera
