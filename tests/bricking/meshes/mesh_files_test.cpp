// tests/bricking/meshes/mesh_files_test.cpp: meshes of files: what is read, and what is refused before
// anything is allocated for it.
#include "bricking/import/meshes/mesh_file.h"
#include "core/base/error.h"
#include "tests/support/mesh_shapes.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <sstream>

namespace tessera {
namespace {

using namespace tessera::test;
using testing::AllOf;
using testing::HasSubstr;

template <typename T> std::string bytesOf(T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}
std::string bytesOf(const glm::vec3& v) {
    return bytesOf(v.x) + bytesOf(v.y) + bytesOf(v.z);
}
std::string words(const glm::vec3& v) {
    std::ostringstream text;
    text.precision(9);
    text << v.x << " " << v.y << " " << v.z;
    return text.str();
}

std::string plyHead(const std::string& format, std::size_t points, std::size_t faces,
                    const std::string& list = "uchar int") {
    return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(points) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
           "\nproperty list " + list + " vertex_indices\nend_header\n";
}
std::string plyText(const TriangleMesh& mesh) {
    std::string text = plyHead("ascii", mesh.points.size(), mesh.triangles.size());
    for (const glm::vec3& p : mesh.points)
        text += words(p) + "\n";
    for (const glm::uvec3& t : mesh.triangles)
        text += "3 " + std::to_string(t.x) + " " + std::to_string(t.y) + " " + std::to_string(t.z) + "\n";
    return text;
}
std::string plyBinary(const TriangleMesh& mesh) {
    std::string bytes = plyHead("binary_little_endian", mesh.points.size(), mesh.triangles.size());
    for (const glm::vec3& p : mesh.points)
        bytes += bytesOf(p);
    for (const glm::uvec3& t : mesh.triangles)
        bytes += '\3' + bytesOf(t.x) + bytesOf(t.y) + bytesOf(t.z);
    return bytes;
}
std::string stlBinary(const TriangleMesh& mesh) {
    std::string bytes(80, '\0');
    bytes += bytesOf(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const glm::uvec3& t : mesh.triangles) {
        bytes += bytesOf(glm::vec3(0));
        for (int n = 0; n < 3; ++n)
            bytes += bytesOf(mesh.points[t[n]]);
        bytes += std::string(2, '\0');
    }
    return bytes;
}
std::string stlText(const TriangleMesh& mesh) {
    std::string text = "solid it\n";
    for (const glm::uvec3& t : mesh.triangles) {
        text += "facet normal 0 0 1\nouter loop\n";
        for (int n = 0; n < 3; ++n)
            text += "vertex " + words(mesh.points[t[n]]) + "\n";
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid it\n";
}
std::string objText(const TriangleMesh& mesh) {
    std::string text = "# a mesh\n";
    for (const glm::vec3& p : mesh.points)
        text += "v " + words(p) + "\n";
    for (const glm::uvec3& t : mesh.triangles)
        text += "f " + std::to_string(t.x + 1) + " " + std::to_string(t.y + 1) + " " +
                std::to_string(t.z + 1) + "\n";
    return text;
}
/// @param document  of the buffer's bytes of points and of indices
std::string glb(const TriangleMesh& mesh,
                const std::function<std::string(std::size_t, std::size_t)>& document = {}) {
    std::string points, indices;
    for (const glm::vec3& p : mesh.points)
        points += bytesOf(p);
    for (const glm::uvec3& t : mesh.triangles)
        indices += bytesOf(t.x) + bytesOf(t.y) + bytesOf(t.z);
    const auto own = [&](std::size_t p, std::size_t i) {
        return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
               R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
               R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
               std::to_string(p / 12) + R"(},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" +
               std::to_string(i / 4) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(p) +
               R"(},{"buffer":0,"byteOffset":)" + std::to_string(p) + R"(,"byteLength":)" +
               std::to_string(i) + R"(}],"buffers":[{"byteLength":)" + std::to_string(p + i) + "}]}";
    };
    std::string json =
        document ? document(points.size(), indices.size()) : own(points.size(), indices.size());
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto size = [](std::size_t n) { return bytesOf(static_cast<std::uint32_t>(n)); };
    return "glTF" + size(2) + size(12 + 8 + json.size() + 8 + points.size() + indices.size()) +
           size(json.size()) + "JSON" + json + size(points.size() + indices.size()) +
           std::string("BIN\0", 4) + points + indices;
}

class MeshFiles : public testing::Test {
  protected:
    void SetUp() override {
        const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  ("tessera-meshes-" + std::string(test->name()) + "-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path file(const std::string& name, const std::string& bytes) const {
        const std::filesystem::path path = folder_ / name;
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }
    TriangleMesh read(const std::string& name, const std::string& bytes) {
        return readMesh(file(name, bytes), ram_);
    }
    /// The message; "" where it is read.
    std::string refusal(const std::string& name, const std::string& bytes) {
        try {
            read(name, bytes);
        } catch (const InputError& e) {
            EXPECT_THAT(e.what(), HasSubstr(name));
            return e.what();
        }
        return "";
    }

    std::filesystem::path folder_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{64} << 20};
};

/// Corners of the triangles, in order.
std::vector<glm::vec3> corners(const TriangleMesh& mesh) {
    std::vector<glm::vec3> list;
    for (const glm::uvec3& t : mesh.triangles)
        for (int n = 0; n < 3; ++n)
            list.push_back(mesh.points[t[n]]);
    return list;
}

TEST_F(MeshFiles, EveryFormatHasTheSameTriangles) {
    const TriangleMesh mesh = sphereMesh({10, -20, 30.5}, 12, 9);
    for (const auto& [name, bytes] :
         std::vector<std::pair<std::string, std::string>>{{"a.ply", plyText(mesh)},
                                                          {"b.PLY", plyBinary(mesh)},
                                                          {"c.stl", stlBinary(mesh)},
                                                          {"d.stl", stlText(mesh)},
                                                          {"e.obj", objText(mesh)},
                                                          {"f.glb", glb(mesh)}}) {
        const TriangleMesh got = read(name, bytes);
        EXPECT_EQ(corners(got), corners(mesh)) << name;
        EXPECT_TRUE(got.normals.empty()) << name;
    }
    EXPECT_EQ(ram_.usedBytes(), 0u);
}

TEST_F(MeshFiles, NodesOfGltfMoveTheirMeshes) {
    const TriangleMesh mesh = quadMesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const auto document = [](std::size_t, std::size_t) {
        return std::string(
            R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
            R"("nodes":[{"children":[1,2],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]},{"mesh":0,"translation":[0,5,0]}],)"
            R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
            R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4},)"
            R"({"bufferView":1,"componentType":5125,"type":"SCALAR","count":6}],)"
            R"("bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],)"
            R"("buffers":[{"byteLength":72}]})");
    };
    const TriangleMesh got = read("a.glb", glb(mesh, document));
    ASSERT_EQ(got.triangles.size(), 4u);
    const auto list = corners(got);
    EXPECT_THAT(list, testing::Contains(glm::vec3(12, 2, 0)));
    EXPECT_THAT(list, testing::Contains(glm::vec3(11, 6, 0)));
    EXPECT_THAT(list, testing::Not(testing::Contains(glm::vec3(1, 1, 0))));
}

TEST_F(MeshFiles, NormalsAndPolygonsAreTaken) {
    const std::string obj = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvn 0 0 2\nf 1//1 2//1 3//1 4//1\n";
    const TriangleMesh got = read("a.obj", obj);
    EXPECT_EQ(got.triangles.size(), 2u);
    ASSERT_EQ(got.normals.size(), got.points.size());
    for (const glm::vec3& n : got.normals)
        EXPECT_EQ(n, glm::vec3(0, 0, 1));
}

TEST_F(MeshFiles, NoTriangles) {
    TriangleMesh none = sphereMesh({0, 0, 0}, 1, 4);
    none.triangles.clear();
    for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
             {"c.stl", stlBinary(none)}, {"d.stl", stlText(none)}, {"e.obj", objText(none)}})
        EXPECT_THAT(refusal(name, bytes), HasSubstr("expected triangles, found none")) << name;
    const std::string shortest =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0";
    // Of PLY they are points; so is a file that names no faces.
    EXPECT_EQ(read("a.ply", plyText(none)).points, none.points);
    EXPECT_EQ(read("b.ply", plyBinary(none)).points, none.points);
    EXPECT_EQ(read("f.ply", shortest).points.size(), 3u);
    const std::size_t faces = shortest.find("element face"), header = shortest.find("end_header");
    const std::string alone = shortest.substr(0, faces) + shortest.substr(header);
    EXPECT_EQ(read("p.ply", alone).points, read("f.ply", shortest).points);
    EXPECT_THAT(refusal("q.ply", alone.substr(0, alone.size() - 6)), HasSubstr("element vertex"));
    std::string empty = alone;
    empty.replace(empty.find("vertex 3"), 8, "vertex 0");
    EXPECT_THAT(refusal("e.ply", empty.substr(0, empty.find("0 0 0"))),
                HasSubstr("expected triangles, found none"));
    EXPECT_NE(refusal("empty.ply", ""), "");
    EXPECT_NE(refusal("empty.stl", ""), "");
    EXPECT_NE(refusal("empty.obj", ""), "");
    EXPECT_NE(refusal("empty.glb", ""), "");
    EXPECT_THAT(refusal("a.vtk", "x"), HasSubstr("expected a mesh that ends in .ply"));
}

// What a header tells is no reason to allocate: the budget is smaller than any of these, and untouched.
TEST_F(MeshFiles, CountsThatTheFileDoesNotHold) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 4);
    const std::string hundredMillion = "100000000";
    std::string ply = plyBinary(mesh);
    const std::string faces = "element face " + std::to_string(mesh.triangles.size());
    ply.replace(ply.find(faces), faces.size(), "element face " + hundredMillion);
    EXPECT_THAT(refusal("a.ply", ply),
                AllOf(HasSubstr("100000000 of element face"), HasSubstr("bytes behind the header")));
    std::string points = plyText(mesh);
    const std::string vertices = "element vertex " + std::to_string(mesh.points.size());
    points.replace(points.find(vertices), vertices.size(), "element vertex 99999999999999999999");
    EXPECT_THAT(refusal("b.ply", points), HasSubstr("a number of elements"));
    std::string stl = stlBinary(mesh);
    stl.replace(80, 4, bytesOf(std::uint32_t{100000000}));
    EXPECT_THAT(refusal("c.stl", stl),
                AllOf(HasSubstr("100000000 triangles"), HasSubstr(std::to_string(stl.size()) + " bytes")));
    std::string list = plyHead("binary_little_endian", 3, 1, "int int");
    for (int n = 0; n < 3; ++n)
        list += bytesOf(glm::vec3(static_cast<float>(n), 0, 0));
    list += bytesOf(std::int32_t{2000000000}) + std::string(64, '\0');
    EXPECT_THAT(refusal("d.ply", list), HasSubstr("faces of 3 to 255 corners, found 2000000000"));
    EXPECT_LT(ram_.peakBytes(), std::size_t{1} << 20);
}

TEST_F(MeshFiles, BudgetsHold) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 40);
    MemoryBudget small("RAM", "--ram", 1 << 16);
    const auto path = file("a.ply", plyBinary(mesh));
    EXPECT_THROW(readMesh(path, small), InputError);
    EXPECT_EQ(small.usedBytes(), 0u);
}

TEST_F(MeshFiles, NumbersThatAreNone) {
    TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 4);
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 2e6f, -1e30f}) {
        mesh.points[5].y = bad;
        for (const auto& [name, bytes] :
             std::vector<std::pair<std::string, std::string>>{{"a.ply", plyText(mesh)},
                                                              {"b.ply", plyBinary(mesh)},
                                                              {"c.stl", stlBinary(mesh)},
                                                              {"e.obj", objText(mesh)},
                                                              {"f.glb", glb(mesh)}})
            EXPECT_NE(refusal(name, bytes), "") << name << " " << bad;
    }
}

TEST_F(MeshFiles, NumbersOfPointsThatAreNotThere) {
    TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 4);
    for (const std::uint32_t bad :
         {static_cast<std::uint32_t>(mesh.points.size()), 0x7fffffffu, 0xffffffffu}) {
        mesh.triangles[7].y = bad;
        for (const auto& [name, bytes] :
             std::vector<std::pair<std::string, std::string>>{{"a.ply", plyText(mesh)},
                                                              {"b.ply", plyBinary(mesh)},
                                                              {"e.obj", objText(mesh)},
                                                              {"f.glb", glb(mesh)}})
            EXPECT_NE(refusal(name, bytes), "") << name << " " << bad;
    }
    EXPECT_NE(refusal("negative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"), "");
    EXPECT_NE(refusal("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"), "");
}

TEST_F(MeshFiles, EveryPrefixIsRefused) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 3);
    for (const auto& [name, bytes] :
         std::vector<std::pair<std::string, std::string>>{{"a.ply", plyText(mesh)},
                                                          {"b.ply", plyBinary(mesh)},
                                                          {"c.stl", stlBinary(mesh)},
                                                          {"d.stl", stlText(mesh)},
                                                          {"f.glb", glb(mesh)}})
        for (std::size_t size = 0; size + 4 < bytes.size(); size += 1 + size / 40)
            EXPECT_NE(refusal(name, bytes.substr(0, size)), "") << name << " of " << size << " bytes";
}

// Bytes that changed are read or refused; nothing else happens, and no budget is passed.
TEST_F(MeshFiles, RandomDamage) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 4);
    std::mt19937 random(1);
    int refused = 0;
    for (const auto& [name, bytes] :
         std::vector<std::pair<std::string, std::string>>{{"a.ply", plyText(mesh)},
                                                          {"b.ply", plyBinary(mesh)},
                                                          {"c.stl", stlBinary(mesh)},
                                                          {"d.stl", stlText(mesh)},
                                                          {"e.obj", objText(mesh)},
                                                          {"f.glb", glb(mesh)}})
        for (int n = 0; n < 120; ++n) {
            std::string damaged = bytes;
            for (int k = 0; k <= n % 3; ++k) {
                const std::size_t reach = n % 2 ? std::min<std::size_t>(damaged.size(), 500) : damaged.size();
                damaged[random() % reach] = static_cast<char>(random());
            }
            refused += !refusal(name, damaged).empty();
        }
    EXPECT_GT(refused, 100);
    EXPECT_EQ(ram_.usedBytes(), 0u);
}

TEST_F(MeshFiles, GltfWithMoreThanItHolds) {
    const TriangleMesh mesh = quadMesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const std::string whole =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4},)"
        R"({"bufferView":1,"componentType":5125,"type":"SCALAR","count":6}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],)"
        R"("buffers":[{"byteLength":72}]})";
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string json = whole;
        EXPECT_NE(json.find(from), std::string::npos) << from;
        json.replace(json.find(from), from.size(), to);
        return refusal("a.glb", glb(mesh, [&](std::size_t, std::size_t) { return json; }));
    };
    EXPECT_EQ(with("\"mesh\":0", "\"mesh\":0"), "");
    EXPECT_THAT(with(R"("count":4)", R"("count":100000000)"), HasSubstr("100000000 items"));
    EXPECT_NE(with(R"("count":6)", R"("count":7)"), "");
    EXPECT_NE(with(R"("byteOffset":48)", R"("byteOffset":49)"), "");
    EXPECT_NE(with(R"("buffers":[{"byteLength":72})", R"("buffers":[{"byteLength":73})"), "");
    EXPECT_NE(with(R"("buffers":[{"byteLength":72})", R"("buffers":[{"uri":"/etc/hostname","byteLength":7})"),
              "");
    EXPECT_NE(with(R"("buffers":[{"byteLength":72})", R"("buffers":[{"uri":"a.glb.bin","byteLength":72})"),
              "");
    EXPECT_THAT(with(R"("buffers":[{"byteLength":72})", R"("buffers":[{"byteLength":72},{"byteLength":7})"),
                HasSubstr("the binary chunk as the first buffer"));
    EXPECT_NE(with(R"({"mesh":0})", R"({"mesh":0,"children":[0]})"), "") << "a ring";
    EXPECT_NE(with(R"({"mesh":0})", R"({"mesh":1})"), "");
    EXPECT_NE(with(R"("POSITION":0)", R"("POSITION":2)"), "");
    EXPECT_NE(with(R"("indices":1)", R"("indices":0)"), "");
    EXPECT_NE(with("\"version\":\"2.0\"", "\"version\":\"1.0\""), "");
    EXPECT_NE(with(R"({"asset")", R"({"extensionsRequired":["KHR_draco_mesh_compression"],"asset")"), "");
}

} // namespace
} // namespace tessera
