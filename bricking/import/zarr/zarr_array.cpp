// bricking/import/zarr/zarr_array.cpp: see zarr_array.h.
#include "bricking/import/zarr/zarr_array.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostCodecs = 8;

std::vector<std::int64_t> lengthsOf(const JsonValue& list, std::size_t axes) {
    std::vector<std::int64_t> lengths;
    const JsonItems items = list.items(ZarrArray::kMostAxes, "axes");
    if (items.empty() || (axes != 0 && items.size() != axes))
        list.refuse(axes == 0 ? "a length for each axis" : std::to_string(axes) + " lengths");
    for (const JsonValue item : items)
        lengths.push_back(item.integer(1, static_cast<int>(ZarrArray::kMostAlong)));
    return lengths;
}

std::uint64_t productOf(const std::vector<std::int64_t>& lengths, std::uint64_t most) {
    std::uint64_t all = 1;
    for (const std::int64_t length : lengths) {
        if (static_cast<std::uint64_t>(length) > most / all)
            return most + 1;
        all *= static_cast<std::uint64_t>(length);
    }
    return all;
}

bool isFloat(FileType type) {
    return type == FileType::f32 || type == FileType::f64;
}

/// The bits of a floating-point fill value: a number, or Zarr's words for what JSON lacks.
std::uint64_t floatBitsOf(const nlohmann::json& raw, FileType type, const JsonValue& fill) {
    const bool isSingle = type == FileType::f32;
    double value = 0;
    if (raw.is_number()) {
        value = raw.get<double>();
    } else if (raw.is_string()) {
        const auto word = raw.get<std::string>();
        constexpr int kHex = 16;
        if (word == "NaN")
            value = std::numeric_limits<double>::quiet_NaN();
        else if (word == "Infinity" || word == "-Infinity")
            value = (word[0] == '-' ? -1 : 1) * std::numeric_limits<double>::infinity();
        else if (word.size() == 2 + (isSingle ? 8 : 16) && word.starts_with("0x") &&
                 word.find_first_not_of("0123456789abcdefABCDEF", 2) == std::string::npos)
            return std::stoull(word.substr(2), nullptr, kHex);
        else
            fill.refuse("a number, NaN, Infinity, -Infinity or its bits as 0x...");
    } else if (!raw.is_null()) {
        fill.refuse("a number");
    }
    return isSingle ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                    : std::bit_cast<std::uint64_t>(value);
}

/// The range of a type of whole numbers, as doubles.
std::pair<double, double> rangeOf(FileType type) {
    const auto of = [](auto typed) {
        using T = decltype(typed);
        return std::pair(static_cast<double>(std::numeric_limits<T>::lowest()),
                         static_cast<double>(std::numeric_limits<T>::max()));
    };
    switch (type) {
    case FileType::i8:
        return of(std::int8_t{});
    case FileType::u8:
        return of(std::uint8_t{});
    case FileType::i16:
        return of(std::int16_t{});
    case FileType::u16:
        return of(std::uint16_t{});
    case FileType::i32:
        return of(std::int32_t{});
    case FileType::u32:
        return of(std::uint32_t{});
    case FileType::i64:
        return of(std::int64_t{});
    default:
        return of(std::uint64_t{});
    }
}

/// A fill value of version 2 without what programs wrap numbers in: a list of one, a text (n5-zarr until
/// 2024), a fraction of whole numbers.
nlohmann::json plainFill(nlohmann::json raw, FileType type) {
    if (raw.is_array() && raw.size() == 1)
        raw = nlohmann::json(raw.front());
    if (raw.is_string()) {
        const auto word = raw.get<std::string>();
        const bool isNumber = !word.empty() && word.find_first_not_of("0123456789+-.eE") == std::string::npos;
        if (nlohmann::json number = nlohmann::json::parse(word, nullptr, false);
            isNumber && number.is_number())
            raw = std::move(number);
    }
    constexpr double kExact = 9007199254740992; // 2^53
    if (raw.is_number_float() && !isFloat(type)) {
        const auto value = raw.get<double>();
        if (value == std::floor(value) && std::abs(value) <= kExact)
            raw = static_cast<std::int64_t>(value);
    }
    return raw;
}

/// @param raw  "fill_value" of `root`
void setFill(ZarrArray& array, const JsonValue& root, const nlohmann::json& raw) {
    const JsonValue fill = root.at("fill_value");
    std::uint64_t bits = 0;
    if (isFloat(array.type))
        bits = floatBitsOf(raw, array.type, fill);
    else if (raw.is_boolean())
        bits = raw.get<bool>();
    else if (raw.is_number_unsigned())
        bits = raw.get<std::uint64_t>();
    else if (raw.is_number_integer())
        bits = static_cast<std::uint64_t>(raw.get<std::int64_t>());
    else if (!raw.is_null())
        fill.refuse("a whole number");
    const auto [lowest, highest] = rangeOf(array.type);
    const double value = raw.is_number() ? raw.get<double>() : 0;
    if (!isFloat(array.type) && (value < lowest || value > highest))
        fill.refuse(std::string("a value of ") + name(array.type));
    array.fillShown = raw.is_null() ? "0" : raw.is_string() ? raw.get<std::string>() : raw.dump();
    for (std::size_t i = 0; i < array.valueBytes(); ++i)
        array.fill[array.bigEndian ? array.valueBytes() - 1 - i : i] =
            static_cast<std::byte>(bits >> (8 * i) & 0xFF);
}

void setType(ZarrArray& array, const std::string& word, const JsonValue& type) {
    const auto found = word == "bool" ? FileType::u8 : fileTypeOf(word);
    if (!found)
        type.refuse("numbers (int8 to uint64, bool, float32, float64)");
    array.type = *found;
}

// Version 2.

std::string v3NameOf(const std::string& dtype) {
    if (dtype.size() != 3 || std::string_view("<>|").find(dtype[0]) == std::string_view::npos)
        return "";
    const std::string_view digits = "1248";
    if (dtype[1] == 'b')
        return dtype[2] == '1' ? "bool" : "";
    if (dtype[1] == 'f')
        return dtype[2] == '4' ? "float32" : dtype[2] == '8' ? "float64" : "";
    if ((dtype[1] != 'i' && dtype[1] != 'u') || digits.find(dtype[2]) == std::string_view::npos)
        return "";
    return (dtype[1] == 'i' ? "int" : "uint") + std::to_string(8 * (dtype[2] - '0'));
}

void readVersion2(ZarrArray& array, const JsonValue& root, const nlohmann::json& raw) {
    array.shape = lengthsOf(root.at("shape"), 0);
    array.chunk = lengthsOf(root.at("chunks"), array.shape.size());
    const JsonValue dtype = root.at("dtype");
    if (!dtype.isText())
        dtype.refuse("numbers, such as \"<u2\" or \"<f4\"");
    setType(array, v3NameOf(dtype.text()), dtype);
    array.bigEndian = dtype.text()[0] == '>';
    array.order.resize(array.shape.size());
    std::iota(array.order.begin(), array.order.end(), std::size_t{0});
    if (root.at("order").oneOf({"C", "F"}) == "F")
        std::reverse(array.order.begin(), array.order.end());
    if (root.has("filters") && !raw.at("filters").is_null() && !root.at("filters").items().empty())
        root.at("filters").refuse("no filters");
    if (!raw.contains("compressor"))
        root.at("compressor"); // refuses
    if (!raw.at("compressor").is_null()) {
        const std::string id = root.at("compressor").at("id").oneOf({"blosc", "zstd", "gzip", "zlib", "lz4"});
        array.codecs.push_back(id == "blosc"  ? ZarrCodec::blosc
                               : id == "zstd" ? ZarrCodec::zstd
                               : id == "gzip" ? ZarrCodec::gzip
                               : id == "lz4"  ? ZarrCodec::lz4
                                              : ZarrCodec::zlib);
    }
    array.isSeparatorSaid = root.has("dimension_separator");
    array.separator = array.isSeparatorSaid ? root.at("dimension_separator").oneOf({".", "/"}) : ".";
    root.at("fill_value"); // refuses
    setFill(array, root, plainFill(raw.at("fill_value"), array.type));
}

// Version 3.

/// A codec's name: an object's, or a text by itself.
std::string nameOfCodec(const JsonValue& codec) {
    return codec.isText() ? codec.text() : codec.at("name").text();
}

/// From values to bytes, then from bytes to bytes.
void readCodecs(ZarrArray& array, const JsonItems& codecs) {
    bool hasBytes = false, isCompressed = false;
    array.order.resize(array.shape.size());
    std::iota(array.order.begin(), array.order.end(), std::size_t{0});
    for (const JsonValue codec : codecs) {
        const std::string word = nameOfCodec(codec);
        if (!hasBytes && word == "transpose") {
            const JsonValue list = codec.at("configuration").at("order");
            const std::vector<double> axes = list.numbers(array.order.size());
            std::vector<std::size_t> next;
            std::vector<bool> isTaken(axes.size());
            for (const double axis : axes) {
                const bool isAxis = axis >= 0 && axis < static_cast<double>(axes.size()) &&
                                    axis == std::floor(axis) && !isTaken[static_cast<std::size_t>(axis)];
                if (!isAxis)
                    list.refuse("every axis once");
                isTaken[static_cast<std::size_t>(axis)] = true;
                next.push_back(array.order[static_cast<std::size_t>(axis)]);
            }
            array.order = next;
        } else if (!hasBytes && word == "bytes") {
            hasBytes = true;
            const bool hasEndian =
                codec.isObject() && codec.has("configuration") && codec.at("configuration").has("endian");
            if (!hasEndian && array.valueBytes() > 1)
                codec.refuse("an endian, as values have several bytes");
            array.bigEndian =
                hasEndian && codec.at("configuration").at("endian").oneOf({"little", "big"}) == "big";
        } else if (hasBytes && word == "crc32c") {
            array.codecs.push_back(ZarrCodec::crc32c);
        } else if (hasBytes && !isCompressed && (word == "blosc" || word == "zstd" || word == "gzip")) {
            isCompressed = true;
            array.codecs.push_back(word == "blosc"  ? ZarrCodec::blosc
                                   : word == "zstd" ? ZarrCodec::zstd
                                                    : ZarrCodec::gzip);
        } else {
            codec.refuse("transpose, bytes, then one of blosc, zstd and gzip, or crc32c");
        }
    }
    if (!hasBytes)
        throw badFile(array.where, "codecs with \"bytes\" among them", "none");
}

void readShards(ZarrArray& array, const JsonValue& codec) {
    const JsonValue about = codec.at("configuration");
    const std::vector<std::int64_t> shard = array.chunk;
    array.chunk = lengthsOf(about.at("chunk_shape"), shard.size());
    for (std::size_t axis = 0; axis < shard.size(); ++axis) {
        if (shard[axis] % array.chunk[axis] != 0)
            about.at("chunk_shape").refuse("lengths that divide those of the shard");
        array.shard.push_back(shard[axis] / array.chunk[axis]);
    }
    if (productOf(array.shard, ZarrArray::kMostChunksOfShard) > ZarrArray::kMostChunksOfShard)
        about.at("chunk_shape").refuse("at most 16777216 chunks a shard");
    if (about.has("index_location"))
        array.isIndexInFront = about.at("index_location").oneOf({"start", "end"}) == "start";
    const JsonItems index = about.at("index_codecs").items(kMostCodecs, "codecs");
    if (index.size() != 2 || nameOfCodec(index[0]) != "bytes" || nameOfCodec(index[1]) != "crc32c")
        about.at("index_codecs").refuse("bytes, then crc32c");
    if (index[0].isObject() && index[0].has("configuration"))
        index[0].at("configuration").at("endian").oneOf({"little"});
    readCodecs(array, about.at("codecs").items(kMostCodecs, "codecs"));
}

void readVersion3(ZarrArray& array, const JsonValue& root, const nlohmann::json& raw) {
    array.shape = lengthsOf(root.at("shape"), 0);
    const JsonValue grid = root.at("chunk_grid");
    grid.at("name").oneOf({"regular"});
    array.chunk = lengthsOf(grid.at("configuration").at("chunk_shape"), array.shape.size());
    setType(array, root.at("data_type").text(), root.at("data_type"));
    if (root.has("storage_transformers") && !root.at("storage_transformers").items().empty())
        root.at("storage_transformers").refuse("none");
    const JsonItems codecs = root.at("codecs").items(kMostCodecs, "codecs");
    if (codecs.size() == 1 && codecs[0].isObject() && nameOfCodec(codecs[0]) == "sharding_indexed")
        readShards(array, codecs[0]);
    else
        readCodecs(array, codecs);
    const JsonValue keys = root.at("chunk_key_encoding");
    const bool isDefault = keys.at("name").oneOf({"default", "v2"}) == "default";
    array.separator = isDefault ? "/" : ".";
    if (keys.has("configuration") && keys.at("configuration").has("separator"))
        array.separator = keys.at("configuration").at("separator").oneOf({"/", "."});
    array.prefix = isDefault ? "c" + array.separator : "";
    root.at("fill_value"); // refuses
    setFill(array, root, raw.at("fill_value"));
    if (raw.contains("dimension_names") && raw.at("dimension_names").is_array()) {
        const JsonItems names = root.at("dimension_names").items(ZarrArray::kMostAxes, "axes");
        if (names.size() != array.shape.size())
            root.at("dimension_names").refuse("a name for each axis");
        for (const JsonValue name : names)
            array.dimensionNames.push_back(name.isText() ? name.text() : "");
    }
}

} // namespace

std::size_t ZarrArray::chunkBytes() const {
    return static_cast<std::size_t>(productOf(chunk, kMostChunkBytes)) * valueBytes();
}

ZarrArray zarrArrayOf(const ZarrNode& node) {
    TESSERA_CHECK(node.isArray);
    ZarrArray array;
    array.path = node.path;
    array.folder = node.folder;
    array.where = node.metadataFile;
    const JsonValue root(*node.metadata, node.metadataFile);
    if (node.version == 2)
        readVersion2(array, root, *node.metadata);
    else
        readVersion3(array, root, *node.metadata);
    if (productOf(array.chunk, ZarrArray::kMostChunkBytes) * array.valueBytes() > ZarrArray::kMostChunkBytes)
        throw badFile(array.where, "chunks of at most 1 GiB", "larger ones");
    return array;
}

} // namespace tessera
