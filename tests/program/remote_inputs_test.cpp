// tests/program/remote_inputs_test.cpp: labels and meshes behind addresses, by option and by scene: the
// picture is that of the same files on a disk; what is refused.
#include "core/image/image_file.h"
#include "tests/support/http_server.h"
#include "tests/support/program_fixture.h"

#include <cstdlib>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class RemoteInputs : public Program {
  protected:
    void SetUp() override {
        ASSERT_EQ(run("phantom ramp --size 12x10x8 -o a.zarr").exitCode, 0);
        fs::create_directory(folder_ / "far");
        std::string voxels;
        for (int i = 0; i < 8 * 8 * 8; ++i)
            voxels += i % 16 < 8 ? "1 " : "0 ";
        const std::string head = "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\n"
                                 "sizes: 8 8 8\nspace directions: (64,0,0) (0,64,0) (0,0,64)\n"
                                 "kinds: domain domain domain\nencoding: ascii\n"
                                 "space origin: (-256,-256,-256)\n";
        write("far/l.nrrd", head + "\n" + voxels + "\n");
        write("far/l.nhdr", head + "data file: l.raw\n\n");
        write("far/m.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                           "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                           "end_header\n-200 0 -200\n200 0 -200\n0 0 200\n3 0 1 2\n");
        write("far/m.stl", "no mesh");
    }
    std::string drawing(const std::string& out, const std::string& more) {
        return "render a.zarr --preset auto --engine native --no-check --size 40x30 -o " + out + " " + more;
    }
    HttpServer server{folder_.path()};
};

TEST_F(RemoteInputs, PicturesAreThoseOfFilesOnDisks) {
    for (const auto& [option, file] : {std::pair{"--labels ", "l.nrrd"}, {"--mesh ", "m.ply"}}) {
        ASSERT_EQ(run(drawing("plain.exr", "")).exitCode, 0);
        const Outcome here = run(drawing("here.exr", std::string(option) + "far/" + file));
        ASSERT_EQ(here.exitCode, 0) << here.problems;
        EXPECT_NE(readImage(folder_ / "here.exr").pixels, readImage(folder_ / "plain.exr").pixels);
        const std::string address = server.address(std::string("far/") + file);
        const Outcome there = run(drawing("there.exr", option + address + "?token=word"));
        ASSERT_EQ(there.exitCode, 0) << there.problems;
        EXPECT_THAT(there.problems + there.out + readAll(folder_ / "there.exr"), Not(HasSubstr("word")));
        // As a scene names it, and again: labels are imported once.
        const std::string value =
            std::string(option) == "--mesh " ? R"("meshes":[{"path":")" + address + R"("}],)" : "";
        const std::string labels =
            value.empty() ? R"(,"labels":{"path":")" + address + R"("})" : std::string();
        write("s.json", R"({"tesseraScene":1,)" + value +
                            R"("volumes":[{"path":"a.zarr","transferFunction":"auto")" + labels +
                            R"(}],"image":{"size":[40,30]}})");
        const Outcome scene = run("render s.json --engine native --no-check -o scene.exr");
        ASSERT_EQ(scene.exitCode, 0) << scene.problems;
        const auto pixels = [&](const std::string& name) { return readImage(folder_ / name).pixels; };
        EXPECT_EQ(pixels("there.exr"), pixels("here.exr"));
        EXPECT_EQ(pixels("scene.exr"), pixels("here.exr"));
    }
}

TEST_F(RemoteInputs, WhatCannotBeReadIsRefusedByItsAddress) {
    const std::string far = server.address("far/");
    expectRefused(drawing("a.exr", "--labels " + far + "none.nrrd"), {far + "none.nrrd", "nothing there"});
    expectRefused(drawing("a.exr", "--mesh " + far + "none.ply"), {far + "none.ply", "nothing there"});
    expectRefused(drawing("a.exr", "--labels " + far + "l.nhdr"), {far + "l.nhdr", "l.raw"});
    expectRefused(drawing("a.exr", "--mesh " + far + "m.stl"), {far + "m.stl"});
    ::setenv("TESSERA_CACHE_SIZE", "400", 1); // a quarter is for what lies behind addresses
    expectRefused(drawing("a.exr", "--mesh " + far + "m.ply"),
                  {far + "m.ply", "at most 100 B", "TESSERA_CACHE_SIZE"});
    ::unsetenv("TESSERA_CACHE_SIZE");
    server.statuses["/far/m.ply"] = 401;
    expectRefused(drawing("a.exr", "--mesh " + far + "m.ply"), {far + "m.ply", "401"});
}

} // namespace
} // namespace tessera::test
