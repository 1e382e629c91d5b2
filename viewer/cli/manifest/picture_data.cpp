// viewer/cli/manifest/picture_data.cpp: see picture_data.h.
#include "viewer/cli/manifest/picture_data.h"

#include "core/base/address.h"
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/fnv_hash.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Kind = PictureData::Kind;

constexpr std::array<const char*, 5> kKinds = {"volume", "labels", "labelNames", "mesh", "environment"};
constexpr std::size_t kReaderBytes = std::size_t{64} << 20; // enough for the metadata of any store

std::string hashOfBytes(const fs::path& path) {
    refusePipeOrDevice(path);
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw badFile(path.string(), "a readable file", "none");
    FnvHash hash;
    std::vector<char> block(std::size_t{1} << 18);
    while (file) {
        checkInterrupted();
        file.read(block.data(), static_cast<std::streamsize>(block.size()));
        hash.addBytes({block.data(), static_cast<std::size_t>(file.gcount())});
    }
    if (file.bad())
        throw badFile(path.string(), "a readable file", "one that cannot be read to its end");
    return hash.digits();
}

PictureData ofFile(Kind kind, std::size_t number, const fs::path& path) {
    PictureData data{.kind = kind, .number = number};
    data.extension = path.extension().string();
    std::error_code ignored;
    if (isAddress(path) || !fs::is_regular_file(path, ignored))
        return data;
    data.contentHash = contentHashOfFile(path);
    data.bytes = fs::file_size(path, ignored);
    return data;
}

PictureData ofVolume(std::size_t number, const StoreReader& store) {
    const VolumeInfo& info = store.info();
    PictureData data{.kind = Kind::volume, .number = number, .contentHash = store.contentHash()};
    data.extentVoxels = info.extentVoxels;
    data.type = name(info.type);
    return data;
}

PictureData ofLabels(std::size_t number, const Labels& labels) {
    PictureData data{.kind = Kind::labels, .number = number};
    data.extension = labels.path.extension().string();
    if (labels.store.empty())
        return data;
    MemoryBudget ram("RAM", "--ram", kReaderBytes);
    const StoreReader store(labels.store, ram);
    data.contentHash = store.contentHash();
    data.extentVoxels = store.info().extentVoxels;
    return data;
}

bool namesFile(const fs::path& names) {
    return !names.empty() && names != Labels::kTotalSegmentator;
}

/// As a scene needs them, without what they hold.
std::vector<PictureData> neededBy(const Scene& scene) {
    std::vector<PictureData> all;
    for (std::size_t n = 0; n < scene.volumes.size(); ++n)
        all.push_back({.kind = Kind::volume, .number = n});
    for (std::size_t n = 0; n < scene.volumes.size(); ++n)
        if (const Labels& labels = scene.volumes[n].labels; !labels.path.empty()) {
            all.push_back({.kind = Kind::labels, .number = n, .extension = labels.path.extension().string()});
            if (namesFile(labels.names))
                all.push_back(
                    {.kind = Kind::labelNames, .number = n, .extension = labels.names.extension().string()});
        }
    for (std::size_t n = 0; n < scene.meshes.size(); ++n)
        if (const fs::path& path = scene.meshes[n].path; !path.empty())
            all.push_back({.kind = Kind::mesh, .number = n, .extension = path.extension().string()});
    if (const auto& sky = scene.lighting.environment; sky && !sky->file.path.empty())
        all.push_back({.kind = Kind::environment, .extension = sky->file.path.extension().string()});
    return all;
}

bool isSame(const PictureData& a, const PictureData& b) {
    return a.kind == b.kind && a.number == b.number;
}

/// Of an axis; 0 for what is no number of voxels.
int voxelsOf(const json& value) {
    constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
    return value.is_number_unsigned() && value.get<std::uint64_t>() <= kMost ? value.get<int>() : 0;
}

glm::ivec3 extentOf(const json& value) {
    return value.is_array() && value.size() == 3
               ? glm::ivec3(voxelsOf(value.at(0)), voxelsOf(value.at(1)), voxelsOf(value.at(2)))
               : glm::ivec3(0);
}

std::string hashOf(const json& row) {
    std::string hash = row.value("contentHash", "");
    constexpr std::size_t kDigits = 16;
    if (!hash.empty() &&
        (hash.size() != kDigits || hash.find_first_not_of("0123456789abcdef") != std::string::npos))
        throw InputError("a contentHash that is not 16 digits");
    return hash;
}

/// What a manifest says of one, if it does.
std::optional<PictureData> said(const json& manifest, const PictureData& needed) {
    for (const json& row : manifest.value("data", json::array())) {
        const auto kind = std::ranges::find(kKinds, row.at("kind").get<std::string>());
        if (kind == kKinds.end())
            continue;
        PictureData data{.kind = static_cast<Kind>(kind - kKinds.begin()),
                         .number = row.value("number", std::size_t{1}) - 1};
        if (!isSame(data, needed))
            continue;
        data.contentHash = hashOf(row);
        data.extentVoxels = extentOf(row.value("extentVoxels", json()));
        data.type = row.value("type", "");
        data.bytes = row.value("bytes", std::uint64_t{0});
        data.extension = needed.extension;
        return data;
    }
    if (needed.kind != Kind::volume)
        return std::nullopt;
    const json further = manifest.value("furtherVolumes", json::array());
    const json volume = needed.number == 0                   ? manifest.value("store", json::object())
                        : needed.number - 1 < further.size() ? further.at(needed.number - 1)
                                                             : json::object();
    PictureData data = needed;
    data.contentHash = hashOf(volume);
    data.extentVoxels = extentOf(volume.value("extentVoxels", json()));
    data.type = volume.value("type", "");
    return data;
}

} // namespace

std::string nameOf(const PictureData& data) {
    const std::string number = std::to_string(data.number + 1);
    switch (data.kind) {
    case Kind::volume:
        return "volume " + number;
    case Kind::labels:
        return "labels of volume " + number;
    case Kind::labelNames:
        return "names of labels of volume " + number;
    case Kind::mesh:
        return "mesh " + number;
    case Kind::environment:
        break;
    }
    return "environment";
}

namespace {
template <typename AnyScene> auto& placeIn(AnyScene& scene, const PictureData& data) {
    switch (data.kind) {
    case Kind::volume:
        return scene.volumes.at(data.number).path;
    case Kind::labels:
        return scene.volumes.at(data.number).labels.path;
    case Kind::labelNames:
        return scene.volumes.at(data.number).labels.names;
    case Kind::mesh:
        return scene.meshes.at(data.number).path;
    case Kind::environment:
        break;
    }
    return scene.lighting.environment.value().file.path;
}
} // namespace

fs::path& pathOf(const PictureData& data, Scene& scene) {
    return placeIn(scene, data);
}
const fs::path& pathOf(const PictureData& data, const Scene& scene) {
    return placeIn(scene, data);
}

std::string contentHashOfFile(const fs::path& path) {
    // A window saves many pictures of the same files.
    using Key = std::tuple<std::string, std::uintmax_t, fs::file_time_type::rep>;
    constexpr std::size_t kKept = 64;
    static std::mutex mutex;
    static std::map<Key, std::string> known;
    std::error_code ignored;
    const Key key{fs::absolute(path).string(), fs::file_size(path, ignored),
                  fs::last_write_time(path, ignored).time_since_epoch().count()};
    {
        const std::lock_guard lock(mutex);
        if (const auto found = known.find(key); found != known.end())
            return found->second;
    }
    std::string hash = hashOfBytes(path);
    const std::lock_guard lock(mutex);
    if (known.size() >= kKept)
        known.clear();
    return known[key] = std::move(hash);
}

std::vector<PictureData> dataOf(const Scene& scene, Stores stores) {
    TESSERA_CHECK(scene.volumes.size() == stores.size());
    std::vector<PictureData> all = neededBy(scene);
    for (PictureData& data : all) {
        if (data.kind == Kind::volume)
            data = ofVolume(data.number, *stores[data.number]);
        else if (data.kind == Kind::labels)
            data = ofLabels(data.number, scene.volumes[data.number].labels);
        else
            data = ofFile(data.kind, data.number, pathOf(data, scene));
    }
    return all;
}

json dataJson(std::span<const PictureData> all) {
    json rows = json::array();
    for (const PictureData& data : all) {
        json row = {{"kind", kKinds[static_cast<std::size_t>(data.kind)]}, {"number", data.number + 1}};
        if (!data.contentHash.empty())
            row["contentHash"] = data.contentHash;
        if (data.extentVoxels != glm::ivec3(0))
            row["extentVoxels"] = {data.extentVoxels.x, data.extentVoxels.y, data.extentVoxels.z};
        if (!data.type.empty())
            row["type"] = data.type;
        if (data.bytes > 0)
            row["bytes"] = data.bytes;
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<PictureData> dataOfManifest(const json& manifest, const Scene& scene, const std::string& where) {
    std::vector<PictureData> all = neededBy(scene);
    try {
        for (PictureData& data : all)
            data = said(manifest, data).value_or(data);
    } catch (const json::exception&) {
        throw badFile(where, "the manifest of a picture of tessera", "another \"data\"");
    } catch (const InputError& problem) {
        throw badFile(where, "the manifest of a picture of tessera", problem.what());
    }
    return all;
}

} // namespace tessera
