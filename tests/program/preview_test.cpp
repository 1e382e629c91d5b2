// tests/program/preview_test.cpp: a first picture of a store behind an address is by its preview, and nothing
// else is.
#include "core/image/image_file.h"
#include "core/image/image_metrics.h"
#include "tests/support/http_server.h"
#include "tests/support/program_fixture.h"

#include <algorithm>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class Previews : public Program {
  protected:
    void SetUp() override {
        ASSERT_EQ(run("phantom torso --size 96x72x112 -o t.zarr").exitCode, 0);
        ASSERT_EQ(run("export t.zarr t.nrrd").exitCode, 0);
        ASSERT_EQ(run("import t.nrrd s.zarr").exitCode, 0);
        const Outcome made = run("import t.nrrd p.zarr --preview 16");
        ASSERT_EQ(made.exitCode, 0) << made.problems;
        EXPECT_THAT(made.problems, HasSubstr("preview: "));
        EXPECT_THAT(made.problems, HasSubstr("level 0, with loss"));
    }
    std::vector<std::string> asked(const HttpServer& server) const {
        std::vector<std::string> targets;
        for (const AskedOf& one : server.asked())
            targets.push_back(one.target);
        return targets;
    }
};

TEST_F(Previews, AreDrawnFirstWhereTheStoreIsFarAway) {
    const HttpServer server(folder_.path());
    const std::string how = " --size 64x64 --engine native --preset bone";
    ASSERT_EQ(run("render s.zarr -o here.exr" + how).exitCode, 0);
    const Outcome drawn = run("render " + server.address("p.zarr") + " -o far.exr --first first.exr" + how);
    ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
    EXPECT_THAT(drawn.problems, HasSubstr("wrote first.exr, coarse, after "));
    const Image here = readImage(folder_ / "here.exr"), far = readImage(folder_ / "far.exr"),
                first = readImage(folder_ / "first.exr");
    EXPECT_EQ(compare(here, far).maxAbs, 0) << "the picture itself is by the store's own voxels";
    EXPECT_GT(compare(here, first).maxAbs, 0);
    EXPECT_LT(compare(here, first).rms, 0.1);
    // All of the preview comes before the first voxel of the store.
    const std::vector<std::string> targets = asked(server);
    const auto isOf = [](const char* what) {
        return [what](const std::string& target) { return target.find(what) != std::string::npos; };
    };
    const auto preview = std::find_if(targets.begin(), targets.end(), isOf("/preview/0/c/"));
    const auto voxels = std::find_if(targets.begin(), targets.end(), isOf("p.zarr/0/c/"));
    ASSERT_NE(preview, targets.end());
    ASSERT_NE(voxels, targets.end());
    EXPECT_LT(preview, voxels);
    // Without --first nothing of it is asked for.
    const std::size_t before = targets.size();
    ASSERT_EQ(run("render " + server.address("p.zarr") + " -o again.exr" + how).exitCode, 0);
    const std::vector<std::string> later = asked(server);
    EXPECT_TRUE(
        std::none_of(later.begin() + static_cast<std::ptrdiff_t>(before), later.end(), isOf("/preview")));
    // A damaged preview costs its picture alone.
    for (const auto& file : fs::recursive_directory_iterator(folder_ / "p.zarr/preview/0"))
        if (file.is_regular_file() && file.path().filename() != "zarr.json")
            fs::resize_file(file.path(), file.file_size() / 2);
    fs::remove_all(folder_ / "cache");
    ASSERT_EQ(run("render " + server.address("p.zarr") + " -o third.exr --first f.exr" + how).exitCode, 0);
    EXPECT_EQ(compare(here, readImage(folder_ / "third.exr")).maxAbs, 0);
}

// Where the volume is moved to, the preview is too.
TEST_F(Previews, LieWhereTheirVolumeDoes) {
    const HttpServer server(folder_.path());
    const std::string camera =
        R"({"position":[0,-900,0],"focalPoint":[0,0,0],"viewUp":[0,0,1],"viewAngle":40})";
    const std::string moved = "volumes[0].transform=[1,0,0,120,0,1,0,0,0,0,1,0]";
    ASSERT_EQ(run("render " + server.address("p.zarr") +
                  " -o far.exr --first first.exr --size 64x64 --engine native " +
                  "--preset bone --set camera=" + camera + " --set " + moved)
                  .exitCode,
              0);
    const Image far = readImage(folder_ / "far.exr"), first = readImage(folder_ / "first.exr");
    EXPECT_GT(
        std::count_if(far.pixels.begin(), far.pixels.end(), [](const glm::vec4& p) { return p.r > 0.1f; }),
        50);
    EXPECT_LT(compare(far, first).rms, 0.1);
}

TEST_F(Previews, LeaveTheStoreAsItIs) {
    EXPECT_EQ(readAll(folder_ / "p.zarr/zarr.json"), readAll(folder_ / "s.zarr/zarr.json"));
    EXPECT_EQ(run("validate p.zarr").exitCode, 0);
    EXPECT_EQ(run("validate p.zarr/preview").exitCode, 0);
    EXPECT_EQ(run("render p.zarr/preview -o p.png --size 32x32 --engine native").exitCode, 0);
    // A store that is there gets one; what is wrong with it is found.
    ASSERT_EQ(run("import s.zarr s.zarr --preview 16").exitCode, 0);
    EXPECT_EQ(readAll(folder_ / "s.zarr/preview/zarr.json"), readAll(folder_ / "p.zarr/preview/zarr.json"));
    const fs::path shard = folder_ / "s.zarr/preview/0/c/0/0/0";
    ASSERT_TRUE(fs::exists(shard));
    fs::resize_file(shard, fs::file_size(shard) - 1);
    EXPECT_EQ(run("validate s.zarr").exitCode, 1);
    expectRefused("import t.nrrd q.zarr --preview 7", {"--preview", "7"});
    expectRefused("import t.nrrd q.zarr --codec dct-8", {"--codec", "lz4, zstd, none"});
}

} // namespace
} // namespace tessera::test
