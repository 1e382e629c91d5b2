// tests/viewer/window/window_script_test.cpp: scripts of input: what each step changes and asks for, which
// steps are refused and why, and what they wait for.
#include "core/base/program_folders.h"
#include "tests/support/window_record.h"
#include "viewer/window/script.h"

#include <fstream>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

/// A window whose hand is a script.
class ScriptWindow : public PictureWindow {
  public:
    ScriptWindow() {
        desk.showSlices = false;
        records = [](const Drawn&) { return false; };
        window.resize = [this](const glm::ivec2& s) {
            say("size " + std::to_string(s.x) + " x " + std::to_string(s.y));
        };
        window.capture = [this](const std::filesystem::path& p) { say("captures " + p.filename().string()); };
        window.close = [this] { say("closes"); };
        window.countGlObjects = [] { return 7; };
        window.loseContext = [this] { say("loses its context"); };
        window.press = [this](int key, bool shift) {
            say("key " + std::to_string(key) + (shift ? " with Shift" : ""));
        };
        window.point = [this](const ScriptedHand& h) {
            say("hand " + std::to_string(std::lround(h.at.x)) + " " + std::to_string(std::lround(h.at.y)) +
                (h.down ? " down" : "") +
                (h.wheel != 0 ? " wheel " + std::to_string(std::lround(h.wheel)) : ""));
        };
    }
    /// Runs it for at most so many frames; its message where it is refused.
    std::string run(const std::string& lines, int frames = 30) {
        std::ofstream(folder / "script") << lines;
        try {
            Script script(folder / "script");
            for (int n = 0; n < frames; ++n) {
                frame();
                if (!script.advance(desk, endoscopy, window))
                    return "";
            }
            return "waits";
        } catch (const Error& e) {
            std::string words = e.what();
            if (const auto at = words.find((folder / "script").string()); at != std::string::npos)
                words.replace(at, (folder / "script").string().size(), "script");
            return words;
        }
    }
    void stepped(const std::string& lines, int frames = 30) {
        std::string out, problem, name = lines;
        std::replace(name.begin(), name.end(), '\n', '|');
        step(name, [&] {
            ::testing::internal::CaptureStdout();
            problem = run(lines, frames);
            out = ::testing::internal::GetCapturedStdout();
            if (!out.empty())
                viewing.said.push_back("prints: " + out.substr(0, out.size() - 1));
            if (!problem.empty())
                viewing.said.push_back("ends: " + problem);
        });
    }
    ScratchFolder folder;
    Script::Window window;

  private:
    void say(const std::string& words) { viewing.said.push_back(words); }
};

TEST(WindowDrawn, StepsOfAScript) {
    ScriptWindow w;
    w.step("open", [] {});
    for (const char* const lines : {"open /a/b.zarr",
                                    "print message",
                                    "click 10 20",
                                    "double-click 10 20",
                                    "drag 10 20 70 80",
                                    "wheel 10 20 3",
                                    "key m",
                                    "key M",
                                    "key 1",
                                    "orbit 20 10",
                                    "pan 0.1 -0.2",
                                    "zoom 1.5",
                                    "roll 30",
                                    "view left",
                                    "fit",
                                    "projection parallel",
                                    "projection perspective",
                                    "turn 90 3",
                                    "preset bone-1",
                                    "light studio",
                                    "shift 100 1.5",
                                    "isosurface 250",
                                    "size 640x480",
                                    "picture a.png",
                                    "legend on\nscale-bar on\npicture a.png 2",
                                    "scale-bar off\npicture a.png 100",
                                    "window w.ppm",
                                    "mode maximum",
                                    "window-of 40,400",
                                    "window-of lung",
                                    "crop 1 2 3 4 5 6",
                                    "place 1 2 3",
                                    "panels on",
                                    "panels off",
                                    "help on",
                                    "help off",
                                    "levels on",
                                    "levels off",
                                    "line 1 2 3 4 5 6",
                                    "tree 1 2 3",
                                    "print state",
                                    "quit",
                                    "lose-context",
                                    "# nothing\n\n  \nzoom 2"})
        w.stepped(lines);
    EXPECT_FALSE(w.desk.showHelp || w.desk.showLevels || w.desk.savesScaleBar || w.desk.showPanels);
    w.stepped("planes on");
    EXPECT_TRUE(w.desk.showSlices);
    w.stepped("planes off");
    w.viewing.answer = PickedPlace{0, true, {1, 2, 3}, {4, 5, 6}, 77, 1};
    w.stepped("pick 30 40");
    EXPECT_EQ(w.viewing.pickedAt, glm::dvec2(30, 40));
    w.viewing.answer->hit = false;
    w.stepped("pick 31 40");
    w.viewing.answer.reset();
    w.stepped("pick 31 40");
    for (const char* const bad :
         {"leap 3", "orbit 1", "orbit 1 x", "zoom inf", "size 10x10", "size 640", "key mm", "key #",
          "choose 1", "line 1 2 3 4", "tree 1 2 3 4 5 6", "fly-to 3", "record", "answer fly", "view above",
          "mode none", "zoom 2\n\npan a b"})
        w.stepped(bad);
    compareWithRecord(w, "script-steps");
}

TEST(WindowScript, WaitsForWhatItNames) {
    ScriptWindow w;
    w.frame();
    const auto waits = [&](const std::string& what) { return w.run("wait " + what, 3); };
    w.viewing.drawn->stage = Stage::whole;
    EXPECT_EQ(waits("volume"), "");
    EXPECT_EQ(waits("line"), "");
    EXPECT_EQ(waits("picture"), "");
    EXPECT_EQ(waits("whole"), "");
    EXPECT_EQ(waits("rest"), "waits");
    w.viewing.now.atRest = true;
    EXPECT_EQ(waits("rest"), "");
    EXPECT_EQ(waits("still"), "");
    EXPECT_EQ(waits("choice"), "waits");
    w.viewing.offered = std::make_shared<VolumeOffers>();
    EXPECT_EQ(waits("choice"), "");
    w.viewing.now.kind = ViewingState::Kind::opening;
    EXPECT_EQ(waits("choice"), "waits");
    w.viewing.now.kind = ViewingState::Kind::failed;
    w.viewing.now.what = "no such file";
    EXPECT_EQ(waits("choice"), "");
    EXPECT_NE(waits("rest").find("no such file"), std::string::npos);
    EXPECT_EQ(w.run("wait 0"), "");
    w.viewing.now.kind = ViewingState::Kind::open;
    const auto start = WindowClock::now();
    EXPECT_EQ(w.run("wait 40", 1000000), "");
    const auto took = WindowClock::now() - start;
    EXPECT_GE(took, std::chrono::milliseconds(40));
    EXPECT_LT(took, std::chrono::seconds(20));
    for (const Stage stage : {Stage::moving, Stage::loading, Stage::whole, Stage::round, Stage::still}) {
        auto picture = std::make_shared<ShownPicture>(*w.viewing.drawn);
        picture->stage = stage;
        w.viewing.drawn = picture;
        EXPECT_EQ(waits("whole"), stage == Stage::moving || stage == Stage::loading ? "waits" : "");
    }
    EXPECT_EQ(waits("samples 1"), "waits");
    auto round = std::make_shared<ShownPicture>(*w.viewing.drawn);
    round->samples = SamplesSeen{8, 64, 0.01};
    w.viewing.drawn = round;
    EXPECT_EQ(waits("samples 8"), "");
    EXPECT_EQ(waits("samples 9"), "waits");
    EXPECT_NE(waits("samples few").find("a number"), std::string::npos);
    EXPECT_NE(waits("samples").find("a number"), std::string::npos);
    w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
    EXPECT_EQ(waits("line"), "waits");
    w.desk.setCamera(w.desk.camera(), false);
    w.viewing.now.refused = w.viewing.shows;
    w.viewing.now.problem = "it does not fit";
    w.frame();
    EXPECT_NE(waits("rest").find("it does not fit"), std::string::npos);
    EXPECT_EQ(waits("volume"), "");
    w.viewing.seen.reset();
    w.viewing.drawn.reset();
    EXPECT_EQ(waits("volume"), "waits");
    EXPECT_EQ(waits("picture"), "waits");
    EXPECT_NE(w.run("orbit 1 2").find("an open volume first"), std::string::npos);
}

TEST(WindowScript, ChoosesByNumber) {
    ScriptWindow w;
    auto offers = std::make_shared<VolumeOffers>();
    offers->offers.resize(2);
    offers->offers[1].path = "/scans/second";
    offers->offers[1].pick.series = 5;
    w.viewing.offered = offers;
    w.frame();
    EXPECT_NE(w.run("choose 0"), "");
    EXPECT_NE(w.run("choose 3"), "");
    w.viewing.said.clear();
    EXPECT_EQ(w.run("choose 2 4"), "");
    ASSERT_EQ(w.viewing.said.size(), 1u);
    EXPECT_EQ(w.viewing.said[0], "open second at 600 x 600, series 5, phase 4");
    w.viewing.offered.reset();
    w.viewing.now.kind = ViewingState::Kind::opening;
    EXPECT_EQ(w.run("choose 1"), "waits");
}

} // namespace
} // namespace tessera::test
