// tests/program/window_test.cpp: the real window on a display of its own (Xvfb), driven by a hand that does
// not know that it is none (xdotool): what is saved there is, bit for bit, what `tessera render` draws of the
// scene that was saved beside it.
#include "bricking/store/store_reader.h"
#include "core/base/scratch_folder.h"
#include "core/image/image_file.h"
#include "core/image/image_metrics.h"
#include "core/scene/scene.h"
#include "tests/support/dicom_writer.h"
#include "viewer/session/slice_frame.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

std::string readAll(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// A process that ends with it.
class Process {
  public:
    Process(const std::vector<std::string>& words, const fs::path& folder, const fs::path& said,
            int keptOpen = -1) {
        child_ = ::fork();
        if (child_ != 0)
            return;
        fs::current_path(folder);
        if (const int out = ::open(said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644); out >= 0) {
            if (keptOpen != 1)
                ::dup2(out, 1);
            ::dup2(out, 2);
        }
        std::vector<char*> argv;
        for (const std::string& word : words)
            argv.push_back(const_cast<char*>(word.c_str()));
        argv.push_back(nullptr);
        ::execvp(argv[0], argv.data());
        ::_exit(127);
    }
    ~Process() {
        if (child_ > 0)
            ::kill(child_, SIGTERM); // a display's server takes its lock along
        if (child_ > 0 && !exitCode(2s)) {
            ::kill(child_, SIGKILL);
            ::waitpid(child_, nullptr, 0);
        }
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t id() const { return child_; }
    /// Once it has ended, within that time.
    std::optional<int> exitCode(std::chrono::seconds patience) {
        const auto end = std::chrono::steady_clock::now() + patience;
        do {
            int status = 0;
            if (child_ > 0 && ::waitpid(child_, &status, WNOHANG) == child_) {
                child_ = 0;
                code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
            }
            if (child_ == 0)
                return code_;
            std::this_thread::sleep_for(20ms);
        } while (std::chrono::steady_clock::now() < end);
        return std::nullopt;
    }

  private:
    pid_t child_ = 0;
    int code_ = 0;
};

class WindowTest : public ::testing::Test {
  protected:
    void SetUp() override {
        if (std::system("command -v Xvfb >/dev/null && command -v xdotool >/dev/null") != 0)
            GTEST_SKIP() << "Xvfb or xdotool is not installed";
        ::setenv("XDG_CONFIG_HOME", (folder_ / "config").c_str(), 1);
        ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
        int ends[2];
        ASSERT_EQ(::pipe(ends), 0);
        display_.emplace(std::vector<std::string>{"Xvfb", "-displayfd", std::to_string(ends[1]), "-screen",
                                                  "0", "1400x1000x24", "-nolisten", "tcp",
                                                  // Else it ends who comes as the last one leaves.
                                                  "-noreset"},
                         folder_.path(), folder_ / "xvfb.txt");
        ::close(ends[1]);
        std::string number;
        for (char c = 0; ::read(ends[0], &c, 1) == 1 && c != '\n';)
            number += c;
        ::close(ends[0]);
        ASSERT_FALSE(number.empty()) << readAll(folder_ / "xvfb.txt");
        ::setenv("DISPLAY", (":" + number).c_str(), 1);
        const auto end = std::chrono::steady_clock::now() + 20s;
        while (printed("xdotool getdisplaygeometry") != "1400 1000") {
            ASSERT_LT(std::chrono::steady_clock::now(), end) << readAll(folder_ / "xvfb.txt");
            std::this_thread::sleep_for(50ms);
        }
    }
    void TearDown() override {
        window_.reset();
        display_.reset();
    }

    void start(const std::string& path, const std::string& more = "") {
        std::vector<std::string> words = {TESSERA_PROGRAM, "view",   path,           "--size", "900x600",
                                          "--ram",         "512MiB", "--gpu-memory", "256MiB"};
        words[4] = size_;
        if (size_.empty())
            words.erase(words.begin() + 3, words.begin() + 5);
        if (path.empty())
            words.erase(words.begin() + 2);
        if (!more.empty())
            words.insert(words.end(), {"--script", more});
        window_.emplace(words, folder_.path(), folder_ / "window.txt");
    }
    /// What a command prints.
    std::string printed(const std::string& command) const {
        std::string text;
        if (std::FILE* const pipe = ::popen((command + " 2>/dev/null").c_str(), "r")) {
            char part[256];
            while (std::fgets(part, sizeof part, pipe))
                text += part;
            ::pclose(pipe);
        }
        while (!text.empty() && text.back() == '\n')
            text.pop_back();
        return text;
    }
    std::string title() const {
        return printed("xdotool getwindowname $(xdotool search --name Tessera | tail -1)");
    }
    ::testing::AssertionResult rests() {
        const auto end = std::chrono::steady_clock::now() + 60s;
        std::string last;
        int still = 0;
        while (std::chrono::steady_clock::now() < end) {
            last = title();
            still = last.find("(at rest)") != std::string::npos ? still + 1 : 0;
            if (still == 8)
                return ::testing::AssertionSuccess();
            if (window_->exitCode(0s))
                return ::testing::AssertionFailure()
                       << "the window is gone: " << readAll(folder_ / "window.txt");
            std::this_thread::sleep_for(50ms);
        }
        return ::testing::AssertionFailure() << "\"" << last << "\": " << readAll(folder_ / "window.txt");
    }
    /// Does something that begins another picture, and waits for its end.
    ::testing::AssertionResult after(const std::string& hand) {
        if (std::system(("xdotool " + hand).c_str()) != 0)
            return ::testing::AssertionFailure() << hand;
        std::this_thread::sleep_for(600ms); // the title goes from rest first
        return rests();
    }
    /// Saves picture and scene, and draws the scene without a window.
    ::testing::AssertionResult isThePictureOfItsScene() {
        for (const char* const file : {"torso.png", "torso.json", "drawn.png"})
            fs::remove(folder_ / file);
        if (std::system("xdotool key F12 sleep 0.3 key ctrl+s") != 0)
            return ::testing::AssertionFailure() << "no key";
        const auto end = std::chrono::steady_clock::now() + 20s;
        while (!fs::exists(folder_ / "torso.png") || !fs::exists(folder_ / "torso.json")) {
            if (std::chrono::steady_clock::now() > end)
                return ::testing::AssertionFailure() << "nothing was saved";
            std::this_thread::sleep_for(50ms);
        }
        // Half of both budgets: what stills have.
        Process render({TESSERA_PROGRAM, "render", "torso.json", "-o", "drawn.png", "--ram", "256MiB",
                        "--gpu-memory", "128MiB"},
                       folder_.path(), folder_ / "render.txt");
        if (render.exitCode(60s) != 0)
            return ::testing::AssertionFailure() << readAll(folder_ / "render.txt");
        picture_ = readImage(folder_ / "torso.png");
        const Image drawn = readImage(folder_ / "drawn.png");
        if (picture_.size != drawn.size)
            return ::testing::AssertionFailure() << "sizes differ";
        const auto differing =
            static_cast<long>(picture_.pixels.size()) -
            std::inner_product(picture_.pixels.begin(), picture_.pixels.end(), drawn.pixels.begin(), 0L,
                               std::plus<>(), [](const auto& a, const auto& b) { return a == b ? 1L : 0L; });
        if (differing > 0)
            return ::testing::AssertionFailure() << differing << " pixels differ";
        return ::testing::AssertionSuccess();
    }
    /// The scene as it is in the window.
    Scene scene() {
        fs::remove(folder_ / "torso.json");
        EXPECT_EQ(std::system("xdotool key ctrl+s"), 0);
        const auto end = std::chrono::steady_clock::now() + 20s;
        while (!fs::exists(folder_ / "torso.json") && std::chrono::steady_clock::now() < end)
            std::this_thread::sleep_for(50ms);
        return loadScene(folder_ / "torso.json");
    }
    /// Where a place lies in the window, by the camera's own formula. The panel is 330 wide.
    static glm::dvec2 inWindow(const Scene& scene, const glm::dvec3& mm) {
        const Camera& camera = std::get<Camera>(scene.camera);
        const glm::dvec3 c = glm::transpose(patientFromCamera(camera)) * (mm - camera.position);
        const glm::dvec2 size(scene.imageSize);
        const double scale = size.y / 2 / (-c.z * std::tan(glm::radians(camera.viewAngle) / 2));
        return glm::dvec2(330 + size.x / 2 + c.x * scale, size.y / 2 - c.y * scale);
    }
    double differenceFrom(const Image& before) const {
        double sum = 0;
        for (std::size_t i = 0; i < before.pixels.size(); ++i)
            sum += glm::length(before.pixels[i] - picture_.pixels[i]);
        return sum / static_cast<double>(before.pixels.size());
    }

    ScratchFolder folder_;
    std::optional<Process> display_, window_;
    std::string size_ = "900x600"; // units
    Image picture_;
};

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

// Twice as many pixels to a unit: the picture has them all, the panel is as wide in units, and what is
// clicked is what lies there.
TEST_F(WindowTest, OnAFineDisplayUnitsHaveMorePixels) {
    if (std::system("command -v xrdb >/dev/null") != 0)
        GTEST_SKIP() << "xrdb is not installed";
    ASSERT_EQ(std::system("echo 'Xft.dpi: 192' | xrdb -merge"), 0);
    size_ = "600x450";
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    ASSERT_EQ(std::system("xdotool windowfocus --sync $(xdotool search --name Tessera | tail -1)"), 0);
    ASSERT_TRUE(isThePictureOfItsScene());
    const double wide = std::floor((600 - 330) * 0.72); // beside the panel, the planes' 28 %
    EXPECT_NEAR(picture_.size.x, 2 * wide, 1);
    EXPECT_EQ(picture_.size.y, 900);
    ASSERT_TRUE(after("key Tab sleep 0.3 key x"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(picture_.size, glm::ivec2(1200, 900));
    const std::vector<glm::dvec2> clicks = {{560, 380}, {640, 560}};
    ASSERT_TRUE(
        after("key m mousemove 560 380 sleep 0.3 click 1 sleep 1 mousemove 640 560 sleep 0.3 click 1"));
    const Scene now = scene();
    ASSERT_EQ(now.measurements.size(), 1u);
    ASSERT_EQ(now.measurements[0].points.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec2 seen = inWindow(now, now.measurements[0].points[i]) - glm::dvec2(330, 0);
        EXPECT_NEAR(seen.x, clicks[i].x, 1.01) << i;
        EXPECT_NEAR(seen.y, clicks[i].y, 1.01) << i;
    }
}

// One rule: what shows fits the pane that it is shown in, of whatever shape, from every side, and after every
// preset; what a hand has moved stays in the picture where the pane gets narrower.
TEST_F(WindowTest, WhatShowsFitsItsPane) {
    std::ofstream(folder_ / "s.txt") << "wait still\npicture first.png\n"
                                        "view left\nwait still\npicture left.png\n"
                                        "preset skin\nwait still\npicture skin.png\n"
                                        "planes off\npanels off\nwait still\npicture wide.png\n"
                                        "orbit 30 20\nzoom 3\nfit\nwait still\npicture fitted.png\n"
                                        "planes on\npanels on\nwait still\npicture narrow.png\n"
                                        "projection parallel\nwait still\npicture parallel.png\n"
                                        "mode isosurface\nwait still\npicture surface.png\n"
                                        "mode slice\nwait still\npicture slice.png\n"
                                        "view left\nwait still\npicture sagittal.png\n"
                                        "mode composite\nwait still\npicture back.png\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    for (const char* const name : {"first", "left", "skin", "wide", "fitted", "narrow", "parallel", "surface",
                                   "slice", "sagittal", "back"}) {
        const Image picture = readImage(folder_ / (std::string(name) + ".png"));
        const glm::ivec2 size = picture.size;
        glm::ivec2 low = size, high(-1);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                if (const glm::vec4 p = picture.pixels[static_cast<std::size_t>(y * size.x + x)];
                    p.r + p.g + p.b > 0.02f)
                    low = glm::min(low, {x, y}), high = glm::max(high, {x, y});
        ASSERT_GT(high.x, 0) << name << " shows nothing";
        EXPECT_GT(low.x, 0) << name;
        EXPECT_GT(low.y, 0) << name;
        EXPECT_LT(high.x, size.x - 1) << name;
        EXPECT_LT(high.y, size.y - 1) << name;
        const glm::dvec2 part = glm::dvec2(high - low + 1) / glm::dvec2(size);
        const bool slice = std::string(name) == "slice" || std::string(name) == "sagittal";
        EXPECT_GT(std::max(part.x, part.y), slice ? 0.6 : 0.85) // slices fit with the air around the patient
            << name << " fills " << part.x << " x " << part.y;
    }
}

// More pixels than are shown are those of `tessera render` with that size.
TEST_F(WindowTest, APictureIsSavedLargerThanItIsShown) {
    std::ofstream(folder_ / "s.txt") << "wait still\npicture torso.png 2\nwait 500\nwait rest\n"
                                        "scene torso.json\nscale-bar on\npicture torso-bar.png 2\nwait 500\n"
                                        "wait rest\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    const Image large = readImage(folder_ / "torso.png");
    const glm::ivec2 size = loadScene(folder_ / "torso.json").imageSize;
    ASSERT_EQ(large.size, 2 * size);
    const auto drawn = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words = {TESSERA_PROGRAM,
                                          "render",
                                          "torso.json",
                                          "-o",
                                          "drawn.png",
                                          "--ram",
                                          "256MiB",
                                          "--gpu-memory",
                                          "128MiB",
                                          "--size",
                                          std::to_string(large.size.x) + "x" + std::to_string(large.size.y)};
        words.insert(words.end(), more.begin(), more.end());
        Process render(words, folder_.path(), folder_ / "render.txt");
        EXPECT_EQ(render.exitCode(60s), 0) << readAll(folder_ / "render.txt");
        return readImage(folder_ / "drawn.png").pixels;
    };
    EXPECT_TRUE(large.pixels == drawn({}));
    const Image barred = readImage(folder_ / "torso-bar.png");
    EXPECT_TRUE(barred.pixels == drawn({"--scale-bar"}));
    int changed = 0;
    for (int y = 0; y < barred.size.y; ++y)
        for (int x = 0; x < barred.size.x; ++x)
            if (barred.at(x, y) != large.at(x, y)) {
                ++changed;
                EXPECT_TRUE(x > barred.size.x / 3 && y > barred.size.y * 3 / 4) << x << " " << y;
            }
    EXPECT_GT(changed, 400);
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

// Where the mode has nothing to draw it is offered what it lacks; a scene that cannot be drawn ends a wait.
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

// The size that is named is the size that one gets, whatever is remembered.
TEST_F(WindowTest, ASizeThatIsNamedIsTaken) {
    fs::create_directories(folder_ / "config/tessera");
    std::ofstream(folder_ / "config/tessera/window.json") << R"({"windowSize": [700, 500]})";
    const auto sizeNow = [&] {
        return printed("xdotool getwindowgeometry --shell $(xdotool search --name Tessera | tail -1) | "
                       "sed -n 's/^\\(WIDTH\\|HEIGHT\\)=//p' | tr '\\n' ' '");
    };
    start(TESSERA_TORSO); // --size 900x600
    ASSERT_TRUE(rests());
    EXPECT_EQ(sizeNow(), "900 600 ");
    EXPECT_EQ(std::system("xdotool key ctrl+q"), 0);
    ASSERT_EQ(window_->exitCode(10s), 0);
    size_.clear();
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    EXPECT_EQ(sizeNow(), "900 600 ") << "remembered";
}

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

    // The largest patch that the flight does not see is in the middle of the picture that looks for it.
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

/// A NIfTI file of 16 bits, a voxel of a millimetre.
/// @param value  of a place, mm, LPS
void writeNifti(const fs::path& file, const glm::ivec3& size, const glm::dvec3& origin,
                const std::function<double(const glm::dvec3&)>& value) {
    std::string text(352, '\0');
    const auto put = [&](std::size_t at, auto number) { std::memcpy(&text[at], &number, sizeof number); };
    put(0, 348);
    const std::int16_t dims[] = {3, static_cast<std::int16_t>(size.x), static_cast<std::int16_t>(size.y),
                                 static_cast<std::int16_t>(size.z)};
    for (std::size_t i = 0; i < 4; ++i)
        put(40 + 2 * i, dims[i]);
    put(70, std::int16_t{4}); // of 16 bits
    put(72, std::int16_t{16});
    for (std::size_t i = 0; i < 4; ++i)
        put(76 + 4 * i, 1.0f);
    put(108, 352.0f);
    put(123, std::uint8_t{2}); // mm
    put(254, std::int16_t{1}); // places by the rows that follow: RAS
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float sign = axis < 2 ? -1.0f : 1.0f;
        put(280 + 20 * axis, sign);
        put(292 + 16 * axis, sign * static_cast<float>(origin[static_cast<int>(axis)]));
    }
    text.replace(344, 3, "n+1");
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const auto voxel =
                    static_cast<std::int16_t>(std::lround(value(origin + glm::dvec3(x, y, z))));
                text.append(reinterpret_cast<const char*>(&voxel), 2);
            }
    std::ofstream(file, std::ios::binary) << text;
}

// What one has to know of a volume is told as it is opened.
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

// Two places in a pipe with a piece between them that is as dark as the lung which it opens to: a line
// through it may lie in the lung, and is not flown before somebody says so.
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
