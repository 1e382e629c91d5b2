// bricking/store/zarr_metadata.cpp: see zarr_metadata.h.
#include "bricking/store/zarr_metadata.h"

#include "bricking/store/checked_json.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/shard.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"
#include "core/base/fnv_hash.h"
#include "core/base/magnitude.h"
#include "core/base/shown_text.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace tessera {
namespace {

constexpr int kMaxFileLevel = 63;
constexpr int kMaxExtent = 1 << 30; // so that sums with a chunk or shard stay inside int
constexpr std::size_t kMaxTextBytes = 64, kMaxRemarkBytes = 300, kMaxRemarks = 16;

/// A number as JSON: integer types without fraction, as Zarr demands of fill values.
Json valueJson(const VolumeInfo& info, double value) {
    if (info.type == ValueType::f32)
        return value;
    return static_cast<std::int64_t>(value);
}

Json zyx(const glm::dvec3& v) {
    return Json::array({v.z, v.y, v.x});
}
Json zyx(const glm::ivec3& v) {
    return Json::array({v.z, v.y, v.x});
}

bool fits(ValueType type, double value) {
    const auto whole = [&](double lowest, double highest) {
        return value == std::floor(value) && value >= lowest && value <= highest;
    };
    switch (type) {
    case ValueType::u8:
        return whole(0, 255);
    case ValueType::i16:
        return whole(-32768, 32767);
    case ValueType::u16:
        return whole(0, 65535);
    case ValueType::f32:
        return std::isfinite(value) && static_cast<double>(static_cast<float>(value)) == value;
    }
    return false;
}

/// RFC-4 names per array axis x, y, z: the patient axis a voxel step mostly follows; empty where two axes
/// follow the same one.
std::array<std::string, 3> orientations(const VolumeInfo& info) {
    static const char* const kNames[3][2] = {{"right-to-left", "left-to-right"},
                                             {"anterior-to-posterior", "posterior-to-anterior"},
                                             {"inferior-to-superior", "superior-to-inferior"}};
    std::array<std::string, 3> names;
    unsigned seen = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 step(info.patientFromVoxel[axis]);
        int main = 0;
        for (int i = 1; i < 3; ++i)
            if (std::abs(step[i]) > std::abs(step[main]))
                main = i;
        seen |= 1u << main;
        names[static_cast<std::size_t>(axis)] = kNames[main][step[main] < 0];
    }
    if (seen != 7)
        return {};
    return names;
}

Json omeAttributes(const StoreMetadata& metadata) {
    const VolumeInfo& info = metadata.info;
    const std::string label = info.acquisition.modality.empty() ? "volume" : info.acquisition.modality;
    const auto orientation = orientations(info);
    Json axes = Json::array();
    for (int axis = 2; axis >= 0; --axis) {
        Json entry = {{"name", std::string(1, "xyz"[axis])}, {"type", "space"}, {"unit", "millimeter"}};
        if (const auto& value = orientation[static_cast<std::size_t>(axis)]; !value.empty())
            entry["orientation"] = {{"type", "anatomical"}, {"value", value}};
        axes.push_back(entry);
    }
    Json datasets = Json::array();
    const glm::dvec3 spacing = info.spacingMm(), origin = firstVoxelCentreMm(info);
    for (int level = 0; level < kLevelCount; ++level) {
        const double pitch = static_cast<double>(1 << level);
        // The first sample of level l lies in the middle of 2^l voxels, half a voxel short of 2^(l-1).
        const Json transforms = Json::array(
            {{{"type", "scale"}, {"scale", zyx(pitch * spacing)}},
             {{"type", "translation"}, {"translation", zyx(origin + 0.5 * (pitch - 1) * spacing)}}});
        datasets.push_back({{"path", std::to_string(level)}, {"coordinateTransformations", transforms}});
    }
    const bool hounsfield = info.unit == "HU";
    const auto stored = [&](double physical) {
        return (physical - info.rescaleIntercept) / info.rescaleSlope;
    };
    // Other viewers show stored values: the soft tissue window -160..240 HU, or all there is.
    double start = hounsfield ? stored(-160) : metadata.lowest,
           end = hounsfield ? stored(240) : metadata.highest;
    if (start > end)
        std::swap(start, end);
    const Json window = {{"min", valueJson(info, metadata.lowest)},
                         {"max", valueJson(info, metadata.highest)},
                         {"start", start},
                         {"end", end}};
    const Json channel = {{"color", "FFFFFF"}, {"label", label}, {"active", true}, {"window", window}};
    const bool isMean = metadata.rule == kPyramidRule;
    Json ome = {{"version", "0.5"},
                {"multiscales", Json::array({{{"name", label},
                                              {"type", isMean ? "mean" : "mode"},
                                              {"metadata", {{"method", metadata.rule}}},
                                              {"axes", axes},
                                              {"datasets", datasets}}})}};
    if (isMean) // names have no window
        ome["omero"] = {{"channels", Json::array({channel})}, {"rdefs", {{"model", "greyscale"}}}};
    if (!metadata.imageLabel.empty())
        ome["image-label"] = Json::parse(metadata.imageLabel);
    return ome;
}

Json tesseraAttributes(const StoreMetadata& metadata) {
    const VolumeInfo& info = metadata.info;
    Json affine = Json::array();
    for (int row = 0; row < 4; ++row) {
        Json line = Json::array();
        for (int column = 0; column < 4; ++column)
            line.push_back(info.patientFromVoxel[column][row]);
        affine.push_back(line);
    }
    Json levels = Json::array();
    for (const auto& records : metadata.shards) {
        std::uint64_t written = 0;
        Json shards = Json::array();
        for (const ShardRecord& record : records) {
            shards.push_back(Json::array({record.chunks, record.indexCrc, record.payloadCrc}));
            written += record.chunks;
        }
        levels.push_back({{"chunksWritten", written}, {"shards", shards}});
    }
    const glm::ivec3 e = info.extentVoxels;
    Json json = {
        {"version", kStoreVersion},
        {"extentVoxels", Json::array({e.x, e.y, e.z})},
        {"valueType", name(info.type)},
        {"rescale", {{"slope", info.rescaleSlope}, {"intercept", info.rescaleIntercept}}},
        {"unit", info.unit},
        {"fillStored", valueJson(info, info.fillStored)},
        {"patientFromVoxel", affine},
        {"originalOrder",
         {{"sourceAxis", info.originalOrder.sourceAxis}, {"flipped", info.originalOrder.flipped}}},
        {"acquisition",
         {{"modality", info.acquisition.modality},
          {"kernel", info.acquisition.kernel},
          {"tubeVoltageKv", info.acquisition.tubeVoltageKv},
          {"sliceThicknessMm", info.acquisition.sliceThicknessMm}}},
        {"nonFiniteVoxels", info.nonFiniteVoxels},
        {"clampedVoxels", info.clampedVoxels},
        {"range",
         {{"lowest", valueJson(info, metadata.lowest)}, {"highest", valueJson(info, metadata.highest)}}},
        {"levelRule", metadata.rule},
        {"levels", levels},
        {"stats", {{"path", "stats"}, {"brick", kBrickExtent}, {"cell", kCellExtent}}}};
    // Written only if there is something to say: the same voxels keep the same content hash.
    if (info.lossy)
        json["lossy"] = true;
    if (info.lossy && info.lossyRatio > 0)
        json["lossyRatio"] = info.lossyRatio;
    if (!info.orientationKnown)
        json["orientationKnown"] = false;
    if (!info.frameOfReference.empty())
        json["frameOfReference"] = info.frameOfReference;
    if (info.nonFiniteVoxels > 0)
        json["absentStored"] = info.absentStored;
    if (info.suvPerValue > 0)
        json["suvPerValue"] = info.suvPerValue;
    if (metadata.codec != Codec::lz4)
        json["codec"] = nameOf(metadata.codec);
    if (!info.remarks.empty())
        json["remarks"] = info.remarks;
    if (info.filePart) {
        const auto& [level, finest, extent, box] = *info.filePart;
        json["filePart"] = {
            {"level", level},
            {"finestVoxels", Json::array({finest.x, finest.y, finest.z})},
            {"levelVoxels", Json::array({extent.x, extent.y, extent.z})},
            {"box", Json::array({box.low.x, box.high.x, box.low.y, box.high.y, box.low.z, box.high.z})}};
    }
    return json;
}

Json groupJson(const StoreMetadata& metadata) {
    Json document = {
        {"zarr_format", 3},
        {"node_type", "group"},
        {"attributes", {{"ome", omeAttributes(metadata)}, {"tessera", tesseraAttributes(metadata)}}}};
    seal(document);
    return document;
}

Json levelJson(const StoreMetadata& metadata, int level) {
    const VolumeInfo& info = metadata.info;
    const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
    const ShardLayout layout = shardLayout(extent);
    const Json crc = {{"name", "crc32c"}};
    Json bytes = {{"name", "bytes"}, {"configuration", {{"endian", "little"}}}};
    Json codecs = Json::array({bytes});
    if (const int step = dctStep(metadata.codec); step > 0) {
        codecs.push_back({{"name", "tessera.dct"}, {"configuration", {{"step", step}}}});
    } else if (metadata.codec != Codec::none) {
        const BloscParameters blosc = bloscParameters(metadata.codec);
        codecs.push_back({{"name", "blosc"},
                          {"configuration",
                           {{"cname", blosc.name},
                            {"clevel", blosc.level},
                            {"shuffle", "bitshuffle"},
                            {"typesize", bytesPerValue(info.type)},
                            {"blocksize", 0}}}});
    }
    codecs.push_back(crc);
    const Json sharding = {{"name", "sharding_indexed"},
                           {"configuration",
                            {{"chunk_shape", Json::array({kChunkExtent, kChunkExtent, kChunkExtent})},
                             {"codecs", codecs},
                             {"index_codecs", Json::array({bytes, crc})},
                             {"index_location", "end"}}}}; // the only place that all readers honour
    return {
        {"zarr_format", 3},
        {"node_type", "array"},
        {"shape", zyx(extent)},
        {"data_type", name(info.type)},
        {"chunk_grid", {{"name", "regular"}, {"configuration", {{"chunk_shape", zyx(layout.shardExtent)}}}}},
        {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", "/"}}}}},
        {"fill_value", valueJson(info, info.fillStored)},
        {"codecs", Json::array({sharding})},
        {"dimension_names", Json::array({"z", "y", "x"})},
        {"attributes", Json::object()}};
}

std::string numbered(const std::string& pointer, std::size_t i) {
    return pointer + "/" + std::to_string(i);
}

std::uint64_t countAt(const Json& document, const std::string& pointer, const std::string& where) {
    return static_cast<std::uint64_t>(
        integerAt(document, pointer, 0, std::numeric_limits<std::int64_t>::max(), where));
}

FilePart parseFilePart(const Json& document, const std::string& root, const std::string& where) {
    FilePart part;
    part.level = static_cast<int>(integerAt(document, root + "/level", 0, kMaxFileLevel, where));
    const auto numberAlong = [&](const char* list, int at, std::int64_t least) {
        return static_cast<int>(integerAt(document, numbered(root + "/" + list, static_cast<std::size_t>(at)),
                                          least, kMaxExtent, where));
    };
    for (int axis = 0; axis < 3; ++axis) {
        part.finestVoxels[axis] = numberAlong("finestVoxels", axis, 1);
        part.levelVoxels[axis] = numberAlong("levelVoxels", axis, 1);
        part.box.low[axis] = numberAlong("box", 2 * axis, 0);
        part.box.high[axis] = numberAlong("box", 2 * axis + 1, 1);
    }
    return part;
}

VolumeInfo parseInfo(const Json& document, const std::string& where) {
    const std::string root = "/attributes/tessera";
    VolumeInfo info;
    for (int axis = 0; axis < 3; ++axis)
        info.extentVoxels[axis] = static_cast<int>(
            integerAt(document, numbered(root + "/extentVoxels", static_cast<std::size_t>(axis)), 1,
                      kMaxExtent, where));
    const std::string typeName = textAt(document, root + "/valueType", where);
    bool known = false;
    for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32})
        if (typeName == name(type)) {
            info.type = type;
            known = true;
        }
    if (!known)
        throw badFile(where, "a value type uint8, int16, uint16 or float32", "'" + typeName + "'");
    info.rescaleSlope = numberAt(document, root + "/rescale/slope", where);
    info.rescaleIntercept = numberAt(document, root + "/rescale/intercept", where);
    info.unit = textAt(document, root + "/unit", where);
    info.fillStored = numberAt(document, root + "/fillStored", where);
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column)
            info.patientFromVoxel[static_cast<int>(column)][static_cast<int>(row)] =
                numberAt(document, numbered(numbered(root + "/patientFromVoxel", row), column), where);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        info.originalOrder.sourceAxis[axis] = static_cast<int>(
            integerAt(document, numbered(root + "/originalOrder/sourceAxis", axis), 0, 2, where));
        info.originalOrder.flipped[axis] =
            flagAt(document, numbered(root + "/originalOrder/flipped", axis), where);
    }
    info.acquisition.modality = textAt(document, root + "/acquisition/modality", where);
    info.acquisition.kernel = textAt(document, root + "/acquisition/kernel", where);
    info.acquisition.tubeVoltageKv = numberAt(document, root + "/acquisition/tubeVoltageKv", where);
    info.acquisition.sliceThicknessMm = numberAt(document, root + "/acquisition/sliceThicknessMm", where);
    info.nonFiniteVoxels = countAt(document, root + "/nonFiniteVoxels", where);
    info.clampedVoxels = countAt(document, root + "/clampedVoxels", where);
    // Told only where there is something to tell.
    const auto has = [&](const char* key) { return document.contains(Json::json_pointer(root + "/" + key)); };
    if (has("lossy"))
        info.lossy = flagAt(document, root + "/lossy", where);
    if (has("lossyRatio"))
        info.lossyRatio = numberAt(document, root + "/lossyRatio", where);
    if (has("orientationKnown"))
        info.orientationKnown = flagAt(document, root + "/orientationKnown", where);
    if (has("frameOfReference")) {
        info.frameOfReference = textAt(document, root + "/frameOfReference", where);
        if (!isDicomUid(info.frameOfReference))
            throw badFile(where, root + "/frameOfReference to be a DICOM UID, 1 to 64 digits and full stops",
                          "'" + printable(info.frameOfReference.substr(0, kMaxTextBytes)) + "' of " +
                              std::to_string(info.frameOfReference.size()) + " bytes");
    }
    if (has("absentStored"))
        info.absentStored = numberAt(document, root + "/absentStored", where);
    if (has("suvPerValue"))
        info.suvPerValue = numberAt(document, root + "/suvPerValue", where);
    if (has("remarks")) {
        const Json& remarks = jsonAt(document, root + "/remarks", where);
        for (std::size_t i = 0; i < remarks.size(); ++i)
            info.remarks.push_back(textAt(document, numbered(root + "/remarks", i), where));
    }
    if (has("filePart"))
        info.filePart = parseFilePart(document, root + "/filePart", where);
    return info;
}

std::vector<ShardRecord> parseShards(const Json& document, const std::string& pointer,
                                     const ShardLayout& layout, const std::string& where) {
    const Json& list = jsonAt(document, pointer, where);
    if (!list.is_array() || list.size() != cellCount(layout.shards))
        throw badFile(where, pointer + " to hold " + std::to_string(cellCount(layout.shards)) + " shards",
                      std::to_string(list.size()));
    std::vector<ShardRecord> records(list.size());
    for (std::size_t i = 0; i < records.size(); ++i) {
        const Json& entry = list[i];
        if (!entry.is_array() || entry.size() != 3)
            throw badFile(where, numbered(pointer, i) + " to be three numbers", "something else");
        const auto part = [&](const char* at, std::size_t most) {
            return static_cast<std::uint32_t>(
                integerAt(entry, at, 0, static_cast<std::int64_t>(most), where));
        };
        records[i] = {part("/0", layout.entries()), part("/1", UINT32_MAX), part("/2", UINT32_MAX)};
    }
    return records;
}

} // namespace

namespace {
constexpr double kLeastStoredMm = 1e-9, kMostStoredMm = 1e9, kFarthestStoredMm = 1e18;
} // namespace

void checkStorable(const VolumeInfo& info, const std::string& where) {
    info.validate(where);
    // Wider than the bounds of importers: only so that no arithmetic overflows on a foreign store.
    const glm::dvec3 spacing = info.spacingMm();
    for (int axis = 0; axis < 3; ++axis)
        if (!(spacing[axis] >= kLeastStoredMm && spacing[axis] <= kMostStoredMm))
            throw badFile(where, "a voxel spacing from 1e-9 to 1e9 mm",
                          shownNumber(spacing[axis]) + " mm along axis " + std::to_string(axis));
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(info.patientFromVoxel[3][axis]) <= kFarthestStoredMm))
            throw badFile(where, "a first voxel within 1e18 mm of the origin",
                          shownNumber(info.patientFromVoxel[3][axis]) + " mm");
    if (!(std::abs(info.rescaleSlope) >= 1 / kLargestValue))
        throw badFile(where, "a rescale slope that tells values apart", shownNumber(info.rescaleSlope));
    checkValue(info.rescaleSlope, "a rescale slope", where);
    checkValue(info.rescaleIntercept, "a rescale intercept", where);
    for (int axis = 0; axis < 3; ++axis)
        if (info.extentVoxels[axis] > kMaxExtent)
            throw badFile(where, "at most 2^30 voxels along every axis",
                          std::to_string(info.extentVoxels[axis]));
    if (!fits(info.type, info.fillStored))
        throw badFile(where, std::string("a fill value that ") + name(info.type) + " can hold",
                      std::to_string(info.fillStored));
    for (const double value : {info.acquisition.tubeVoltageKv, info.acquisition.sliceThicknessMm,
                               info.lossyRatio, info.absentStored, info.suvPerValue})
        if (!std::isfinite(value))
            throw badFile(where, "finite acquisition values", std::to_string(value));
    for (int column = 0; column < 4; ++column)
        if (info.patientFromVoxel[column][3] != (column == 3 ? 1.0 : 0.0))
            throw badFile(where, "an affine whose last row is 0 0 0 1", "another one");
}

VolumeInfo withPlainTexts(VolumeInfo info) {
    const auto makePlain = [](std::string& text, std::size_t most) {
        if (text.size() > most)
            text.resize(most);
        for (char& c : text)
            if (c < 0x20 || c > 0x7e)
                c = '?';
    };
    for (std::string* text : {&info.unit, &info.acquisition.modality, &info.acquisition.kernel})
        makePlain(*text, kMaxTextBytes);
    info.frameOfReference = uidOrNone(std::move(info.frameOfReference));
    if (info.remarks.size() > kMaxRemarks)
        info.remarks.resize(kMaxRemarks);
    for (std::string& remark : info.remarks)
        makePlain(remark, kMaxRemarkBytes);
    return info;
}

std::string groupDocument(const StoreMetadata& metadata) {
    return storedText(groupJson(metadata));
}

std::string levelDocument(const StoreMetadata& metadata, int level) {
    return storedText(levelJson(metadata, level));
}

StoreMetadata parseGroup(std::string_view text, const std::string& where) {
    const Json document = parseJson(text, where);
    const std::string root = "/attributes/tessera";
    const auto version = integerAt(document, root + "/version", 1, INT32_MAX, where);
    if (version != kStoreVersion)
        throw badFile(where, "store version " + std::to_string(kStoreVersion), std::to_string(version));
    checkSeal(document, where);
    StoreMetadata metadata;
    metadata.info = parseInfo(document, where);
    checkStorable(metadata.info, where);
    metadata.lowest = numberAt(document, root + "/range/lowest", where);
    metadata.highest = numberAt(document, root + "/range/highest", where);
    if (!fits(metadata.info.type, metadata.lowest) || !fits(metadata.info.type, metadata.highest) ||
        metadata.lowest > metadata.highest)
        throw badFile(where, "a range of values of the stored type", "another one");
    metadata.rule = textAt(document, root + "/levelRule", where);
    if (metadata.rule != kPyramidRule && metadata.rule != kMajorityRule)
        throw badFile(
            where, std::string(root) + "/levelRule to be '" + kPyramidRule + "' or '" + kMajorityRule + "'",
            "another rule");
    if (document.contains(Json::json_pointer(root + "/codec")))
        metadata.codec = namesOf<Codec>().named(textAt(document, root + "/codec", where), where);
    if (dctStep(metadata.codec) > 0 && bytesPerValue(metadata.info.type) > 2)
        throw badFile(where, "values of one or two bytes by codec " + nameOf(metadata.codec),
                      name(metadata.info.type));
    if (const Json::json_pointer at("/attributes/ome/image-label"); document.contains(at))
        metadata.imageLabel = document.at(at).dump(); // the checksum holds
    for (int level = 0; level < kLevelCount; ++level) {
        const auto at = static_cast<std::size_t>(level);
        metadata.shards[at] = parseShards(document, numbered(root + "/levels", at) + "/shards",
                                          shardLayout(levelExtent(metadata.info.extentVoxels, level)), where);
    }
    checkEqual(document, groupJson(metadata), where);
    return metadata;
}

void checkLevel(std::string_view text, const StoreMetadata& metadata, int level, const std::string& where) {
    checkEqual(parseJson(text, where), levelJson(metadata, level), where);
}

bool isGroupOfOurs(std::string_view text) {
    const Json document = Json::parse(text, nullptr, false);
    return document.is_object() && document.contains(Json::json_pointer("/attributes/tessera/version"));
}

bool couldBeOurs(std::string_view text) {
    const Json document = Json::parse(text, nullptr, false);
    if (document.is_object())
        return document.contains(Json::json_pointer("/attributes/tessera")) ||
               !document.contains("node_type");
    return text.find("node_type") == std::string_view::npos || text.find("tessera") != std::string_view::npos;
}

std::string contentHashOf(const StoreMetadata& metadata) {
    StoreMetadata content = metadata; // of the same voxels, whatever else is known of their source
    content.info.remarks.clear();
    content.info.frameOfReference.clear();
    content.info.filePart.reset();
    FnvHash hash;
    hash.addBytes(groupJson(content).dump());
    return hash.digits();
}

} // namespace tessera
