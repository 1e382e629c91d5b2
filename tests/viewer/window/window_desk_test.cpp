// tests/viewer/window/window_desk_test.cpp: the window's desk: sizes of pictures, fitted cameras, picked
// points, names of files, presets, planes, and offers.
#include "core/base/program_folders.h"
#include "tests/support/desk.h"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

namespace tessera {
namespace {

using test::Desk;

/// A size is taken once it stays, and what was seen stays on the picture.
TEST(WindowState, TakesASizeThatStays) {
    Desk d;
    d.desk.setCamera(d.desk.camera(), false);
    const Camera before = d.desk.camera();
    const std::uint64_t shows = d.viewing.shows;
    d.desk.setPictureSize({200, 300});
    EXPECT_FALSE(d.desk.hasAsked());
    EXPECT_TRUE(d.desk.settle());
    EXPECT_EQ(d.desk.scene().imageSize, glm::ivec2(400, 300));
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    d.desk.setPictureSize({100, 300});
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    d.desk.settle();
    EXPECT_EQ(d.viewing.shows, shows);
    std::this_thread::sleep_for(std::chrono::milliseconds(90));
    d.desk.settle();
    EXPECT_EQ(d.desk.scene().imageSize, glm::ivec2(100, 300));
    EXPECT_EQ(d.viewing.shows, shows + 1);
    EXPECT_TRUE(d.desk.hasAsked());
    EXPECT_GT(d.desk.camera().viewAngle, before.viewAngle) << "as much to each side";
    d.desk.setPictureSize({400, 300});
    std::this_thread::sleep_for(std::chrono::milliseconds(210));
    d.desk.settle();
    EXPECT_EQ(d.desk.camera(), before);
}

/// A fitted camera is asked for by side until the user moves it.
TEST(WindowState, FitsUntilTheUserMoves) {
    Desk d;
    EXPECT_FALSE(d.desk.isFitted());
    d.desk.fitView(View::left);
    EXPECT_TRUE(d.desk.isFitted());
    EXPECT_TRUE(d.desk.isFitting());
    ASSERT_TRUE(std::holds_alternative<FittedView>(d.viewing.asked.camera));
    EXPECT_EQ(std::get<FittedView>(d.viewing.asked.camera).view, View::left);
    EXPECT_TRUE(std::get<FittedView>(d.viewing.asked.camera).named);
    d.draw();
    EXPECT_FALSE(d.desk.isFitting());
    EXPECT_EQ(d.desk.camera().position, glm::dvec3(400, 0, 0));
    Scene lit = d.desk.scene();
    lit.shading.ambient = 0.5;
    d.desk.setScene(lit, false);
    EXPECT_TRUE(std::holds_alternative<Camera>(d.viewing.asked.camera)) << "the same shows";
    d.desk.setScene(lit, false, true);
    EXPECT_TRUE(std::holds_alternative<FittedView>(d.viewing.asked.camera));
    d.desk.setProjection(Projection::parallel);
    ASSERT_TRUE(std::holds_alternative<FittedView>(d.viewing.asked.camera));
    EXPECT_EQ(std::get<FittedView>(d.viewing.asked.camera).projection, Projection::parallel);
    d.draw();
    d.desk.setCamera(d.desk.camera(), false);
    EXPECT_FALSE(d.desk.isFitted());
    EXPECT_FALSE(d.desk.isFitting());
    EXPECT_TRUE(std::holds_alternative<Camera>(d.viewing.asked.camera));
    d.desk.resetCamera();
    EXPECT_EQ(d.desk.camera(), std::get<Camera>(d.viewing.seen->scene.camera));
    auto fitted = std::make_shared<VolumeSeen>(*d.viewing.seen);
    fitted->fitted = FittedView{View::posterior, Projection::parallel, Fit::volume, true, {}};
    d.viewing.seen = fitted;
    d.desk.update();
    EXPECT_TRUE(d.desk.isFitted());
    d.desk.setCamera(d.desk.camera(), false);
    d.desk.resetCamera();
    ASSERT_TRUE(std::holds_alternative<FittedView>(d.viewing.asked.camera));
    EXPECT_EQ(std::get<FittedView>(d.viewing.asked.camera).view, View::posterior);
    d.desk.fitView();
    EXPECT_EQ(std::get<FittedView>(d.viewing.asked.camera).fit, Fit::volume);
}

/// In mode slice sides turn the plane.
TEST(WindowState, SidesTurnASlice) {
    const std::pair<View, Orientation> sides[] = {
        {View::left, Orientation::sagittal},    {View::right, Orientation::sagittal},
        {View::anterior, Orientation::coronal}, {View::posterior, Orientation::coronal},
        {View::superior, Orientation::axial},   {View::inferior, Orientation::axial}};
    Desk d;
    Scene scene = d.desk.scene();
    scene.mode = Mode::slice;
    scene.slice.positionMm = 5;
    d.desk.setScene(scene, false);
    EXPECT_TRUE(d.desk.isFitted());
    for (const auto& [side, orientation] : sides) {
        const Orientation before = d.desk.scene().slice.orientation;
        d.desk.fitView(side);
        EXPECT_EQ(d.desk.scene().slice.orientation, orientation);
        d.desk.undo();
        EXPECT_EQ(d.desk.scene().slice.orientation, before);
        d.desk.redo();
        EXPECT_EQ(d.desk.scene().slice.orientation, orientation);
        EXPECT_FALSE(d.desk.scene().slice.positionMm);
        EXPECT_FALSE(std::get<FittedView>(d.viewing.asked.camera).named) << "seen along its normal";
    }
    scene = d.desk.scene();
    scene.mode = Mode::composite;
    d.desk.setScene(scene, false);
    EXPECT_TRUE(d.desk.isFitted());
}

/// Points that were picked on an earlier picture are not those of this one.
TEST(WindowState, PicksAreOfTheLastPicture) {
    Desk d;
    d.viewing.answer = PickedPlace{3, true, {1, 2, 3}, {1, 2, 3}, 5, 0};
    d.desk.update();
    EXPECT_TRUE(d.desk.picked());
    d.desk.setCamera(d.desk.camera(), false);
    EXPECT_FALSE(d.desk.picked());
    d.desk.update();
    EXPECT_FALSE(d.desk.picked());
    d.viewing.answer->number = 4;
    d.desk.update();
    EXPECT_TRUE(d.desk.picked());
}

TEST(WindowState, FilesAreNamedAndNeverReplaced) {
    const ScratchFolder folder;
    Desk d;
    const std::string base = (folder / "s").string();
    for (const char* const name : {"s.json", "s-2.json", "s-3.json"}) {
        d.desk.saveScene(base);
        EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
    }
    d.desk.saveScene(base + ".json");
    EXPECT_TRUE(std::filesystem::exists(folder / "s-4.json"));
    EXPECT_NE(d.desk.message()->text.find("wrote the scene "), std::string::npos);
    std::ifstream in(folder / "s.json");
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    EXPECT_EQ(text, sceneJson(d.desk.scene()) + "\n");
    d.desk.saveScene(base + "/no/folder");
    EXPECT_TRUE(d.desk.message()->problem);
    std::ofstream(folder / "p.exr") << "x";
    const std::pair<const char*, const char*> pictures[] = {{"p", "p.png"},         {"p.png", "p.png"},
                                                            {"p.exr", "p-2.exr"},   {"p.tif", "p.tif"},
                                                            {"p.jpg", "p.jpg.png"}, {"a.b", "a.b.png"}};
    for (const auto& [name, file] : pictures) {
        d.viewing.said.clear();
        d.desk.savePicture((folder / name).string());
        EXPECT_EQ(d.viewing.said, (std::vector<std::string>{std::string("screenshot ") + file}));
    }
    d.desk.savesScaleBar = true;
    d.viewing.said.clear();
    d.desk.savePicture((folder / "p").string(), 4);
    EXPECT_EQ(d.viewing.said, (std::vector<std::string>{"still p.png of 1600 x 1200 with a scale bar"}));
    EXPECT_NE(d.desk.message()->text.find("1600 x 1200 pixels are drawn for "), std::string::npos);
    d.desk.savesScaleBar = false;
    d.desk.savesLegend = true;
    d.viewing.said.clear();
    d.desk.savePicture((folder / "p").string());
    EXPECT_EQ(d.viewing.said,
              (std::vector<std::string>{"screenshot p.png with chest, HU from -200 to 1200"}));
}

TEST(WindowState, SlicesWithOverlaysHaveALegend) {
    Desk d;
    EXPECT_FALSE(d.desk.showsLegend());
    Scene scene = d.desk.scene();
    scene.mode = Mode::slice;
    d.desk.setScene(scene, false);
    EXPECT_FALSE(d.desk.showsLegend()) << "nothing lies over it";
    scene.volumes.push_back({"pet.zarr"});
    d.desk.setScene(scene, false);
    EXPECT_TRUE(d.desk.showsLegend());
    d.desk.showLegend = false;
    EXPECT_FALSE(d.desk.showsLegend());
    scene.mode = Mode::composite;
    d.desk.setScene(scene, false);
    d.desk.showLegend = true;
    EXPECT_TRUE(d.desk.showsLegend());
}

TEST(WindowState, PresetsAreTakenKeptAndNamed) {
    Desk d;
    EXPECT_EQ(d.desk.presetName(), "its own");
    d.desk.takePreset("bone-1");
    EXPECT_EQ(d.desk.presetName(), "bone-1");
    Preset kept;
    d.presets.keep = [&](const Preset& p) { kept = p; };
    d.presets.find = [&](const std::string& name, std::vector<std::string>& leftOut) {
        EXPECT_EQ(name, "mine");
        leftOut = {"clouds", "rain"};
        return kept;
    };
    d.presets.write = [&](const Preset& p, const std::filesystem::path& file, const std::string& format) {
        EXPECT_EQ(p.name, "f");
        EXPECT_EQ(file, "/x/f.json");
        EXPECT_EQ(format, "slicer");
        return std::vector<std::string>{"snow"};
    };
    Scene scene = d.desk.scene();
    scene.volumes[0].transferFunction = TransferFunction::fromOpacity({{0, 0}, {500, 0.5}}, {}, 1);
    scene.shading.ambient = 0.7;
    d.desk.setScene(scene, false);
    EXPECT_EQ(d.desk.presetName(), "its own");
    d.desk.keepPreset("mine");
    EXPECT_EQ(kept.name, "mine");
    EXPECT_EQ(d.desk.message()->text, "kept the preset mine");
    d.desk.takePreset("bone-1");
    d.desk.takePreset("mine");
    EXPECT_EQ(sceneJson(d.desk.scene()), sceneJson(scene));
    EXPECT_EQ(d.desk.presetName(), "mine");
    EXPECT_EQ(d.desk.message()->text, "mine: left out: clouds, rain");
    d.desk.undo();
    EXPECT_EQ(d.desk.presetName(), "bone-1");
    d.desk.writePreset("/x/f.json", "slicer");
    EXPECT_EQ(d.desk.message()->text, "wrote /x/f.json; left out: snow");
}

TEST(WindowState, PlanesHaveAShareOfTheWidth) {
    Desk d;
    EXPECT_EQ(d.desk.planesShare(), 0.28);
    const std::pair<double, double> shares[] = {{0.4, 0.4}, {0, 0.12}, {0.12, 0.12}, {0.8, 0.8}, {1, 0.8}};
    for (const auto& [asked, given] : shares) {
        d.desk.enlargedPlane = 1;
        EXPECT_EQ(d.desk.planesShare(), 0.6);
        d.desk.setPlanesShare(asked);
        EXPECT_EQ(d.desk.planesShare(), given);
        EXPECT_EQ(d.desk.enlargedPlane, -1);
    }
}

TEST(WindowState, AnotherPhaseLeavesTheView) {
    Desk d;
    d.viewing.said.clear();
    d.desk.stepPhase(1);
    d.desk.showPhase(1);
    EXPECT_TRUE(d.viewing.said.empty()) << "there are none";
    const auto phaseIs = [&](int phase) {
        auto seen = std::make_shared<VolumeSeen>(*test::pretendedVolume({400, 300}));
        seen->phases = {"0 %", "50 %", "75 %"};
        seen->phase = phase;
        seen->scene.volumes.front().source.phase = phase;
        d.viewing.seen = seen;
        d.viewing.now.kind = ViewingState::Kind::open;
        d.desk.update();
    };
    phaseIs(1);
    Scene scene = d.desk.scene();
    auto camera = std::get<Camera>(scene.camera);
    camera.position += glm::dvec3(3, 4, 5);
    scene.camera = camera;
    scene.cuts.boxes.push_back({{0, 0, 0}, {9, 9, 9}, CropBox::Space::patient, Keep::inside});
    scene.shading.ambient = 0.7;
    d.desk.setScene(scene, false);
    SliceWish planes = d.desk.slices();
    planes.placeMm = {1, 2, 3};
    d.desk.setSlices(planes);
    d.viewing.said.clear();
    d.desk.stepPhase(1);
    EXPECT_EQ(d.viewing.said.back(), "open chest.zarr at 400 x 300, series 0, phase 2, in the same view");
    d.viewing.now.kind = ViewingState::Kind::opening;
    d.desk.update();
    d.desk.stepPhase(1); // from the one that is on its way
    EXPECT_THAT(d.viewing.said.back(), ::testing::HasSubstr("phase 3"));
    d.desk.stepPhase(1); // behind the last the first
    EXPECT_THAT(d.viewing.said.back(), ::testing::HasSubstr("phase 1"));
    d.desk.stepPhase(-1);
    EXPECT_THAT(d.viewing.said.back(), ::testing::HasSubstr("phase 3"));
    const std::size_t asked = d.viewing.said.size();
    d.desk.showPhase(4);
    d.desk.showPhase(0);
    EXPECT_EQ(d.viewing.said.size(), asked) << "no such phase";
    phaseIs(3);
    scene.volumes.front().source.phase = 3;
    EXPECT_EQ(sceneJson(d.desk.scene()), sceneJson(scene));
    EXPECT_EQ(sceneJson(d.viewing.asked), sceneJson(scene));
    EXPECT_EQ(d.desk.slices().placeMm, planes.placeMm);
    EXPECT_THAT(d.viewing.said.back(), ::testing::HasSubstr("planes through 1.00 2.00 3.00"));
    d.desk.undo();
    EXPECT_EQ(d.desk.scene().volumes.front().source.phase, 3) << "edits before it are not undone";
}

TEST(WindowState, OffersAreChosenOrDismissed) {
    Desk d;
    auto offers = std::make_shared<VolumeOffers>();
    offers->offers.resize(2);
    offers->offers[1] = {"/scans/two", {7, 0, true, true}, "", "", "", {}};
    d.viewing.offered = offers;
    d.desk.update();
    EXPECT_EQ(d.desk.offers(), offers);
    d.viewing.said.clear();
    d.desk.choose(2);
    EXPECT_TRUE(d.viewing.said.empty()) << "no such offer";
    d.desk.showBrowser = true;
    d.desk.choose(1, 3);
    EXPECT_EQ(d.viewing.said,
              (std::vector<std::string>{"open two at 400 x 300, series 7, phase 3, resampled, with gaps"}));
    EXPECT_FALSE(d.desk.showBrowser);
    EXPECT_EQ(d.desk.offers(), nullptr) << "until there are others";
    d.desk.update();
    d.desk.dismissOffers();
    EXPECT_EQ(d.desk.offers(), nullptr);
    d.desk.update();
    EXPECT_EQ(d.desk.offers(), nullptr);
}

} // namespace
} // namespace tessera
