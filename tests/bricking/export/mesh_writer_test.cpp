// tests/bricking/export/mesh_writer_test.cpp: meshes that are written: read back by this program's readers,
// byte by byte where others count on it, and what is left where writing fails.
#include "bricking/export/meshes/mesh_writer.h"
#include "bricking/import/meshes/mesh_file.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "tests/support/mesh_shapes.h"

#include <csignal>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class MeshWriting : public ::testing::Test {
  protected:
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(folder_.path()))
            all.push_back(entry.path().filename());
        std::ranges::sort(all);
        return all;
    }
    std::string bytesOf(const std::string& name) const {
        std::ifstream file(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    std::uint64_t write(const std::string& name, const TriangleMesh& mesh,
                        const std::string& about = "a mesh") {
        MeshWriter writer(folder_ / name, about, ram_);
        put(mesh, writer);
        return writer.finish();
    }
    static void put(const TriangleMesh& mesh, MeshWriter& writer) {
        for (const glm::vec3& p : mesh.points)
            writer.point(p);
        for (const glm::uvec3& t : mesh.triangles)
            writer.triangle({t.x, t.y, t.z}, {glm::dvec3(mesh.points[t.x]), glm::dvec3(mesh.points[t.y]),
                                              glm::dvec3(mesh.points[t.z])});
    }
    ScratchFolder folder_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{512} << 20};
};

/// Large enough that buffers are written more than once.
TriangleMesh ball() {
    return sphereMesh({-123.456, 7.1, 1001.25}, 60, 180);
}

TEST_F(MeshWriting, IsReadBackAsItWas) {
    const TriangleMesh mesh = ball();
    for (const std::string& ending : meshFileEndings()) {
        SCOPED_TRACE(ending);
        const std::uint64_t bytes = write("m" + ending, mesh, std::string(300, 'x') + "\n");
        EXPECT_EQ(bytes, fs::file_size(folder_ / ("m" + ending)));
        const TriangleMesh back = readMesh(folder_ / ("m" + ending), ram_);
        ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
        if (ending != ".stl") {
            EXPECT_EQ(back.points, mesh.points);
            EXPECT_EQ(back.triangles, mesh.triangles);
        }
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int i = 0; i < 3; ++i)
                ASSERT_EQ(back.points[back.triangles[t][i]], mesh.points[mesh.triangles[t][i]]);
    }
    EXPECT_EQ(names().size(), meshFileEndings().size());
}

TEST_F(MeshWriting, HeadsHaveWhatOthersCountOn) {
    const TriangleMesh mesh = quadMesh(glm::dvec3(0), {1, 0, 0}, {0, 2, 0});
    write("m.ply", mesh, "isosurface of 5 \xc2\xb5m\nend_header");
    const std::string ply = bytesOf("m.ply");
    EXPECT_EQ(ply.find("ply\nformat binary_little_endian 1.0\ncomment isosurface of 5 ??m?end_header\n"), 0u);
    EXPECT_THAT(ply, HasSubstr("\nelement vertex 4\n"));
    EXPECT_THAT(ply, HasSubstr("\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"));
    EXPECT_EQ(ply.size(), 512u + 4 * 12 + 2 * 13);
    write("m.stl", mesh);
    const std::string stl = bytesOf("m.stl");
    ASSERT_EQ(stl.size(), 84u + 2 * 50);
    EXPECT_NE(stl.substr(0, 5), "solid");
    float normal[3];
    std::memcpy(normal, stl.data() + 84, sizeof normal);
    EXPECT_EQ(normal[2], 1) << "the corners turn to the left, seen from the tip of the normal";
    write("m.obj", mesh);
    const std::string obj = bytesOf("m.obj");
    EXPECT_EQ(obj.find("# a mesh\n# 4 points, 2 triangles"), 0u);
    EXPECT_THAT(obj, HasSubstr("\nv 1 2 0\n"));
    EXPECT_TRUE(obj.ends_with("f 1 2 3\nf 1 3 4\n"));
    write("m.glb", mesh);
    const std::string glb = bytesOf("m.glb");
    std::uint32_t words[5];
    std::memcpy(words, glb.data(), sizeof words);
    EXPECT_EQ(words[0], 0x46546C67u);
    EXPECT_EQ(words[2], glb.size());
    EXPECT_EQ(words[3] % 4, 0u);
    EXPECT_THAT(glb, HasSubstr(R"("max":[1.0,2.0,0.0],"min":[0.0,0.0,0.0])"));
}

template <class T> T numberAt(const std::string& bytes, std::size_t at) {
    T value{};
    EXPECT_LE(at + sizeof value, bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// Each format whole, of two triangles whose normal is that of the patient's front. Bounds are on both sides
/// of 0.
TEST_F(MeshWriting, FilesAreTheseBytes) {
    const TriangleMesh mesh = quadMesh({3, -5, 7}, {1, 0, 0}, {0, 0, 2});
    const std::vector<std::uint32_t> numbers = {0, 1, 2, 0, 2, 3};
    write("m.glb", mesh);
    const std::string glb = bytesOf("m.glb");
    constexpr std::size_t kJson = 2028, kBinary = 4 * 12 + 6 * 4;
    ASSERT_EQ(glb.size(), 12 + 8 + kJson + 8 + kBinary);
    EXPECT_EQ(glb.substr(0, 4), "glTF");
    EXPECT_EQ(numberAt<std::uint32_t>(glb, 4), 2u);
    EXPECT_EQ(numberAt<std::uint32_t>(glb, 8), glb.size());
    EXPECT_EQ(numberAt<std::uint32_t>(glb, 12), kJson);
    EXPECT_EQ(glb.substr(16, 4), "JSON");
    EXPECT_EQ(nlohmann::json::parse(glb.substr(20, kJson)), nlohmann::json::parse(R"({
        "asset": {"version": "2.0", "generator": "Tessera", "extras": {"about": "a mesh"}},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                       "min": [3.0, -5.0, 7.0], "max": [4.0, -5.0, 9.0]},
                      {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48, "target": 34962},
                        {"buffer": 0, "byteOffset": 48, "byteLength": 24, "target": 34963}],
        "buffers": [{"byteLength": 72}]})"));
    EXPECT_EQ(numberAt<std::uint32_t>(glb, 20 + kJson), kBinary);
    EXPECT_EQ(glb.substr(24 + kJson, 4), std::string("BIN\0", 4));
    const std::size_t body = 28 + kJson;
    for (std::size_t n = 0; n < 4; ++n)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_EQ(numberAt<float>(glb, body + 12 * n + 4 * axis), mesh.points[n][static_cast<int>(axis)]);
    for (std::size_t n = 0; n < numbers.size(); ++n)
        EXPECT_EQ(numberAt<std::uint32_t>(glb, body + 48 + 4 * n), numbers[n]);

    write("m.stl", mesh);
    const std::string stl = bytesOf("m.stl");
    ASSERT_EQ(stl.size(), 84u + 2 * 50);
    EXPECT_EQ(stl.substr(0, 80), "a mesh" + std::string(74, ' '));
    EXPECT_EQ(numberAt<std::uint32_t>(stl, 80), 2u);
    for (std::size_t t = 0; t < 2; ++t) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(numberAt<float>(stl, 84 + 50 * t + 4 * axis), axis == 1 ? -1 : 0) << "the normal";
            for (std::size_t corner = 0; corner < 3; ++corner)
                EXPECT_EQ(numberAt<float>(stl, 96 + 50 * t + 12 * corner + 4 * axis),
                          mesh.points[numbers[3 * t + corner]][static_cast<int>(axis)]);
        }
        EXPECT_EQ(numberAt<std::uint16_t>(stl, 84 + 50 * t + 48), 0);
    }

    write("m.obj", mesh);
    EXPECT_EQ(bytesOf("m.obj"), "# a mesh\n# 4 points, 2 triangles" + std::string(223, ' ') +
                                    "\nv 3 -5 7\nv 4 -5 7\nv 4 -5 9\nv 3 -5 9\nf 1 2 3\nf 1 3 4\n");

    write("m.ply", mesh);
    const std::string ply = bytesOf("m.ply");
    ASSERT_EQ(ply.size(), 512u + 4 * 12 + 2 * 13);
    for (std::size_t n = 0; n < 4; ++n)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_EQ(numberAt<float>(ply, 512 + 12 * n + 4 * axis), mesh.points[n][static_cast<int>(axis)]);
    for (std::size_t n = 0; n < numbers.size(); ++n)
        EXPECT_EQ(numberAt<std::uint32_t>(ply, 512 + 48 + 13 * (n / 3) + 1 + 4 * (n % 3)), numbers[n]);
    EXPECT_EQ(ply[512 + 48], 3);
    EXPECT_EQ(ply[512 + 48 + 13], 3);
}

TEST_F(MeshWriting, RefusesOtherFilesBeforeAnythingIsDone) {
    const auto refuses = [&](const fs::path& path, const std::string& words) {
        EXPECT_THAT([&] { checkMeshFile(path); }, ThrowsMessage<InputError>(HasSubstr(words)));
        EXPECT_THAT([&] { MeshWriter(path, "", ram_); }, ThrowsMessage<InputError>(HasSubstr(words)));
    };
    refuses(folder_ / "m.vtk", "a mesh to write that ends in .ply, .stl, .obj, .glb, found \".vtk\"");
    refuses(folder_ / "m", "found \"\"");
    refuses(folder_ / "no" / "m.ply", "an existing folder to write in");
    fs::create_directory(folder_ / "m.ply");
    refuses(folder_ / "m.ply", "found a folder");
    EXPECT_NO_THROW(checkMeshFile(folder_ / "M.STL"));
    MemoryBudget little("RAM", "--ram", 1 << 20);
    EXPECT_THROW(MeshWriter(folder_ / "n.ply", "", little), InputError);
    EXPECT_EQ(names(), std::vector<std::string>{"m.ply"});
}

TEST_F(MeshWriting, NothingIsLeftOfAMeshThatEndsEarly) {
    std::ofstream(folder_ / "m.ply") << "before";
    {
        MeshWriter writer(folder_ / "m.ply", "", ram_);
        put(ball(), writer);
        EXPECT_EQ(names().size(), 2u) << "an unfinished file, and none for the triangles";
    }
    EXPECT_EQ(bytesOf("m.ply"), "before");
    EXPECT_EQ(names(), std::vector<std::string>{"m.ply"});
    // a disk that is full after 2 MiB, of either part
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    ::signal(SIGXFSZ, SIG_IGN);
    for (const rlim_t bytes : {rlim_t{1} << 19, rlim_t{2} << 20}) {
        const rlimit limit{bytes, before.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        EXPECT_THROW(write("m.stl", ball()), Error);
        EXPECT_THROW(write("m.obj", ball()), Error);
        EXPECT_THROW(write("m.glb", sphereMesh({0, 0, 0}, 1, 250)), Error);
        ::setrlimit(RLIMIT_FSIZE, &before);
        EXPECT_EQ(names(), std::vector<std::string>{"m.ply"});
    }
}

} // namespace
} // namespace tessera::test
