// bricking/statistics/kept_histograms.cpp: local histograms beside a store's statistics: see
// local_histograms.h. On disk: STORE/stats/histograms/numbers is uint16 [z][y][x] over the level's samples,
// shares is uint16 [representative][side and bin]. The group's attributes.tessera hold the version, the
// store's content hash, what is hidden, the settings, the level, the bins' centres, and a CRC-32C of either
// array.
#include "bricking/statistics/check_statistics.h"
#include "bricking/statistics/local_histograms.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/shard.h"
#include "bricking/store/stand_in_reader.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_array.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <memory>
#include <span>
#include <string>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kHistogramsVersion = 1; // others are made anew
constexpr std::uint64_t kMostGroupBytes = 1 << 16;
constexpr const char* kFolder = "stats/histograms";
constexpr const char* kRoot = "/attributes/tessera/";

ArraySpec numbersSpec(const glm::ivec3& extent) {
    return {"uint16", sizeof(std::uint16_t), extent, glm::min(extent, glm::ivec3(256, 256, 16)), 0};
}
ArraySpec sharesSpec(std::size_t representatives) {
    const auto count = static_cast<int>(representatives);
    return {
        "uint16", sizeof(std::uint16_t), {1, 1, count}, {1, 1, std::min(count, 1024)}, LocalHistograms::kRow};
}

std::span<std::byte> slicesOf(std::vector<std::uint16_t>& values, const ArraySpec& spec, int layer) {
    const std::size_t slice =
        cellCount({spec.grid.x, spec.grid.y, 1}) * spec.elementBytes() / sizeof(std::uint16_t);
    const int first = layer * spec.chunk.z, count = std::min(spec.chunk.z, spec.grid.z - first);
    return std::as_writable_bytes(std::span(values).subspan(slice * static_cast<std::size_t>(first),
                                                            slice * static_cast<std::size_t>(count)));
}

Json aboutOf(const StoreReader& store, std::uint32_t hidden, const LocalHistogramSettings& settings) {
    return {{"kind", "local histograms"},      {"version", kHistogramsVersion},
            {"store", store.contentHash()},    {"hidden", hidden},
            {"radius", settings.radiusMm},     {"bins", settings.bins},
            {"most", settings.representatives}};
}

std::string groupPath(const StoreReader& store) {
    return (store.path() / kFolder / "zarr.json").string();
}

/// Throws BadFile where it is missing or damaged.
Json readGroup(const StoreReader& store, const StoreFolder& folder) {
    const std::string where = groupPath(store);
    const auto text = readText(folder, std::string(kFolder) + "/zarr.json", store.path(), kMostGroupBytes);
    if (!text)
        throw badFile(where, "local histograms", "none");
    Json group = parseJson(*text, where);
    checkSeal(group, where);
    return group;
}

LocalHistograms read(const StoreReader& store, std::uint32_t hidden, const LocalHistogramSettings& settings,
                     MemoryBudget& ram) {
    const StoreFolder folder = openFolder(store.path());
    const std::string where = groupPath(store);
    const Json group = readGroup(store, folder);
    const std::string root = kRoot;
    const Json expected = aboutOf(store, hidden, settings);
    for (const auto& [key, value] : expected.items())
        if (jsonAt(group, root + key, where) != value)
            throw badFile(where, "\"" + key + "\" " + value.dump(), "another");
    LocalHistograms kept;
    kept.settings = settings;
    kept.level = localHistogramLevel(store.info(), settings.radiusMm);
    kept.extent = levelExtent(store.info().extentVoxels, kept.level);
    const auto representatives = static_cast<std::size_t>(
        integerAt(group, root + "representatives", 1, settings.representatives, where));
    const Json& centres = jsonAt(group, root + "centres", where);
    if (!centres.is_array() || centres.empty() || centres.size() > static_cast<std::size_t>(settings.bins))
        throw badFile(where, "centres of 1 to " + std::to_string(settings.bins) + " bins", "others");
    for (std::size_t n = 0; n < centres.size(); ++n) {
        const double centre = numberAt(group, root + "centres/" + std::to_string(n), where);
        if (!std::isfinite(centre) || (n > 0 && centre <= kept.centres.back()))
            throw badFile(where, "ascending centres of bins", "others");
        kept.centres.push_back(centre);
    }
    kept.charge = ram.charge(localHistogramBytes(store.info(), settings), "local histograms");
    const auto readArray = [&](const char* name, const ArraySpec& spec, std::vector<std::uint16_t>& values) {
        const std::string array = std::string(kFolder) + "/" + name;
        const Charge scratch = ram.charge(spec.scratchBytes(), "reading local histograms");
        checkArrayMetadata(folder, array, spec, store.path());
        values.resize(cellCount(spec.grid) * spec.elementBytes() / sizeof(std::uint16_t));
        for (int layer = 0; layer < spec.layers(); ++layer)
            readArrayLayer(folder, array, spec, layer, slicesOf(values, spec, layer), store.path());
        if (crc32c(std::as_bytes(std::span(values))) !=
            integerAt(group, root + "crcs/" + name, 0, UINT32_MAX, where))
            throw badFile((store.path() / array).string(), "the array that its group describes", "another");
    };
    readArray("numbers", numbersSpec(kept.extent), kept.numbers);
    readArray("shares", sharesSpec(representatives), kept.shares);
    if (*std::max_element(kept.numbers.begin(), kept.numbers.end()) >= representatives)
        throw badFile((store.path() / kFolder / "numbers").string(),
                      "numbers below " + std::to_string(representatives), "a higher one");
    return kept;
}

/// @param made  its vectors are read alone
void write(LocalHistograms& made, const StoreReader& store, std::uint32_t hidden, const fs::path& folder) {
    Json group = {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", Json::object()}};
    Json& about = group["attributes"]["tessera"];
    about = aboutOf(store, hidden, made.settings);
    about["level"] = made.level;
    about["representatives"] = made.representatives();
    about["centres"] = made.centres;
    const auto writeArray = [&](const char* name, const ArraySpec& spec, std::vector<std::uint16_t>& values) {
        writeArrayMetadata(folder / name, spec);
        for (int layer = 0; layer < spec.layers(); ++layer)
            writeArrayLayer(folder / name, spec, layer, slicesOf(values, spec, layer));
        about["crcs"][name] = crc32c(std::as_bytes(std::span(values)));
    };
    writeArray("numbers", numbersSpec(made.extent), made.numbers);
    writeArray("shares", sharesSpec(made.representatives()), made.shares);
    seal(group);
    writeFile(folder / "zarr.json", storedText(group));
}

/// What a group's document says it is of.
/// @param hidden  gets the number of the hidden part
LocalHistograms readAny(const StoreReader& store, MemoryBudget& ram, std::uint32_t& hidden) {
    const std::string where = groupPath(store);
    const Json group = readGroup(store, openFolder(store.path()));
    const std::string root = kRoot;
    LocalHistogramSettings settings;
    settings.radiusMm = numberAt(group, root + "radius", where);
    if (!(settings.radiusMm > 0))
        throw badFile(where, root + "radius above 0", "another");
    settings.bins = static_cast<int>(integerAt(group, root + "bins", 2, settings.kMostBins, where));
    settings.representatives =
        static_cast<int>(integerAt(group, root + "most", 1, settings.kMostRepresentatives, where));
    if (localHistogramLevel(store.info(), settings.radiusMm) == kLevelCount)
        throw badFile(where, root + "radius of a level", "another");
    hidden = static_cast<std::uint32_t>(integerAt(group, root + "hidden", 0, UINT32_MAX, where));
    return read(store, hidden, settings, ram);
}

} // namespace

void checkLocalHistograms(const StoreReader& store, MemoryBudget& ram, const StatisticsFault& found) {
    std::error_code ignored;
    if (fs::symlink_status(store.path() / kFolder, ignored).type() == fs::file_type::not_found)
        return;
    try {
        std::uint32_t hidden = 0;
        readAny(store, ram, hidden);
    } catch (const BadFile& problem) {
        found(kFolder, problem);
    }
}

std::string compareLocalHistograms(const StoreReader& store, MemoryBudget& ram, int threads,
                                   const StatisticsFault& found) {
    std::error_code ignored;
    if (fs::symlink_status(store.path() / kFolder, ignored).type() == fs::file_type::not_found)
        return "";
    try {
        std::uint32_t hidden = 0;
        const LocalHistograms kept = readAny(store, ram, hidden);
        if (hidden != 0)
            return "local histograms were not compared: they are of the volume without a part that was "
                   "hidden";
        const Statistics statistics = loadStatistics(store, ram, threads);
        const LocalHistograms made = makeLocalHistograms(store, statistics, kept.settings, ram, threads);
        if (made.centres != kept.centres || made.numbers != kept.numbers || made.shares != kept.shares)
            found(kFolder,
                  badFile((store.path() / kFolder).string(), "what the voxels give", "something else"));
        return "";
    } catch (const InputError& problem) { // of the budget: files have been read before
        return std::string("local histograms were not compared: ") + problem.what();
    }
}

std::shared_ptr<const LocalHistograms> localHistogramsOf(const StoreReader& store, const ChunkSource& volume,
                                                         std::uint32_t hidden, const Statistics& statistics,
                                                         const LocalHistogramSettings& settings,
                                                         MemoryBudget& ram, int threads) {
    try {
        return std::make_shared<const LocalHistograms>(read(store, hidden, settings, ram));
    } catch (const InputError&) {
        // An optional cache, as the statistics are.
    }
    auto made =
        std::make_shared<LocalHistograms>(makeLocalHistograms(volume, statistics, settings, ram, threads));
    if (hasStandIns(store))
        return made;
    try {
        const Charge scratch = ram.charge(std::max(numbersSpec(made->extent).scratchBytes(),
                                                   sharesSpec(made->representatives()).scratchBytes()),
                                          "keeping local histograms");
        TemporaryFolder folder(store.path() / kFolder);
        write(*made, store, hidden, folder.path());
        folder.commit(false, true);
    } catch (const Error&) {
        // A store that cannot be written: made again next time.
    } catch (const fs::filesystem_error&) {
    }
    return made;
}

} // namespace tessera
