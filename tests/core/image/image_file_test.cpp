// tests/core/image/image_file_test.cpp: pictures on disk: exact EXR, sRGB PNG and TIFF with straight alpha,
// the manifest, and nothing half-written.
#include "core/image/image_file.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/program_folders.h"
#include "core/image/colour.h"

#include <OpenImageIO/imageio.h>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <utility>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

class ImageFile : public ::testing::Test {
  protected:
    std::size_t filesInFolder() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
    }
    const ScratchFolder folder_;
};

Image randomImage(bool opaque) {
    Image image(glm::ivec2(37, 23)); // odd and not square: a swapped axis shows
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (glm::vec4& p : image.pixels) {
        const float a = opaque ? 1.0f : uniform(random);
        p = glm::vec4(uniform(random) * a, uniform(random) * a, uniform(random) * a, a);
    }
    return image;
}

TEST_F(ImageFile, ExrKeepsEveryBit) {
    Image image = randomImage(false);
    image.at(0, 0) = glm::vec4(1e-30f, 7.5f, 0.1f, 0); // a pixel without alpha keeps its light
    const fs::path path = folder_ / "a.exr";
    writeImage(path, image, R"({"a":1})");
    const Image again = readImage(path);
    ASSERT_EQ(again.size, image.size);
    EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), again.pixels.begin()));
    EXPECT_EQ(readManifest(path), R"({"a":1})");
}

/// Rows that are given band by band make the file that the picture makes.
TEST_F(ImageFile, RowsMakeTheSameFile) {
    for (const bool opaque : {false, true})
        for (const char* name : {"a.png", "a.tif", "a.exr"}) {
            Image image(glm::ivec2(19, 2 * ImageRows::kAtOnce + 7));
            std::mt19937 random(3);
            std::uniform_real_distribution<float> uniform(0, 1);
            for (glm::vec4& p : image.pixels) {
                const float a = opaque ? 1 : uniform(random);
                p = glm::vec4(uniform(random) * a, uniform(random) * a, uniform(random) * a, a);
            }
            writeImage(folder_ / name, image, R"({"a":1})");
            const auto bytes = [&] {
                std::ifstream file(folder_ / name, std::ios::binary);
                return std::string(std::istreambuf_iterator<char>(file), {});
            };
            const std::string whole = bytes();
            const Image again = readImage(folder_ / name);
            ASSERT_EQ(again.size, image.size);
            for (std::size_t i = 0; i < image.pixels.size(); ++i)
                for (int c = 0; c < 4; ++c)
                    ASSERT_NEAR(again.pixels[i][c], image.pixels[i][c], 0.02) << name << " " << i;
            std::vector<glm::vec4> band;
            int next = 0;
            writeImageRows(folder_ / name,
                           {image.size, opaque,
                            [&](int first, int count) -> std::span<const glm::vec4> {
                                EXPECT_EQ(std::exchange(next, first + count), first) << "from the top down";
                                EXPECT_LE(count, ImageRows::kAtOnce);
                                const auto begin = image.pixels.begin() + first * image.size.x;
                                band.assign(begin, begin + count * image.size.x);
                                return band;
                            }},
                           R"({"a":1})");
            EXPECT_EQ(next, image.size.y);
            EXPECT_EQ(bytes(), whole) << name;
            // What the rows throw leaves the file as it was.
            EXPECT_THROW(
                writeImageRows(
                    folder_ / name,
                    {image.size, opaque,
                     [&](int first, int count) -> std::span<const glm::vec4> {
                         if (first > 0)
                             throw InputError("no rows");
                         return std::span(image.pixels).first(static_cast<std::size_t>(count * image.size.x));
                     }},
                    ""),
                InputError);
            EXPECT_EQ(bytes(), whole) << name;
        }
}

/// A layer that is given row by row is the layer that is there at once.
TEST_F(ImageFile, ExrHasALayerOfRows) {
    const Image image = randomImage(false), above = randomImage(false);
    std::vector<LayerChannel> channels;
    for (int c = 0; c < 4; ++c)
        channels.push_back({std::string("over.") + "RGBA"[c], &above.pixels[0][c], 4});
    writeImage(folder_ / "a.exr", image, "{}", channels);
    const auto rowsOf = [](const Image& of) {
        return ImageRows{of.size, false, [&of](int first, int count) {
                             return std::span(of.pixels).subspan(
                                 static_cast<std::size_t>(first) * static_cast<std::size_t>(of.size.x),
                                 static_cast<std::size_t>(count) * static_cast<std::size_t>(of.size.x));
                         }};
    };
    const LayerRows layer{"over", rowsOf(above)};
    writeImageRows(folder_ / "b.exr", rowsOf(image), "{}", 0, &layer);
    const auto bytes = [&](const char* name) {
        std::ifstream file(folder_ / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    EXPECT_EQ(bytes("b.exr"), bytes("a.exr"));
    EXPECT_EQ(readImage(folder_ / "b.exr").pixels, image.pixels);
}

/// Read by others under the names that compositing programs expect; our own reader takes the colour.
TEST_F(ImageFile, ExrHoldsLayersUnderTheirNames) {
    const Image image = randomImage(false);
    Image normals(image.size);
    for (std::size_t i = 0; i < normals.pixels.size(); ++i)
        normals.pixels[i] = {-1.0f, 0.5f * static_cast<float>(i), 7.0f, 984.25f};
    const fs::path path = folder_ / "a.exr";
    const std::vector<LayerChannel> layers = {{"normal.X", &normals.pixels[0].x, 4},
                                              {"normal.Y", &normals.pixels[0].y, 4},
                                              {"normal.Z", &normals.pixels[0].z, 4},
                                              {"depth.Z", &normals.pixels[0].w, 4}};
    writeImage(path, image, R"({"a":1})", layers);
    EXPECT_EQ(readManifest(path), R"({"a":1})");
    const Image again = readImage(path);
    ASSERT_EQ(again.size, image.size);
    EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), again.pixels.begin()));
    const auto input = OIIO::ImageInput::open(path.string());
    ASSERT_TRUE(input);
    const std::vector<std::string> names = {"R",       "G",        "B",        "A",
                                            "depth.Z", "normal.X", "normal.Y", "normal.Z"};
    ASSERT_EQ(input->spec().channelnames, names);
    EXPECT_EQ(input->spec().alpha_channel, 3);
    std::vector<float> values(8 * image.pixels.size());
    ASSERT_TRUE(input->read_image(0, 0, 0, 8, OIIO::TypeDesc::FLOAT, values.data()));
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const glm::vec4& p = image.pixels[i];
        const glm::vec4& n = normals.pixels[i];
        const std::vector<float> expected = {p.r, p.g, p.b, p.a, n.w, n.x, n.y, n.z};
        ASSERT_TRUE(std::equal(expected.begin(), expected.end(), &values[8 * i])) << i;
    }
}

TEST_F(ImageFile, PngHoldsSrgbBytesAndStraightAlpha) {
    Image image(glm::ivec2(3, 2));
    image.at(0, 0) = glm::vec4(0.5f, 0, 1, 1);
    image.at(1, 0) = glm::vec4(0.25f, 0, 0.5f, 0.5f); // the same colour, half covered
    image.at(2, 0) = glm::vec4(0);
    image.at(0, 1) = glm::vec4(2, -1, NAN, 1);
    const fs::path path = folder_ / "a.png";
    writeImage(path, image, "{}");

    OIIO::ImageSpec hints;
    hints["oiio:UnassociatedAlpha"] = 1;
    const auto input = OIIO::ImageInput::open(path.string(), &hints);
    ASSERT_TRUE(input);
    ASSERT_EQ(input->spec().nchannels, 4);
    EXPECT_EQ(input->spec().format, OIIO::TypeDesc(OIIO::TypeDesc::UINT8));
    std::vector<std::uint8_t> bytes(3 * 2 * 4);
    ASSERT_TRUE(input->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, bytes.data()));
    const std::vector<std::uint8_t> expected = {188, 0, 255, 255, 188, 0, 255, 128, 0, 0, 0, 0,
                                                255, 0, 0,   255, 0,   0, 0,   0,   0, 0, 0, 0};
    EXPECT_EQ(bytes, expected);

    const Image again = readImage(path); // premultiplied and linear again
    EXPECT_NEAR(again.at(1, 0).r, linearFromSrgb(188 / 255.0) * 128 / 255, 1e-6);
    EXPECT_NEAR(again.at(1, 0).b, 128 / 255.0, 1e-6);
}

TEST_F(ImageFile, PngAndTiffRoundTripWithinTheirSteps) {
    for (const bool opaque : {true, false}) {
        const Image image = randomImage(opaque);
        for (const char* name : {"a.png", "a.tif", "b.TIFF"}) {
            // 1 step of the encoded value is at most 2.4/1.055 of one in linear light; alpha adds half a step
            const double tolerance = (std::string(name) == "a.png" ? 1 / 255.0 : 1 / 65535.0) * 1.8;
            writeImage(folder_ / name, image, "{\"manifest\": \"not for diagnosis\"}");
            const Image again = readImage(folder_ / name);
            ASSERT_EQ(again.size, image.size) << name;
            for (std::size_t i = 0; i < image.pixels.size(); ++i)
                for (int c = 0; c < 4; ++c)
                    ASSERT_NEAR(image.pixels[i][c], again.pixels[i][c], tolerance) << name << " " << i;
            EXPECT_EQ(OIIO::ImageInput::open((folder_ / name).string())->spec().nchannels, opaque ? 3 : 4);
            EXPECT_EQ(readManifest(folder_ / name), "{\"manifest\": \"not for diagnosis\"}");
        }
    }
}

TEST_F(ImageFile, ReplacesAFileButNothingElseAndLeavesNothingBehind) {
    const Image image = randomImage(true);
    writeImage(folder_ / "a.png", image, "1");
    writeImage(folder_ / "a.png", image, "2");
    EXPECT_EQ(readManifest(folder_ / "a.png"), "2");
    EXPECT_EQ(filesInFolder(), 1u);
    fs::create_directory(folder_ / "folder.png");
    EXPECT_THROW(writeImage(folder_ / "folder.png", image, ""), Error);
    EXPECT_THROW(writeImage(folder_ / "missing" / "a.png", image, ""), Error);
    EXPECT_EQ(filesInFolder(), 2u);
    fs::remove_all(folder_ / "folder.png");
    const Image empty; // no picture at all: the writer refuses, and no temporary file stays
    EXPECT_THROW(writeImage(folder_ / "empty.png", empty, ""), Error);
    EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(ImageFile, CallingOffLeavesNothingBehind) {
    const Image image = randomImage(true);
    const Cancellation::Flag isOff{true};
    for (const char* name : {"a.png", "a.tif", "a.exr"}) {
        const Cancellation off(&isOff);
        EXPECT_THROW(writeImage(folder_ / name, image, ""), Cancelled) << name;
    }
    EXPECT_EQ(filesInFolder(), 0u);
}

/// The file's own numbers as another library reads them, as floats; alpha as it stands in the file.
std::vector<float> readByOpenImageIO(const fs::path& path, std::string& description) {
    OIIO::ImageSpec hints;
    hints["oiio:UnassociatedAlpha"] = 1;
    const auto input = OIIO::ImageInput::open(path.string(), &hints);
    if (!input)
        return {};
    const OIIO::ImageSpec& spec = input->spec();
    std::vector<float> values(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()));
    description = spec.get_string_attribute("ImageDescription");
    return values;
}

TEST_F(ImageFile, AnotherLibraryReadsTheSame) {
    for (const bool opaque : {true, false})
        for (const char* name : {"a.png", "a.exr", "a.tif"}) {
            const Image image = randomImage(opaque);
            writeImage(folder_ / name, image, R"({"a":[1,2]})");
            std::string description;
            const std::vector<float> values = readByOpenImageIO(folder_ / name, description);
            const bool linear = std::string(name) == "a.exr";
            const std::size_t channels = linear || !opaque ? 4 : 3;
            ASSERT_EQ(values.size(), image.pixels.size() * channels) << name;
            EXPECT_EQ(description, R"({"a":[1,2]})") << name;
            const double step = std::string(name) == "a.png" ? 1 / 255.0 : 1 / 65535.0;
            for (std::size_t i = 0; i < image.pixels.size(); ++i) {
                const glm::vec4 p = image.pixels[i];
                for (std::size_t c = 0; c < channels; ++c) {
                    const double kept = static_cast<double>(p[static_cast<int>(c)]);
                    const double expected =
                        linear || c == 3 ? kept : srgbFromLinear(kept / static_cast<double>(p.a));
                    ASSERT_NEAR(values[i * channels + c], expected, linear ? 0 : 0.51 * step)
                        << name << " pixel " << i << " channel " << c;
                }
            }
        }
}

TEST_F(ImageFile, PicturesOfAnotherLibraryAreRead) {
    const std::vector<float> values = {0.25f, 0.5f, 0.75f, 1, 0, 1, 0.125f, 0.5f};
    const std::pair<const char*, OIIO::TypeDesc> kinds[] = {
        {"a.png", OIIO::TypeDesc::UINT16}, {"a.exr", OIIO::TypeDesc::HALF}, {"a.tif", OIIO::TypeDesc::UINT8}};
    for (const auto& [name, type] : kinds) {
        OIIO::ImageSpec spec(2, 1, 4, type);
        spec["oiio:UnassociatedAlpha"] = 1;
        spec["ImageDescription"] = "of another";
        const auto output = OIIO::ImageOutput::create((folder_ / name).string());
        ASSERT_TRUE(output->open((folder_ / name).string(), spec) &&
                    output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
        EXPECT_EQ(readManifest(folder_ / name), "of another") << name;
        const Image image = readImage(folder_ / name);
        ASSERT_EQ(image.size, glm::ivec2(2, 1)) << name;
        const bool linear = std::string(name) == "a.exr";
        for (int x = 0; x < 2; ++x)
            for (int c = 0; c < 4; ++c) {
                const float* const pixel = &values[static_cast<std::size_t>(4 * x)];
                const float value = pixel[c];
                const double expected = linear || c == 3 ? value
                                                         : linearFromSrgb(static_cast<double>(value)) *
                                                               static_cast<double>(pixel[3]);
                EXPECT_NEAR(image.at(x, 0)[c], expected, linear ? 0 : 1.2 / 255) << name << x << c;
            }
    }
}

/// Most memory that the process took so far.
long peakMiB() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
}

// A few bytes overwritten, or the end missing: a picture or an InputError, and no memory for sizes that only
// the header states. Except in EXR's first header bytes: OpenEXR allocates a text of any length that they
// state.
TEST_F(ImageFile, DamageIsRefusedOrRead) {
    const std::pair<const char*, int> kinds[] = {{"a.png", 300}, {"a.tif", 300}, {"a.exr", 100}};
    [[maybe_unused]] const long before = peakMiB();
    std::mt19937 random(11);
    for (const auto& [name, turns] : kinds) {
        writeImage(folder_ / name, randomImage(false), "manifest");
        std::ifstream file(folder_ / name, std::ios::binary);
        const std::string whole(std::istreambuf_iterator<char>(file), {});
        int refused = 0;
        for (int turn = 0; turn < turns; ++turn) {
            std::string damaged = whole;
            // Headers are short: every other damage is in the first bytes.
            const std::size_t head = std::string(name) == "a.exr" ? 400 : 0;
            const std::size_t range = turn % 2 ? whole.size() - head : 400;
            const std::size_t at = head + random() % range;
            if (turn % 5 == 0)
                damaged.resize(at);
            else
                for (std::size_t i = at; i < std::min(at + 1 + turn % 4, whole.size()); ++i)
                    damaged[i] = static_cast<char>(random());
            std::ofstream(folder_ / name, std::ios::binary) << damaged;
            try {
                readManifest(folder_ / name);
                readImage(folder_ / name);
            } catch (const InputError&) {
                ++refused;
            }
        }
        EXPECT_GE(refused, turns / 5) << name;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        EXPECT_LT(peakMiB(), before + 64) << name;
#endif
    }
}

/// Runs body while no file may grow beyond `bytes`: a disk that is full.
/// @return what it said
std::string saidWhenFull(rlim_t bytes, const std::function<void()>& body) {
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const rlimit limit{bytes, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::string said;
    try {
        body();
    } catch (const Error& error) {
        said = error.what();
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    return said;
}

// PNG's writer forgets that a write failed. Limits that end in the header, in the pixels and in the last
// bytes.
TEST_F(ImageFile, AFullDiskLeavesTheGoodPictureAndSaysSo) {
    for (const char* name : {"a.png", "a.exr", "a.tif"}) {
        writeImage(folder_ / name, randomImage(true), "good");
        const std::uintmax_t size = fs::file_size(folder_ / name);
        for (const std::uintmax_t limit : {std::uintmax_t{0}, std::uintmax_t{20}, size / 2, size - 1}) {
            const std::string said =
                saidWhenFull(limit, [&] { writeImage(folder_ / name, randomImage(true), "evil"); });
            EXPECT_NE(said.find(std::string(name) + ": cannot be written"), std::string::npos)
                << limit << " of " << size << " bytes: " << said;
            EXPECT_EQ(readManifest(folder_ / name), "good") << name << " at " << limit;
        }
    }
    EXPECT_EQ(filesInFolder(), 3u);
}

TEST_F(ImageFile, BadNamesAndFilesAreInputErrors) {
    EXPECT_NO_THROW(checkImagePath("x/Y.PNG"));
    for (const char* name : {"a.jpg", "a", "a.png.bak", ""})
        EXPECT_THROW(checkImagePath(name), InputError);
    EXPECT_THROW(readImage(folder_ / "none.png"), InputError);
    ASSERT_EQ(::mkfifo((folder_ / "pipe.png").c_str(), 0600), 0);
    EXPECT_THROW(readImage(folder_ / "pipe.png"), InputError) << "nobody may ever write there";
    std::ofstream(folder_ / "text.exr") << "no picture";
    EXPECT_THROW(readImage(folder_ / "text.exr"), InputError);
    writeImage(folder_ / "a.exr", randomImage(false), "");
    fs::resize_file(folder_ / "a.exr", fs::file_size(folder_ / "a.exr") / 2);
    EXPECT_THROW(readImage(folder_ / "a.exr"), InputError);
}

// Nothing but its beginning and its end is read.
TEST_F(ImageFile, SizesAndEndsAreSeenWithoutThePixels) {
    for (const char* name : {"a.png", "a.exr", "a.tif"})
        for (const bool opaque : {true, false}) {
            const fs::path path = folder_ / name;
            const Image image = randomImage(opaque);
            writeImage(path, image, "some");
            EXPECT_EQ(pictureSize(path), image.size) << name;
            EXPECT_NO_THROW(checkPictureIsWhole(path)) << name;
            for (std::uintmax_t bytes = fs::file_size(path); bytes-- > 0;) {
                fs::resize_file(path, bytes);
                EXPECT_THROW(checkPictureIsWhole(path), InputError) << name << " of " << bytes << " bytes";
                if (bytes > 400)
                    bytes -= bytes / 50;
            }
        }
    EXPECT_THROW(pictureSize(folder_ / "none.png"), InputError);
}

} // namespace
} // namespace tessera
