// bricking/analysis/body/kept_table.cpp: see kept_table.h. On disk: STORE/stats/table/shares is uint8
// [z][y][x], the mask's own level, and missing where nothing is hidden. The group's attributes.tessera hold
// the version, the store's content hash, the level, the litres or the reason, and a CRC-32C of the array.
#include "bricking/analysis/body/kept_table.h"

#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/remote_files.h"
#include "bricking/store/shard.h"
#include "bricking/store/stand_in_reader.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_array.h"
#include "core/base/address.h"
#include "core/base/error.h"

#include <algorithm>
#include <glm/common.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kVersion = 2; // another one is found anew
constexpr std::uint64_t kMaxGroupBytes = 1 << 16;
constexpr const char* kTable = "stats/table";
constexpr const char* kShares = "stats/table/shares";

ArraySpec sharesSpec(const glm::ivec3& extent) {
    return {"uint8", 1, extent, glm::min(extent, glm::ivec3(256, 256, 16)), 0};
}

std::span<std::byte> layerOf(std::span<std::uint8_t> shares, const ArraySpec& spec, int layer) {
    const std::size_t slice = cellCount({spec.grid.x, spec.grid.y, 1});
    const int first = layer * spec.chunk.z, count = std::min(spec.chunk.z, spec.grid.z - first);
    return std::as_writable_bytes(
        shares.subspan(slice * static_cast<std::size_t>(first), slice * static_cast<std::size_t>(count)));
}

FoundTable readTable(const StoreReader& store, MemoryBudget& ram) {
    const StoreFolder folder = openFolder(store.path());
    const std::string file = std::string(kTable) + "/zarr.json", where = (store.path() / file).string();
    const auto text = readText(folder, file, store.path(), kMaxGroupBytes);
    if (!text)
        throw badFile(where, "the mask of a table", "none");
    const Json group = parseJson(*text, where);
    checkSeal(group, where);
    const std::string root = "/attributes/tessera/";
    integerAt(group, root + "version", kVersion, kVersion, where);
    if (textAt(group, root + "store", where) != store.contentHash())
        throw badFile(where, "the mask of this store's table", "that of another");
    FoundTable found;
    found.why = textAt(group, root + "why", where);
    found.litres = numberAt(group, root + "litres", where);
    if (!found.why.empty())
        return found;
    const auto level = static_cast<int>(integerAt(group, root + "level", 0, kLevelCount - 1, where));
    const ArraySpec spec = sharesSpec(levelExtent(store.info().extentVoxels, level));
    const Charge scratch = ram.charge(spec.scratchBytes(), "reading the mask of the table");
    Charge own = ram.charge(cellCount(spec.grid), "reading the mask of the table");
    checkArrayMetadata(folder, kShares, spec, store.path());
    std::vector<std::uint8_t> shares(cellCount(spec.grid));
    for (int layer = 0; layer < spec.layers(); ++layer)
        readArrayLayer(folder, kShares, spec, layer, layerOf(shares, spec, layer), store.path());
    if (crc32c(std::as_bytes(std::span(shares))) != integerAt(group, root + "crc", 0, UINT32_MAX, where))
        throw badFile((store.path() / kShares).string(), "the array that its group describes", "another");
    own = {};
    found.mask = std::make_shared<const Mask>(store.info().extentVoxels, level, std::move(shares), ram);
    return found;
}

void write(const FoundTable& found, const StoreReader& store, const fs::path& folder) {
    const Json plain = {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", Json::object()}};
    Json group = plain;
    Json& about = group["attributes"]["tessera"];
    about = {{"kind", "table"},
             {"version", kVersion},
             {"store", store.contentHash()},
             {"why", found.why},
             {"litres", found.litres}};
    if (found.mask) {
        const int level = found.mask->level();
        const ArraySpec spec = sharesSpec(levelExtent(store.info().extentVoxels, level));
        std::vector<std::uint8_t> shares(found.mask->shares().begin(), found.mask->shares().end());
        about["level"] = level;
        about["crc"] = crc32c(std::as_bytes(std::span(shares)));
        writeArrayMetadata(folder / "shares", spec);
        for (int layer = 0; layer < spec.layers(); ++layer)
            writeArrayLayer(folder / "shares", spec, layer, layerOf(shares, spec, layer));
    }
    seal(group);
    writeFile(folder / "zarr.json", storedText(group));
}

} // namespace

void keepTable(const FoundTable& found, const StoreReader& store, const fs::path& folder) {
    fs::remove_all(folder / kTable);
    fs::create_directories(folder / kTable);
    write(found, store, folder / kTable);
}

std::optional<FoundTable> keptTableOf(const StoreReader& store, MemoryBudget& ram) {
    const auto isThere = [&] {
        std::error_code ignored;
        if (isAddress(store.path()))
            return openIn(openFolder(store.path()), std::string(kTable) + "/zarr.json", store.path())
                .has_value();
        return fs::symlink_status(store.path() / kTable, ignored).type() != fs::file_type::not_found;
    };
    if (!isThere())
        return std::nullopt;
    return readTable(store, ram);
}

FoundTable tableOf(const StoreReader& store, MemoryBudget& ram, int threads) {
    try {
        return readTable(store, ram);
    } catch (const OutOfReach&) {
        throw;
    } catch (const InputError&) {
        // An optional cache, as the statistics are.
    }
    FoundTable found = findTable(store, ram, threads);
    if (hasStandIns(store))
        return found;
    try {
        TemporaryFolder folder(store.path() / kTable);
        write(found, store, folder.path());
        folder.commit(false, true);
    } catch (const Error&) {
        // A store that cannot be written: found again next time.
    } catch (const fs::filesystem_error&) {
    }
    return found;
}

} // namespace tessera
