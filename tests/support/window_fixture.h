// tests/support/window_fixture.h: the real window on a display of its own (Xvfb), driven by a hand that does
// not know that it is none (xdotool).
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/program_folders.h"
#include "core/image/image_file.h"
#include "core/image/image_metrics.h"
#include "core/scene/scene.h"
#include "tests/support/dicom_writer.h"
#include "viewer/session/view_geometry.h"

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

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::HasSubstr;

inline std::string readAll(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// A NIfTI file of 16 bits, a voxel of a millimetre.
/// @param value  of a place, mm, LPS
inline void writeNifti(const fs::path& file, const glm::ivec3& size, const glm::dvec3& origin,
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

    /// @param script  of input; "": none
    void start(const std::string& path, const std::string& script = "",
               const std::vector<std::string>& more = {}) {
        std::vector<std::string> words = {TESSERA_PROGRAM, "view",   path,           "--size", "900x600",
                                          "--ram",         "512MiB", "--gpu-memory", "256MiB"};
        words[4] = size_;
        if (size_.empty())
            words.erase(words.begin() + 3, words.begin() + 5);
        if (path.empty())
            words.erase(words.begin() + 2);
        if (!script.empty())
            words.insert(words.end(), {"--script", script});
        words.insert(words.end(), more.begin(), more.end());
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

} // namespace tessera::test
