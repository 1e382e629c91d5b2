// tests/support/zarr_writer.h: arrays of Zarr as other programs write them: version 2 and 3, chunks of any
// shape, orders of axes and bytes, compressions, shards.
#pragma once

#include "bricking/store/codec.h"
#include "tests/support/label_file_tools.h"

#include <blosc.h>
#include <functional>
#include <glm/vec3.hpp>
#include <lz4.h>
#include <nlohmann/json.hpp>
#include <numeric>
#include <zstd.h>

namespace tessera::test {

using Json = nlohmann::json;

struct WrittenZarr {
    int version = 3;
    std::vector<std::size_t> shape, chunk, shard; // shard: elements; empty: none
    std::string type = "uint16";
    bool bigEndian = false, hasCrc = false, hasKnownSize = true, isIndexInFront = false;
    std::string compressor = "none";     // blosc, zstd, gzip, zlib, lz4
    std::vector<std::size_t> order = {}; // of a chunk's axes; empty: as they are. Version 2: reversed alone
    std::string separator = "/";
    Json attributes = Json::object();
    std::int64_t fill = 0;
    bool leavesOutFill = true; // chunks of fill alone have no file
};

/// "{...}" as a file.
inline void writeJson(const std::filesystem::path& path, const Json& document) {
    std::filesystem::create_directories(path.parent_path());
    writeBytes(path, document.dump());
}

inline std::string compressed(const WrittenZarr& zarr, const std::string& raw, std::size_t valueBytes) {
    std::string out;
    if (zarr.compressor == "blosc") {
        out.resize(raw.size() + BLOSC_MAX_OVERHEAD);
        out.resize(static_cast<std::size_t>(blosc_compress_ctx(
            5, BLOSC_SHUFFLE, valueBytes, raw.size(), raw.data(), out.data(), out.size(), "zstd", 0, 1)));
    } else if (zarr.compressor == "zstd") {
        ZSTD_CCtx* const context = ZSTD_createCCtx();
        ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, zarr.hasKnownSize ? 1 : 0);
        out.resize(ZSTD_compressBound(raw.size()));
        out.resize(ZSTD_compress2(context, out.data(), out.size(), raw.data(), raw.size()));
        ZSTD_freeCCtx(context);
    } else if (zarr.compressor == "gzip") {
        out = gzipped(raw);
    } else if (zarr.compressor == "zlib") {
        uLongf bytes = compressBound(raw.size());
        out.resize(bytes);
        compress(reinterpret_cast<Bytef*>(out.data()), &bytes, reinterpret_cast<const Bytef*>(raw.data()),
                 raw.size());
        out.resize(bytes);
    } else if (zarr.compressor == "lz4") { // of numcodecs: the size, then one block
        const auto size = static_cast<std::uint32_t>(raw.size());
        out.resize(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(raw.size()))));
        out.resize(static_cast<std::size_t>(LZ4_compress_default(
            raw.data(), out.data(), static_cast<int>(raw.size()), static_cast<int>(out.size()))));
        out.insert(0, reinterpret_cast<const char*>(&size), sizeof size);
    } else {
        out = raw;
    }
    if (zarr.hasCrc) {
        const std::uint32_t crc = crc32c(std::as_bytes(std::span(out)));
        out.append(reinterpret_cast<const char*>(&crc), sizeof crc);
    }
    return out;
}

inline std::string typedBytes(const std::string& type, const std::vector<std::uint32_t>& values, bool big) {
    return type == "uint8" || type == "bool" ? fileBytes<std::uint8_t>(values, big)
           : type == "int8"                  ? fileBytes<std::int8_t>(values, big)
           : type == "uint16"                ? fileBytes<std::uint16_t>(values, big)
           : type == "int16"                 ? fileBytes<std::int16_t>(values, big)
           : type == "uint32"                ? fileBytes<std::uint32_t>(values, big)
           : type == "int32"                 ? fileBytes<std::int32_t>(values, big)
           : type == "uint64"                ? fileBytes<std::uint64_t>(values, big)
           : type == "int64"                 ? fileBytes<std::int64_t>(values, big)
           : type == "float32"               ? fileBytes<float>(values, big)
           : type == "float64"               ? fileBytes<double>(values, big)
                                             : "";
}

/// Calls body with every place of a grid, slowest axis first.
inline void eachPlace(const std::vector<std::size_t>& grid,
                      const std::function<void(const std::vector<std::size_t>&)>& body) {
    std::vector<std::size_t> at(grid.size());
    while (true) {
        body(at);
        std::size_t axis = grid.size();
        while (axis > 0 && ++at[axis - 1] == grid[axis - 1])
            at[--axis] = 0;
        if (axis == 0)
            return;
    }
}

/// The values of a chunk in its order of bytes; beyond the array the fill.
inline std::vector<std::uint32_t> chunkValues(const WrittenZarr& zarr, const std::vector<std::size_t>& place,
                                              const std::vector<std::uint32_t>& values) {
    const std::size_t axes = zarr.shape.size();
    std::vector<std::size_t> order = zarr.order;
    if (order.empty()) {
        order.resize(axes);
        std::iota(order.begin(), order.end(), std::size_t{0});
    }
    std::vector<std::size_t> ordered(axes);
    for (std::size_t i = 0; i < axes; ++i)
        ordered[i] = zarr.chunk[order[i]];
    std::vector<std::uint32_t> chunk;
    eachPlace(ordered, [&](const std::vector<std::size_t>& in) {
        std::vector<std::size_t> at(axes);
        for (std::size_t i = 0; i < axes; ++i)
            at[order[i]] = place[order[i]] * zarr.chunk[order[i]] + in[i];
        std::size_t index = 0;
        bool isInside = true;
        for (std::size_t i = 0; i < axes; ++i) {
            index = index * zarr.shape[i] + at[i];
            isInside = isInside && at[i] < zarr.shape[i];
        }
        chunk.push_back(isInside ? values[index] : static_cast<std::uint32_t>(zarr.fill));
    });
    return chunk;
}

inline Json zarrCodecs(const WrittenZarr& zarr) {
    Json codecs = Json::array();
    if (!zarr.order.empty())
        codecs.push_back({{"name", "transpose"}, {"configuration", {{"order", zarr.order}}}});
    codecs.push_back({{"name", "bytes"}, {"configuration", {{"endian", zarr.bigEndian ? "big" : "little"}}}});
    if (zarr.compressor == "blosc")
        codecs.push_back({{"name", "blosc"},
                          {"configuration", {{"cname", "zstd"}, {"clevel", 5}, {"shuffle", "shuffle"}}}});
    else if (zarr.compressor != "none")
        codecs.push_back({{"name", zarr.compressor}, {"configuration", {{"level", 5}}}});
    if (zarr.hasCrc)
        codecs.push_back("crc32c");
    return codecs;
}

inline Json arrayMetadata(const WrittenZarr& zarr) {
    if (zarr.version == 2) {
        const char kind = zarr.type == "bool"          ? 'b'
                          : zarr.type.starts_with("u") ? 'u'
                          : zarr.type.starts_with("f") ? 'f'
                                                       : 'i';
        const std::size_t bytes = typedBytes(zarr.type, {0}, false).size();
        return {{"zarr_format", 2},
                {"shape", zarr.shape},
                {"chunks", zarr.chunk},
                {"dtype", std::string(bytes == 1       ? "|"
                                      : zarr.bigEndian ? ">"
                                                       : "<") +
                              kind + std::to_string(bytes)},
                {"compressor", zarr.compressor == "none" ? Json() : Json({{"id", zarr.compressor}})},
                {"fill_value", zarr.fill},
                {"order", zarr.order.empty() ? "C" : "F"},
                {"filters", nullptr},
                {"dimension_separator", zarr.separator}};
    }
    const Json index = Json::array(
        {Json{{"name", "bytes"}, {"configuration", {{"endian", "little"}}}}, Json{{"name", "crc32c"}}});
    Json codecs = zarrCodecs(zarr);
    if (!zarr.shard.empty())
        codecs = Json::array({Json{{"name", "sharding_indexed"},
                                   {"configuration",
                                    {{"chunk_shape", zarr.chunk},
                                     {"codecs", codecs},
                                     {"index_codecs", index},
                                     {"index_location", zarr.isIndexInFront ? "start" : "end"}}}}});
    return {{"zarr_format", 3},
            {"node_type", "array"},
            {"shape", zarr.shape},
            {"data_type", zarr.type},
            {"chunk_grid",
             {{"name", "regular"},
              {"configuration", {{"chunk_shape", zarr.shard.empty() ? zarr.chunk : zarr.shard}}}}},
            {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", zarr.separator}}}}},
            {"fill_value", zarr.fill},
            {"codecs", codecs},
            {"attributes", zarr.attributes}};
}

/// Writes an array of values in the order of its shape.
inline void writeZarrArray(const std::filesystem::path& folder, const WrittenZarr& zarr,
                           const std::vector<std::uint32_t>& values) {
    std::filesystem::create_directories(folder);
    writeJson(folder / (zarr.version == 2 ? ".zarray" : "zarr.json"), arrayMetadata(zarr));
    std::vector<std::size_t> grid, per, files;
    for (std::size_t i = 0; i < zarr.shape.size(); ++i) {
        per.push_back(zarr.shard.empty() ? 1 : zarr.shard[i] / zarr.chunk[i]);
        files.push_back((zarr.shape[i] - 1) / (zarr.chunk[i] * per[i]) + 1);
    }
    eachPlace(files, [&](const std::vector<std::size_t>& file) {
        std::string payload;
        std::vector<std::uint64_t> index;
        bool hasChunk = false;
        const std::size_t count =
            std::accumulate(per.begin(), per.end(), std::size_t{1}, std::multiplies<>());
        const std::size_t front = zarr.isIndexInFront ? 16 * count + 4 : 0;
        eachPlace(per, [&](const std::vector<std::size_t>& in) {
            std::vector<std::size_t> place;
            for (std::size_t i = 0; i < in.size(); ++i)
                place.push_back(file[i] * per[i] + in[i]);
            const auto chunk = chunkValues(zarr, place, values);
            const bool isFill = std::all_of(chunk.begin(), chunk.end(), [&](std::uint32_t value) {
                return value == static_cast<std::uint32_t>(zarr.fill);
            });
            if (isFill && zarr.leavesOutFill) {
                index.insert(index.end(), 2, ~std::uint64_t{0});
                return;
            }
            const std::string raw = typedBytes(zarr.type, chunk, zarr.bigEndian);
            const std::string bytes = compressed(zarr, raw, raw.size() / chunk.size());
            payload += zarr.shard.empty() ? "" : "gap"; // which a shard may have
            index.push_back(front + payload.size());
            index.push_back(bytes.size());
            payload += bytes;
            hasChunk = true;
        });
        if (!hasChunk)
            return;
        std::string key = zarr.version == 2 ? "" : "c" + zarr.separator;
        for (std::size_t i = 0; i < file.size(); ++i)
            key += (i == 0 ? "" : zarr.separator) + std::to_string(file[i]);
        if (!zarr.shard.empty()) {
            std::string table(reinterpret_cast<const char*>(index.data()), index.size() * 8);
            const std::uint32_t crc = crc32c(std::as_bytes(std::span(table)));
            table.append(reinterpret_cast<const char*>(&crc), sizeof crc);
            payload = zarr.isIndexInFront ? table + payload : payload + table;
        }
        std::filesystem::create_directories((folder / key).parent_path());
        writeBytes(folder / key, payload);
    });
}

/// A group with attributes: of version 3 those of OME below "ome".
inline void writeZarrGroup(const std::filesystem::path& folder, int version, const Json& ome) {
    if (version == 2) {
        writeJson(folder / ".zgroup", {{"zarr_format", 2}});
        writeJson(folder / ".zattrs", ome);
        return;
    }
    Json attributes = Json::object();
    if (!ome.empty())
        attributes["ome"] = ome;
    writeJson(folder / "zarr.json", {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", attributes}});
}

/// "multiscales" of one level; axes named by letters, of which t and c are not of space.
inline Json multiscaleOf(const std::string& axes, const std::vector<double>& scale,
                         const std::vector<double>& translation, const std::string& path = "0") {
    Json list = Json::array();
    for (const char axis : axes) {
        Json row = {{"name", std::string(1, axis)},
                    {"type", axis == 't'   ? "time"
                             : axis == 'c' ? "channel"
                                           : "space"}};
        if (row["type"] == "space")
            row["unit"] = "millimeter";
        list.push_back(row);
    }
    const Json transformations = Json::array({Json{{"type", "scale"}, {"scale", scale}},
                                              Json{{"type", "translation"}, {"translation", translation}}});
    const Json dataset = {{"path", path}, {"coordinateTransformations", transformations}};
    return {{"axes", list}, {"datasets", Json::array({dataset})}};
}

} // namespace tessera::test
