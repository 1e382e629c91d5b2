// tests/program/window_flight_test.cpp: lines are found, flown and made a film of.
#include "tests/support/window_fixture.h"

namespace tessera::test {
namespace {

// A line is asked for, flown and made a film of: what the window shows on the way is what the film's frame of
// that moment shows.
TEST_F(WindowTest, AFlightIsTheFilmOfItsPath) {
    std::ofstream(folder_ / "s.txt") << "wait whole\n"
                                        "line -67 -33 -155 0 38 -200\n"
                                        "wait line\n"
                                        "fly-to 0\n"
                                        "scene flown.json\n"
                                        "save-path path.json\n"
                                        "fly-to 40\n"
                                        "wait still\n"
                                        "picture flown.png\n"
                                        "cover\n"
                                        "wait line\n"
                                        "look-at-patch 1\n"
                                        "wait still\n"
                                        "picture patch.png\n"
                                        "scene patch.json\n"
                                        "quit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    // 20 mm/s and 25 frames/s: 40 mm are reached at frame 50.
    Process film({TESSERA_PROGRAM, "render", "flown.json", "--path", "path.json", "--frames", "50-50", "-o",
                  "frames/", "--ram", "256MiB", "--gpu-memory", "128MiB"},
                 folder_.path(), folder_ / "film.txt");
    ASSERT_EQ(film.exitCode(60s), 0) << readAll(folder_ / "film.txt");
    Image frame;
    for (const auto& entry : fs::directory_iterator(folder_ / "frames"))
        if (entry.path().extension() == ".png")
            frame = readImage(entry.path());
    const Image flown = readImage(folder_ / "flown.png");
    EXPECT_FALSE(isBlank(flown));
    ASSERT_EQ(frame.size, flown.size);
    EXPECT_EQ(frame.pixels, flown.pixels);

    // The largest patch that the flight does not see is in the middle of the picture that searches for it.
    Process coverage({TESSERA_PROGRAM, "coverage", TESSERA_TORSO, "--path", "path.json", "--size",
                      std::to_string(flown.size.x) + "x" + std::to_string(flown.size.y), "-o", "unseen.json"},
                     folder_.path(), folder_ / "coverage.txt");
    ASSERT_EQ(coverage.exitCode(60s), 0) << readAll(folder_ / "coverage.txt");
    const auto patch = nlohmann::json::parse(readAll(folder_ / "unseen.json"))["patches"][0]["middle"];
    const Camera camera = std::get<Camera>(loadScene(folder_ / "patch.json").camera);
    const glm::dvec3 way = glm::dvec3(patch[0], patch[1], patch[2]) - camera.position;
    EXPECT_GT(glm::dot(glm::normalize(way), glm::normalize(camera.focalPoint - camera.position)), 0.99);
    EXPECT_FALSE(isBlank(readImage(folder_ / "patch.png")));
}

// Two places in a pipe, and between them a piece as dark as the lung that it opens to. A line through it may
// lie in the lung, and is not flown before the user confirms it.
TEST_F(WindowTest, ALineThatMayHaveLeftTheLumenIsAskedAbout) {
    writeNifti(folder_ / "pipe.nii", {90, 60, 90}, {-30, -30, -5}, [](const glm::dvec3& p) {
        const double away = glm::length(p - glm::dvec3(0, 0, std::clamp(p.z, 0.0, 80.0)));
        const double pipe = -1000 + 1040 * std::clamp(away - 5.5, 0.0, 1.0);
        if (p.z > 30 && p.z < 50 && pipe < -800)
            return -840.0;
        const bool open = p.x > 10 || (p.x > 0 && std::abs(p.z - 40) < 5 && std::abs(p.y) < 3);
        return std::min(pipe, open ? -850.0 : 40.0);
    });
    std::ofstream(folder_ / "s.txt")
        << "wait whole\nline 0 0 6 0 0 74\nwait line\n"
           "save-path found.json\nwait whole\nwindow found.ppm\n"
           "fly-to 60\nwait 300\nscene asked.json\nwindow asked.ppm\n"
           "answer cancel\nwait 200\nscene cancelled.json\n"
           "fly-to 60\nanswer stop\nwait whole\nscene stopped.json\n"
           "save-path stopped-path.json\n"
           "load-path found.json\nfly-to 60\nscene loaded.json\n"
           "answer fly\nwait whole\nscene flown.json\nsave-path flown-path.json\n"
           "load-path found.json\nfly 3\nquit\n";
    start("pipe.nii", "s.txt");
    EXPECT_EQ(window_->exitCode(60s), 2) << "an answer is due";
    EXPECT_THAT(readAll(folder_ / "window.txt"), HasSubstr("an answer first"));
    const auto sceneIn = [&](const char* name) { return loadScene(folder_ / name); };
    const auto pathIn = [&](const char* name) { return nlohmann::json::parse(readAll(folder_ / name)); };
    const double leaves = pathIn("found.json")["lumen"].value("leavesAt", 0.0);
    EXPECT_NEAR(leaves, 24, 2);
    const glm::dvec3 outside = std::get<Camera>(sceneIn("asked.json").camera).position;
    for (const char* const name : {"asked.json", "cancelled.json"}) {
        EXPECT_EQ(sceneIn(name).mode, Mode::composite) << name;
        EXPECT_EQ(std::get<Camera>(sceneIn(name).camera).position, outside) << name;
    }
    EXPECT_EQ(sceneIn("stopped.json").mode, Mode::isosurface) << "it is flown";
    EXPECT_NEAR(std::get<Camera>(sceneIn("stopped.json").camera).position.z, 6 + leaves, 2)
        << "to where it may have left the lumen";
    EXPECT_EQ(pathIn("stopped-path.json")["flight"]["to"], leaves);
    EXPECT_NEAR(std::get<Camera>(sceneIn("loaded.json").camera).position.z, 6 + leaves, 2) << "asked anew";
    EXPECT_NEAR(std::get<Camera>(sceneIn("flown.json").camera).position.z, 66, 3);
    EXPECT_FALSE(pathIn("flown-path.json")["flight"].contains("to"));
}

} // namespace
} // namespace tessera::test
