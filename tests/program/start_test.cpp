// tests/program/start_test.cpp: libraries and memory at the program's start: no library of GL, pictures or
// importers, and little memory. Each library is loaded only where it is needed.
#include "core/base/program_folders.h"

#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sstream>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

extern char** environ;

namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

// By file name. Large libraries are a way for others: OpenImageIO brings OpenCV, which brings libGLX.
const std::string kGl = "^(libGL|libOpenGL|libEGL|libgbm|libLLVM|libglapi|libgallium|.*_dri[.]so)";
const std::string kPictures = "^(tessera_pictures|libOpenImageIO|libopencv|libOpenEXR|libpng|libtiff)";
const std::string kImporters = "^(tessera_importers|libdcm|liboflog|libopenjp2|libcharls|libvtk|libgdcm)";
const std::string kSlices = "^(tessera_slices|libOpenImageIO)";
const std::string kFigures = "^(tessera_annotations|libcairo|libpango|libfontconfig)";
constexpr double kMostMiB = 40; // resident, to say how it is used

struct Outcome {
    std::vector<std::string> loaded; // libraries, by file name
    double residentMiB = 0;          // at most
};

class Start : public ::testing::Test {
  protected:
    /// The dynamic linker itself tells every library that it initialises, later ones included.
    Outcome run(const std::string& arguments) {
        std::vector<std::string> words = {TESSERA_PROGRAM};
        std::istringstream text(arguments);
        for (std::string word; text >> word;)
            words.push_back(word);
        std::vector<char*> argv;
        for (std::string& word : words)
            argv.push_back(word.data());
        argv.push_back(nullptr);
        const std::string log = (folder_ / "loaded").string();
        std::vector<std::string> settings = {"LD_DEBUG=libs", "LD_DEBUG_OUTPUT=" + log};
        std::vector<char*> variables;
        for (std::string& setting : settings)
            variables.push_back(setting.data());
        for (char** each = environ; *each; ++each)
            variables.push_back(*each);
        variables.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addchdir_np(&actions, folder_.path().c_str());
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "out", O_WRONLY | O_CREAT | O_TRUNC, 0600);
        pid_t child = 0;
        // Not forked: a child begins with a copy of its parent's account.
        EXPECT_EQ(::posix_spawn(&child, TESSERA_PROGRAM, &actions, nullptr, argv.data(), variables.data()),
                  0);
        posix_spawn_file_actions_destroy(&actions);
        int status = 0;
        rusage usage{};
        ::wait4(child, &status, 0, &usage);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << arguments;
        Outcome result;
        result.residentMiB = static_cast<double>(usage.ru_maxrss) / 1024;
        std::ifstream file(log + "." + std::to_string(child));
        const std::string mark = "calling init: ";
        for (std::string line; std::getline(file, line);)
            if (const std::size_t at = line.find(mark); at != std::string::npos)
                result.loaded.push_back(fs::path(line.substr(at + mark.size())).filename());
        EXPECT_THAT(result.loaded, ::testing::Contains(HasSubstr("libstdc++"))) << "nothing was told";
        return result;
    }
    const tessera::ScratchFolder folder_;
};

TEST_F(Start, HelpAndInfoLoadNothingOfGlPicturesAndImporters) {
    run("phantom sphere --size 40x33x24 -o s.zarr -q");
    for (const char* arguments : {"--help", "render --help", "--version", "info s.zarr"}) {
        const Outcome said = run(arguments);
        for (const std::string& kind : {kGl, kPictures, kImporters})
            EXPECT_THAT(said.loaded, Each(Not(ContainsRegex(kind)))) << arguments;
        EXPECT_LE(said.loaded.size(), 24u) << arguments;
    }
}

TEST_F(Start, HelpTakesLittleMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer keeps freed memory and shadows the rest";
#endif
    const double mib = run("--help").residentMiB;
    std::printf("%.1f MiB\n", mib);
    EXPECT_LE(mib, kMostMiB);
}

TEST_F(Start, APictureByTheCpuLoadsNothingOfGlAndOfImporters) {
    run("phantom sphere --size 40x33x24 -o s.zarr -q");
    for (const std::string engine : {"mirror", "native"}) {
        const Outcome drew =
            run("render s.zarr --engine " + engine + " --size 16x16 -o " + engine + ".png -q");
        EXPECT_TRUE(fs::exists(folder_ / (engine + ".png")));
        for (const std::string& kind : {kGl, kImporters, kFigures})
            EXPECT_THAT(drew.loaded, Each(Not(ContainsRegex(kind)))) << engine;
        EXPECT_LE(drew.loaded.size(), 48u) << engine;
        // The names above still mean something.
        EXPECT_THAT(drew.loaded, ::testing::Contains("tessera_pictures.so"));
    }
}

#if TESSERA_WITH_IMPORT
TEST_F(Start, AnImportLoadsNothingOfGl) {
    std::ofstream(folder_ / "v.json")
        << R"({"data":"v.raw","type":"uint8","extent":[4,4,4],"spacing":[1,1,1]})";
    std::ofstream(folder_ / "v.raw") << std::string(64, 'a');
    const Outcome imported = run("import v.json v.zarr -q");
    EXPECT_THAT(imported.loaded,
                Each(Not(ContainsRegex(kGl)))); // readers of VTK and DCMTK need some of pictures
    EXPECT_THAT(imported.loaded, Each(Not("tessera_pictures.so")));
    EXPECT_THAT(imported.loaded, ::testing::Contains("tessera_importers.so"));
    EXPECT_THAT(imported.loaded, Each(Not(ContainsRegex(kSlices))));
}

/// Two pages of 4x4 pixels.
std::string smallTiff() {
    std::string file = "II";
    const auto put = [&](std::uint32_t value, int bytes) {
        for (int i = 0; i < bytes; ++i)
            file += static_cast<char>(value >> 8 * i);
    };
    put(42, 2);
    put(24, 4);
    file += std::string(16, 'a'); // the pixels of both
    constexpr std::uint32_t kPageBytes = 2 + 8 * 12 + 4;
    for (const std::uint32_t next : {24 + kPageBytes, 0u}) {
        put(8, 2);
        for (const auto& [tag, value] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
                 {256, 4}, {257, 4}, {258, 8}, {259, 1}, {262, 1}, {273, 8}, {278, 4}, {279, 16}}) {
            put(tag, 2), put(4, 2), put(1, 4), put(value, 4);
        }
        put(next, 4);
    }
    return file;
}

// OpenImageIO takes time and memory to load: slices that are pictures alone ask for it.
TEST_F(Start, OnlyAStackLoadsWhatReadsIt) {
    std::ofstream(folder_ / "v.tif", std::ios::binary) << smallTiff();
    const Outcome stack = run("import v.tif t.zarr --spacing 1,1,2 -q");
    EXPECT_TRUE(fs::exists(folder_ / "t.zarr"));
    EXPECT_THAT(stack.loaded, ::testing::Contains("tessera_slices.so"));
    std::ofstream(folder_ / "v.mha")
        << "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n"
           "ElementSpacing = 1 1 1\nElementDataFile = LOCAL\n" +
               std::string(64, 'a');
    const Outcome other = run("import v.mha m.zarr -q");
    EXPECT_TRUE(fs::exists(folder_ / "m.zarr"));
    EXPECT_THAT(other.loaded, Each(Not(ContainsRegex(kSlices))));
}
#endif

} // namespace
