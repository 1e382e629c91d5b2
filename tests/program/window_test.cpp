// tests/program/window_test.cpp: a saved picture is bit for bit the one that `tessera render` draws of the
// scene saved beside it. Impossible actions give a message.
#include "tests/support/window_fixture.h"

namespace tessera::test {
namespace {

TEST_F(WindowTest, WhatAHandDoesIsWhatTheProgramDraws) {
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    ASSERT_EQ(std::system("xdotool windowfocus --sync $(xdotool search --name Tessera | tail -1)"), 0);
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image first = picture_;
    EXPECT_FALSE(isBlank(first));

    // Left drag: it turns.
    ASSERT_TRUE(after("mousemove 600 300 sleep 0.2 mousedown 1 sleep 0.3 mousemove 640 310 sleep 0.2 "
                      "mousemove 720 335 sleep 0.2 mouseup 1"));
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image turned = picture_;
    EXPECT_GT(differenceFrom(first), 0.01);

    // A point of the function's curve, dragged down: the panel is 330 wide, its curve at y 297 to 447.
    ASSERT_TRUE(after(
        "mousemove 222 309 mousedown 1 sleep 0.2 mousemove 224 340 sleep 0.2 mousemove 226 400 sleep 0.2 "
        "mouseup 1 mousemove 600 300"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_GT(differenceFrom(turned), 0.002) << "the curve's point was not dragged";
    // Taken back: the very scene of before.
    ASSERT_TRUE(after("key ctrl+z"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(differenceFrom(turned), 0);

    // The wheel, a double click, a side by its key.
    ASSERT_TRUE(after("mousemove 560 260 click 4 click 4 click 4"));
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image nearer = picture_;
    EXPECT_GT(differenceFrom(turned), 0.01);
    ASSERT_TRUE(after("mousemove 600 330 click --repeat 2 --delay 60 1"));
    ASSERT_TRUE(after("key 3"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_GT(differenceFrom(nearer), 0.01);

    // Without panels and planes the picture is as wide as the window.
    ASSERT_TRUE(after("key Tab sleep 0.3 key x"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(picture_.size, glm::ivec2(900, 600));
    ASSERT_TRUE(after("windowsize --sync $(xdotool search --name Tessera | tail -1) 640 420"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(picture_.size, glm::ivec2(640, 420));

    EXPECT_EQ(std::system("xdotool key ctrl+q"), 0);
    EXPECT_EQ(window_->exitCode(10s), 0) << readAll(folder_ / "window.txt");
    EXPECT_THAT(readAll(folder_ / "config/tessera/window.json"), HasSubstr("torso.zarr"));
}

TEST_F(WindowTest, KeysThatAreSetAreInItsScene) {
    start(TESSERA_TORSO, "", {"--set", "mode=mip", "--set", "window=100,900", "--set", "camera.view=left"});
    ASSERT_TRUE(rests());
    ASSERT_EQ(std::system("xdotool windowfocus --sync $(xdotool search --name Tessera | tail -1)"), 0);
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_FALSE(isBlank(picture_));
    const Scene now = scene();
    EXPECT_EQ(now.mode, Mode::maximum);
    EXPECT_EQ(std::get<GreyWindow>(now.window), (GreyWindow{100, 900}));
    const Camera& camera = std::get<Camera>(now.camera);
    EXPECT_GT(camera.position.x - camera.focalPoint.x, 100) << "seen from the patient's left";
}

// At rest after rounds of paths; the scene that is saved names the number of samples.
TEST_F(WindowTest, PathsOfLightAreWhatTheProgramDraws) {
    size_ = "480x200";
    start(TESSERA_TORSO, "",
          {"--set", "lighting.transport.bounces=4", "--set", "lighting.lights[0].kind=directional"});
    ASSERT_TRUE(rests());
    ASSERT_EQ(std::system("xdotool windowfocus --sync $(xdotool search --name Tessera | tail -1)"), 0);
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image first = picture_;
    EXPECT_FALSE(isBlank(first));
    ASSERT_TRUE(after("mousemove 380 100 sleep 0.2 mousedown 1 sleep 0.3 mousemove 400 110 sleep 0.2 "
                      "mousemove 420 115 sleep 0.2 mouseup 1"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_GT(differenceFrom(first), 0.01);
    EXPECT_EQ(scene().quality.pixels.samples, Transport::kSamples);
    EXPECT_TRUE(scene().lighting.transport);
}

TEST_F(WindowTest, AHandMeasuresCutsAndMovesTheCrosshair) {
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    ASSERT_EQ(std::system("xdotool windowfocus --sync $(xdotool search --name Tessera | tail -1)"), 0);
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image whole = picture_;

    // Two clicks measure between two places; each is seen where it was clicked.
    const std::vector<glm::dvec2> clicks = {{520, 250}, {560, 420}};
    ASSERT_TRUE(
        after("key m mousemove 520 250 sleep 0.3 click 1 sleep 1 mousemove 560 420 sleep 0.3 click 1"));
    Scene now = scene();
    ASSERT_EQ(now.measurements.size(), 1u);
    ASSERT_EQ(now.measurements[0].points.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec2 seen = inWindow(now, now.measurements[0].points[i]);
        EXPECT_NEAR(seen.x, clicks[i].x, 1.01) << i; // the middle of the clicked pixel, and rounding
        EXPECT_NEAR(seen.y, clicks[i].y, 1.01) << i;
    }
    EXPECT_EQ(valueOf(now.measurements[0]),
              glm::length(now.measurements[0].points[0] - now.measurements[0].points[1]));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(differenceFrom(whole), 0) << "measurements are in no picture";

    // The crosshair, dragged on the axial plane, is where a plane that cuts goes through. Of the 570 units
    // beside the panel the planes have the last 28 %, three of them one above the other.
    const double left = 330 + std::floor(570 * 0.72) + 2;
    const glm::dvec2 size(900 - left, 600.0 / 3 - 2), target = glm::dvec2(left, 0) + glm::dvec2(60, 70);
    const auto move = [](const glm::dvec2& p) {
        return "mousemove " + std::to_string(std::lround(p.x)) + " " + std::to_string(std::lround(p.y)) + " ";
    };
    ASSERT_TRUE(after(move(target + 40.0) + "sleep 0.2 mousedown 1 sleep 0.2 " + move(target + 9.0) +
                      "sleep 0.2 " + move(target) + "sleep 0.2 mouseup 1 sleep 0.2 mousemove 500 560 key n"));
    now = scene();
    ASSERT_EQ(now.cuts.planes.size(), 1u);
    const CutPlane plane = now.cuts.planes[0];
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const VolumeInfo info = StoreReader(TESSERA_TORSO, ram).info();
    const SliceFrame axial = sliceFrame(info, Orientation::axial, plane.point, glm::ivec2(size));
    const glm::dvec2 crosshair = axial.pictureFromPatient(plane.point) + glm::dvec2(left, 0);
    EXPECT_NEAR(crosshair.x, target.x, 1.01);
    EXPECT_NEAR(crosshair.y, target.y, 1.01);
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image cut = picture_;
    EXPECT_GT(differenceFrom(whole), 0.002);

    // Its handle pushes it along its normal, and nowhere else.
    const glm::dvec2 handle = inWindow(now, plane.point);
    ASSERT_TRUE(after(move(handle) + "sleep 0.2 mousedown 1 sleep 0.2 " + move(handle + glm::dvec2(0, 20)) +
                      "sleep 0.2 " + move(handle + glm::dvec2(0, 40)) +
                      "sleep 0.2 mouseup 1 mousemove 500 560"));
    const CutPlane pushed = scene().cuts.planes.at(0);
    const glm::dvec3 way = pushed.point - plane.point;
    EXPECT_GT(glm::length(way), 5);
    EXPECT_LT(glm::length(glm::cross(way, plane.normal)), 1e-6 * glm::length(way));
    EXPECT_EQ(pushed.normal, plane.normal);
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_GT(differenceFrom(cut), 0.002);
    ASSERT_TRUE(after("key ctrl+z"));
    ASSERT_TRUE(after("key ctrl+z"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(differenceFrom(whole), 0) << "both edits are taken back";

    // Scissors, and a box around the whole volume, which cuts nothing.
    ASSERT_TRUE(after("key k sleep 0.3 mousemove 480 200 mousedown 1 sleep 0.2 mousemove 620 210 sleep 0.2 "
                      "mousemove 610 380 sleep 0.2 mousemove 490 370 sleep 0.2 mouseup 1 mousemove 500 560"));
    now = scene();
    ASSERT_EQ(now.cuts.scissors.size(), 1u);
    EXPECT_EQ(now.cuts.scissors[0].keep, Keep::outside);
    ASSERT_TRUE(isThePictureOfItsScene());
    const Image scissored = picture_;
    EXPECT_GT(differenceFrom(whole), 0.002);
    ASSERT_TRUE(after("key b"));
    now = scene();
    ASSERT_EQ(now.cuts.boxes.size(), 1u);
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(differenceFrom(scissored), 0);

    // A side of the box goes where its handle is dragged, and no other side goes anywhere.
    const CropBox box = now.cuts.boxes[0];
    const auto leftSide = [&](const CropBox& b) {
        return glm::dvec3(info.patientFromVoxel *
                          glm::dvec4(b.high.x, (b.low.y + b.high.y) / 2, (b.low.z + b.high.z) / 2, 1));
    };
    const glm::dvec2 grip = inWindow(now, leftSide(box)), moved = grip - glm::dvec2(60, 0);
    ASSERT_TRUE(after(move(grip) + "sleep 0.2 mousedown 1 sleep 0.2 " + move(grip - glm::dvec2(30, 0)) +
                      "sleep 0.2 " + move(moved) + "sleep 0.2 mouseup 1 mousemove 500 560"));
    now = scene();
    const CropBox smaller = now.cuts.boxes.at(0);
    EXPECT_LT(smaller.high.x, box.high.x);
    EXPECT_EQ(smaller.low, box.low);
    EXPECT_EQ(smaller.high.y, box.high.y);
    EXPECT_EQ(smaller.high.z, box.high.z);
    EXPECT_NEAR(inWindow(now, leftSide(smaller)).x, moved.x, 3);
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_GT(differenceFrom(scissored), 0.0005);
}

// A folder with several series: the list is clicked, and what was clicked is drawn and saved. Without a path
// the folder is found by clicks, too.
TEST_F(WindowTest, ASeriesIsChosenByAClick) {
    fs::create_directories(folder_ / "a-scan"); // before what programs keep here
    for (const int series : {1, 2})
        for (int n = 0; n < 3 + 4 * (series - 1); ++n) {
            DicomImage image;
            image.columns = image.rows = 24;
            image.spacingX = image.spacingY = 1;
            image.series = std::to_string(series);
            image.pixels.assign(576, 24);
            for (int y = 6; y < 18; ++y)
                for (int x = 6; x < 18; ++x)
                    image.pixels[static_cast<std::size_t>(24 * y + x)] = 2000;
            image.position = glm::dvec3(0, 0, 2 * n);
            writeDicom(folder_ / "a-scan" / (std::to_string(series) + "-" + std::to_string(n)), image);
        }
    // In the browser: the folder, "open this folder", then the second row of the list.
    for (const std::string& way :
         {std::string("wait choice\n"),
          std::string("wait 300\nclick 400 284\nwait 300\nwindow in.ppm\nclick 520 254\n"
                      "wait choice\n")}) {
        std::ofstream(folder_ / "s.txt") << way << "wait 1000\nwindow list.ppm\nclick 600 340\nwait 300\n"
                                         << "wait still\npicture chosen.png\nscene chosen.json\nquit\n";
        start(way.find("click") == std::string::npos ? "a-scan" : "", "s.txt");
        ASSERT_EQ(window_->exitCode(60s), 0) << readAll(folder_ / "window.txt");
        const SceneVolume chosen = loadScene(folder_ / "chosen.json").volumes.front();
        EXPECT_EQ(chosen.path.filename(), "a-scan");
        EXPECT_EQ(chosen.source.series, 2);
        const Image picture = readImage(folder_ / "chosen.png");
        EXPECT_FALSE(isBlank(picture));
        // The scene draws the same when nothing is left of the import.
        fs::remove_all(folder_ / "cache");
        Process render({TESSERA_PROGRAM, "render", "chosen.json", "-o", "again.png", "--ram", "256MiB",
                        "--gpu-memory", "128MiB"},
                       folder_.path(), folder_ / "render.txt");
        ASSERT_EQ(render.exitCode(60s), 0) << readAll(folder_ / "render.txt");
        EXPECT_TRUE(picture.pixels == readImage(folder_ / "again.png").pixels);
        for (const char* const file : {"chosen.json", "chosen.png", "again.png"})
            fs::remove(folder_ / file);
        fs::remove_all(folder_ / "cache");
    }
}

// If the mode has nothing to draw it is offered the missing part; a scene that cannot be drawn ends a wait.
TEST_F(WindowTest, IsosurfacesAloneGetOne) {
    std::ofstream(folder_ / "s.txt") << "wait whole\nmode isosurface\nwait still\nscene surface.json\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(60s), 0) << readAll(folder_ / "window.txt");
    const Scene seen = loadScene(folder_ / "surface.json");
    ASSERT_EQ(seen.surfaces.size(), 1u);
    EXPECT_GT(seen.surfaces[0].value, 100) << "bone's";
    EXPECT_LT(seen.surfaces[0].value, 600);
}

TEST_F(WindowTest, AScriptDoesNotWaitForWhatCannotBeDrawn) {
    std::ofstream(folder_ / "s.txt") << "wait whole\nsize 3000x2400\nwait 1000\nwait still\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(60s), 2) << readAll(folder_ / "window.txt");
    EXPECT_THAT(readAll(folder_ / "window.txt"), HasSubstr("line 4"));
}

// Facts that a user must know of a volume are reported as it is opened.
TEST_F(WindowTest, ALabelMapIsSaidToBeOne) {
    const auto ball = [](const glm::dvec3& p, double x, double r) {
        return glm::length(p - glm::dvec3(x, 0, 0)) < r;
    };
    writeNifti(folder_ / "labels.nii", {60, 40, 40}, {-30, -20, -20}, [&](const glm::dvec3& p) {
        return ball(p, -15, 10) ? 2.0 : ball(p, 12, 12) ? 7.0 : 0.0;
    });
    std::ofstream(folder_ / "s.txt") << "wait whole\nprint message\nquit\n";
    start("labels.nii", "s.txt");
    EXPECT_EQ(window_->exitCode(60s), 0);
    EXPECT_THAT(readAll(folder_ / "window.txt"), HasSubstr("message: looks like a label map"));
}

// All that a context holds is made anew; what was open, seen and set stays.
TEST_F(WindowTest, ALostContextLosesNothing) {
    std::ofstream(folder_ / "s.txt") << "wait still\norbit 30 10\nlevels on\nwait still\nwait 5000\n"
                                        "window before.ppm\nlose-context\nwait 5500\nwindow after.ppm\n"
                                        "orbit 30 10\nwait still\npicture turned.png\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    const std::string before = readAll(folder_ / "before.ppm"), after = readAll(folder_ / "after.ppm");
    ASSERT_EQ(before.size(), after.size());
    std::size_t differing = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        differing += before[i] != after[i];
    EXPECT_LT(differing, before.size() / 100) << "but for what the State panel counts";
    EXPECT_FALSE(isBlank(readImage(folder_ / "turned.png")));
}

TEST_F(WindowTest, AtRestItTakesNoProcessor) {
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    std::this_thread::sleep_for(5s); // messages go
    const auto ticks = [&] {
        const std::string stat = readAll("/proc/" + std::to_string(window_->id()) + "/stat");
        std::istringstream fields(stat.substr(stat.rfind(')') + 2));
        std::string field;
        long user = 0, system = 0;
        for (int i = 3; i < 14; ++i)
            fields >> field;
        fields >> user >> system;
        return user + system;
    };
    const long before = ticks();
    std::this_thread::sleep_for(3s);
    EXPECT_LE(ticks() - before, 6) << "hundredths of a second in three: 2 % of a processor";
}

TEST_F(WindowTest, AScriptWithAMistakeIsRefusedByItsLine) {
    std::ofstream(folder_ / "s.txt") << "wait rest\n\nspin 10\n";
    start(TESSERA_TORSO, "s.txt");
    EXPECT_EQ(window_->exitCode(20s), 2);
    EXPECT_THAT(readAll(folder_ / "window.txt"), HasSubstr("line 3"));
}

TEST_F(WindowTest, EditsKeepTheOpacityByGradient) {
    std::ofstream(folder_ / "graded.json")
        << R"({"tesseraPreset":1,"unit":"HU","scalarOpacity":[[-200,0],[300,0.5]],)"
        << R"("gradientOpacity":[[0,0],[60,1]]})";
    std::ofstream(folder_ / "s.txt") << "wait picture\npreset graded.json\nwait still\nshift 20 1.1\n"
                                     << "wait still\nscene out.json\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    EXPECT_EQ(window_->exitCode(60s), 0) << readAll(folder_ / "window.txt");
    const Scene seen = loadScene(folder_ / "out.json");
    const auto& function = std::get<TransferFunction>(seen.volumes.front().transferFunction);
    EXPECT_EQ(function.gradientOpacity(), GradientOpacity::fromPoints({{0, 0}, {60, 1}}));
    EXPECT_NE(function.opacityPoints().front().value, -200);
}

TEST_F(WindowTest, WithoutADisplayItSaysSo) {
    ::setenv("DISPLAY", ":7777", 1);
    start(TESSERA_TORSO);
    EXPECT_EQ(window_->exitCode(20s), 1);
    EXPECT_THAT(readAll(folder_ / "window.txt"), HasSubstr("no window can be opened"));
}

TEST_F(WindowTest, WhatCannotBeOpenedIsSaidInTheWindow) {
    std::ofstream(folder_ / "s.txt") << "wait 500\nwindow shown.ppm\nquit\n";
    start("nowhere.zarr", "s.txt");
    EXPECT_EQ(window_->exitCode(30s), 0) << readAll(folder_ / "window.txt");
    EXPECT_GT(fs::file_size(folder_ / "shown.ppm"), 900u * 600 * 3);
    // Letters in the colour of warnings in the upper part, where else nothing is.
    const std::string picture = readAll(folder_ / "shown.ppm");
    const std::size_t pixels = picture.size() - 900u * 600 * 3;
    int letters = 0;
    for (std::size_t y = 60; y < 100; ++y)
        for (std::size_t x = 340; x < 890; ++x) {
            const std::size_t at = pixels + 3 * (y * 900 + x);
            letters += static_cast<unsigned char>(picture[at]) > 200 &&
                       static_cast<unsigned char>(picture[at + 2]) < 120;
        }
    EXPECT_GT(letters, 100);
}

} // namespace
} // namespace tessera::test
