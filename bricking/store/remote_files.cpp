// bricking/store/remote_files.cpp: see remote_files.h.
#include "bricking/store/remote_files.h"

#include "core/base/address.h"
#include "core/base/error.h"

#include <map>
#include <mutex>
#include <utility>

namespace tessera {
namespace {

struct Reachable {
    std::mutex mutex;
    std::map<std::string, std::shared_ptr<RemoteFiles>> files; // by address
};
Reachable& reachable() {
    static Reachable all;
    return all;
}

} // namespace

void makeReachable(const std::string& address, std::shared_ptr<RemoteFiles> files) {
    Reachable& all = reachable();
    const std::lock_guard lock(all.mutex);
    all.files[address] = std::move(files);
}

std::optional<RemotePlace> remotePlaceOf(const std::filesystem::path& path) {
    if (!isAddress(path))
        return std::nullopt;
    std::string address = path.string(), below;
    while (address.ends_with('/'))
        address.pop_back();
    const std::string whole = address;
    Reachable& all = reachable();
    const std::lock_guard lock(all.mutex);
    while (true) {
        if (const auto found = all.files.find(address); found != all.files.end())
            return RemotePlace{found->second, below};
        const std::size_t slash = address.rfind('/');
        if (slash == std::string::npos || address[slash - 1] == '/')
            throw badFile(whole, "an address that was opened", "another");
        below = address.substr(slash + 1) + (below.empty() ? "" : "/" + below);
        address.resize(slash);
    }
}

} // namespace tessera
