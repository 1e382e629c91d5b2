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
