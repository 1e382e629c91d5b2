// tests/bricking/labels/refused_zarr_test.cpp: labels in Zarr that are damaged, lie, or are beyond what is
// taken.
#include "bricking/import/labels/open_labels.h"
#include "tests/support/label_tools.h"
#include "tests/support/refusals.h"
#include "tests/support/zarr_label_image.h"

#include <filesystem>
#include <functional>

namespace tessera::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class RefusedZarr : public testing::Test {
  protected:
    void SetUp() override { write(); }
    void write() {
        std::filesystem::remove_all(folder / "a.zarr");
        WrittenZarr zarr;
        zarr.compressor = compressor;
        writeLabels(folder / "a.zarr", zarr, zarrLabelValues(7 * 11 * 13),
                    multiscaleOf("zyx", {1, 1, 1}, {0, 0, 0}), "cells",
                    {{"colors", Json::array({Json{{"label-value", 1}, {"rgba", {1, 2, 3, 4}}}})},
                     {"properties", Json::array({Json{{"label-value", 1}, {"name", "a"}}})}});
    }
    std::string refusalWith(const std::filesystem::path& file, const std::function<void(Json&)>& change) {
        Json document = Json::parse(readBytes(folder / "a.zarr" / file));
        const std::string before = document.dump();
        change(document);
        writeBytes(folder / "a.zarr" / file, document.dump());
        const std::string said = refusalOfReading(folder / "a.zarr");
        writeBytes(folder / "a.zarr" / file, before);
        EXPECT_TRUE(said.empty() || said.find((folder / "a.zarr").string()) != std::string::npos) << said;
        return said;
    }
    const std::filesystem::path folder = labelTestFolder(), image = "labels/cells/zarr.json",
                                array = "labels/cells/0/zarr.json", chunk = "labels/cells/0/c/1/1/1";
    std::string compressor = "zstd";
};

TEST_F(RefusedZarr, DamagedChunks) {
    for (const char* kind : {"none", "blosc", "zstd", "gzip"}) {
        compressor = kind;
        write();
        ASSERT_EQ(refusalOfReading(folder / "a.zarr"), "");
        const auto path = folder / "a.zarr" / chunk;
        const std::string whole = readBytes(path);
        for (const std::string& bytes :
             {whole.substr(0, whole.size() - 3), whole.substr(0, 5), std::string(), std::string(40, 'x'),
              whole + whole.substr(0, 100), std::string(200000, '\0')}) {
            writeBytes(path, bytes);
            EXPECT_THAT(refusalOfReading(folder / "a.zarr"), HasSubstr(path.string()))
                << kind << " " << bytes.size();
        }
        writeBytes(path, whole);
        // Chunks that are whole, and of another size than the array says.
        EXPECT_THAT(refusalWith(array,
                                [](Json& a) {
                                    a["chunk_grid"]["configuration"]["chunk_shape"] = {3, 4, 6};
                                }),
                    HasSubstr("bytes"))
            << kind;
        EXPECT_THAT(refusalWith(array, [](Json& a) { a["data_type"] = "uint32"; }), HasSubstr("bytes"))
            << kind;
    }
}

TEST_F(RefusedZarr, LinksThatMetadataName) {
    for (const char* name : {"labels", "labels/cells", "labels/cells/0"}) {
        write();
        const auto path = folder / "a.zarr" / name, moved = folder / "moved";
        std::filesystem::remove_all(moved);
        std::filesystem::rename(path, moved);
        std::filesystem::create_directory_symlink(moved, path);
        EXPECT_THAT(refusalOfReading(folder / "a.zarr"), HasSubstr(path.string() + ": expected a folder"));
    }
}

TEST_F(RefusedZarr, LyingMetadata) {
    using Lie = std::pair<const char*, std::function<void(Json&)>>;
    const auto grid = [](Json& a) -> Json& { return a["chunk_grid"]["configuration"]["chunk_shape"]; };
    for (const auto& [said, change] :
         std::vector<Lie>{{"shape",
                           [](Json& a) {
                               a["shape"] = {7, 11};
                           }},
                          {"shape",
                           [](Json& a) {
                               a["shape"] = {7, 0, 13};
                           }},
                          {"shape",
                           [](Json& a) {
                               a["shape"] = {7, -2, 13};
                           }},
                          {"shape",
                           [](Json& a) {
                               a["shape"] = {7, 11, 5000000000};
                           }},
                          {"shape", [](Json& a) { a["shape"] = "7"; }},
                          {"2^62",
                           [](Json& a) {
                               a["shape"] = {1073741824, 1073741824, 1073741824};
                           }},
                          {"1 GiB",
                           [&](Json& a) {
                               grid(a) = {1073741824, 1073741824, 1073741824};
                           }},
                          {"chunk_shape",
                           [&](Json& a) {
                               grid(a) = {3, 4};
                           }},
                          {"chunk_shape",
                           [&](Json& a) {
                               grid(a) = {3, 0, 5};
                           }},
                          {"numbers", [](Json& a) { a["data_type"] = "float16"; }},
                          {"data_type", [](Json& a) { a["data_type"] = "complex64"; }},
                          {"codecs", [](Json& a) { a["codecs"][1]["name"] = "bz2"; }},
                          {"codecs", [](Json& a) { a["codecs"] = Json::array(); }},
                          {"endian", [](Json& a) { a["codecs"][0].erase("configuration"); }},
                          {"fill_value", [](Json& a) { a["fill_value"] = 65536; }},
                          {"fill_value", [](Json& a) { a["fill_value"] = "NaN"; }},
                          {"name", [](Json& a) { a["chunk_grid"]["name"] = "rectangular"; }},
                          {"zarr_format", [](Json& a) { a["zarr_format"] = 4; }},
                          {"array", [](Json& a) { a["node_type"] = "group"; }}})
        EXPECT_THAT(refusalWith(array, change), HasSubstr(said));
    const auto scales = [](Json& i) -> Json& { return i["attributes"]["ome"]["multiscales"][0]; };
    const auto label = [](Json& i) -> Json& { return i["attributes"]["ome"]["image-label"]; };
    for (const auto& [said, change] : std::vector<Lie>{
             {"multiscales", [](Json& i) { i["attributes"]["ome"].erase("multiscales"); }},
             {"multiscales", [](Json& i) { i["attributes"]["ome"]["multiscales"] = Json::array(); }},
             {"version", [](Json& i) { i["attributes"]["ome"]["version"] = "0.6"; }},
             {"axes", [&](Json& i) { scales(i).erase("axes"); }},
             {"axes",
              [&](Json& i) {
                  scales(i)["axes"] = {"z", "y", "x"};
              }},
             {"a list of 2 numbers", [&](Json& i) { scales(i)["axes"].erase(0); }},
             {"different names", [&](Json& i) { scales(i)["axes"][0]["name"] = "y"; }},
             {"three axes of space",
              [&](Json& i) {
                  scales(i)["axes"][0] = {{"name", "t"}, {"type", "time"}};
              }},
             {"datasets", [&](Json& i) { scales(i)["datasets"] = Json::array(); }},
             {"a path below", [&](Json& i) { scales(i)["datasets"][0]["path"] = "../../../.."; }},
             {"a path below", [&](Json& i) { scales(i)["datasets"][0]["path"] = "/etc"; }},
             {"no Zarr there", [&](Json& i) { scales(i)["datasets"][0]["path"] = "9"; }},
             {"scale",
              [&](Json& i) {
                  scales(i)["datasets"][0]["coordinateTransformations"][0]["scale"] = {1, 0, 1};
              }},
             {"scale",
              [&](Json& i) {
                  scales(i)["datasets"][0]["coordinateTransformations"][0]["scale"] = {1, 1};
              }},
             {"type",
              [&](Json& i) { scales(i)["datasets"][0]["coordinateTransformations"][0]["type"] = "affine"; }},
             {"no scale", [&](Json& i) { scales(i)["datasets"][0].erase("coordinateTransformations"); }},
             {"\"pixel\"", [&](Json& i) { scales(i)["axes"][0]["unit"] = "pixel"; }},
             {"rgba",
              [&](Json& i) {
                  label(i)["colors"][0]["rgba"] = {1, 2, 3};
              }},
             {"rgba",
              [&](Json& i) {
                  label(i)["colors"][0]["rgba"] = {1, 2, 256, 3};
              }},
             {"rgba", [&](Json& i) { label(i)["colors"][0]["rgba"] = "red"; }},
             {"label-value", [&](Json& i) { label(i)["colors"][0]["label-value"] = -1; }},
             {"label-value", [&](Json& i) { label(i)["colors"][0]["label-value"] = 1.5; }},
             {"every label once", [&](Json& i) { label(i)["colors"].push_back(label(i)["colors"][0]); }},
             {"colors", [&](Json& i) { label(i)["colors"] = 7; }},
             {"properties",
              [&](Json& i) {
                  label(i)["properties"] = {1, 2};
              }},
             {"image-label", [&](Json& i) { i["attributes"]["ome"]["image-label"] = 3; }}})
        EXPECT_THAT(refusalWith(image, change), HasSubstr(said));
    const std::filesystem::path list = "labels/zarr.json";
    EXPECT_THAT(refusalWith(list, [](Json& l) { l["attributes"]["ome"]["labels"] = Json::array(); }),
                HasSubstr("empty list"));
    EXPECT_THAT(refusalWith(list, [](Json& l) { l["attributes"]["ome"]["labels"] = {"../.."}; }),
                HasSubstr("a path below"));
    EXPECT_THAT(refusalWith(list, [](Json& l) { l["attributes"]["ome"]["labels"] = {"other"}; }),
                HasSubstr("no Zarr there"));
    EXPECT_THAT(refusalWith(list, [](Json& l) { l["attributes"]["ome"].erase("labels"); }),
                HasSubstr("a list \"labels\""));
    for (const char* text : {"{\"zarr_format\": 3,", "[3]"}) {
        writeBytes(folder / "a.zarr" / image, text);
        EXPECT_THAT(refusalOfReading(folder / "a.zarr"),
                    AllOf(HasSubstr("JSON"), HasSubstr((folder / "a.zarr" / image).string())));
    }
}

/// Lists and numbers up to the last that is taken.
TEST_F(RefusedZarr, BoundsOfMetadata) {
    const auto ofImage = [&](const std::function<void(Json&)>& change) {
        return refusalWith(image, [&](Json& i) { change(i["attributes"]["ome"]["multiscales"][0]); });
    };
    const auto firstScale = [](Json& s) -> Json& {
        return s["datasets"][0]["coordinateTransformations"][0]["scale"];
    };
    const auto firstTranslation = [](Json& s) -> Json& {
        return s["datasets"][0]["coordinateTransformations"][1]["translation"];
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const double scale : {1e12, 0.0, -1.0})
            EXPECT_THAT(ofImage([&](Json& s) { firstScale(s)[axis] = scale; }),
                        HasSubstr("scales above 0, at most 1e12"))
                << scale;
        for (const double far : {1e15, -1e15})
            EXPECT_THAT(ofImage([&](Json& s) { firstTranslation(s)[axis] = far; }),
                        HasSubstr("translations of at most 1e15"))
                << far;
        EXPECT_THAT(ofImage([&](Json& s) { firstScale(s)[axis] = 0.999e12; }),
                    testing::Not(HasSubstr("scales above 0")));
        EXPECT_THAT(ofImage([&](Json& s) { firstTranslation(s)[axis] = -0.999e15; }),
                    testing::Not(HasSubstr("translations of at most")));
    }
    const auto repeated = [](Json& list, std::size_t count) {
        const Json last = list.back();
        while (list.size() < count)
            list.push_back(last);
    };
    for (const auto& [count, isTaken] : {std::pair(16u, true), {17u, false}})
        EXPECT_EQ(ofImage([&, n = count](Json& s) {
                      s["datasets"][0]["coordinateTransformations"].push_back({{"type", "identity"}});
                      repeated(s["datasets"][0]["coordinateTransformations"], n);
                  }).empty(),
                  isTaken)
            << count;
    for (const auto& [count, isTaken] : {std::pair(64u, true), {65u, false}})
        EXPECT_EQ(ofImage([&, n = count](Json& s) { repeated(s["datasets"], n); }).empty(), isTaken) << count;
    // Codecs, axes and chunks of shards.
    const auto ofArray = [&](const std::function<void(Json&)>& change) { return refusalWith(array, change); };
    for (const auto& [type, low, high] :
         std::vector<std::tuple<const char*, std::int64_t, std::int64_t>>{{"int8", -128, 127},
                                                                          {"uint8", 0, 255},
                                                                          {"int16", -32768, 32767},
                                                                          {"uint16", 0, 65535},
                                                                          {"int32", -2147483648, 2147483647},
                                                                          {"uint32", 0, 4294967295}}) {
        for (const std::int64_t fill : {low, high})
            EXPECT_THAT(ofArray([&, t = type](Json& a) { a["data_type"] = t, a["fill_value"] = fill; }),
                        testing::Not(HasSubstr("fill_value")))
                << type << fill;
        for (const std::int64_t fill : {low - 1, high + 1})
            EXPECT_THAT(ofArray([&, t = type](Json& a) { a["data_type"] = t, a["fill_value"] = fill; }),
                        AllOf(HasSubstr("fill_value"), HasSubstr(std::string("a value of ") + type)))
                << type << fill;
    }
    EXPECT_THAT(ofArray([](Json& a) {
                    a["dimension_names"] = {"z", "y"};
                }),
                HasSubstr("a name for each axis"));
    EXPECT_EQ(ofArray([](Json& a) { a["dimension_names"] = {"z", "y", nullptr}; }), "");
    EXPECT_THAT(ofArray([](Json& a) { a["storage_transformers"] = {1}; }), HasSubstr("storage_transformers"));
    EXPECT_EQ(ofArray([](Json& a) { a["storage_transformers"] = Json::array(); }), "");
    EXPECT_THAT(ofArray([](Json& a) { a["codecs"].push_back("zstd"); }),
                HasSubstr("one of blosc, zstd and gzip"));
    EXPECT_THAT(ofArray([](Json& a) { a["codecs"].insert(a["codecs"].begin(), Json("crc32c")); }),
                HasSubstr("transpose, bytes, then"));
    EXPECT_THAT(ofArray([](Json& a) { a["codecs"].erase(0); }), HasSubstr("codecs"));
    for (const Json& order : {Json{0, 1, 1}, Json{0, 1, 3}, Json{0, -1, 2}, Json{0, 1, 1.5}})
        EXPECT_THAT(ofArray([&](Json& a) {
                        a["codecs"].insert(a["codecs"].begin(), Json{{"name", "transpose"},
                                                                     {"configuration", {{"order", order}}}});
                    }),
                    HasSubstr("every axis once"))
            << order;
}

TEST_F(RefusedZarr, ShardsAndVersion2) {
    WrittenZarr zarr;
    zarr.shape = kShape;
    zarr.chunk = {3, 4, 5};
    zarr.shard = {6, 8, 10};
    zarr.compressor = "blosc";
    zarr.hasCrc = true;
    writeZarrArray(folder / "s", zarr, zarrLabelValues(7 * 11 * 13));
    const auto shard = folder / "s/c/0/0/0";
    const std::string whole = readBytes(shard);
    for (const std::size_t flipped :
         {std::size_t{9}, whole.size() / 3, whole.size() - 40, whole.size() - 1}) {
        std::string bytes = whole;
        bytes[flipped] = static_cast<char>(bytes[flipped] ^ 4);
        writeBytes(shard, bytes);
        EXPECT_THAT(refusalOfReading(folder / "s"), HasSubstr(shard.string())) << flipped;
    }
    writeBytes(shard, whole.substr(0, 60));
    EXPECT_THAT(refusalOfReading(folder / "s"), HasSubstr("cut short"));
    for (const Json& index : {Json::array({"bytes"}), Json::array({"crc32c", "bytes"}),
                              Json::array({"bytes", "zstd"}), Json::array({"transpose", "crc32c"})}) {
        Json document = arrayMetadata(zarr);
        document["codecs"][0]["configuration"]["index_codecs"] = index;
        writeBytes(folder / "s/zarr.json", document.dump());
        EXPECT_THAT(refusalOfReading(folder / "s"), HasSubstr("index_codecs")) << index;
    }
    WrittenZarr two;
    two.version = 2;
    two.shape = kShape;
    two.chunk = {3, 4, 5};
    two.compressor = "zlib";
    for (const auto& [key, value] :
         std::vector<std::pair<std::string, Json>>{{"filters", Json::array({Json{{"id", "delta"}}})},
                                                   {"compressor", Json{{"id", "lzma"}}},
                                                   {"dtype", "<f2"},
                                                   {"dtype", "<M8[ns]"},
                                                   {"dtype", Json::array({"a"})},
                                                   {"order", "Z"},
                                                   {"zarr_format", 1},
                                                   {"chunks", Json::array({3, 4})},
                                                   {"dimension_separator", "-"}}) {
        Json metadata = arrayMetadata(two);
        metadata[key] = value;
        writeZarrArray(folder / "v2", two, zarrLabelValues(7 * 11 * 13));
        writeBytes(folder / "v2/.zarray", metadata.dump());
        EXPECT_THAT(refusalOfReading(folder / "v2"), AllOf(HasSubstr(".zarray"), HasSubstr(key)));
    }
}

} // namespace
} // namespace tessera::test
