// tests/viewer/session/finer_session_test.cpp: a file of several levels that is not in the cache: a coarse
// level is shown while the finest is imported, and what was set meanwhile stays.
#include "core/base/program_folders.h"
#include "tests/support/looker.h"

#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kSide = 96, kLevels = 3;

/// An image of OME-Zarr 0.4 whose levels halve one another.
void writeImage(const fs::path& group) {
    fs::create_directories(group);
    std::ofstream(group / ".zgroup") << R"({"zarr_format":2})";
    json datasets = json::array(), axes = json::array();
    for (const char* const axis : {"z", "y", "x"})
        axes.push_back(json{{"name", axis}, {"type", "space"}, {"unit", "millimeter"}});
    for (int level = 0; level < kLevels; ++level) {
        const int side = kSide >> level;
        const double mm = 1 << level, first = (mm - 1) / 2;
        const std::string name = std::to_string(level);
        const json scale = {{"type", "scale"}, {"scale", {mm, mm, mm}}},
                   shift = {{"type", "translation"}, {"translation", {first, first, first}}};
        datasets.push_back(json{{"path", name}, {"coordinateTransformations", json::array({scale, shift})}});
        fs::create_directories(group / name);
        std::ofstream(group / name / ".zarray") << json{
            {"zarr_format", 2}, {"shape", {side, side, side}}, {"chunks", {side, side, side}},
            {"dtype", "|u1"},   {"compressor", nullptr},       {"fill_value", 0},
            {"order", "C"},     {"filters", nullptr}}.dump();
        std::string voxels;
        for (int n = 0; n < side * side * side; ++n)
            voxels += static_cast<char>(n % side * 200 / side);
        std::ofstream(group / name / "0.0.0", std::ios::binary) << voxels;
    }
    const json scales = {{"version", "0.4"}, {"axes", axes}, {"datasets", datasets}};
    std::ofstream(group / ".zattrs") << json{{"multiscales", json::array({scales})}}.dump();
}

class FinerSession : public ::testing::Test {
  protected:
    FinerSession() {
        ::setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
        writeImage(path);
    }
    ~FinerSession() override { ::unsetenv("XDG_CACHE_HOME"); }
    ViewSessionOptions options(std::uint64_t firstBytes) const {
        ViewSessionOptions made;
        made.stills = false;
        made.engine = EngineKind::native;
        made.ramBytes = kRamBytes;
        made.gpuBytes = kGpuBytes;
        made.common.quiet = true;
        made.firstBytes = firstBytes;
        return made;
    }
    static int sideOf(const Looker& looker) {
        const auto volume = looker.viewing->volume();
        return volume ? volume->info.extentVoxels.x : 0;
    }
    const ScratchFolder folder;
    const fs::path path = folder / "a.zarr";
};

TEST_F(FinerSession, ACoarseLevelIsShownFirstAndWhatIsSetStays) {
    constexpr std::uint64_t kOfLevel2 = (kSide >> 2) * (kSide >> 2) * (kSide >> 2);
    std::vector<int> sides; // of the volumes that came
    Looker looker(options(kOfLevel2));
    looker.viewing->open(path, kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return sideOf(looker) > 0; }));
    sides.push_back(sideOf(looker));
    Scene scene = looker.viewing->volume()->scene;
    EXPECT_FALSE(scene.volumes.front().source.fileLevel) << "saved, it opens the finest";
    Camera camera = std::get<Camera>(scene.camera);
    camera.position += glm::dvec3(7, -3, 2);
    scene.camera = camera;
    scene.volumes.front().transferFunction = "bone";
    scene.cuts.boxes.push_back({glm::dvec3(0), glm::dvec3(kSide >> 3), CropBox::Space::voxels, Keep::inside});
    looker.viewing->show(scene, false);
    ASSERT_TRUE(looker.comesTo([&] { return sideOf(looker) == kSide && looker.viewing->state().atRest; }));
    EXPECT_EQ(sides.front(), kSide >> 2);
    const Scene fine = looker.viewing->volume()->scene;
    EXPECT_LT(glm::distance(looker.viewing->picture()->camera.position, camera.position), 1e-9);
    EXPECT_FALSE(fine.volumes.front().source.fileLevel);
    if (!fine.cuts.boxes.empty()) { // it was set before the finest was there
        EXPECT_LT(glm::distance(fine.cuts.boxes.front().high, glm::dvec3(kSide >> 1)), 1e-9)
            << "in its voxels";
    }
    EXPECT_EQ(looker.viewing->state().problem, "");
    EXPECT_EQ(looker.viewing->volume()->info.filePart, std::nullopt);
    // In the cache: the next time it is the finest at once.
    Looker again(options(kOfLevel2));
    again.viewing->open(path, kPicture);
    ASSERT_TRUE(again.comesTo([&] { return sideOf(again) > 0; }));
    EXPECT_EQ(sideOf(again), kSide);
}

TEST_F(FinerSession, AnotherVolumeOrTheEndCallsTheImportOff) {
    for (const bool opensAnother : {true, false}) {
        Looker looker(options(1 << 16));
        looker.viewing->open(path, kPicture);
        ASSERT_TRUE(looker.comesTo([&] { return sideOf(looker) > 0; }));
        if (!opensAnother)
            continue; // its end
        writeImage(folder / "b.zarr");
        looker.viewing->open(folder / "b.zarr", kPicture);
        ASSERT_TRUE(looker.comesTo([&] {
            const auto volume = looker.viewing->volume();
            return volume->path == folder / "b.zarr" && sideOf(looker) == kSide;
        }));
    }
}

TEST_F(FinerSession, WhereNoneIsSmallEnoughTheFinestIsAwaited) {
    Looker looker(options(1));
    looker.viewing->open(path, kPicture);
    ASSERT_TRUE(looker.comesTo([&] { return sideOf(looker) > 0; }));
    EXPECT_EQ(sideOf(looker), kSide);
}

} // namespace
} // namespace tessera::test
