// tests/core/base/small_parts_test.cpp: small functions at their bounds: names of temporary files and what of
// them is swept, sizes, UIDs, folders of settings, colours, loops, and scenes of one of several volumes.
#include "core/base/dicom_uid.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/magnitude.h"
#include "core/base/ownership.h"
#include "core/base/program_folders.h"
#include "core/base/threads.h"
#include "core/base/volume.h"
#include "core/image/colour.h"
#include "core/image/image.h"
#include "core/scene/scene.h"
#include "tests/support/refusals.h"

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <optional>
#include <string>
#include <unistd.h>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(TemporaryNames, HoldTheirNameAndGiveItBack) {
    const std::string mine = ".a.png.tessera-" + std::to_string(::getpid()) + "-3";
    EXPECT_EQ(temporaryName("a.png", "tessera", 3), mine);
    EXPECT_EQ(nameOfTemporary(mine, "tessera"), "a.png");
    EXPECT_EQ(nameOfTemporary(mine + "-removed", "tessera"), "a.png");
    EXPECT_EQ(nameOfTemporary(".x.tessera-1-2", "tessera"), "x");
    EXPECT_EQ(nameOfTemporary(".a.tessera-1-2.tessera-7-0", "tessera"), "a.tessera-1-2") << "the last mark";
    for (const char* other : {"", ".", "a.tessera-1-2", ".tessera-1-2", "..tessera-1", ".a.tessera-1",
                              ".a.tessera--2", ".a.tessera-1-", ".a.tessera-1-2x", ".a.tessera-x-2",
                              ".a.tesser-1-2", ".a.tessera-1-2-3", "-removed"})
        EXPECT_FALSE(nameOfTemporary(other, "tessera")) << other;
    // Long ones keep their extension; the name without mark and numbers has 180 bytes.
    for (const std::size_t size : {180u, 181u, 255u}) {
        const std::string name = std::string(size - 4, 'n') + ".png";
        const std::optional<std::string> back = nameOfTemporary(temporaryName(name, "tessera", 0), "tessera");
        ASSERT_TRUE(back) << size;
        EXPECT_EQ(*back, std::string(176, 'n') + ".png") << size;
    }
    const std::string longer = "a." + std::string(200, 'e'); // such an extension is none
    EXPECT_EQ(nameOfTemporary(temporaryName(longer, "tessera", 0), "tessera"), longer.substr(0, 180));
}

// What has a temporary name and no owner goes; what has one, other names and links stay.
TEST(TemporaryNames, OfTheDeadAreSweptAlone) {
    const ScratchFolder folder;
    if (!locksProve(folder.path()))
        GTEST_SKIP() << "locks prove nothing on this file system";
    for (const char* name : {".dead.tessera-1-0", "kept.txt", ".held.tessera-1-1"})
        std::ofstream(folder / name) << "text";
    fs::create_directory(folder / ".deep.tessera-1-2");
    std::ofstream(folder / ".deep.tessera-1-2" / "a") << "text";
    fs::create_symlink(folder / "kept.txt", folder / ".link.tessera-1-3");
    const auto isTemporary = [](const std::string& name) {
        return nameOfTemporary(name, "tessera").has_value();
    };
    {
        const LockTry held = tryLock(folder / ".held.tessera-1-1", LockKind::exclusive);
        ASSERT_TRUE(held.locked);
        sweepLeftovers(folder.path(), isTemporary);
        EXPECT_FALSE(fs::exists(folder / ".dead.tessera-1-0"));
        EXPECT_FALSE(fs::exists(folder / ".deep.tessera-1-2"));
        EXPECT_TRUE(fs::exists(folder / ".held.tessera-1-1")) << "its owner lives";
        EXPECT_TRUE(fs::is_symlink(folder / ".link.tessera-1-3"));
        EXPECT_TRUE(fs::exists(folder / "kept.txt"));
    }
    std::vector<std::string> found;
    eachLeftover(folder.path(), isTemporary, [&](const fs::path& path) {
        found.push_back(path.filename().string());
        EXPECT_TRUE(tryLock(path, LockKind::exclusive).busy) << "it is held meanwhile";
    });
    EXPECT_EQ(found, std::vector<std::string>{".held.tessera-1-1"});
    eachLeftover(folder / "missing", isTemporary, [](const fs::path&) { ADD_FAILURE(); });
}

TEST(Sizes, AreWholeNumbersUpToTheLargest) {
    EXPECT_EQ(parseImageSize("1x640", "f", 640), glm::ivec2(1, 640));
    EXPECT_EQ(parseVolumeSize("3x100000x20", "f", 999999), glm::ivec3(3, 100000, 20));
    for (const char* bad : {"", "x", "5", "0x5", "5x0", "5x641", "641x5", "5x5x5", "5x5x", "x5x5", "-1x5",
                            "5 x5", "+5x5", "5x1e2", "0000005x5"})
        EXPECT_EQ(test::refusalOf([&] { parseImageSize(bad, "--size", 640); }),
                  "--size: expected WIDTHxHEIGHT with numbers from 1 to 640, found \"" + std::string(bad) +
                      "\"");
    EXPECT_EQ(test::refusalOf([] { parseVolumeSize("5x5", "--size", 9); }),
              "--size: expected XxYxZ with numbers from 1 to 9, found \"5x5\"");
    EXPECT_EQ(shownNumber(1e308) + " " + shownNumber(-0.25) + " " + shownNumber(123456.5),
              "1e+308 -0.25 123456");
}

TEST(DicomUids, AreDigitsAndStops) {
    for (const std::string& good : {std::string("1"), std::string("1.2.840.10008"), std::string(64, '1')}) {
        EXPECT_TRUE(isDicomUid(good)) << good;
        EXPECT_EQ(uidOrNone(good), good);
    }
    for (const std::string& bad :
         {std::string(), std::string(".1"), std::string("1.2a"), std::string("1 "), std::string(65, '1')}) {
        EXPECT_FALSE(isDicomUid(bad)) << bad;
        EXPECT_EQ(uidOrNone(bad), "");
    }
    EXPECT_TRUE(areFramesApart("1.2", "1.3"));
    EXPECT_FALSE(areFramesApart("1.2", "1.2"));
    EXPECT_FALSE(areFramesApart("", "1.2") || areFramesApart("1.2", "") || areFramesApart("", ""));
}

TEST(Files, PipesAndDevicesAreRefusedAndErrorsGoWithoutTheirPath) {
    const ScratchFolder folder;
    std::ofstream(folder / "file") << "text";
    fs::create_symlink("/dev/null", folder / "link");
    for (const fs::path& path : {folder / "file", folder.path(), folder / "missing"}) {
        EXPECT_FALSE(isPipeOrDevice(path)) << path;
        EXPECT_NO_THROW(refusePipeOrDevice(path));
    }
    for (const fs::path& path : {fs::path("/dev/null"), folder / "link"}) {
        EXPECT_TRUE(isPipeOrDevice(path)) << path;
        EXPECT_THROW(refusePipeOrDevice(path), InputError);
    }
    EXPECT_EQ(withoutPath(badFile("f", "a", "b")), "expected a, found b");
    EXPECT_EQ(withoutPath(Error("a disk is full")), "a disk is full");
}

TEST(Settings, AreInTheFolderThatTheEnvironmentNames) {
    const auto valueOf = [](const char* name) {
        const char* const value = std::getenv(name);
        return value ? std::optional<std::string>(value) : std::nullopt;
    };
    const auto set = [](const char* name, const std::optional<std::string>& value) {
        value ? ::setenv(name, value->c_str(), 1) : ::unsetenv(name);
    };
    const auto config = valueOf("XDG_CONFIG_HOME"), home = valueOf("HOME");
    const auto folder = [&](const std::optional<std::string>& c, const std::optional<std::string>& h) {
        set("XDG_CONFIG_HOME", c);
        set("HOME", h);
        return userConfigFolder();
    };
    EXPECT_EQ(folder("/c", "/h"), "/c/tessera");
    EXPECT_EQ(folder(std::nullopt, "/h"), "/h/.config/tessera");
    EXPECT_EQ(folder("", "/h"), "/h/.config/tessera");
    EXPECT_EQ(folder("relative", "/h"), "/h/.config/tessera");
    EXPECT_EQ(folder("/c", std::nullopt), "/c/tessera");
    EXPECT_EQ(folder("c", "h"), "");
    EXPECT_EQ(folder(std::nullopt, std::nullopt), "");
    set("XDG_CONFIG_HOME", config);
    set("HOME", home);
}

// However many threads there are, every turn is taken once.
TEST(Loops, TakeEveryTurnOnce) {
    for (const int threads : {0, 1, 2, 5})
        for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{1000}}) {
            std::vector<std::atomic<int>> taken(count);
            parallelFor(count, threads, [&](std::size_t i) { ++taken[i]; });
            for (const std::atomic<int>& times : taken)
                ASSERT_EQ(times, 1) << threads << " " << count;
        }
    EXPECT_GE(defaultThreads(), 1);
}

TEST(Colours, AreFoundByNameAndNumber) {
    EXPECT_EQ(findColour("red"), glm::vec3(1, 0, 0));
    EXPECT_EQ(findColour("LIME"), glm::vec3(0, 1, 0));
    EXPECT_EQ(findColour("#0000fF"), glm::vec3(0, 0, 1));
    const glm::vec3 mixed = findColour("#804020").value_or(glm::vec3(0));
    EXPECT_FLOAT_EQ(mixed.r, static_cast<float>(linearFromSrgb(128.0 / 255)));
    EXPECT_FLOAT_EQ(mixed.g, static_cast<float>(linearFromSrgb(64.0 / 255)));
    EXPECT_FLOAT_EQ(mixed.b, static_cast<float>(linearFromSrgb(32.0 / 255)));
    for (const char* bad : {"", "#", "#12345", "#1234567", "#12345g", "rod", "1234567"})
        EXPECT_FALSE(findColour(bad)) << bad;
    EXPECT_EQ(nearestColour("rod"), "red");
    EXPECT_EQ(parseBackground("transparent", "f"), std::nullopt);
    EXPECT_EQ(parseBackground("white", "f"), glm::vec3(1));
    EXPECT_THAT(test::refusalOf([] { parseBackground("rod", "--background"); }),
                testing::AllOf(testing::StartsWith("--background: expected transparent, #rrggbb or"),
                               testing::EndsWith("found \"rod\"; nearest: \"red\"")));
    for (const auto& [name, format] : std::map<std::string, PictureFormat>{{"a.png", PictureFormat::png},
                                                                           {"a.b.EXR", PictureFormat::exr},
                                                                           {"a.tif", PictureFormat::tiff},
                                                                           {"a.Tiff", PictureFormat::tiff}})
        EXPECT_EQ(pictureFormat(name), format) << name;
    for (const char* bad : {"a", "png", "a.jpg", "a.png.gz", ".png"})
        EXPECT_THROW(pictureFormat(bad), InputError) << bad;
}

TEST(ScenesOfVolumes, HaveWhatTheVolumeSaysElseTheScene) {
    Scene scene;
    scene.volumes.resize(3);
    for (std::size_t n = 0; n < 3; ++n)
        scene.volumes[n].path = std::to_string(n);
    scene.window = GreyWindow{1, 2};
    scene.valueColour = ValueColour::inverse;
    scene.volumes[1].window = GreyWindow{3, 4};
    scene.volumes[2].valueColour = ValueColour::transferFunction;
    scene.volumes[2].labels.ofVolume = 7;
    for (std::size_t n = 0; n < 3; ++n) {
        const Scene alone = sceneOfVolume(scene, n);
        ASSERT_EQ(alone.volumes.size(), 1u);
        EXPECT_EQ(alone.volumes[0].path, std::to_string(n));
        EXPECT_EQ(alone.window, WindowChoice(n == 1 ? GreyWindow{3, 4} : GreyWindow{1, 2})) << n;
        EXPECT_EQ(alone.valueColour, n == 2 ? ValueColour::transferFunction : ValueColour::inverse) << n;
        EXPECT_EQ(alone.volumes[0].labels.place(), "volumes[" +
                                                       std::to_string(n == 0   ? 0
                                                                      : n == 1 ? 1
                                                                               : 7) +
                                                       "].labels");
    }
    EXPECT_ANY_THROW(sceneOfVolume(scene, 3));
}

TEST(ScenesOfVolumes, DrawMeshesThatShow) {
    Scene scene;
    EXPECT_FALSE(drawsMeshes(scene));
    scene.meshes.resize(4);
    for (SceneMesh& mesh : scene.meshes)
        mesh.path = "/of/a.stl";
    scene.meshes[0].show = false;
    scene.meshes[1].opacity = 0;
    EXPECT_TRUE(drawsMeshes(scene));
    EXPECT_EQ(drawnMeshes(scene).size(), 2u);
    scene.meshes.resize(2);
    EXPECT_FALSE(drawsMeshes(scene));
    EXPECT_TRUE(drawnMeshes(scene).empty());
    EXPECT_EQ(scene.meshes[0].name(), "a.stl");
    EXPECT_EQ(SceneMesh().name(), "tube");
    // A shape follows from where it comes from and how it is made, not from how it looks.
    const SceneMesh mesh = scene.meshes[0];
    const auto isSame = [&](const auto& change) {
        SceneMesh other = mesh;
        change(other);
        EXPECT_FALSE(other == mesh);
        return mesh.isSameShape(other);
    };
    EXPECT_TRUE(isSame([](SceneMesh& m) { m.colour = glm::dvec3(0.5); }));
    EXPECT_TRUE(isSame([](SceneMesh& m) { m.opacity = 0.5; }));
    EXPECT_TRUE(isSame([](SceneMesh& m) { m.material = MaterialResponse{}; }));
    EXPECT_TRUE(isSame([](SceneMesh& m) { m.show = true; }));
    EXPECT_TRUE(isSame([](SceneMesh& m) { m.clipped = false; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.path = "b"; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.tube = Tube{}; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.space = MeshSpace::ras; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.rois = {"a"}; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.contours = ContourStyle::surface; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.lineRadiusMm = 2; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.surfaceStepMm = 2; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.surfaceGapMm = 2; }));
    EXPECT_FALSE(isSame([](SceneMesh& m) { m.sameFrame = true; }));
}

TEST(VolumePlaces, SpacingsAreMeansOfAllThree) {
    VolumeInfo info;
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 6});
    EXPECT_EQ(meanSpacingMm(info), 3);
}

} // namespace
} // namespace tessera
