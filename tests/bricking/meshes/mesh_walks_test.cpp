// tests/bricking/meshes/mesh_walks_test.cpp: the walks over files of meshes: what they count, and each rule
// by which they refuse, at the last value that is taken and the first that is not.
#include "bricking/import/meshes/mesh_walk.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"

#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::EndsWith;
using ::testing::HasSubstr;

template <class T> std::string packedBytes(T value, bool big = false) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return big ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

class MeshWalks : public ::testing::Test {
  protected:
    /// "points triangles exact", or why it is refused.
    template <class Walk> std::string outcome(Walk walk, const std::string& name, const std::string& bytes) {
        std::ofstream(folder / name, std::ios::binary) << bytes;
        try {
            const MeshCounts counts = walk(InputFile(folder / name));
            return std::to_string(counts.points) + " " + std::to_string(counts.triangles) +
                   (counts.exact ? " exact" : "");
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(folder.path().string()));
            return error.what();
        }
    }
    std::string ply(const std::string& bytes) { return outcome(walkPly, "a.ply", bytes); }
    std::string stl(const std::string& bytes) { return outcome(walkStl, "a.stl", bytes); }
    std::string obj(const std::string& bytes) { return outcome(walkObj, "a.obj", bytes); }
    std::string gltf(const json& document) { return outcome(walkGltf, "a.gltf", document.dump()); }
    ScratchFolder folder;
};

const std::string kPlyEnd = "property float x\nproperty float y\nproperty float z\nelement face 2\n"
                            "property list uchar int vertex_indices\nend_header\n";

TEST_F(MeshWalks, PlyOfText) {
    const std::string head = "ply\nformat ascii 1.0\ncomment any words\nobj_info more\n\nelement vertex 4\n" +
                             kPlyEnd,
                      points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n", faces = "3 0 1 2\n4 0 1 2 3\n";
    EXPECT_EQ(ply(head + points + faces), "4 3 exact");
    EXPECT_EQ(ply(head + points + "3 0 1 2\r\n4\t0  1 2 3\r\n"), "4 3 exact");
    for (const auto& [text, said] : std::vector<std::pair<std::string, std::string>>{
             {"3 0 1 2\n2 0 1\n", "faces of 3 to 255 corners, found 2"},
             {"3 0 1 2\n256 0 1 2\n", "faces of 3 to 255 corners, found 256"},
             {"3 0 1 2\n-3 0 1 2\n", "faces of 3 to 255 corners, found -3"},
             {"3 0 1 4\n3 0 1 2\n", "numbers of vertices below 4, found 4"},
             {"3 0 1 2\n3 0 -1 2\n", "numbers of vertices below 4, found -1"},
             {"3 0 1 2\n3 0 1\n", "another number in a line, found its end"},
             {"3 0 1 2\n3 0 1 2 3\n", "lines of element face with 4 numbers, found one with 5"},
             {"3 0 1 2\n3 0 1.5 2\n", "a whole number, found \"1.5\""},
             {"3 0 1 2            \n", "2 of element face, found the end of the file"}})
        EXPECT_THAT(ply(head + points + text), HasSubstr(said)) << text;
    std::string fan = "255";
    for (int n = 0; n < 255; ++n)
        fan += " " + std::to_string(n % 4);
    EXPECT_EQ(ply(head + points + "3 0 1 2\n" + fan + "\n"), "4 254 exact");
    const std::string longest(4000 - 5, ' ');
    EXPECT_EQ(ply(head + points + "3 0 1" + longest.substr(2) + " 2\n4 0 1 2 3\n"), "4 3 exact");
    EXPECT_THAT(ply(head + points + "3 0 1" + longest + " 2\n4 0 1 2 3\n"),
                HasSubstr("lines of at most 4000 bytes"));
}

TEST_F(MeshWalks, PlyHeaders) {
    const std::string body = "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n3 0 1 2\n";
    const auto with = [&](const std::string& from, const std::string& to, const std::string& data = "") {
        std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n" + kPlyEnd;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return ply(text.replace(at, from.size(), to) + (data.empty() ? body : data));
    };
    EXPECT_EQ(with("ply\n", "ply \n"), "3 2 exact");
    EXPECT_EQ(with("vertex_indices", "vertex_index"), "3 2 exact");
    EXPECT_EQ(with("int vertex", "uint16 vertex"), "3 2 exact");
    for (const auto& [from, to, said] : std::vector<std::tuple<std::string, std::string, std::string>>{
             {"ply\n", "ply 1\n", "a file that begins with \"ply\""},
             {"ply\n", "PLY\n", "a file that begins with \"ply\""},
             {"ascii", "utf8", "a format of PLY"},
             {"format ascii 1.0", "format ascii", "a header of PLY, found \"format ascii\""},
             {"element vertex 3", "element vertex", "a header of PLY"},
             {"element vertex 3", "element vertex 3x", "a number of elements, found \"3x\""},
             {"element vertex 3", "element vertex -3", "a number of elements"},
             {"element vertex 3", "property int i\nelement vertex 3", "a header of PLY"},
             {"element vertex", "element point", "elements vertex and face, in this order"},
             {"element face", "element edge", "elements vertex and face, in this order"},
             {"property float x\n", "", "vertices with x, y and z, found no x"},
             {"property float y", "property float w", "vertices with x, y and z, found no y"},
             {"property float z", "property list uchar float z", "vertices with x, y and z, found no z"},
             {"vertex_indices", "corners", "faces with a list vertex_indices"},
             {"uchar int vertex", "uchar float vertex", "faces with a list vertex_indices"},
             {"property list uchar int", "property int", "faces with a list vertex_indices"},
             {"list uchar", "list float", "property list of a whole number"},
             {"list uchar", "array uchar", "property list of a whole number"},
             {"float x", "real x", "a type of PLY, found \"real\""},
             {"end_header\n", "", "a header of PLY"},
             {"end_header", "end", "a header of PLY, found \"end\""}})
        EXPECT_THAT(with(from, to), HasSubstr(said)) << from << " -> " << to;
    std::string lines;
    for (int n = 0; n < 992; ++n) // nine others: the last is number 1000, from 0 on
        lines += "comment\n";
    EXPECT_EQ(with("element vertex", lines + "element vertex"), "3 2 exact");
    EXPECT_THAT(with("element vertex", lines + "comment\nelement vertex"),
                HasSubstr("a header of at most 1000 lines"));
    // Two bytes of text a number at least: what the file's rest cannot be is refused before it is read.
    const std::string told = " as its header tells, found 34 bytes behind the header";
    EXPECT_THAT(with("element vertex 3", "element vertex 6"), HasSubstr("6 of element vertex," + told));
    EXPECT_THAT(with("element vertex 3", "element vertex 5"), ::testing::Not(HasSubstr(told)));
    EXPECT_THAT(with("element face 2", "element face 18"), HasSubstr("18 of element face," + told));
    EXPECT_THAT(with("element face 2", "element face 17"), ::testing::Not(HasSubstr(told)));
    EXPECT_THAT(with("element face 2", "element nothing 3\nelement face 2"),
                HasSubstr("elements vertex and face"));
    EXPECT_EQ(with("end_header", "element edge 0\nproperty int a\nend_header"), "3 2 exact");
    EXPECT_THAT(with("end_header", "element edge 0\nend_header"), HasSubstr("0 of element edge"));
}

TEST_F(MeshWalks, PlyOfEveryTypeAndOrder) {
    for (const bool big : {false, true}) {
        const auto faces = [&](const char* count, const char* corner, const std::string& data) {
            std::string points;
            for (int n = 0; n < 9; ++n)
                points += packedBytes(static_cast<float>(n), big);
            return ply(std::string("ply\nformat binary_") + (big ? "big" : "little") +
                       "_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 1\nproperty double weight\nproperty list " +
                       count + " " + corner +
                       " vertex_indices\nproperty list ushort char flags\nend_header\n" + points +
                       packedBytes(0.5, big) + data + packedBytes(std::uint16_t{2}, big) + "ab");
        };
        const auto three = [&](auto count, auto corner) {
            using Count = decltype(count);
            using Corner = decltype(corner);
            return packedBytes(static_cast<Count>(3), big) + packedBytes(static_cast<Corner>(0), big) +
                   packedBytes(static_cast<Corner>(2), big) + packedBytes(corner, big);
        };
        for (const char* name : {"uchar", "uint8"})
            EXPECT_EQ(faces(name, name, three(std::uint8_t{}, std::uint8_t{1})), "3 1 exact") << name;
        for (const char* name : {"char", "int8"})
            EXPECT_EQ(faces(name, name, three(std::int8_t{}, std::int8_t{1})), "3 1 exact") << name;
        for (const char* name : {"ushort", "uint16"})
            EXPECT_EQ(faces(name, name, three(std::uint16_t{}, std::uint16_t{1})), "3 1 exact") << name;
        for (const char* name : {"short", "int16"})
            EXPECT_EQ(faces(name, name, three(std::int16_t{}, std::int16_t{1})), "3 1 exact") << name;
        for (const char* name : {"uint", "uint32"})
            EXPECT_EQ(faces(name, name, three(std::uint32_t{}, std::uint32_t{1})), "3 1 exact") << name;
        for (const char* name : {"int", "int32"})
            EXPECT_EQ(faces(name, name, three(std::int32_t{}, std::int32_t{1})), "3 1 exact") << name;
        // The sign, and every byte.
        EXPECT_THAT(faces("uchar", "char", three(std::uint8_t{}, std::int8_t{-1})),
                    HasSubstr("below 3, found -1"));
        EXPECT_THAT(faces("uchar", "uchar", three(std::uint8_t{}, std::uint8_t{255})),
                    HasSubstr("below 3, found 255"));
        EXPECT_THAT(faces("uchar", "short", three(std::uint8_t{}, std::int16_t{-2})), HasSubstr("found -2"));
        EXPECT_THAT(faces("uchar", "ushort", three(std::uint8_t{}, std::uint16_t{0x8001})),
                    HasSubstr("found 32769"));
        EXPECT_THAT(faces("uchar", "int", three(std::uint8_t{}, std::int32_t{0x01020304})),
                    HasSubstr("found 16909060"));
        EXPECT_THAT(faces("uchar", "int", three(std::uint8_t{}, std::int32_t{-5})), HasSubstr("found -5"));
        EXPECT_THAT(faces("uchar", "uint", three(std::uint8_t{}, std::uint32_t{0xFFFFFFFF})),
                    HasSubstr("found 4294967295"));
        EXPECT_THAT(faces("uchar", "uchar", std::string("\2\0\1", 3) + std::string(9, '\0')),
                    HasSubstr("faces of 3 to 255 corners, found 2"));
    }
}

TEST_F(MeshWalks, Stl) {
    const auto binary = [](std::uint32_t told, std::size_t triangles) {
        return std::string(80, '\1') + packedBytes(told) + std::string(50 * triangles, '\0');
    };
    EXPECT_EQ(stl(binary(3, 3)), "9 3 exact");
    EXPECT_EQ(stl(binary(0x201, 0x201)), "1539 513 exact");
    EXPECT_EQ(stl(binary(0, 0)), "0 0 exact");
    EXPECT_THAT(stl(binary(3, 3) + "x"),
                EndsWith("expected 234 bytes of the 3 triangles that its header tells, found 235 bytes"));
    EXPECT_THAT(stl(binary(0x01000000, 0)), HasSubstr("838860884 bytes of the 16777216 triangles"));
    EXPECT_THAT(stl(binary(0, 0).substr(0, 83)),
                EndsWith("the 84 bytes that a binary STL begins with, found 83 bytes"));
    const std::string facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    EXPECT_EQ(stl("solid\n" + facet + "\t\n" + facet + "endsolid\n"), "6 2 exact");
    EXPECT_THAT(stl("solid\n" + facet + facet),
                EndsWith("found 2 facets, 6 vertices, 2 ends of facets, and no endsolid"));
    EXPECT_THAT(stl("solid\n" + facet + "endsolid\n" + facet), EndsWith("and no endsolid"));
    EXPECT_THAT(stl("solid\n" + facet + "vertex 0 0 0\nendsolid\n"),
                EndsWith("found 1 facets, 4 vertices, 1 ends of facets"));
    EXPECT_THAT(stl("solid\n" + facet + "endfacet\nendsolid\n"),
                EndsWith("found 1 facets, 3 vertices, 2 ends of facets"));
    EXPECT_THAT(stl("solid\n" + facet + "facet\nendsolid\n"),
                EndsWith("found 2 facets, 3 vertices, 1 ends of facets"));
    EXPECT_THAT(stl("solid\nvertex 1 2\nendsolid\n"),
                HasSubstr("expected vertex X Y Z, found \"vertex 1 2\""));
    EXPECT_THAT(stl("solid\nvertex 1 2 3 4\nendsolid\n"), HasSubstr("expected vertex X Y Z"));
    EXPECT_EQ(stl("solid " + std::string(994, 'n') + "\n" + facet + "endsolid\n"), "3 1 exact");
    EXPECT_THAT(stl("solid " + std::string(995, 'n') + "\n" + facet + "endsolid\n"),
                HasSubstr("lines of at most 1000 bytes"));
}

TEST_F(MeshWalks, Obj) {
    const std::string points = "v 0 0 0\nv 1 0 0 0.5\nv 0 1 0\nv 1 1 1\nvn 0 0 1\nvn 1 0 0\nvt 0 0\n";
    EXPECT_EQ(obj("# words\n" + points +
                  "f 1 2 3\nf 1/1 2/1 3/1 4/1\nf 1//2 2//1 3//1\nf -1/-1/-2 -2/1/2 -4/1/1\ng part\n"),
              "4 5");
    EXPECT_EQ(obj(points + "f 1 2 3\nv 0 0 0\nf 5 4 3 2 1"), "5 4");
    for (const auto& [face, most] : std::vector<std::pair<std::string, int>>{{"f 1 2 5", 4},
                                                                             {"f 1 2 -5", 4},
                                                                             {"f 0 1 2", 4},
                                                                             {"f 1 2 x", 4},
                                                                             {"f 1 2 3x", 4},
                                                                             {"f /1 2 3", 4},
                                                                             {"f 1/2 2 3", 1},
                                                                             {"f 1/-2 2 3", 1},
                                                                             {"f 1/0 2 3", 1},
                                                                             {"f 1/1/3 2 3", 2},
                                                                             {"f 1//3 2 3", 2},
                                                                             {"f 1 2 3//-3", 2}})
        EXPECT_THAT(
            obj(points + face + "\nv 0 0 0\n"),
            EndsWith("a face of numbers from 1 to " + std::to_string(most) + ", found \"" + face + "\""))
            << face;
    EXPECT_THAT(obj(points + "f 1 2\n"), HasSubstr("a face of three corners at least"));
    for (const char* point : {"v 0 0", "v 0 0 x", "v nan 0 0", "v 0 inf 0", "v 0 0 1e999", "v 1x 0 0"})
        EXPECT_THAT(obj(std::string(point) + "\n"),
                    HasSubstr("expected v X Y Z, found \"" + std::string(point)))
            << point;
    EXPECT_THAT(obj("v 0 0 \\\n0\n"), HasSubstr("lines that end where they end"));
    EXPECT_EQ(obj("#" + std::string(999, 'c') + "\n"), "0 0");
    EXPECT_THAT(obj("#" + std::string(1000, 'c') + "\n"), HasSubstr("lines of at most 1000 bytes"));
}

/// A quad: positions of 12 bytes each with a stride of 16, normals, and indices of 16 bits.
json quad() {
    return json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1, 2]}, {"mesh": 0}, {"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}, {"mode": 1, "attributes": {}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4},
                      {"bufferView": 0, "byteOffset": 4, "componentType": 5121, "type": "VEC4", "count": 4},
                      {"bufferView": 1, "byteOffset": 2, "componentType": 5123, "type": "SCALAR", "count": 6}],
        "bufferViews": [{"buffer": 0, "byteLength": 60, "byteStride": 16}, {"buffer": 0, "byteOffset": 60, "byteLength": 14}],
        "buffers": [{"uri": "a.bin", "byteLength": 74}]})");
}

TEST_F(MeshWalks, GltfRanges) {
    std::ofstream(folder / "a.bin", std::ios::binary) << std::string(74, '\0');
    const auto with = [&](const std::string& pointer, const json& value) {
        json document = quad();
        document[json::json_pointer(pointer)] = value;
        return gltf(document);
    };
    const auto without = [&](const std::string& parent, const std::string& key) {
        json document = quad();
        document[json::json_pointer(parent)].erase(key);
        return gltf(document);
    };
    EXPECT_EQ(gltf(quad()), "8 4");
    for (const auto& [pointer, value, said] : std::vector<std::tuple<std::string, json, std::string>>{
             {"/asset/version", "2.1", ""},
             {"/asset/version", "20", "expected glTF 2"},
             {"/asset/version", 2, "a version"},
             {"/images", json::array(), ""},
             {"/images", {1}, "a document without images"},
             {"/skins", {1}, "a document without skins"},
             {"/extensionsRequired", {"any"}, "a document without extensionsRequired"},
             // Buffers, views, accessors: up to what holds them.
             {"/buffers/0/byteLength", 75, "buffers of at most 74 bytes, which are there, found 75"},
             {"/buffers/0/byteLength", 73, "views of a buffer's 73 bytes, found one up to 74"},
             {"/buffers/0/uri", 1, "a buffer's uri"},
             {"/buffers/0/uri", "", "buffers in this file, or in files of its folder"},
             {"/buffers/0/uri", "../a.bin",
              "buffers in this file, or in files of its folder, found \"../a.bin\""},
             {"/buffers/0/uri", "c:a.bin", "buffers in this file"},
             {"/buffers/0/uri", "d\\a.bin", "buffers in this file"},
             {"/buffers/0/uri", "none.bin", "none.bin"},
             {"/buffers/0/uri", "data:x," + std::string(100, 'A'), ""}, // 75 bytes
             {"/buffers/0/uri", "data:x," + std::string(96, 'A'), "at most 72 bytes"},
             {"/buffers/1", {{"byteLength", 0}}, "the binary chunk as the first buffer"},
             {"/bufferViews/1/byteLength", 15, "views of a buffer's 74 bytes, found one up to 75"},
             {"/bufferViews/1/byteOffset", 61, "up to 75"},
             {"/bufferViews/0/byteStride", 252,
              "accessors of at most a view's 60 bytes, found 4 items of 12"},
             {"/bufferViews/0/byteStride", 253, "views of a buffer's 74 bytes, found one up to 60"},
             {"/bufferViews/0/byteStride", 0, "accessors of at most a view's 60 bytes"},
             {"/bufferViews/0/byteStride", 17, "accessors of at most a view's 60 bytes"},
             {"/bufferViews/0/byteStride", 15, ""},
             {"/bufferViews/0/buffer", 1, "buffers below 1, found 1"},
             {"/accessors/0/byteOffset", 1, "accessors of at most a view's 60 bytes, found 4 items of 12"},
             {"/accessors/1/byteOffset", 8, ""},
             {"/accessors/1/byteOffset", 9, "found 4 items of 4"},
             {"/accessors/2/byteOffset", 3, "accessors of at most a view's 14 bytes, found 6 items of 2"},
             {"/accessors/2/count", 7, "7 items of 2"},
             {"/accessors/2/count", 0, "0 items of 2"},
             {"/accessors/2/count", -1, "a whole number \"count\", found -1"},
             {"/accessors/2/count", 1099511627777, "a whole number \"count\""},
             {"/accessors/2/count", 1099511627776, "1099511627776 items of 2"},
             {"/accessors/2/byteOffset", 15, "accessors of at most a view's 14 bytes"},
             {"/accessors/2/bufferView", 2, "bufferViews below 2, found 2"},
             {"/accessors/2/sparse", 1, "accessors of a view each, none sparse"},
             {"/accessors/2/componentType", 5124, "a componentType of glTF, found 5124"},
             {"/accessors/2/type", "VEC5", "a type of glTF"},
             // What is drawn.
             {"/accessors/0/componentType", 5125, "positions of three floats"},
             {"/accessors/1/count", 3, "as many of NORMAL as positions"},
             {"/accessors/2/componentType", 5122, "indices of whole numbers"},
             {"/accessors/2/componentType", 5121, ""},
             {"/meshes/0/primitives/0/indices", 0, "indices of whole numbers"},
             {"/meshes/0/primitives/0/indices", 3, "accessors below 3, found 3"},
             {"/meshes/0/primitives/0/attributes/NORMAL", 3, "accessors below 3, found 3"},
             {"/meshes/0/primitives/0/attributes/NORMAL", "x", "numbers of accessors"},
             {"/meshes/0/primitives/0/attributes/POSITION", 1, "positions of three floats"},
             // Nodes.
             {"/scene", 1, "scenes below 1, found 1"},
             {"/scenes/0/nodes/0", 3, "nodes below 3, found 3"},
             {"/scenes/0/nodes/0", "x", "numbers of nodes, found \"x\""},
             {"/nodes/1/mesh", 1, "meshes below 1, found 1"},
             {"/nodes/0/children/0", 3, "nodes below 3, found 3"},
             {"/nodes/0/children/0", "x", "numbers of nodes"},
             {"/nodes/0/children/0", 2, "nodes with one parent at most, found node 2 with two"},
             {"/nodes/1/children", {2}, "found node 2 with two"},
             {"/nodes/1/children", {0}, "nodes that are trees"}}) {
        const std::string found = with(pointer, value);
        EXPECT_TRUE(said.empty() ? found == "8 4" : found.find(said) != std::string::npos)
            << found << ": " << pointer << " " << value.dump().substr(0, 20);
    }
    EXPECT_THAT(without("/asset", "version"), HasSubstr("glTF with \"version\""));
    EXPECT_THAT(without("", "asset"), HasSubstr("glTF with \"asset\""));
    EXPECT_THAT(without("/accessors/2", "type"), HasSubstr("glTF with \"type\""));
    EXPECT_THAT(without("/accessors/2", "bufferView"), HasSubstr("accessors of a view each"));
    EXPECT_THAT(without("/meshes/0", "primitives"), HasSubstr("glTF with \"primitives\""));
    EXPECT_THAT(without("/meshes/0/primitives/0", "attributes"), HasSubstr("glTF with \"attributes\""));
    EXPECT_THAT(without("/meshes/0/primitives/0/attributes", "POSITION"), HasSubstr("accessors below 3"));
    EXPECT_THAT(without("", "buffers"), HasSubstr("buffers below 0, found 0"));
    EXPECT_EQ(without("", "scene"), "8 4");
    // Corners: two triangles of six indices, four of a strip, one and a third of four points.
    EXPECT_EQ(with("/meshes/0/primitives/0/mode", 4), "8 4");
    EXPECT_EQ(with("/meshes/0/primitives/0/mode", 5), "8 12") << "at most";
    EXPECT_EQ(with("/meshes/0/primitives/0/mode", 3), "0 0") << "lines";
    EXPECT_EQ(without("/meshes/0/primitives/0", "indices"), "8 2");
    EXPECT_EQ(with("/nodes/2", json::object()), "4 2");
}

/// Bytes of an item: of each componentType, as many as its type has.
TEST_F(MeshWalks, GltfItemsOfEveryType) {
    std::ofstream(folder / "a.bin", std::ios::binary) << std::string(74, '\0');
    for (const auto& [component, each] :
         {std::pair(5120, 1), {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}})
        for (const auto& [type, count] : {std::pair("SCALAR", 1),
                                          {"VEC2", 2},
                                          {"VEC3", 3},
                                          {"VEC4", 4},
                                          {"MAT2", 4},
                                          {"MAT3", 9},
                                          {"MAT4", 16}}) {
            json document = quad();
            json& view = document["bufferViews"][2] = {{"buffer", 0}, {"byteLength", each * count}};
            document["accessors"][3] = {
                {"bufferView", 2}, {"componentType", component}, {"type", type}, {"count", 1}};
            EXPECT_EQ(gltf(document), "8 4") << component << type;
            document["accessors"][3]["count"] = 2;
            EXPECT_THAT(gltf(document), HasSubstr("2 items of " + std::to_string(each * count)))
                << component << type;
            view["byteLength"] = each * count - 1;
            document["accessors"][3]["count"] = 1;
            EXPECT_THAT(gltf(document), HasSubstr("1 items of " + std::to_string(each * count)))
                << component << type;
        }
}

TEST_F(MeshWalks, GltfNodesAreSixtyFourDeepAtMost) {
    std::ofstream(folder / "a.bin", std::ios::binary) << std::string(74, '\0');
    const auto deep = [&](int nodes) {
        json document = quad();
        document["nodes"] = json::array();
        for (int n = 0; n < nodes; ++n)
            document["nodes"].push_back({{"children", json::array({n + 1})}});
        document["nodes"].push_back({{"mesh", 0}});
        return gltf(document);
    };
    EXPECT_EQ(deep(1), "4 2");
    EXPECT_EQ(deep(64), "4 2");
    EXPECT_THAT(deep(65), HasSubstr("nodes at most 64 deep"));
    json document = quad();
    document["nodes"] = json::array();
    for (int n = 0; n < 100000; ++n)
        document["nodes"].push_back(json::object());
    EXPECT_EQ(gltf(document), "0 0");
    document["nodes"].push_back(json::object());
    EXPECT_THAT(gltf(document), HasSubstr("a list \"nodes\" of at most 100000"));
}

/// Binary: a header of 12 bytes, a chunk of JSON, and one of the first buffer.
TEST_F(MeshWalks, Glb) {
    json document = quad();
    document["buffers"][0].erase("uri");
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto size = [](std::size_t n) { return packedBytes(static_cast<std::uint32_t>(n)); };
    const auto glb = [&](std::uint32_t version, long more, std::size_t length, const std::string& kind,
                         const std::string& rest) {
        return outcome(
            walkGltf, "a.glb",
            "glTF" + size(version) +
                size(static_cast<std::size_t>(20 + static_cast<long>(text.size() + rest.size()) + more)) +
                size(length) + kind + text + rest);
    };
    const std::string bin = size(74) + std::string("BIN\0", 4) + std::string(74, '\0');
    EXPECT_EQ(glb(2, 0, text.size(), "JSON", bin), "8 4");
    EXPECT_THAT(glb(1, 0, text.size(), "JSON", bin),
                HasSubstr("expected binary glTF 2 of " + std::to_string(20 + text.size() + bin.size()) +
                          " bytes, found version 1 of"));
    for (const long more : {1L, -1L})
        EXPECT_THAT(glb(2, more, text.size(), "JSON", bin),
                    HasSubstr("version 2 of " +
                              std::to_string(20 + static_cast<long>(text.size() + bin.size()) + more)));
    EXPECT_THAT(glb(2, 0, text.size(), "JSOX", bin), HasSubstr("a chunk of JSON first"));
    EXPECT_THAT(glb(2, 0, text.size() + bin.size() + 1, "JSON", bin), HasSubstr("a chunk of JSON first"));
    EXPECT_THAT(glb(2, 0, text.size(), "JSON", size(73) + bin.substr(4)),
                HasSubstr("buffers of at most 73 bytes"));
    EXPECT_THAT(glb(2, 0, text.size(), "JSON", size(75) + bin.substr(4)),
                HasSubstr("a binary chunk of 74 bytes, found 75"));
    EXPECT_THAT(glb(2, 0, text.size(), "JSON", size(74) + "BIN " + bin.substr(8)),
                HasSubstr("a binary chunk"));
    EXPECT_THAT(glb(2, 0, text.size(), "JSON", ""), HasSubstr("buffers of at most 0 bytes"));
    EXPECT_THAT(outcome(walkGltf, "a.glb", "glTF" + std::string(15, '\0')),
                EndsWith("expected glTF, found 19 bytes"));
}

} // namespace
} // namespace tessera::test
