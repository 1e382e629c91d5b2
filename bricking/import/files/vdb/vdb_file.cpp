// bricking/import/files/vdb/vdb_file.cpp: see vdb_file.h. Rules: the headers of OpenVDB 10 (io/Archive.h,
// io/GridDescriptor.h, math/Maps.h) and the files that it writes.
#include "bricking/import/files/vdb/vdb_file.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/files/vdb/vdb_bytes.h"
#include "bricking/import/files/vdb/vdb_values.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <span>
#include <string_view>

namespace tessera {
namespace {

constexpr std::uint64_t kMark = 0x56444220;
constexpr std::uint32_t kFirstVersion = 222, kLastVersion = 224;
constexpr std::uint32_t kMostEntries = 65536; // grids, or metadata of one

/// Names that are given twice end in a separator and a number.
std::string shownName(const std::string& name) {
    constexpr char kSeparator = '\x1e';
    const std::size_t at = name.find(kSeparator);
    return at == std::string::npos ? name : name.substr(0, at) + "[" + name.substr(at + 1) + "]";
}

std::uint32_t countIn(VdbBytes& bytes, const char* of) {
    const auto count = bytes.number<std::uint32_t>();
    if (count > kMostEntries)
        bytes.refuse(std::string(of) + ", 65536 at most", std::to_string(count));
    return count;
}

/// Values by their names: type and bytes. Long ones are passed over.
struct Value {
    std::string type, bytes;
};
std::map<std::string, Value> metadataIn(VdbBytes& bytes) {
    std::map<std::string, Value> values;
    for (std::uint32_t left = countIn(bytes, "metadata"); left > 0; --left) {
        const std::string name = bytes.word();
        Value value{bytes.word(), ""};
        const auto length = bytes.number<std::uint32_t>();
        constexpr std::uint32_t kMostHeld = 256;
        if (length <= kMostHeld) {
            value.bytes.resize(length);
            bytes.read(std::as_writable_bytes(std::span(value.bytes)));
            values[name] = std::move(value);
        } else {
            bytes.skip(length);
        }
    }
    return values;
}

template <class T>
std::optional<T> numberIn(const std::map<std::string, Value>& values, const char* name, const char* type) {
    const auto at = values.find(name);
    if (at == values.end() || at->second.type != type || at->second.bytes.size() != sizeof(T))
        return std::nullopt;
    T value;
    std::memcpy(&value, at->second.bytes.data(), sizeof value);
    return value;
}

void readTransform(VdbBytes& bytes, VdbHead& head) {
    const std::string map = bytes.word();
    const auto vector = [&] {
        glm::dvec3 v;
        for (int axis = 0; axis < 3; ++axis)
            v[axis] = bytes.number<double>();
        return v;
    };
    const auto scale = [&] {
        const glm::dvec3 by = vector();
        constexpr std::uint64_t kDerived = 4 * 3 * sizeof(double); // lengths and inverses
        bytes.skip(kDerived);
        for (int axis = 0; axis < 3; ++axis) {
            head.step[static_cast<std::size_t>(axis)] = glm::dvec3(0);
            head.step[static_cast<std::size_t>(axis)][axis] = by[axis];
        }
    };
    if (map == "ScaleMap" || map == "UniformScaleMap") {
        scale();
    } else if (map == "TranslationMap") {
        head.origin = vector();
    } else if (map == "ScaleTranslateMap" || map == "UniformScaleTranslateMap") {
        head.origin = vector();
        scale();
    } else if (map == "AffineMap" || map == "UnitaryMap") { // of row vectors
        std::array<double, 4> last{};
        for (std::size_t row = 0; row < 4; ++row) {
            (row < 3 ? head.step[row] : head.origin) = vector();
            last[row] = bytes.number<double>();
        }
        if (last != std::array<double, 4>{0, 0, 0, 1})
            bytes.refuse("a transform that is linear", "one with a perspective");
    } else {
        bytes.refuse("a transform that is linear (scale, translation, affine)", shownWord(map));
    }
}

} // namespace

std::vector<VdbGrid> readVdbGrids(const InputFile& file) {
    VdbBytes bytes(file, 0, file.sizeBytes());
    if (bytes.left() < sizeof kMark || bytes.number<std::uint64_t>() != kMark)
        bytes.refuse("an OpenVDB file", file.sizeBytes() == 0 ? "an empty file" : "another beginning");
    const auto version = bytes.number<std::uint32_t>();
    if (version < kFirstVersion || version > kLastVersion)
        bytes.refuse("an OpenVDB file of version 222 to 224", "version " + std::to_string(version));
    constexpr std::uint64_t kLibraryVersion = 8, kUuid = 36;
    bytes.skip(kLibraryVersion);
    if (bytes.number<std::uint8_t>() != 1)
        bytes.refuse("a file that says where its grids are", "a stream of grids");
    bytes.skip(kUuid);
    metadataIn(bytes);
    std::vector<VdbGrid> grids;
    for (std::uint32_t left = countIn(bytes, "grids"); left > 0; --left) {
        VdbGrid grid;
        grid.name = shownName(bytes.word());
        grid.type = bytes.word();
        constexpr std::string_view kHalf = "_HalfFloat";
        grid.isHalf = grid.type.ends_with(kHalf);
        if (grid.isHalf)
            grid.type.resize(grid.type.size() - kHalf.size());
        grid.treeOf = shownName(bytes.word());
        grid.at = bytes.number<std::uint64_t>();
        grid.leavesAt = bytes.number<std::uint64_t>();
        grid.end = bytes.number<std::uint64_t>();
        if (grid.at < bytes.at() || grid.leavesAt < grid.at || grid.end < grid.leavesAt ||
            grid.end > file.sizeBytes())
            bytes.refuse("grids within the file", "one up to byte " + std::to_string(grid.end) + " of " +
                                                      std::to_string(file.sizeBytes()) +
                                                      " (is it truncated?)");
        bytes.skip(grid.end - bytes.at());
        grids.push_back(std::move(grid));
    }
    return grids;
}

VdbHead readVdbHead(const InputFile& file, const VdbGrid& grid) {
    VdbBytes bytes(file, grid.at, grid.leavesAt);
    VdbHead head;
    head.compression = bytes.number<std::uint32_t>();
    if ((head.compression & ~(kVdbZip | kVdbActiveMask | kVdbBlosc)) != 0)
        bytes.refuse("values that are plain or packed by zlib or Blosc",
                     "compression " + std::to_string(head.compression));
    const std::map<std::string, Value> values = metadataIn(bytes);
    const auto textOf = [&](const char* name) {
        const auto at = values.find(name);
        return at != values.end() && at->second.type == "string" ? at->second.bytes : std::string();
    };
    head.gridClass = textOf("class");
    head.unit = textOf("unit");
    head.space = textOf("tessera_space");
    head.extent = numberIn<glm::ivec3>(values, "tessera_extent", "vec3i");
    head.low = numberIn<glm::ivec3>(values, "file_bbox_min", "vec3i");
    head.high = numberIn<glm::ivec3>(values, "file_bbox_max", "vec3i");
    head.voxels = numberIn<std::int64_t>(values, "file_voxel_count", "int64");
    readTransform(bytes, head);
    head.treeAt = bytes.at();
    return head;
}

} // namespace tessera
