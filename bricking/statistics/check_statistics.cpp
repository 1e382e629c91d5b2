// bricking/statistics/check_statistics.cpp: see check_statistics.h.
#include "bricking/statistics/check_statistics.h"

#include "bricking/statistics/fill_values.h"
#include "bricking/statistics/statistics.h"
#include "bricking/statistics/statistics_layout.h"
#include "bricking/store/codec.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <system_error>

namespace tessera {
namespace {

/// An array whose checksums stand in the group's document.
struct KeptArray {
    std::string part, path; // below the store
    ArraySpec spec;
    std::string sums; // JSON pointer to its checksum, or to those of its layers
    bool perLayer = false;
};

/// Reads an array whole, layer by layer.
/// @param group  null: its checksums are not known
void checkArray(const StoreReader& store, const StoreFolder& folder, const KeptArray& array,
                const Json* group, std::span<std::byte> room, const StatisticsFault& found) {
    const std::string where = (store.path() / kStatisticsFile).string();
    const std::string shown = (store.path() / array.path).string();
    const ArraySpec& spec = array.spec;
    const auto check = [&](const std::string& sum, std::uint32_t crc) {
        if (group && integerAt(*group, sum, 0, UINT32_MAX, where) != crc)
            throw badFile(shown, "the array that stats/zarr.json describes", "another");
    };
    const auto noting = [&](const auto& body) {
        try {
            body();
            return true;
        } catch (const BadFile& problem) {
            found(array.part, problem);
            return false;
        }
    };
    noting([&] { checkArrayMetadata(folder, array.path, spec, store.path()); });
    std::uint32_t crc = 0;
    bool isWhole = true;
    for (int layer = 0; layer < spec.layers(); ++layer) {
        const int slices = std::min(spec.chunk.z, spec.grid.z - layer * spec.chunk.z);
        const auto bytes = room.first(cellCount({spec.grid.x, spec.grid.y, slices}) * spec.elementBytes());
        isWhole &= noting([&] {
            readArrayLayer(folder, array.path, spec, layer, bytes, store.path());
            if (array.perLayer)
                check(array.sums + "/" + std::to_string(layer), crc32c(bytes));
        });
        crc = crc32c(bytes, crc);
    }
    if (isWhole && !array.perLayer)
        noting([&] { check(array.sums, crc); });
}

/// Bytes of the largest layer.
std::size_t layerBytes(const ArraySpec& spec) {
    return cellCount({spec.grid.x, spec.grid.y, std::min(spec.grid.z, spec.chunk.z)}) * spec.elementBytes();
}

/// The counts of the histogram against the number of voxels.
void checkHistogram(const StoreReader& store, const Json& group) {
    const std::string where = (store.path() / kStatisticsFile).string();
    std::uint64_t voxels = 0;
    for (int bin = 0; bin < kHistogramBins; ++bin)
        voxels += static_cast<std::uint64_t>(integerAt(
            group, "/attributes/tessera/histogram/" + std::to_string(bin), 0, std::int64_t{1} << 62, where));
    if (voxels != store.info().voxelCount())
        throw badFile(where, "a histogram of all voxels", std::to_string(voxels) + " counts");
    numberAt(group, "/attributes/tessera/lowest", where);
    numberAt(group, "/attributes/tessera/highest", where);
    if (group["attributes"]["tessera"].contains(kFillsKey))
        readFills(group, std::string("/attributes/tessera/") + kFillsKey, voxels, where);
}

} // namespace

const std::vector<std::string>& statisticsParts() {
    static const std::vector<std::string> parts = {"stats/cell_min",  "stats/cell_max", "stats/brick_min",
                                                   "stats/brick_max", "stats/rays",     kStatisticsFile};
    return parts;
}

int newestStatistics() {
    return static_cast<int>(kStatisticsVersion);
}

int checkStatistics(const StoreReader& store, MemoryBudget& ram, const StatisticsFault& found) {
    const StoreFolder folder = openFolder(store.path());
    const auto isLost = [&](const std::filesystem::path& part) {
        std::error_code ignored;
        return std::filesystem::symlink_status(store.path() / part, ignored).type() ==
               std::filesystem::file_type::not_found;
    };
    if (isLost("stats")) {
        found(kStatisticsFile, badFile((store.path() / "stats").string(), "statistics", "no such folder"));
        return 0;
    }
    std::optional<Json> group;
    std::int64_t version = 0;
    const std::string root = "/attributes/tessera/";
    try {
        group = readStatisticsGroup(folder, store);
        version = integerAt(*group, root + "version", kOldestStatistics, kStatisticsVersion,
                            (store.path() / kStatisticsFile).string());
        checkHistogram(store, *group);
    } catch (const BadFile& problem) {
        found(kStatisticsFile, problem);
    }
    const glm::ivec3 cells = cellGrid(store.info().extentVoxels),
                     bricks = brickGrid(store.info().extentVoxels);
    std::vector<KeptArray> arrays;
    for (const char* name : {"cell_min", "cell_max", "brick_min", "brick_max"}) {
        const bool isOfCells = name[0] == 'c';
        if (isOfCells || version != kOldestStatistics)
            arrays.push_back({std::string("stats/") + name, std::string("stats/") + name,
                              floatSpec(isOfCells ? cells : bricks), root + "arrays/" + name, false});
    }
    for (int part = 0; part < kBrickRayParts; ++part)
        arrays.push_back(
            {"stats/rays", rayPath(part), raySpec(bricks), root + "rays/" + std::to_string(part), true});
    std::size_t most = 0, scratchBytes = 0;
    for (const KeptArray& array : arrays) {
        most = std::max(most, layerBytes(array.spec));
        scratchBytes = std::max(scratchBytes, array.spec.scratchBytes());
    }
    const Charge charge = ram.charge(most + scratchBytes, "checking statistics");
    std::vector<std::byte> room(most);
    for (const KeptArray& array : arrays)
        if (!isLost(array.part))
            checkArray(store, folder, array, group ? &*group : nullptr, room, found);
        else if (&array == &arrays.back() || (&array + 1)->part != array.part) // once a part
            found(array.part, badFile((store.path() / array.part).string(), "an array", "no such folder"));
    if (isLost("stats/rays"))
        return static_cast<int>(version);
    try {
        const std::string where = (store.path() / kRayGroupFile).string();
        const auto text = readText(folder, kRayGroupFile, store.path(), 4096);
        if (!text)
            throw badFile(where, "the group of the rays", "no such file");
        checkEqual(parseJson(*text, where), plainGroup(), where);
    } catch (const BadFile& problem) {
        found("stats/rays", problem);
    }
    return static_cast<int>(version);
}

} // namespace tessera
