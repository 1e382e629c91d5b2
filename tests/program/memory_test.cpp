// tests/program/memory_test.cpp: the true memory of the process, as the kernel counts it. The largest
// resident memory of import, phantom and render stays within a limit. It is the budgets, plus the memory of
// the same command with almost no work (libraries, driver, compiled shaders), plus 32 MiB. On a software
// device GPU memory is resident memory too.
#include "core/base/program_folders.h"
#include "tests/support/folders.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sstream>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

extern char** environ;

namespace {

namespace fs = std::filesystem;
constexpr double kMiB = 1 << 20;
constexpr double kSlackMiB = 32;

class Memory : public ::testing::Test {
  protected:
    void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
        GTEST_SKIP() << "a sanitizer keeps freed memory and shadows the rest";
#endif
        // A driver that compiles a program takes some 40 MiB more than one that kept it: each run compiles.
        ::setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    }

    /// Runs the program in the folder; the largest resident memory in MiB. Not forked: a child begins with a
    /// copy of its parent's account.
    double peakMiB(const std::string& arguments) {
        std::vector<std::string> words = {TESSERA_PROGRAM};
        std::istringstream text(arguments);
        for (std::string word; text >> word;)
            words.push_back(word);
        std::vector<char*> argv;
        for (std::string& word : words)
            argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addchdir_np(&actions, folder_.path().c_str());
        const std::string log = (folder_ / "log").string();
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                         0600);
        pid_t child = 0;
        const int failure = ::posix_spawn(&child, TESSERA_PROGRAM, &actions, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        EXPECT_EQ(failure, 0);
        int status = 0;
        rusage usage{};
        ::wait4(child, &status, 0, &usage);
        std::ifstream said(log);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
            << arguments << "\n"
            << std::string(std::istreambuf_iterator<char>(said), {});
        return static_cast<double>(usage.ru_maxrss) / 1024;
    }
    void expectWithin(const std::string& arguments, double emptyMiB, double budgetsMiB) {
        const double peak = peakMiB(arguments);
        std::printf("%6.1f MiB: %5.1f of %5.1f MiB above the empty one: %s\n", peak, peak - emptyMiB,
                    budgetsMiB + kSlackMiB, arguments.c_str());
        EXPECT_LE(peak, emptyMiB + budgetsMiB + kSlackMiB) << arguments;
    }
    static std::string budgets(int ramMiB, int gpuMiB) {
        return " --ram " + std::to_string(ramMiB) + "MiB --gpu-memory " + std::to_string(gpuMiB) + "MiB";
    }
    /// The smallest volume there is, in the format that is read next.
    void writeRaw(const std::string& name, int x, int y, int z) {
        std::ofstream(folder_ / (name + ".json"))
            << R"({"data":")" << name
            << R"(.raw","type":"int16","unit":"HU","spacing":[1.5,1.5,1.5],"extent":[)" << x << "," << y
            << "," << z << "]}";
        std::ofstream file(folder_ / (name + ".raw"), std::ios::binary);
        std::vector<std::int16_t> row(static_cast<std::size_t>(x));
        std::uint32_t noise = 1;
        for (int k = 0; k < z; ++k)
            for (int j = 0; j < y; ++j) {
                for (int i = 0; i < x; ++i) { // a body with noise, in air
                    noise = noise * 1664525u + 1013904223u;
                    const double r = std::hypot(2.0 * i / x - 1, 2.0 * j / y - 1);
                    row[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(
                        r > 0.9 ? -1000 : 400 * std::cos(9 * r + 0.05 * k) + (noise >> 26));
                }
                file.write(reinterpret_cast<const char*>(row.data()),
                           static_cast<std::streamsize>(row.size() * sizeof row[0]));
            }
    }

    const tessera::ScratchFolder folder_;
};

TEST_F(Memory, PhantomAndRenderStayWithinTheirBudgets) {
    const double emptyPhantom = peakMiB("phantom torso --size 1x1x1 -o tiny.zarr -q");
    expectWithin("phantom torso --size 256x192x300 -o torso.zarr -q --ram 24MiB", emptyPhantom, 24);
    const double empty = peakMiB("render tiny.zarr -o a.png --size 1x1 -q --gl-device software");
    for (const auto& [ram, gpu] : {std::pair(10, 3), {12, 6}, {24, 24}, {64, 12}, {96, 64}})
        expectWithin("render torso.zarr -o a.png --size 160x160 -q --gl-device software" + budgets(ram, gpu),
                     empty, ram + gpu);
    expectWithin("render torso.zarr -o a.png --size 160x160 -q --no-skipping --preset soft-tissue"
                 " --gl-device software" +
                     budgets(48, 24),
                 empty, 48 + 24);
    // Engines of the processor have no device; their level is chosen by the same budget, and takes none of
    // it.
    const double emptyMirror = peakMiB("render tiny.zarr -o a.png --size 1x1 -q --engine mirror");
    for (const int ram : {10, 48})
        expectWithin("render torso.zarr -o a.png --size 96x96 -q --engine mirror" + budgets(ram, 24),
                     emptyMirror, ram);
}

TEST_F(Memory, LargePicturesAreOnTheLedger) {
    const double empty = peakMiB("phantom sphere --size 2x2x2 -o tiny.zarr -q");
    const int pixelsMiB = 4; // 2048 x 2048
    for (const char* name : {"a.png", "a.exr", "a.tif"})
        expectWithin("render tiny.zarr --size 2048x2048 -q --engine mirror --preset auto -o " +
                         std::string(name) + budgets(pixelsMiB * 56, 256),
                     empty, pixelsMiB * 56);
    expectWithin("render tiny.zarr --size 1024x1024 -q --engine reference --preset auto -o a.exr" +
                     budgets(144, 64),
                 empty, 144);
}

TEST_F(Memory, ImportStaysWithinItsBudget) {
#if TESSERA_WITH_IMPORT
    writeRaw("tiny", 2, 2, 2);
    writeRaw("body", 256, 192, 300);
    const double empty = peakMiB("import tiny.json tiny.zarr -q");
    for (const int ram : {12, 24, 64})
        expectWithin("import body.json body.zarr -q --force --ram " + std::to_string(ram) + "MiB", empty,
                     ram);
    const fs::path abdomen = fs::weakly_canonical(tessera::test::testData()) / "ct-abdomen-dicom";
    if (!fs::exists(abdomen))
        GTEST_SKIP() << "the rest: " << abdomen << " is absent";
    // One slice of it would be the empty scene; libraries are the same, so the raw one is the stricter
    // measure.
    expectWithin("import " + abdomen.string() + " abdomen.zarr -q --ram 48MiB", empty, 48);
    const double emptyRender = peakMiB("render tiny.zarr -o a.png --size 1x1 -q --gl-device software");
    expectWithin("render abdomen.zarr -o a.png --size 256x256 -q --gl-device software" + budgets(48, 24),
                 emptyRender, 48 + 24);
#else
    GTEST_SKIP() << "built without importers";
#endif
}

} // namespace
