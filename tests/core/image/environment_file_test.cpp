// tests/core/image/environment_file_test.cpp: pictures of all directions: exact values, means over the sphere
// of large ones, and what is refused.
#include "core/image/environment_file.h"

#include "core/base/error.h"
#include "core/base/program_folders.h"

#include <OpenImageIO/imageio.h>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Pixel = std::function<glm::vec3(int column, int row)>;

class EnvironmentFiles : public ::testing::Test {
  protected:
    fs::path written(const std::string& name, glm::ivec2 size, const Pixel& pixel, int channels = 3,
                     const std::function<void(OIIO::ImageSpec&)>& change = {}) const {
        OIIO::ImageSpec spec(size.x, size.y, channels, OIIO::TypeDesc::FLOAT);
        if (channels == 1)
            spec.channelnames = {"Y"};
        if (change)
            change(spec);
        std::vector<float> values;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                for (int c = 0; c < channels; ++c)
                    values.push_back(c < 3 ? pixel(x, y)[c] : 1.0f);
        const fs::path path = folder_.path() / name;
        const auto out = OIIO::ImageOutput::create(path.string());
        EXPECT_TRUE(out && out->open(path.string(), spec)) << OIIO::geterror();
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, values.data())) << out->geterror();
        return path;
    }
    std::string problemOf(const fs::path& path, std::size_t bytes = std::size_t{64} << 20) const {
        MemoryBudget ram("RAM", "--ram", bytes);
        const auto begin = std::chrono::steady_clock::now();
        std::string problem;
        try {
            readEnvironment(path, ram);
            ADD_FAILURE() << path << ": accepted";
        } catch (const InputError& error) {
            problem = error.what();
        }
        EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
        EXPECT_LE(ram.peakBytes(), std::size_t{16} << 20);
        EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
        return problem;
    }
    EnvironmentPixels read(const fs::path& path) const {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        EnvironmentPixels pixels = readEnvironment(path, ram);
        EXPECT_EQ(ram.usedBytes(), 0u);
        EXPECT_EQ(pixels.radiance.size(),
                  static_cast<std::size_t>(pixels.size.x) * static_cast<std::size_t>(pixels.size.y));
        return pixels;
    }
    const ScratchFolder folder_;
};

glm::vec3 gradual(int column, int row) {
    return {0.25f * static_cast<float>(column), 1000.0f * static_cast<float>(row), 1.0f / 1024};
}

TEST_F(EnvironmentFiles, SmallOnesAreReadAsTheyAre) {
    const glm::ivec2 size(70, 35);
    const auto isSame = [&](const EnvironmentPixels& found) {
        EXPECT_EQ(found.size, size);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                ASSERT_EQ(found.radiance[static_cast<std::size_t>(y * size.x + x)], gradual(x, y));
        EXPECT_TRUE(found.notes.empty());
    };
    isSame(read(written("a.exr", size, gradual)));
    isSame(read(written("alpha.exr", size, gradual, 4)));
    isSame(read(written("tiles.exr", size, gradual, 3,
                        [](OIIO::ImageSpec& spec) { spec.tile_width = 16, spec.tile_height = 8; })));
    const auto grey = [](int x, int y) { return glm::vec3(static_cast<float>(x + 100 * y)); };
    EXPECT_EQ(read(written("grey.exr", size, grey, 1)).radiance[71], glm::vec3(101));
    const EnvironmentPixels shared = read(written("a.hdr", size, gradual)); // 8 bits of the greatest
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            EXPECT_LE(glm::length(shared.radiance[static_cast<std::size_t>(y * size.x + x)] - gradual(x, y)),
                      0.02f * std::max(1.0f, gradual(x, y).g));
    EXPECT_EQ(read(written("least.exr", {2, 1}, gradual)).size, glm::ivec2(2, 1));
}

/// What a large one sends through the sphere stays, and stays where it is; sizes need not divide.
TEST_F(EnvironmentFiles, LargeOnesAreReducedByMeansOverTheSphere) {
    for (const glm::ivec2 size : {glm::ivec2(1024, 512), glm::ivec2(1398, 699)}) {
        const EnvironmentPixels found = read(written("big.exr", size, [](int x, int y) {
            return glm::vec3(x % 7 == 0 ? 3.0f : 0.5f, static_cast<float>(y),
                             x < 300 && y < 90 ? 800.0f : 0.0f);
        }));
        ASSERT_EQ(found.size, EnvironmentPixels::kKept);
        const auto light = [](const glm::ivec2& of, const Pixel& pixel) {
            glm::dvec3 sum(0);
            for (int y = 0; y < of.y; ++y)
                for (int x = 0; x < of.x; ++x)
                    sum += 2 * M_PI / of.x * (std::cos(M_PI * y / of.y) - std::cos(M_PI * (y + 1) / of.y)) *
                           glm::dvec3(pixel(x, y));
            return sum;
        };
        const glm::dvec3 expected = light(size, [&](int x, int y) {
            return glm::vec3(x % 7 == 0 ? 3.0f : 0.5f, static_cast<float>(y),
                             x < 300 && y < 90 ? 800.0f : 0.0f);
        });
        const glm::dvec3 kept = light(found.size, [&](int x, int y) {
            return found.radiance[static_cast<std::size_t>(y * found.size.x + x)];
        });
        EXPECT_LT(glm::length(kept / expected - 1.0), 1e-5);
        const auto at = [&](int x, int y) { return found.radiance[static_cast<std::size_t>(y * 512 + x)].b; };
        EXPECT_EQ(at(300 * 512 / size.x + 1, 20), 0);
        EXPECT_FLOAT_EQ(at(300 * 512 / size.x - 1, 20), 800);
        EXPECT_EQ(at(20, 90 * 256 / size.y + 1), 0);
    }
}

TEST_F(EnvironmentFiles, NegativeValuesCountAsNothing) {
    const EnvironmentPixels found = read(written(
        "below.exr", {4, 2}, [](int x, int y) { return glm::vec3(x == 2 && y == 1 ? -3.0f : 1.0f, 1, 1); }));
    EXPECT_EQ(found.radiance[6], glm::vec3(0, 1, 1));
    ASSERT_EQ(found.notes.size(), 1u);
    EXPECT_THAT(found.notes[0], HasSubstr("below.exr: 1 of 24 values are below 0"));
}

TEST_F(EnvironmentFiles, OthersAreRefused) {
    const auto one = [](int, int) { return glm::vec3(1); };
    EXPECT_THAT(problemOf(folder_.path()), HasSubstr("expected a file, found a folder"));
    EXPECT_THAT(problemOf(folder_.path() / "none.exr"),
                HasSubstr("none.exr: expected a file, found nothing there"));
    ASSERT_EQ(::mkfifo((folder_.path() / "pipe.exr").c_str(), 0600), 0);
    EXPECT_THAT(problemOf(folder_.path() / "pipe.exr"), HasSubstr("a pipe"));
    std::ofstream(folder_.path() / "text.exr") << "a text, and no picture";
    EXPECT_THAT(problemOf(folder_.path() / "text.exr"),
                HasSubstr("OpenEXR's or Radiance's format, found another file"));
    std::ofstream(folder_.path() / "empty.hdr");
    EXPECT_THAT(problemOf(folder_.path() / "empty.hdr"), HasSubstr("found another file"));
    std::ofstream(folder_.path() / "magic.exr") << "\x76\x2f\x31\x01";
    EXPECT_THAT(problemOf(folder_.path() / "magic.exr"), HasSubstr("expected a readable picture"));
    EXPECT_THAT(problemOf(written("square.exr", {8, 8}, one)),
                HasSubstr("twice as wide as high, 2x1 to 4096x2048 pixels, found 8x8"));
    EXPECT_THAT(problemOf(written("large.hdr", {4098, 2049}, one)), HasSubstr("found 4098x2049"));
    EXPECT_THAT(problemOf(written("names.exr", {4, 2}, one, 3,
                                  [](OIIO::ImageSpec& spec) {
                                      spec.channelnames = {"U", "V", "W"};
                                  })),
                HasSubstr("expected channels R, G and B"));
    EXPECT_THAT(problemOf(written("part.exr", {4, 2}, one, 3,
                                  [](OIIO::ImageSpec& spec) { spec.full_width = 8, spec.full_height = 4; })),
                HasSubstr("expected pixels for the whole picture"));
    const auto with = [&](float value) {
        return [=](int x, int y) { return glm::vec3(1, x == 3 && y == 1 ? value : 1.0f, 1); };
    };
    EXPECT_THAT(
        problemOf(written("nan.exr", {4, 2}, with(NAN))),
        HasSubstr("nan.exr: expected radiance of at most 1e9, found not a number in column 3, row 1"));
    EXPECT_THAT(problemOf(written("inf.exr", {4, 2}, with(INFINITY))),
                HasSubstr("found infinity in column 3"));
    EXPECT_THAT(problemOf(written("much.exr", {4, 2}, with(1e10f))), HasSubstr("in column 3, row 1"));
}

/// Headers that tell of more than there is take neither time nor memory.
TEST_F(EnvironmentFiles, HeadersThatLieAreRefused) {
    for (const char* size :
         {"-Y 0 +X 0", "-Y 100000 +X 200000", "-Y 2147483647 +X 4294967294", "-Y -4 +X -8"}) {
        std::ofstream(folder_.path() / "lie.hdr") << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
                                                  << size << "\nabcd";
        EXPECT_THAT(problemOf(folder_.path() / "lie.hdr"), HasSubstr("lie.hdr: expected")) << size;
    }
    std::ofstream(folder_.path() / "short.hdr")
        << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2048 +X 4096\nabcd";
    EXPECT_THAT(problemOf(folder_.path() / "short.hdr"),
                HasSubstr("short.hdr: expected 2048 rows of pixels"));
    // An EXR of 8x4 whose windows say other sizes.
    const fs::path honest = written("honest.exr", {8, 4}, gradual);
    std::ifstream in(honest, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    for (const glm::ivec2 size : {glm::ivec2(0, 0), {16384, 8192}, {2000000000, 1000000000}, {4096, 2048}}) {
        std::string lying = bytes;
        const std::int32_t window[4] = {0, 0, size.x - 1, size.y - 1};
        for (const char* name : {"dataWindow", "displayWindow"}) {
            const std::size_t at = lying.find(name) + std::strlen(name) + 1 + std::strlen("box2i") + 1 + 4;
            std::memcpy(&lying[at], window, sizeof window);
        }
        std::ofstream(folder_.path() / "lie.exr", std::ios::binary) << lying;
        EXPECT_THAT(problemOf(folder_.path() / "lie.exr"), HasSubstr("lie.exr: expected")) << size.x;
    }
}

TEST_F(EnvironmentFiles, CutShortAreRefused) {
    for (const char* name : {"cut.exr", "cut.hdr"}) {
        const fs::path path = written(name, {300, 150}, gradual);
        const std::uintmax_t size = fs::file_size(path);
        for (const double share : {0.999, 0.7, 0.3, 0.05, 0.004}) {
            fs::resize_file(path, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
            EXPECT_THAT(problemOf(path), HasSubstr(std::string(name) + ": expected")) << share;
        }
    }
}

TEST_F(EnvironmentFiles, AreReadWithinTheBudget) {
    const fs::path path = written("a.exr", {1024, 512}, gradual);
    EXPECT_THAT(problemOf(path, 1 << 20), HasSubstr("--ram"));
}

} // namespace
} // namespace tessera
