// tests/bricking/store/store_format_test.cpp: the bytes of a store, by the formats' definitions: Zarr v3, its
// sharding and OME-Zarr 0.5, docs/formats.md for the rest. What is written and read by one code could
// otherwise change unnoticed.
#include "bricking/import/importer.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/zarr_array.h"
#include "bricking/store/zarr_metadata.h"
#include "tests/support/bricking_store_tools.h"

#include <cmath>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

Json documentOf(const fs::path& file) {
    return parseJson(fileText(file), file.string());
}

/// The codecs of a chunk.
Json codecsOf(int valueBytes) {
    return Json::parse(R"([{"name":"bytes","configuration":{"endian":"little"}},
        {"name":"blosc","configuration":{"cname":"lz4","clevel":5,"shuffle":"bitshuffle","typesize":)" +
                       std::to_string(valueBytes) + R"(,"blocksize":0}},{"name":"crc32c"}])");
}

TEST(StoreFormat, AGroupIsOursUnlessItIsAnotherPrograms) {
    const ScratchFolder scratch;
    HashSource source(plainInfo({40, 40, 40}, ValueType::i16));
    import(scratch / "v.zarr", source);
    const std::string whole = fileText(scratch / "v.zarr" / "zarr.json");
    EXPECT_TRUE(couldBeOurs(whole));
    for (const std::string& damaged : {whole.substr(0, whole.size() / 2), std::string(), std::string("{}")})
        EXPECT_TRUE(couldBeOurs(damaged)) << damaged;
    Json group = Json::parse(whole);
    group["attributes"]["tessera"].erase("version");
    EXPECT_TRUE(couldBeOurs(group.dump()));
    group["attributes"].erase("tessera");
    for (const char* word : {"tessera", "/data/tessera/scan.czi"}) {
        group["attributes"]["source"] = word;
        EXPECT_FALSE(couldBeOurs(group.dump())) << word;
    }
    group["attributes"]["a"] = std::string(3 << 20, 'x'); // before "node_type", as consolidated metadata
    EXPECT_FALSE(couldBeOurs(group.dump()));
}

TEST(StoreFormat, LevelsAreShardedArrays) {
    const ScratchFolder scratch;
    VolumeInfo info = plainInfo({70, 40, 600}, ValueType::i16);
    info.fillStored = -3;
    HashSource source(info, [](int x, int y, int z) { return x + y + z; });
    import(scratch / "v.zarr", source);
    const std::vector<std::pair<std::array<int, 3>, std::array<int, 3>>> levels = {
        {{600, 40, 70}, {512, 64, 96}}, // shards of 16 chunks of 32 at most, cut to what is there
        {{300, 20, 35}, {320, 32, 64}}, {{150, 10, 18}, {160, 32, 32}}, {{75, 5, 9}, {96, 32, 32}},
        {{38, 3, 5}, {64, 32, 32}},     {{19, 2, 3}, {32, 32, 32}}};
    for (std::size_t level = 0; level < levels.size(); ++level) {
        const auto& [shape, shard] = levels[level];
        const Json expected = {
            {"zarr_format", 3},
            {"node_type", "array"},
            {"shape", shape},
            {"data_type", "int16"},
            {"chunk_grid", {{"name", "regular"}, {"configuration", {{"chunk_shape", shard}}}}},
            {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", "/"}}}}},
            {"fill_value", -3},
            {"codecs",
             Json::array(
                 {{{"name", "sharding_indexed"},
                   {"configuration",
                    {{"chunk_shape", {32, 32, 32}},
                     {"codecs", codecsOf(2)},
                     {"index_codecs", Json::parse(R"([{"name":"bytes","configuration":{"endian":"little"}},
                                                              {"name":"crc32c"}])")},
                     {"index_location", "end"}}}}})},
            {"dimension_names", {"z", "y", "x"}},
            {"attributes", Json::object()}};
        EXPECT_EQ(documentOf(scratch / "v.zarr" / std::to_string(level) / "zarr.json"), expected) << level;
    }
}

/// Codecs of a volume's chunks: the default says nothing, so that stores stay as they were.
TEST(StoreFormat, CodecsAreThoseThatAreChosen) {
    const ScratchFolder scratch;
    const auto values = [](int x, int y, int z) { return x * y + 3 * z; };
    const auto codecsIn = [&](const fs::path& store, int level) {
        return documentOf(store / std::to_string(level) / "zarr.json")
            .at("/codecs/0/configuration/codecs"_json_pointer);
    };
    std::map<Codec, std::uintmax_t> bytes;
    for (const Codec codec : {Codec::lz4, Codec::zstd, Codec::none}) {
        const fs::path store = scratch / (nameOf(codec) + ".zarr");
        HashSource source(plainInfo({70, 40, 50}, ValueType::i16), values);
        ImportOptions options;
        options.durable = false;
        options.codec = codec;
        options.threads = 2;
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        importToStore(source, store, ram, options);
        const Json group = documentOf(store / "zarr.json").at("attributes").at("tessera");
        EXPECT_EQ(group.value("codec", ""), codec == Codec::lz4 ? "" : nameOf(codec));
        Json expected = codecsOf(2);
        if (codec == Codec::zstd)
            expected[1]["configuration"].update({{"cname", "zstd"}, {"clevel", 3}});
        if (codec == Codec::none)
            expected.erase(1);
        const StoreReader reader(store, ram);
        std::vector<std::byte> chunk(reader.chunkBytes());
        for (int level = 0; level < kLevelCount; ++level)
            EXPECT_EQ(codecsIn(store, level), expected) << level;
        for (int i = 0; i < 3; ++i) {
            reader.readChunk({0, i, 0, 1}, chunk);
            const auto* at = reinterpret_cast<const std::int16_t*>(chunk.data());
            for (int z = 32; z < 50; ++z)
                for (int y = 0; y < 32; ++y)
                    for (int x = 32 * i; x < std::min(32 * i + 32, 70); ++x)
                        ASSERT_EQ(at[(z - 32) * 1024 + y * 32 + x - 32 * i], values(x, y, z));
        }
        bytes[codec] = fs::file_size(store / "0/c/0/0/0");
    }
    EXPECT_LT(bytes[Codec::zstd], bytes[Codec::lz4]);
    EXPECT_LT(bytes[Codec::lz4], bytes[Codec::none]);
    // 3 x 2 x 2 chunks, each with its checksum, and the index
    EXPECT_EQ(bytes[Codec::none], 12 * (65536 + 4) + 12 * 16 + 4);
}

TEST(StoreFormat, ChunksOfAnyCodecAreChecked) {
    std::vector<std::byte> raw(4096), encoded(encodedBound(raw.size())), other(encoded.size()),
        out(raw.size());
    for (std::size_t i = 0; i < raw.size(); ++i)
        raw[i] = static_cast<std::byte>(i * i >> 3);
    for (const Codec codec : {Codec::lz4, Codec::zstd, Codec::none}) {
        const EncodedChunk chunk = encodeChunk(raw, 2, encoded, codec);
        const auto used = std::span(encoded).first(chunk.bytes);
        decodeChunk(used, out, "a chunk", codec);
        EXPECT_EQ(out, raw);
        const EncodedChunk shorter = encodeChunk(std::span(raw).first(2048), 2, other, codec);
        EXPECT_THROW(decodeChunk(std::span(other).first(shorter.bytes), out, "a chunk", codec), InputError);
        for (std::size_t cut = 0; cut < used.size(); cut += 7)
            EXPECT_THROW(decodeChunk(used.first(cut), out, "a chunk", codec), InputError) << cut;
        for (std::size_t at = 0; at < used.size(); at += 11) {
            used[at] ^= std::byte{4};
            EXPECT_THROW(decodeChunk(used, out, "a chunk", codec), InputError) << at;
            used[at] ^= std::byte{4};
        }
    }
}

/// Everything that a group says, of a volume whose every member differs from its default.
TEST(StoreFormat, GroupsDescribeTheVolume) {
    const ScratchFolder scratch;
    VolumeInfo info = plainInfo({5, 3, 2}, ValueType::u16);
    info.patientFromVoxel = patientFromVoxelOf({10, 20, 30}, {0.5, 0, 0}, {0, 0.75, 0}, {0, 0, 2});
    info.rescaleSlope = 0.5;
    info.rescaleIntercept = -8;
    info.unit = "T1";
    info.fillStored = 9;
    info.originalOrder = {{2, 0, 1}, {true, false, true}};
    info.acquisition = {"MR", "K2", 3, 1.25};
    info.nonFiniteVoxels = 4;
    info.absentStored = 6;
    info.clampedVoxels = 7;
    info.lossy = true;
    info.lossyRatio = 12;
    info.orientationKnown = false;
    info.frameOfReference = "1.2.3";
    info.suvPerValue = 0.25;
    info.remarks = {"one", "two"};
    HashSource source(info, [](int x, int y, int z) { return 100 + x + 10 * y + 100 * z; });
    import(scratch / "v.zarr", source);
    const Json document = documentOf(scratch / "v.zarr/zarr.json");
    Json found = document.at("attributes").at("tessera");
    const Json levels = found.at("levels");
    EXPECT_THAT(found.at("checksum").get<std::string>(), testing::MatchesRegex("crc32c:[0-9a-f]+"));
    found.erase("levels"), found.erase("checksum");
    EXPECT_EQ(found, Json::parse(R"({
        "version": 1, "extentVoxels": [5, 3, 2], "valueType": "uint16",
        "rescale": {"slope": 0.5, "intercept": -8.0}, "unit": "T1", "fillStored": 9,
        "patientFromVoxel": [[0.5, 0.0, 0.0, 9.75], [0.0, 0.75, 0.0, 19.625], [0.0, 0.0, 2.0, 29.0], [0.0, 0.0, 0.0, 1.0]],
        "originalOrder": {"sourceAxis": [2, 0, 1], "flipped": [true, false, true]},
        "acquisition": {"modality": "MR", "kernel": "K2", "tubeVoltageKv": 3.0, "sliceThicknessMm": 1.25},
        "nonFiniteVoxels": 4, "clampedVoxels": 7, "range": {"lowest": 100, "highest": 224},
        "levelRule": "2x2x2 mean, level by level, halves to even, edge samples repeated at odd extents",
        "stats": {"path": "stats", "brick": 32, "cell": 8},
        "lossy": true, "lossyRatio": 12.0, "orientationKnown": false, "frameOfReference": "1.2.3",
        "absentStored": 6.0, "suvPerValue": 0.25, "remarks": ["one", "two"]})"));
    ASSERT_EQ(levels.size(), 6u);
    for (const Json& level : levels) {
        EXPECT_EQ(level.at("chunksWritten"), 1);
        ASSERT_EQ(level.at("shards").size(), 1u);
        EXPECT_EQ(level.at("shards").at(0).at(0), 1) << "chunks; then the sums of index and payload";
        EXPECT_EQ(level.at("shards").at(0).size(), 3u);
    }
    // Of a volume that has nothing special to tell, it is not told.
    HashSource plain(plainInfo({5, 3, 2}, ValueType::u16));
    import(scratch / "plain.zarr", plain);
    const Json short_ = documentOf(scratch / "plain.zarr/zarr.json").at("attributes").at("tessera");
    for (const char* key : {"lossy", "lossyRatio", "orientationKnown", "frameOfReference", "absentStored",
                            "suvPerValue", "remarks"})
        EXPECT_FALSE(short_.contains(key)) << key;
    const Json& ome = document.at("attributes").at("ome");
    EXPECT_EQ(ome.at("version"), "0.5");
    const Json& scale = ome.at("multiscales").at(0);
    EXPECT_EQ(scale.at("name"), "MR");
    EXPECT_EQ(scale.at("type"), "mean");
    EXPECT_EQ(ome.at("omero").at("channels").at(0).at("color"), "FFFFFF");
    EXPECT_EQ(ome.at("omero").at("rdefs").at("model"), "greyscale");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(scale.at("axes").at(axis).at("name"), std::string(1, "zyx"[axis]));
        EXPECT_EQ(scale.at("axes").at(axis).at("type"), "space");
        EXPECT_EQ(scale.at("axes").at(axis).at("unit"), "millimeter");
    }
}

/// FNV-1a of the group's text without blanks, as it would be without remarks and frame.
TEST(StoreFormat, TheContentHashIsOneOfTheText) {
    const ScratchFolder scratch;
    HashSource source(plainInfo({40, 33, 3}, ValueType::u8));
    import(scratch / "v.zarr", source);
    std::uint64_t hash = 14695981039346656037u;
    for (const char c : documentOf(scratch / "v.zarr/zarr.json").dump()) {
        hash ^= static_cast<unsigned char>(c);
        hash *= 1099511628211u;
    }
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).contentHash(), text);
}

/// The index of a shard: 16 bytes a chunk at its end, [z][y][x], then its checksum.
TEST(StoreFormat, ShardsHaveTheirIndexAtTheirEnd) {
    const ScratchFolder scratch;
    HashSource source(plainInfo({70, 40, 100}, ValueType::u8), [](int x, int y, int z) {
        return y >= 32 && z >= 64 ? 0
                                  : 1 + (x / 32 + 3 * (y / 32) + 6 * (z / 32)); // two rows of chunks of fill
    });
    import(scratch / "v.zarr", source);
    const std::string file = fileText(scratch / "v.zarr/0/c/0/0/0");
    constexpr std::size_t kChunks = 3 * 2 * 4;
    ASSERT_GT(file.size(), 16 * kChunks + 4);
    const std::size_t begin = file.size() - 16 * kChunks - 4;
    std::uint32_t crc = 0;
    std::memcpy(&crc, file.data() + file.size() - 4, 4);
    EXPECT_EQ(crc, crc32c(std::as_bytes(std::span(file)).subspan(begin, 16 * kChunks)));
    std::vector<std::byte> raw(32 * 32 * 32);
    std::uint64_t used = 0;
    for (std::size_t n = 0; n < kChunks; ++n) {
        std::uint64_t offset = 0, bytes = 0;
        std::memcpy(&offset, file.data() + begin + 16 * n, 8);
        std::memcpy(&bytes, file.data() + begin + 16 * n + 8, 8);
        const std::size_t x = n % 3, y = n / 3 % 2, z = n / 6;
        if (y == 1 && z >= 2) {
            EXPECT_EQ(offset, ~std::uint64_t{0}) << n;
            EXPECT_EQ(bytes, ~std::uint64_t{0}) << n;
            continue;
        }
        ASSERT_LE(offset + bytes, begin) << n;
        used += bytes;
        decodeChunk(std::as_bytes(std::span(file)).subspan(offset, bytes), raw, "a chunk");
        EXPECT_EQ(raw[0], static_cast<std::byte>(1 + x + 3 * y + 6 * z)) << n;
    }
    EXPECT_EQ(used, begin) << "chunks lie side by side";
}

/// Arrays beside the levels, such as statistics: every chunk of several along each axis, and each end.
TEST(StoreFormat, ArraysAreCutIntoChunks) {
    const ScratchFolder scratch;
    for (const std::size_t row : {0u, 3u}) {
        ArraySpec spec;
        spec.dataType = "uint16";
        spec.valueBytes = 2;
        spec.grid = {7, 5, 4};
        spec.chunk = {3, 4, 2};
        spec.row = row;
        const std::size_t each = row == 0 ? 1 : row;
        EXPECT_EQ(spec.elementBytes(), 2 * each);
        EXPECT_EQ(spec.chunkBytes(), 2 * each * 24);
        EXPECT_EQ(spec.layers(), 2);
        const fs::path folder = scratch / std::to_string(row);
        writeArrayMetadata(folder, spec);
        Json expected = {
            {"zarr_format", 3},
            {"node_type", "array"},
            {"shape", {4, 5, 7}},
            {"data_type", "uint16"},
            {"chunk_grid", {{"name", "regular"}, {"configuration", {{"chunk_shape", {2, 4, 3}}}}}},
            {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", "/"}}}}},
            {"fill_value", 0},
            {"codecs", codecsOf(2)},
            {"dimension_names", {"z", "y", "x"}},
            {"attributes", Json::object()}};
        if (row > 0) {
            expected["shape"].push_back(3);
            expected["chunk_grid"]["configuration"]["chunk_shape"].push_back(3);
            expected["dimension_names"].push_back("byte");
        }
        EXPECT_EQ(documentOf(folder / "zarr.json"), expected) << row;
        const auto valueAt = [](std::size_t x, std::size_t y, std::size_t z, std::size_t n) {
            return static_cast<std::uint16_t>(1 + x + 10 * y + 100 * z + 1000 * n);
        };
        for (int layer = 0; layer < spec.layers(); ++layer) {
            std::vector<std::uint16_t> slices;
            for (std::size_t z = 0; z < 2; ++z)
                for (std::size_t y = 0; y < 5; ++y)
                    for (std::size_t x = 0; x < 7; ++x)
                        for (std::size_t n = 0; n < each; ++n)
                            slices.push_back(valueAt(x, y, z + 2 * static_cast<std::size_t>(layer), n));
            writeArrayLayer(folder, spec, layer, std::as_bytes(std::span(slices)));
            std::vector<std::uint16_t> read(slices.size());
            readArrayLayer(openFolder(scratch.path()), std::to_string(row), spec, layer,
                           std::as_writable_bytes(std::span(read)), scratch.path());
            EXPECT_EQ(read, slices) << row << ", " << layer;
        }
        EXPECT_NO_THROW(
            checkArrayMetadata(openFolder(scratch.path()), std::to_string(row), spec, scratch.path()));
        std::vector<std::uint16_t> raw(24 * each);
        for (std::size_t k = 0; k < 2; ++k)
            for (std::size_t j = 0; j < 2; ++j)
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::string name = "c/" + std::to_string(k) + "/" + std::to_string(j) + "/" +
                                             std::to_string(i) + (row > 0 ? "/0" : "");
                    const std::string encoded = fileText(folder / name);
                    ASSERT_FALSE(encoded.empty()) << name;
                    decodeChunk(std::as_bytes(std::span(encoded)), std::as_writable_bytes(std::span(raw)),
                                name);
                    for (std::size_t at = 0; at < raw.size(); ++at) {
                        const std::size_t n = at % each, x = 3 * i + at / each % 3,
                                          y = 4 * j + at / each / 3 % 4, z = 2 * k + at / each / 12;
                        EXPECT_EQ(raw[at], x < 7 && y < 5 ? valueAt(x, y, z, n) : 0) << name << ", " << at;
                    }
                }
        const auto files = fs::recursive_directory_iterator(folder);
        EXPECT_EQ(std::count_if(begin(files), end(files),
                                [](const auto& entry) { return entry.is_regular_file(); }),
                  13);
    }
}

/// Sealed again, as no damage is: each value at its bound, and beyond it.
class SealedStore : public testing::Test {
  protected:
    void SetUp() override {
        VolumeInfo info = plainInfo({33, 4, 3}, ValueType::u8);
        info.nonFiniteVoxels = 1;
        HashSource source(info, [](int x, int y, int z) { return 10 + x + y + z; });
        import(path, source);
        document = documentOf(path / "zarr.json");
        ram.emplace("RAM", "--ram", kPlenty);
    }
    /// Why a store with another value is refused; "" where it is taken. What OME says follows from the rest,
    /// and is compared last.
    std::string with(const std::string& key, const Json& value) {
        Json other = document;
        other["attributes"]["tessera"][Json::json_pointer(key)] = value;
        seal(other);
        setFileText(path / "zarr.json", other.dump());
        try {
            StoreReader(path, *ram);
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    }
    ScratchFolder scratch;
    fs::path path = scratch / "v.zarr";
    Json document;
    std::optional<MemoryBudget> ram;
};

TEST_F(SealedStore, NumbersUpToTheirBounds) {
    const auto expectInteger = [&](const std::string& key, std::int64_t low, std::int64_t high) {
        const std::string said = "zarr.json: expected /attributes/tessera" + key + " to be an integer from " +
                                 std::to_string(low) + " to " + std::to_string(high);
        for (const Json& beyond : {Json(low - 1), Json(0.5), Json("1"), Json(true), Json(~std::uint64_t{0})})
            EXPECT_THAT(with(key, beyond), HasSubstr(said)) << key << beyond;
        if (high < std::numeric_limits<std::int64_t>::max()) {
            EXPECT_THAT(with(key, high + 1), HasSubstr(said)) << key;
        }
        for (const std::int64_t at : {low, high})
            EXPECT_THAT(with(key, at), testing::Not(HasSubstr(said))) << key << at;
        Json other = document;
        Json& holder = other["attributes"]["tessera"][Json::json_pointer(key).parent_pointer()];
        if (!holder.is_array()) {
            holder.erase(Json::json_pointer(key).back());
            seal(other);
            setFileText(path / "zarr.json", other.dump());
            EXPECT_THAT([&] { StoreReader(path, *ram); },
                        testing::ThrowsMessage<InputError>(
                            HasSubstr("expected the key /attributes/tessera" + key + ", found none")));
        }
    };
    expectInteger("/version", 1, INT32_MAX);
    for (const char* axis : {"0", "1", "2"}) {
        expectInteger(std::string("/extentVoxels/") + axis, 1, 1 << 30);
        expectInteger(std::string("/originalOrder/sourceAxis/") + axis, 0, 2);
    }
    expectInteger("/nonFiniteVoxels", 0, std::numeric_limits<std::int64_t>::max());
    expectInteger("/clampedVoxels", 0, std::numeric_limits<std::int64_t>::max());
    EXPECT_THAT(with("/version", 2), HasSubstr("expected store version 1, found 2"));
    EXPECT_EQ(with("/clampedVoxels", 5), "");
    EXPECT_EQ(with("/clampedVoxels", std::numeric_limits<std::int64_t>::max()), "");
    for (const char* key : {"/levels/0/shards/0/0"}) // one shard of 2 x 1 x 1 chunks
        for (const auto& [count, isCount] : {std::pair(2, true), {3, false}, {-1, false}})
            EXPECT_EQ(with(key, count).find("to be an integer from 0 to 2") == std::string::npos, isCount)
                << count;
    for (const char* key : {"/levels/0/shards/0/1", "/levels/0/shards/0/2"}) {
        EXPECT_EQ(with(key, 0xFFFFFFFFu).find("to be an integer"), std::string::npos);
        EXPECT_THAT(with(key, std::uint64_t{0x100000000}),
                    HasSubstr("to be an integer from 0 to 4294967295"));
    }
    EXPECT_THAT(with("/levels/0/shards", Json::array()),
                HasSubstr("/attributes/tessera/levels/0/shards to hold 1 shards, found 0"));
    EXPECT_THAT(with("/levels/3/shards/0", {1, 2}), HasSubstr("/levels/3/shards/0 to be three numbers"));
}

TEST_F(SealedStore, ValuesThatAreStorable) {
    EXPECT_EQ(with("/rescale/intercept", 5.5), "");
    EXPECT_THAT(with("/rescale/slope", 0), HasSubstr("slope"));
    for (const char* key : {"/rescale/slope", "/rescale/intercept", "/acquisition/tubeVoltageKv",
                            "/acquisition/sliceThicknessMm", "/fillStored", "/patientFromVoxel/1/2",
                            "/range/lowest", "/absentStored"})
        EXPECT_THAT(with(key, "1"),
                    HasSubstr(std::string("/attributes/tessera") + key + " to be a finite number"))
            << key;
    for (const char* key :
         {"/unit", "/valueType", "/acquisition/modality", "/acquisition/kernel", "/levelRule"})
        EXPECT_THAT(with(key, 1), HasSubstr(std::string("/attributes/tessera") + key + " to be a text"))
            << key;
    for (const char* key :
         {"/originalOrder/flipped/0", "/originalOrder/flipped/2", "/lossy", "/orientationKnown"})
        EXPECT_THAT(with(key, 1),
                    HasSubstr(std::string("/attributes/tessera") + key + " to be true or false"))
            << key;
    EXPECT_THAT(with("/valueType", "int32"),
                HasSubstr("a value type uint8, int16, uint16 or float32, found 'int32'"));
    EXPECT_THAT(with("/levelRule", "max"), HasSubstr("/levelRule to be '"));
    for (const double fill : {256.0, -1.0, 0.5})
        EXPECT_THAT(with("/fillStored", fill), HasSubstr("a fill value that uint8 can hold")) << fill;
    for (const auto& [lowest, highest] : {std::pair(0.0, 256.0), {-1.0, 5.0}, {6.0, 5.0}, {0.5, 5.0}}) {
        Json range = {{"lowest", lowest}, {"highest", highest}};
        EXPECT_THAT(with("/range", range), HasSubstr("a range of values of the stored type")) << range;
    }
    for (const char* at : {"/patientFromVoxel/3/0", "/patientFromVoxel/3/1", "/patientFromVoxel/3/2"})
        EXPECT_THAT(with(at, 1), HasSubstr("an affine whose last row is 0 0 0 1")) << at;
    EXPECT_THAT(with("/patientFromVoxel/3/3", 2), HasSubstr("last row"));
    for (const auto& [key, value, said] : std::vector<std::tuple<std::string, double, std::string>>{
             {"/patientFromVoxel/0/0", 1e9, ""},
             {"/patientFromVoxel/1/1", 1.1e9,
              "a voxel spacing from 1e-9 to 1e9 mm, found 1.1e+09 mm along axis 1"},
             {"/patientFromVoxel/2/2", 1e-9, ""},
             {"/patientFromVoxel/2/2", 0.9e-9, "mm along axis 2"},
             {"/patientFromVoxel/0/3", 1e18, ""},
             {"/patientFromVoxel/0/3", -1.1e18, "a first voxel within 1e18 mm of the origin"},
             {"/patientFromVoxel/2/3", 1.1e18, "a first voxel within 1e18 mm of the origin"}}) {
        // Places follow from the affine: where it is taken, only what OME says is another.
        const std::string found = with(key, value);
        EXPECT_THAT(found, said.empty() ? HasSubstr("/attributes/ome/") : HasSubstr(said)) << key << value;
    }
}

TEST_F(SealedStore, TextsAreShortAndPlain) {
    VolumeInfo info = plainInfo({2, 2, 2}, ValueType::u8);
    for (int n = 0; n < 17; ++n)
        info.remarks.push_back(std::string(1, static_cast<char>('a' + n)));
    info.remarks[0] = std::string(301, 'r');
    info.remarks[1] = " ~\x1f\x7f";
    info.unit = std::string(16, 'u');
    info.acquisition.modality = std::string(65, 'm');
    HashSource source(info);
    import(scratch / "t.zarr", source);
    const VolumeInfo found = StoreReader(scratch / "t.zarr", *ram).info();
    ASSERT_EQ(found.remarks.size(), 16u);
    EXPECT_EQ(found.remarks[0], std::string(300, 'r'));
    EXPECT_EQ(found.remarks[1], " ~??");
    EXPECT_EQ(found.remarks[15], "p");
    EXPECT_EQ(found.unit, info.unit);
    EXPECT_EQ(found.acquisition.modality, std::string(64, 'm'));
}

} // namespace
} // namespace tessera
