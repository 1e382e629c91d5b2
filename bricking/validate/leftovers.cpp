// bricking/validate/leftovers.cpp: see leftovers.h.
#include "bricking/validate/leftovers.h"

#include "bricking/store/store_files.h"
#include "core/base/output_file.h"
#include "core/base/ownership.h"

#include <algorithm>
#include <string>
#include <system_error>

namespace tessera {
namespace fs = std::filesystem;
namespace {

bool isUnfinished(const std::string& name) {
    return nameOfUnfinishedFolder(name) || nameOfUnfinishedFile(name);
}

void gather(const fs::path& folder, std::vector<fs::path>& found) {
    eachLeftover(folder, isUnfinished, [&](const fs::path& leftover) { found.push_back(leftover); });
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code ignored;
        if (entry->symlink_status(ignored).type() == fs::file_type::directory &&
            !isUnfinished(entry->path().filename().string()))
            gather(entry->path(), found);
    }
}

} // namespace

std::vector<fs::path> leftoversOf(const fs::path& store) {
    std::vector<fs::path> found;
    std::error_code ignored;
    const fs::path place = fs::canonical(store, ignored);
    if (!ignored) {
        const std::string name = place.filename().string();
        eachLeftover(
            place.parent_path(),
            [&](const std::string& entry) { return nameOfUnfinishedFolder(entry) == name; },
            [&](const fs::path& leftover) { found.push_back(leftover); });
    }
    gather(store, found);
    std::sort(found.begin(), found.end());
    return found;
}

bool removeLeftover(const fs::path& leftover) {
    const std::string name = leftover.filename().string();
    sweepLeftovers(leftover.parent_path(), [&](const std::string& entry) { return entry == name; });
    std::error_code ignored;
    return fs::symlink_status(leftover, ignored).type() == fs::file_type::not_found;
}

} // namespace tessera
