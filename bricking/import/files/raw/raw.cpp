// bricking/import/files/raw/raw.cpp: see raw.h.
#include "bricking/import/files/raw/raw.h"

#include "bricking/import/files/file_format.h"
#include "bricking/import/files/file_reading.h"
#include "bricking/import/source/plausible.h"
#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using Json = nlohmann::json;
constexpr std::uint64_t kLargestSidecarBytes = 1 << 20; // a sidecar has a dozen short keys
constexpr std::array kKeys = {"data",   "extent", "type",         "spacing",          "origin", "direction",
                              "endian", "offset", "rescaleSlope", "rescaleIntercept", "unit"};

std::string readText(const std::filesystem::path& path) {
    const InputFile file(path);
    if (file.sizeBytes() > kLargestSidecarBytes)
        throw badFile(path.string(), "a sidecar of at most 1 MiB",
                      std::to_string(file.sizeBytes()) + " bytes");
    std::string text(file.sizeBytes(), '\0');
    file.readAt(0, std::as_writable_bytes(std::span(text)));
    return text;
}

/// Reads keys of the sidecar with errors that name file and key.
class Sidecar {
  public:
    Sidecar(std::string where, const Json& json) : where_(std::move(where)), json_(json) {
        if (!json.is_object())
            throw badFile(where_, "a JSON object", json.type_name());
        for (const auto& item : json.items()) {
            if (std::find(kKeys.begin(), kKeys.end(), item.key()) != kKeys.end())
                continue;
            std::string known;
            for (const char* key : kKeys)
                known += (known.empty() ? "" : ", ") + std::string(key);
            throw badFile(where_, "only the keys " + known, "the key \"" + item.key() + "\"");
        }
    }

    bool has(const char* key) const { return json_.contains(key); }
    [[noreturn]] void refuse(const char* key, const std::string& expected) const {
        throw badFile(where_, std::string("\"") + key + "\" to be " + expected,
                      has(key)
                          ? json_.at(key).dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 80)
                          : "no such key");
    }
    std::string text(const char* key, const char* expected) const {
        if (!has(key) || !json_.at(key).is_string())
            refuse(key, expected);
        return json_.at(key).get<std::string>();
    }
    double number(const char* key, double fallback) const {
        if (!has(key))
            return fallback;
        if (!json_.at(key).is_number())
            refuse(key, "a number");
        return json_.at(key).get<double>();
    }
    template <std::size_t N> std::array<double, N> numbers(const char* key, const char* expected) const {
        std::array<double, N> values{};
        if (!has(key) || !json_.at(key).is_array() || json_.at(key).size() != N)
            refuse(key, expected);
        for (std::size_t i = 0; i < N; ++i) {
            if (!json_.at(key)[i].is_number())
                refuse(key, expected);
            values[i] = json_.at(key)[i].get<double>();
        }
        return values;
    }
    const Json& json() const { return json_; }

  private:
    std::string where_;
    const Json& json_;
};

glm::ivec3 readExtent(const Sidecar& sidecar) {
    const auto values = sidecar.numbers<3>("extent", "three whole numbers of voxels");
    glm::ivec3 extent;
    for (int axis = 0; axis < 3; ++axis) {
        const double value = values[static_cast<std::size_t>(axis)];
        if (value != std::floor(value) || value < 1 || value > std::numeric_limits<int>::max())
            sidecar.refuse("extent", "three whole numbers of voxels, at least 1");
        extent[axis] = static_cast<int>(value);
    }
    return extent;
}

glm::dmat4 readAffine(const Sidecar& sidecar) {
    const auto spacing = sidecar.numbers<3>("spacing", "three lengths in mm, above 0");
    for (const double length : spacing)
        if (!(length > 0))
            sidecar.refuse("spacing", "three lengths in mm, above 0");
    std::array<double, 3> origin{};
    if (sidecar.has("origin"))
        origin = sidecar.numbers<3>("origin", "three coordinates in mm");
    std::array<double, 9> direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (sidecar.has("direction"))
        direction = sidecar.numbers<9>("direction", "nine numbers, row by row");
    std::array<glm::dvec3, 3> step;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const glm::dvec3 column{direction[axis], direction[3 + axis], direction[6 + axis]};
        if (!(std::abs(glm::length(column) - 1) < 1e-3))
            sidecar.refuse("direction", "columns of length 1 (lengths belong in \"spacing\")");
        step[axis] = column * spacing[axis];
    }
    return patientFromVoxelOf({origin[0], origin[1], origin[2]}, step[0], step[1], step[2]);
}

std::filesystem::path dataPath(const Sidecar& sidecar, const std::filesystem::path& sidecarPath) {
    const std::filesystem::path data = sidecar.text("data", "the name of the data file");
    if (data.is_absolute())
        return data;
    for (const auto& part : data)
        if (part == "..")
            sidecar.refuse("data", "a path inside the sidecar's folder, or an absolute one");
    return sidecarPath.parent_path() / data;
}

/// The JSON of a file that is small enough for a sidecar; discarded where it is none.
Json smallJson(const std::filesystem::path& path) {
    std::error_code error;
    if (std::filesystem::file_size(path, error) > kLargestSidecarBytes || error)
        return Json(Json::value_t::discarded);
    return Json::parse(readText(path), nullptr, false);
}

/// True if it has the keys "data" and "extent": other JSON is skipped.
bool isRawSidecar(const std::filesystem::path& path) {
    const Json json = smallJson(path);
    return json.is_object() && json.contains("data") && json.contains("extent");
}
std::vector<std::filesystem::path> dataFileOf(const std::filesystem::path& sidecar) {
    const Json json = smallJson(sidecar);
    if (!json.is_object() || !json.contains("data") || !json["data"].is_string())
        return {};
    return {sidecar.parent_path() / json["data"].get<std::string>()};
}

} // namespace

std::unique_ptr<SlabSource> openRaw(const std::filesystem::path& sidecarPath) {
    const Json json = Json::parse(readText(sidecarPath), nullptr, false);
    if (json.is_discarded())
        throw badFile(sidecarPath.string(), "JSON", "text that does not parse");
    const Sidecar sidecar(sidecarPath.string(), json);

    VoxelLayout layout;
    const auto type = fileTypeOf(sidecar.text("type", "a number type such as \"int16\""));
    if (!type)
        sidecar.refuse("type",
                       "int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32 or float64");
    layout.type = *type;
    const std::string endian = sidecar.has("endian") ? sidecar.text("endian", "a word") : "little";
    if (endian != "little" && endian != "big")
        sidecar.refuse("endian", "\"little\" or \"big\"");
    layout.bigEndian = endian == "big";
    if (sidecar.has("offset")) {
        if (!json.at("offset").is_number_unsigned())
            sidecar.refuse("offset", "a whole number of bytes");
        layout.offsetBytes = json.at("offset").get<std::uint64_t>();
    }

    VolumeInfo info;
    info.extentVoxels = readExtent(sidecar);
    info.type = storedTypeOf(layout.type);
    info.patientFromVoxel = readAffine(sidecar);
    info.orientationKnown = sidecar.has("direction");
    info.rescaleSlope = sidecar.number("rescaleSlope", 1);
    info.rescaleIntercept = sidecar.number("rescaleIntercept", 0);
    info.unit = sidecar.has("unit") ? sidecar.text("unit", "a word such as \"HU\"") : "";
    if (info.unit.size() > 16)
        sidecar.refuse("unit", "at most 16 characters");
    const std::string where = sidecarPath.string();
    requirePlausibleGeometry(info, {"\"spacing\"", "\"direction\"", "\"origin\""}, where);
    const bool isReal = layout.type == FileType::f32 || layout.type == FileType::f64;
    requirePlausibleRescale(
        info.rescaleSlope, info.rescaleIntercept,
        isReal ? 0 : std::ldexp(1.0, std::min(24, static_cast<int>(8 * bytesPerFileValue(layout.type)))),
        false, "\"rescaleSlope\"", "\"rescaleIntercept\"", where);
    info.validate(where);
    // If the unit is known, air is the natural padding; -1024 HU must be a value of the stored type.
    if (info.unit == "HU") {
        const double stored = (-1024 - info.rescaleIntercept) / info.rescaleSlope;
        const bool fits =
            info.type == ValueType::f32 ||
            (stored == std::floor(stored) && stored >= (info.type == ValueType::i16 ? -32768 : 0) &&
             stored <= (info.type == ValueType::i16  ? 32767
                        : info.type == ValueType::u8 ? 255
                                                     : 65535));
        if (fits)
            info.fillStored = static_cast<double>(static_cast<float>(stored));
    }

    InputFile file(dataPath(sidecar, sidecarPath));
    const std::uint64_t voxelBytes = voxelBytesInFile(info, layout.type);
    if (layout.offsetBytes > file.sizeBytes() || file.sizeBytes() - layout.offsetBytes != voxelBytes)
        throw badFile(file.path().string(),
                      std::to_string(voxelBytes) + " bytes of voxels after an offset of " +
                          std::to_string(layout.offsetBytes) + ", as " + sidecarPath.string() + " says",
                      "a file of " + std::to_string(file.sizeBytes()) + " bytes");
    std::string description = std::string("raw ") + name(layout.type) + " file with sidecar";
    if (losesPrecision(layout.type))
        description += ", converted to float32";
    return makePlainFileSource(std::move(file), info, layout, std::move(description));
}

FileFormat rawFormat() {
    return {"raw files with a .json sidecar", "the .json sidecar of a raw file",
            [](const std::filesystem::path& path, const SourceOptions&) { return openRaw(path); },
            isRawSidecar, dataFileOf};
}

} // namespace tessera
