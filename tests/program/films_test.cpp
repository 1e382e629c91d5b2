// tests/program/films_test.cpp: films by the program: frames that equal stills, folders that processes share
// and that survive kill -9, what is refused, and the file that ffmpeg makes of them.
#include "tests/support/program_fixture.h"

#include "core/base/error.h"
#include "core/image/image_file.h"
#include "viewer/films/frame_folder.h"
#include "viewer/films/movie_file.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using Clock = std::chrono::steady_clock;

/// Round the sphere, and into another function and light on the way; 11 frames.
constexpr const char* kPath = R"({"tesseraPath":1,"framesPerSecond":10,"keyframes":[
 {"time":0,"camera":{"position":[0,-500,60],"focalPoint":[0,0,0],"viewAngle":40},
  "transferFunction":{"scalarOpacity":[[-500,0],[500,0.1]]}},
 {"time":0.4,"camera":{"position":[300,-300,0],"focalPoint":[0,0,0],"viewAngle":40}},
 {"time":1,"camera":{"position":[400,10,-60],"focalPoint":[0,0,0],"viewAngle":50},
  "transferFunction":{"scalarOpacity":[[-500,0],[500,0.9]],"rgbTransferFunction":[[0,1,0.2,0.1]]}}]})";
/// Through it in a straight line, the camera alone; 10 frames.
constexpr const char* kFlight = R"({"tesseraPath":1,"framesPerSecond":10,
 "lines":[{"count":4,"spacing":30,"points":[[-45,0,0],[-15,0,0],[15,0,0],[45,0,0]],"radius":[30,30,30,30]}],
 "flight":{"speed":100,"viewAngle":120,"lookAhead":10}})";
constexpr const char* kScene = R"({"tesseraScene":1,"volumes":[{"path":"s.zarr",
 "transferFunction":{"scalarOpacity":[[-500,0],[500,0.1]]}}],"image":{"size":[24,16]}})";

std::string pixelsOf(const std::string& png) {
    return png.substr(std::min(png.size(), png.find("IDAT")));
}
std::string frameName(std::size_t n) {
    return FrameFolder::nameOf(n);
}

/// The same way as a line whose lumen is known.
std::string flightInLumen(const std::string& lumen) {
    std::string text = kFlight;
    return text.insert(text.find("\"lines\""), "\"lumen\":" + lumen + ",");
}

class Films : public Program {
  protected:
    void SetUp() override {
        makeSphere();
        write("path.json", kPath);
        write("flight.json", kFlight);
        write("scene.json", kScene);
    }
    /// Names in a folder, in order.
    std::vector<std::string> names(const std::string& folder) const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(folder_ / folder))
            all.push_back(entry.path().filename());
        std::sort(all.begin(), all.end());
        return all;
    }
    std::vector<std::string> pixelsIn(const std::string& folder, std::size_t count) const {
        std::vector<std::string> all;
        for (std::size_t n = 0; n < count; ++n)
            all.push_back(pixelsOf(readAll(folder_ / folder / frameName(n))));
        return all;
    }
    static constexpr std::size_t kFrames = 11;
};

TEST_F(Films, FramesEqualStills) {
    for (const auto& [path, count] : {std::pair{"path.json", kFrames}, {"flight.json", std::size_t{10}}}) {
        const Outcome film =
            run(std::string("render scene.json --path ") + path + " -o film --engine native --json");
        ASSERT_EQ(film.exitCode, 0) << film.problems;
        const json report = json::parse(film.out);
        EXPECT_EQ(report["drawn"], count);
        // if the camera alone moves, bricks stay
        EXPECT_EQ(report["withBricksOfTheOneBefore"], path[0] == 'f' ? count - 1 : 0);
        std::set<std::string> different;
        for (std::size_t n = 0; n < count; n += 3) {
            // a still of the very scene that the frame tells of
            const std::string frame = readAll(folder_ / "film" / frameName(n));
            const json manifest = json::parse(readManifest(folder_ / "film" / frameName(n)));
            EXPECT_EQ(manifest["film"]["frame"], n);
            EXPECT_NEAR(manifest["film"]["seconds"].get<double>(), static_cast<double>(n) / 10, 1e-9);
            json scene = manifest["scene"];
            scene["volumes"][0]["path"] = "s.zarr";
            write("still.json", scene.dump());
            ASSERT_EQ(run("render still.json -o still.png --engine native --verify none").exitCode, 0);
            EXPECT_EQ(pixelsOf(frame), pixelsOf(readAll(folder_ / "still.png"))) << path << " " << n;
            different.insert(pixelsOf(frame));
        }
        EXPECT_EQ(different.size(), (count + 2) / 3) << "frames that do not change";
        fs::remove_all(folder_ / "film");
    }
}

TEST_F(Films, GoOnWhereTheyStopped) {
    const std::string film = "render scene.json --path path.json -o film/ --engine native ";
    ASSERT_EQ(run(film + "--frames 2-4").exitCode, 0);
    EXPECT_EQ(names("film"),
              (std::vector<std::string>{"film.json", frameName(2), frameName(3), frameName(4)}));
    for (const std::size_t n : {2, 3, 4}) { // of the film, not of the part that is drawn
        const json film = json::parse(readManifest(folder_ / "film" / frameName(n)))["film"];
        EXPECT_EQ(film["frame"], n);
        EXPECT_NEAR(film["seconds"].get<double>(), static_cast<double>(n) / 10, 1e-9);
    }
    const auto before = fs::last_write_time(folder_ / "film" / frameName(3));
    const json rest = json::parse(run(film + "--json").out);
    EXPECT_EQ(rest["there"], 3);
    EXPECT_EQ(rest["drawn"], kFrames - 3);
    EXPECT_EQ(fs::last_write_time(folder_ / "film" / frameName(3)), before);
    const std::vector<std::string> all = pixelsIn("film", kFrames);
    fs::remove(folder_ / "film" / frameName(0));
    fs::remove(folder_ / "film" / frameName(7));
    EXPECT_EQ(json::parse(run(film + "--json").out)["drawn"], 2);
    EXPECT_EQ(pixelsIn("film", kFrames), all);
    EXPECT_EQ(names("film").size(), kFrames + 1);
}

/// Another film's frames are never mixed with this one's, and the refusal says what differs.
TEST_F(Films, AFolderHoldsOneFilm) {
    const std::string film = " --path path.json -o film --engine native --frames 0";
    ASSERT_EQ(run("render scene.json" + film).exitCode, 0);
    expectRefused("render scene.json --size 25x16" + film, {"film", "size", "25", "24"});
    expectRefused("render scene.json --fps 11" + film, {"frames", "11", "12"});
    expectRefused("render scene.json --preset auto" + film, {"transferFunction"});
    expectRefused("render scene.json --gpu-memory 200MiB" + film, {"budgets.gpuMemory"});
    expectRefused("render scene.json --path flight.json -o film --engine native", {"frames"});
    expectRefused("render scene.json --path path.json -o film --engine mirror",
                  {"engine", "mirror", "native"});
    // frames of an unknown film, and a file instead of a folder
    fs::remove(folder_ / "film" / "film.json");
    expectRefused("render scene.json" + film, {"film", "without a film.json"});
    write("plain", "x");
    expectRefused("render scene.json --path path.json -o plain", {"plain", "a folder", "a file"});
    write("film/film.json", "{");
    expectRefused("render scene.json" + film, {"film.json", "something else"});
}

TEST_F(Films, WhatIsRefused) {
    const std::string render = "render scene.json ";
    expectRefused(render + "--path nothing.json -o f", {"nothing.json"});
    write("bad.json", R"({"tesseraPath":1,"keyframes":[{"time":0,"cuts":{}}]})");
    expectRefused(render + "--path bad.json -o f", {"bad.json", "\"flight\"", "camera"});
    expectRefused(render + "--path path.json -o f.png", {"f.png", "folder", ".mp4"});
    expectRefused(render + "--path path.json -o f --frames 3-11", {"--frames", "0 to 10", "3-11"});
    expectRefused(render + "--path path.json -o f --frames 4-3", {"--frames"});
    expectRefused(render + "--path path.json -o f --frames x", {"--frames"});
    expectRefused(render + "--path path.json -o f --speed 5", {"--speed", "flown"});
    expectRefused(render + "--path flight.json -o f --speed 5 --seconds 3", {"--speed", "--seconds"});
    expectRefused(render + "--path path.json -o f --view front", {"--view", "--path"});
    expectRefused(render + "-o a.png --frames 3", {"--frames", "--path"});
    expectRefused(render + "-o a.png --fps 3", {"--fps", "--path"});
    EXPECT_FALSE(exists("f"));
}

TEST_F(Films, SpeedAndSeconds) {
    const std::string film = "render scene.json --path flight.json --engine native --size 4x4 --json -o ";
    EXPECT_EQ(json::parse(run(film + "a --speed 30").out)["frames"], 31); // 90 mm in 3 s, 10 a second
    EXPECT_EQ(json::parse(run(film + "b --seconds 2 --fps 4").out)["frames"], 9);
    EXPECT_EQ(json::parse(run(film + "c --speed 0.5 --fps 0.1").out)["frames"], 19); // 180 s, one in 10 s
    EXPECT_EQ(json::parse(run(film + "d --seconds 0.5").out)["frames"], 6);
}

/// Without ffmpeg a film is refused before any work; with one, it gets the frames in their order.
TEST_F(Films, BecomeOneFile) {
    const std::string path = std::getenv("PATH");
    fs::create_directory(folder_ / "bin");
    ::setenv("PATH", (folder_ / "bin").c_str(), 1);
    expectRefused("render scene.json --path path.json -o film.mp4",
                  {"film.mp4", "ffmpeg", "install", "frames/"});
    EXPECT_FALSE(exists("film.mp4.frames"));
    // writes what it was asked, and the frames, into the file that it was asked for
    write("bin/ffmpeg", "#!/bin/sh\nPATH=" + path +
                            "\nall=\"$*\"\nwhile [ $# -gt 1 ]; do [ \"$1\" = -i ] && in=\"$2\"; shift; done\n"
                            "echo \"$all\" > \"$1\"\ncat \"${in%/*}\"/frame-*.png >> \"$1\"\n");
    fs::permissions(folder_ / "bin/ffmpeg", fs::perms::owner_all);
    const std::string film = "render scene.json --path path.json -o film.mp4 --engine native ";
    const Outcome made = run(film + "--frames 3-5");
    ASSERT_EQ(made.exitCode, 0) << made.problems;
    const std::string content = readAll(folder_ / "film.mp4");
    const std::string asked = content.substr(0, content.find('\n'));
    EXPECT_THAT(asked, ::testing::HasSubstr("-framerate 10 -start_number 3 "));
    EXPECT_THAT(asked, ::testing::HasSubstr("-frames:v 3 "));
    EXPECT_FALSE(exists("film.mp4.frames"));
    ASSERT_EQ(run("render scene.json --path path.json -o whole --engine native").exitCode, 0);
    for (std::size_t n = 3; n <= 5; ++n)
        EXPECT_NE(content.find(pixelsOf(readAll(folder_ / "whole" / frameName(n))).substr(0, 40)),
                  std::string::npos);
    // one that fails: what it said, no file, and the frames stay for the next time
    write("bin/ffmpeg", "#!/bin/sh\necho first >&2\necho 'no such codec' >&2\nexit 3\n");
    fs::remove(folder_ / "film.mp4");
    const Outcome failed = run(film + "--frames 3-5");
    EXPECT_EQ(failed.exitCode, 1);
    EXPECT_THAT(failed.problems, ::testing::HasSubstr("no such codec"));
    EXPECT_FALSE(exists("film.mp4"));
    EXPECT_EQ(names("film.mp4.frames").size(), 4U);
    ::setenv("PATH", path.c_str(), 1);
}

TEST_F(Films, CtrlCLeavesWholeFrames) {
    const std::string film =
        "render scene.json --path path.json -o film --engine mirror --size 96x96 --step 0.25";
    const pid_t child = start(film);
    while (!exists("film/" + frameName(1)))
        ::usleep(1000);
    ::kill(child, SIGINT);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 130) << status;
    for (const std::string& name : names("film"))
        EXPECT_NE(name.front(), '.') << name;
    ASSERT_EQ(run(film + " --json").exitCode, 0);
    EXPECT_EQ(names("film").size(), kFrames + 1);
}

/// Two processes on one folder, one of them killed at twenty moments: the other one ends with all frames,
/// each as it should be, and nothing else is left.
TEST_F(Films, SurviveKillsWithTwoProcesses) {
    const std::string film = "render scene.json --path path.json --engine mirror --size 32x32 -o ";
    const auto began = Clock::now();
    ASSERT_EQ(run(film + "whole").exitCode, 0);
    const std::chrono::duration<double> whole = Clock::now() - began;
    const std::vector<std::string> expected = pixelsIn("whole", kFrames);
    std::mt19937 random(7);
    int byBoth = 0;
    for (int kill = 0; kill < 20; ++kill) {
        fs::remove_all(folder_ / "film");
        const pid_t first = start(film + "film"), second = start(film + "film");
        std::this_thread::sleep_for(whole * std::uniform_real_distribution<double>(0, 1)(random));
        ::kill(first, SIGKILL);
        int status = 0;
        ::waitpid(first, &status, 0);
        byBoth += WIFSIGNALED(status);
        ::waitpid(second, &status, 0);
        ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << readAll(folder_ / ".err");
        ASSERT_EQ(pixelsIn("film", kFrames), expected) << kill;
        // the rest of the killed run goes with the next run
        std::ofstream(folder_ / "film" / ".film-1-0.json") << "killed before it was the film's";
        ASSERT_EQ(run(film + "film").exitCode, 0);
        for (const std::string& name : names("film"))
            EXPECT_TRUE(name.front() != '.') << name << " after kill " << kill;
    }
    EXPECT_GT(byBoth, 5);
}

/// A frame that a process has locked stays locked until the process ends, however it ends.
class Claims : public ::testing::TestWithParam<ClaimKind> {
  protected:
    static constexpr double kLease = 0.4;
    const json film_ = {{"tesseraFilm", 1}, {"size", {2, 2}}};
    const ScratchFolder scratch_;
    std::unique_ptr<FrameFolder> open() const {
        return std::make_unique<FrameFolder>(scratch_ / "film", film_, GetParam(), kLease);
    }
};

TEST_P(Claims, OfFramesThatAreThereGo) {
    const auto a = open();
    const auto held = a->claim(7);
    for (const char* const left : {"frame-000002.png", ".frame-000002.png.claim"}) // of one who was killed
        std::ofstream(scratch_ / "film" / left) << "x";
    const auto b = open();
    EXPECT_FALSE(fs::exists(scratch_ / "film/.frame-000002.png.claim"));
    EXPECT_TRUE(fs::exists(scratch_ / "film/.frame-000007.png.claim"));
    EXPECT_FALSE(b->claim(7));
}

TEST_P(Claims, AreForOne) {
    const auto a = open(), b = open();
    auto claim = a->claim(3);
    ASSERT_TRUE(claim);
    EXPECT_FALSE(b->claim(3));
    EXPECT_TRUE(b->claim(4));
    std::this_thread::sleep_for(std::chrono::duration<double>(2 * kLease));
    EXPECT_FALSE(b->claim(3)) << "a claim that is kept up was taken";
    claim.reset();
    EXPECT_TRUE(b->claim(3));
    std::ofstream(a->pathOf(3)) << "x";
    EXPECT_FALSE(b->claim(3)) << "a frame that is there";
}

TEST_P(Claims, EndWithTheirProcess) {
    const auto mine = open();
    const pid_t child = ::fork();
    if (child == 0) {
        const auto theirs = open();
        const auto claim = theirs->claim(5);
        std::ofstream(scratch_ / "claimed") << "x";
        ::pause();
        ::_exit(0);
    }
    while (!fs::exists(scratch_ / "claimed"))
        ::usleep(1000);
    EXPECT_FALSE(mine->claim(5));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    if (GetParam() == ClaimKind::lease)
        std::this_thread::sleep_for(std::chrono::duration<double>(1.2 * kLease));
    EXPECT_TRUE(mine->claim(5));
}

/// Many at once: of all who try, one gets it, and it is free again when that one is done.
TEST_P(Claims, AreNeverForTwo) {
    std::atomic<int> holders{0}, most{0}, got{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            const auto folder = open();
            const auto end = Clock::now() + std::chrono::seconds(60);
            for (int own = 0; own < 5 && Clock::now() < end;)
                if (const auto claim = folder->claim(1)) {
                    most = std::max(most.load(), ++holders);
                    ++got, ++own;
                    std::this_thread::yield();
                    --holders;
                }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(most, 1);
    EXPECT_EQ(got, 20) << "each its five";
}

INSTANTIATE_TEST_SUITE_P(Kinds, Claims, ::testing::Values(ClaimKind::lock, ClaimKind::lease));

TEST_F(Films, APathOfALumenShowsItsWallWhereNothingIsNamed) {
    write("wall.json", flightInLumen(R"({"threshold":-120,"side":"below"})"));
    const std::string film = "render s.zarr --path wall.json --engine native --size 8x6 --frames 0 -o ";
    const auto sceneOfFrame = [&](const std::string& folder) {
        return json::parse(readManifest(folder_ / folder / frameName(0)))["scene"];
    };
    const Outcome wall = run(film + "wall");
    ASSERT_EQ(wall.exitCode, 0) << wall.problems;
    EXPECT_THAT(wall.problems, HasSubstr("the lumen's wall, at -120"));
    EXPECT_EQ(sceneOfFrame("wall")["mode"], "isosurface");
    EXPECT_EQ(sceneOfFrame("wall")["isosurfaces"][0]["value"], -120);
    write("shown.json", flightInLumen(R"({"threshold":-120,"side":"below","noise":9,"surface":-60})"));
    ASSERT_EQ(run("render s.zarr --path shown.json --engine native --size 8x6 --frames 0 -o shown").exitCode,
              0);
    EXPECT_EQ(sceneOfFrame("shown")["isosurfaces"][0]["value"], -60);
    for (const std::string named : {"--preset bone ", "--isosurface=10 ", "--mode mip "}) {
        const std::string folder = "named" + std::to_string(named.size());
        ASSERT_EQ(run(film + folder + " " + named).exitCode, 0) << named;
        EXPECT_THAT(sceneOfFrame(folder).dump(), Not(HasSubstr("-120"))) << named;
    }
    ASSERT_EQ(run("render scene.json --path wall.json --engine native --frames 0 -o scene").exitCode, 0);
    EXPECT_THAT(sceneOfFrame("scene").dump(), Not(HasSubstr("-120"))) << "a scene says what it shows";

    write("leaks.json", flightInLumen(R"({"threshold":-120,"side":"below","leaks":true})"));
    const std::string unfold = "render s.zarr --path leaks.json --unfold --engine native --size 8x8 -o w.png";
    expectRefused(unfold, {"leaks.json", "does not leak", "--may-leak"});
    write("leaks.json", flightInLumen(R"({"threshold":-120,"side":"below","leaks":true,"leavesAt":3.5})"));
    expectRefused(unfold, {"may have left the lumen at 3.5 mm"});
    const Outcome kept = run(unfold + " --may-leak");
    EXPECT_EQ(kept.exitCode, 0);
    EXPECT_THAT(kept.problems, HasSubstr("may have left the lumen at 3.5 mm"));
    expectRefused("render s.zarr -o w.png --may-leak", {"--may-leak", "--unfold"});
    // Its height follows from the line, unless a size is given, by whatever option.
    const std::string unsized =
        "render s.zarr --path leaks.json --unfold --may-leak --engine native -q -o w.png ";
    for (const char* given : {"--size 8x7", "--set image.size=[8,7]"}) {
        ASSERT_EQ(run(unsized + given).exitCode, 0) << given;
        EXPECT_EQ(json::parse(readManifest(folder_ / "w.png"))["scene"]["image"]["size"], json({8, 7}))
            << given;
    }
}

// A film without a path; its subject is never cut off, and its middle stays.
TEST_F(Films, ATurntableGoesAroundWhatIsShown) {
    const std::string small = " --engine mirror --preset auto --size 32x32 --json -q ";
    Outcome outcome = run("render s.zarr --turn 360 --frames 4 -o turn" + small);
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_EQ(json::parse(outcome.out)["frames"], 4);
    for (std::size_t n = 0; n < 4; ++n)
        EXPECT_TRUE(exists("turn/" + frameName(n))) << n;
    EXPECT_FALSE(exists("turn/" + frameName(4)));
    EXPECT_NE(pixelsOf(readAll(folder_ / "turn" / frameName(0))),
              pixelsOf(readAll(folder_ / "turn" / frameName(1))));
    outcome = run("render s.zarr --turn 360 --frames 4 -o turn" + small);
    EXPECT_EQ(json::parse(outcome.out)["there"], 4) << "it goes on where it stopped";
    outcome = run("render s.zarr --turn=-90 --seconds 0.2 --fps 20 --view 30,15 --projection parallel "
                  "--mm-per-pixel 20 -o part" +
                  small);
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_EQ(json::parse(outcome.out)["frames"], 4);
    EXPECT_EQ(run("render scene.json --turn 180 --frames 2 -o c --view left -q").exitCode, 0);
    expectRefused("render s.zarr --turn 360 --path path.json -o a", {"--turn", "--path", "both"});
    expectRefused("render s.zarr --turn 360 --frames 0-9 -o a", {"--frames", "how many", "0-9"});
    expectRefused("render s.zarr --turn 360 --frames 1 -o a", {"--frames", "2"});
    expectRefused("render s.zarr --turn 360 --speed 3 -o a", {"--speed", "--turn"});
    expectRefused("render s.zarr --turn 360 --slice axial -o a", {"--turn", "slice"});
    expectRefused("render s.zarr --turn 360 -o a.png", {"a.png"});
    expectRefused("render s.zarr --frames 9 -o a.png", {"--frames", "--path or --turn"});
}

} // namespace
} // namespace tessera::test
