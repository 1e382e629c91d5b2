// bricking/store/zarr_array.cpp: see zarr_array.h.
#include "bricking/store/zarr_array.h"

#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace tessera {
namespace fs = std::filesystem;
namespace {

Json metadataOf(const ArraySpec& spec) {
    Json shape = {spec.grid.z, spec.grid.y, spec.grid.x};
    Json chunk = {spec.chunk.z, spec.chunk.y, spec.chunk.x};
    Json names = {"z", "y", "x"};
    if (spec.row > 0) {
        shape.push_back(spec.row);
        chunk.push_back(spec.row);
        names.push_back("byte");
    }
    const Json bytes = {{"name", "bytes"}, {"configuration", {{"endian", "little"}}}};
    const Json blosc = {{"name", "blosc"},
                        {"configuration",
                         {{"cname", "lz4"},
                          {"clevel", 5},
                          {"shuffle", "bitshuffle"},
                          {"typesize", spec.valueBytes},
                          {"blocksize", 0}}}};
    const Json crc = {{"name", "crc32c"}};
    return {{"zarr_format", 3},
            {"node_type", "array"},
            {"shape", shape},
            {"data_type", spec.dataType},
            {"chunk_grid", {{"name", "regular"}, {"configuration", {{"chunk_shape", chunk}}}}},
            {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", "/"}}}}},
            {"fill_value", 0},
            {"codecs", Json::array({bytes, blosc, crc})},
            {"dimension_names", names},
            {"attributes", Json::object()}};
}

std::string chunkPath(const ArraySpec& spec, const glm::ivec3& at) {
    return "c/" + std::to_string(at.z) + "/" + std::to_string(at.y) + "/" + std::to_string(at.x) +
           (spec.row > 0 ? "/0" : "");
}

/// Calls body(chunk position, first element inside the layer, size in elements) for the chunks of a layer.
template <typename Body> void eachChunk(const ArraySpec& spec, int layer, const Body& body) {
    const glm::ivec3 chunks = (spec.grid + spec.chunk - 1) / spec.chunk;
    const int slices = std::min(spec.chunk.z, spec.grid.z - layer * spec.chunk.z);
    for (int y = 0; y < chunks.y; ++y)
        for (int x = 0; x < chunks.x; ++x) {
            const glm::ivec3 first(x * spec.chunk.x, y * spec.chunk.y, 0);
            const glm::ivec3 size =
                glm::min(glm::ivec3(spec.grid.x, spec.grid.y, slices) - first, spec.chunk);
            body(glm::ivec3(x, y, layer), first, size);
        }
}

} // namespace

std::size_t ArraySpec::chunkBytes() const {
    return cellCount(chunk) * elementBytes();
}
std::size_t ArraySpec::scratchBytes() const {
    return chunkBytes() + encodedBound(chunkBytes());
}

void writeArrayMetadata(const fs::path& folder, const ArraySpec& spec) {
    fs::create_directories(folder);
    writeFile(folder / "zarr.json", storedText(metadataOf(spec)));
}

void writeArrayLayer(const fs::path& folder, const ArraySpec& spec, int layer,
                     std::span<const std::byte> slices) {
    writeArrayBand(folder, spec, layer, 0, slices);
}

void writeArrayBand(const fs::path& folder, const ArraySpec& spec, int layer, int firstRow,
                    std::span<const std::byte> band) {
    const int slices = std::min(spec.chunk.z, spec.grid.z - layer * spec.chunk.z);
    const auto rows =
        static_cast<int>(band.size() / cellCount({spec.grid.x, 1, slices}) / spec.elementBytes());
    const glm::ivec3 extent(spec.grid.x, rows, slices), start(0, firstRow, 0);
    TESSERA_CHECK(firstRow % spec.chunk.y == 0 &&
                  (rows % spec.chunk.y == 0 || firstRow + rows == spec.grid.y));
    std::vector<std::byte> raw(spec.chunkBytes()), encoded(encodedBound(raw.size()));
    const std::size_t element = spec.elementBytes();
    eachChunk(spec, layer, [&](const glm::ivec3& at, const glm::ivec3& first, const glm::ivec3& size) {
        if (first.y < firstRow || first.y >= firstRow + rows)
            return;
        std::fill(raw.begin(), raw.end(), std::byte{0});
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                std::memcpy(raw.data() + linearIndex({0, y, z}, spec.chunk) * element,
                            band.data() + linearIndex(first - start + glm::ivec3(0, y, z), extent) * element,
                            static_cast<std::size_t>(size.x) * element);
        const EncodedChunk chunk = encodeChunk(raw, spec.valueBytes, encoded);
        const fs::path path = folder / chunkPath(spec, at);
        fs::create_directories(path.parent_path());
        writeFile(path, std::span(std::as_const(encoded)).first(chunk.bytes));
    });
}

void tellArrayLayers(const StoreFolder& store, const std::string& relative, const ArraySpec& spec, int first,
                     int end) {
    if (!store.remote)
        return;
    std::vector<RemoteRange> ranges = {{store.remote->nameOf(relative + "/zarr.json")}};
    for (int layer = first; layer < end; ++layer)
        eachChunk(spec, layer, [&](const glm::ivec3& at, const glm::ivec3&, const glm::ivec3&) {
            ranges.push_back({store.remote->nameOf(relative + "/" + chunkPath(spec, at)), 0,
                              encodedBound(spec.chunkBytes())});
        });
    store.remote->files->willRead(std::move(ranges));
}

void checkArrayMetadata(const StoreFolder& store, const std::string& relative, const ArraySpec& spec,
                        const fs::path& shown) {
    constexpr std::uint64_t kLimitBytes = 65536; // ours have less than 2 KiB
    const std::string name = relative + "/zarr.json";
    const auto text = readText(store, name, shown, kLimitBytes);
    const std::string where = (shown / name).string();
    if (!text)
        throw badFile(where, "the metadata of an array", "no such file");
    checkEqual(parseJson(*text, where), metadataOf(spec), where);
}

void readArrayLayer(const StoreFolder& store, const std::string& relative, const ArraySpec& spec, int layer,
                    std::span<std::byte> slices, const fs::path& shown) {
    std::vector<std::byte> raw(spec.chunkBytes()), encoded(encodedBound(raw.size()));
    const std::size_t element = spec.elementBytes();
    eachChunk(spec, layer, [&](const glm::ivec3& at, const glm::ivec3& first, const glm::ivec3& size) {
        const std::string name = relative + "/" + chunkPath(spec, at);
        const std::string where = (shown / name).string();
        const auto file = openIn(store, name, shown);
        if (!file)
            throw badFile(where, "a chunk", "no such file");
        const std::uint64_t bytes = fileSize(*file, where);
        if (bytes > encoded.size())
            throw badFile(where, "at most " + std::to_string(encoded.size()) + " bytes",
                          std::to_string(bytes));
        const auto used = std::span(encoded).first(static_cast<std::size_t>(bytes));
        readAt(*file, 0, used, where);
        decodeChunk(used, raw, where);
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                std::memcpy(slices.data() + linearIndex(first + glm::ivec3(0, y, z), spec.grid) * element,
                            raw.data() + linearIndex({0, y, z}, spec.chunk) * element,
                            static_cast<std::size_t>(size.x) * element);
    });
}

} // namespace tessera
