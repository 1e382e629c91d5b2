// tests/viewer/session/saved_figures_test.cpp: pictures that two sessions save as one figure, and the memory
// that saving has.
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "core/image/colour.h"
#include "core/image/image_file.h"
#include "tests/support/folders.h"
#include "tests/support/looker.h"
#include "viewer/session/figure_of_stills.h"
#include "viewer/session/shown_picture.h"
#include "viewer/session/view_geometry.h"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using test::kPicture;
using test::Looker;
using testing::HasSubstr;

constexpr int kGap = 8;

ViewSessionOptions ofTwo() {
    ViewSessionOptions options;
    options.engine = EngineKind::native;
    options.ramBytes = test::kRamBytes;
    options.gpuBytes = test::kGpuBytes;
    options.savedPanels = 2;
    return options;
}

/// Two open volumes, and where figures go.
struct Two {
    Looker first{ofTwo()}, second{ofTwo()};
    Scene scene, other;
    ScratchFolder folder;

    Two() : scene(first.opened(test::storePath("torso"))), other(second.opened(test::storePath("torso"))) {
        other.camera = orbited(std::get<Camera>(other.camera), {0.6, 0.2});
        second.viewing->show(other, false);
    }
    /// Of a panel.
    static bool has(const Image& figure, const Image& panel, int left) {
        for (int y = 0; y < panel.size.y; ++y)
            for (int x = 0; x < panel.size.x; ++x)
                if (figure.at(left + x, y) != panel.at(x, y))
                    return false;
        return true;
    }
    Image alone(Looker& looker, const Scene& of, const fs::path& file) {
        looker.viewing->saveStill(of, file, {});
        EXPECT_TRUE(looker.comesTo([&] { return fs::exists(file); }));
        return readImage(file);
    }
};

// Both stills are those that each session saves alone, whichever is done first.
TEST(SavedFigures, StillsOfTwoSessionsBecomeOneFigure) {
    Two two;
    two.scene.imageSize = two.other.imageSize = 2 * kPicture;
    const Image left = two.alone(two.first, two.scene, two.folder / "left.png"),
                right = two.alone(two.second, two.other, two.folder / "right.png");
    for (const bool firstAsksFirst : {true, false}) {
        const fs::path file = two.folder / (firstAsksFirst ? "a.png" : "b.png");
        const auto figure = std::make_shared<FigureOfStills>(2);
        const auto ask = [&](bool first) {
            (first ? two.first : two.second)
                .viewing->saveStill(first ? two.scene : two.other, file, {},
                                    PanelOfStills(figure, first ? 0 : 1));
        };
        ask(firstAsksFirst);
        std::this_thread::sleep_for(std::chrono::milliseconds(firstAsksFirst ? 0 : 1500));
        EXPECT_FALSE(fs::exists(file)) << "before both are asked for";
        ask(!firstAsksFirst);
        ASSERT_TRUE(two.first.comesTo([&] { return fs::exists(file); }));
        const Image both = readImage(file);
        ASSERT_EQ(both.size, glm::ivec2(4 * kPicture.x + kGap, 2 * kPicture.y));
        EXPECT_TRUE(Two::has(both, left, 0));
        EXPECT_TRUE(Two::has(both, right, 2 * kPicture.x + kGap));
        const auto manifest = nlohmann::json::parse(readManifest(file));
        ASSERT_EQ(manifest.at("panels").size(), 2u);
        EXPECT_EQ(manifest["panels"][1]["scene"]["volumes"].size(), 1u);
        EXPECT_EQ(manifest["figure"]["gap"], kGap);
    }
}

// A window adds marks to the scene that it drew: manifests have them, so that the picture is drawn again.
TEST(SavedFigures, ManifestsHaveWhatIsDrawnIntoThePicture) {
    Two two;
    PictureMarks marks;
    marks.annotations.scaleBar = true;
    marks.annotations.title = "as shown";
    marks.annotations.measurements = true;
    marks.measurements = {{MeasurementKind::distance, {{0, 0, 0}, {30, 0, 0}}}};
    const fs::path file = two.folder / "marked.png";
    two.first.viewing->saveStill(two.scene, file, marks);
    ASSERT_TRUE(two.first.comesTo([&] { return fs::exists(file); }));
    const auto scene = nlohmann::json::parse(readManifest(file)).at("scene");
    EXPECT_EQ(scene.at("annotations").at("scaleBar"), true);
    EXPECT_EQ(scene.at("annotations").at("title"), "as shown");
    EXPECT_EQ(scene.at("measurements").size(), 1U);
}

// Whoever waits until nothing more comes has the file.
TEST(SavedFigures, ASessionIsNotAtRestBeforeItsStillIsWritten) {
    Two two;
    two.scene.imageSize = 2 * kPicture;
    for (const char* const name : {"a.png", "b.png", "c.png"}) {
        ASSERT_TRUE(two.first.comesTo([&] { return two.first.viewing->state().atRest; }));
        two.first.viewing->saveStill(two.scene, two.folder / name, {});
        EXPECT_FALSE(two.first.viewing->state().atRest);
        ASSERT_TRUE(two.first.comesTo([&] { return two.first.viewing->state().atRest; }));
        EXPECT_TRUE(fs::exists(two.folder / name)) << name;
    }
    Scene another = two.scene; // of a volume that is not open: no file comes
    another.volumes.front().path = "/another.zarr";
    two.first.viewing->saveStill(another, two.folder / "d.png", {});
    ASSERT_TRUE(two.first.comesTo([&] { return two.first.viewing->state().atRest; }));
    EXPECT_FALSE(fs::exists(two.folder / "d.png"));
}

// A figure that lacks a panel is not written, and the memory of the one that waits comes back.
TEST(SavedFigures, AFigureIsGivenUpWithOneOfItsPanels) {
    Two two;
    two.first.stillOf(0);
    const fs::path file = two.folder / "never.png";
    const auto figure = std::make_shared<FigureOfStills>(2);
    const std::size_t before = two.first.viewing->state().ramUsed;
    two.scene.imageSize = two.other.imageSize = 2 * kPicture;
    two.first.viewing->saveStill(two.scene, file, {}, PanelOfStills(figure, 0));
    {
        const PanelOfStills other(figure, 1); // as of a session that ends
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    ASSERT_TRUE(two.first.comesTo([&] { return two.first.viewing->state().atRest; }));
    EXPECT_FALSE(fs::exists(file));
    EXPECT_LE(two.first.viewing->state().ramUsed, before);
    EXPECT_EQ(two.first.viewing->takeNotice(), "");
    EXPECT_FALSE(figure->put(1, {}, {}, [](const auto&) { FAIL() << "it was given up"; }));
}

// As they are shown: side by side, on their backgrounds.
TEST(SavedFigures, ShownPicturesAreSavedSideBySide) {
    Two two;
    const auto left = two.first.stillOf(0), right = two.second.stillOf(1);
    const fs::path file = two.folder / "shown.png";
    two.first.viewing->saveScreenshot(file, {}, {{right, {}}});
    const Image both = readImage(file);
    ASSERT_EQ(both.size, glm::ivec2(2 * kPicture.x + kGap, kPicture.y));
    two.first.viewing->saveScreenshot(two.folder / "left.png", {});
    EXPECT_TRUE(Two::has(both, readImage(two.folder / "left.png"), 0));
    two.second.viewing->saveScreenshot(two.folder / "right.png", {});
    EXPECT_TRUE(Two::has(both, readImage(two.folder / "right.png"), kPicture.x + kGap));
    for (const char* const ending : {".exr", ".tif"}) // what is charged besides
        EXPECT_NO_THROW(
            two.first.viewing->saveScreenshot(two.folder / (std::string("all") + ending), {}, {{right, {}}}));
    auto other = std::make_shared<ShownPicture>(*right);
    other->image = Image({50, 40});
    try {
        two.first.viewing->saveScreenshot(two.folder / "no.png", {}, {{other, {}}});
        FAIL() << "of two sizes";
    } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr("no.png"));
        EXPECT_THAT(e.what(), HasSubstr("96 x 72 and 50 x 40"));
    }
}

// Saving is charged, and refused as everything is that does not fit.
TEST(SavedFigures, SavingIsChargedToTheBudget) {
    const ScratchFolder folder;
    auto picture = std::make_shared<ShownPicture>();
    picture->image = Image({400, 300});
    const std::size_t pixels = 400 * 300;
    for (const std::size_t panels : {std::size_t{1}, std::size_t{2}}) {
        const std::vector<SavedPanel> saved(panels, {picture, {}});
        const fs::path file = folder / (std::to_string(panels) + ".png");
        MemoryBudget tooSmall("RAM", "--ram", 16 * pixels * panels);
        try {
            savePictures(file, saved, tooSmall);
            FAIL() << "it fits";
        } catch (const InputError& e) {
            EXPECT_THAT(e.what(), HasSubstr("the saved picture"));
            EXPECT_THAT(e.what(), HasSubstr("raise --ram"));
        }
        EXPECT_FALSE(fs::exists(file));
        MemoryBudget ample("RAM", "--ram", 40 * (pixels * panels + 300 * kGap));
        savePictures(file, saved, ample);
        EXPECT_TRUE(fs::exists(file));
        EXPECT_GE(ample.peakBytes(), 16 * pixels * panels);
        EXPECT_EQ(ample.usedBytes(), 0u);
    }
}

} // namespace
} // namespace tessera
