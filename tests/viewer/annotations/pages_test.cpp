// tests/viewer/annotations/pages_test.cpp: figures as PDF and SVG: their manifest, their page and their
// picture; damaged files are refused in words.
#include "core/base/error.h"
#include "core/image/image_file.h"
#include "tests/support/figures.h"
#include "tests/support/refusals.h"
#include "viewer/annotations/figure_drawing.h"

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <string>
#include <unistd.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;

const char* const kManifest =
    R"json({"notice":"not (for) diagnosis","a":"<b>&\"\\c) (","more":[1,2.5,")"]})json";

class Pages : public testing::TestWithParam<const char*> {
  protected:
    Pages() { fs::create_directories(folder_); }
    ~Pages() override { fs::remove_all(folder_); }
    fs::path file(const std::string& name) const { return folder_ / (name + GetParam()); }
    fs::path write(const std::string& name, const Image& picture, Figure figure,
                   const std::string& manifest) {
        figure.size = picture.size;
        writePage(file(name), picture, figure, manifest, ram_);
        return file(name);
    }
    static std::string bytesOf(const fs::path& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void writeBytes(const fs::path& path, const std::string& bytes) {
        std::ofstream(path, std::ios::binary) << bytes;
    }
    static Image picture(const glm::ivec2& size, float alpha) {
        Image image(size);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                image.at(x, y) =
                    alpha * glm::vec4(static_cast<float>(x) / static_cast<float>(size.x),
                                      static_cast<float>(y) / static_cast<float>(size.y), 0.25f, 1);
        return image;
    }
    MemoryBudget ram_{"RAM", "--ram", std::size_t{1} << 30};
    fs::path folder_ = fs::temp_directory_path() / ("tessera-pages-" + std::to_string(::getpid()));
};

TEST_P(Pages, KeepTheManifest) {
    const Image image = picture({90, 60}, 1);
    const Figure figure = test::fullFigure({90, 60}, {});
    for (const std::string& manifest :
         {std::string(kManifest), std::string("{}"), "{\"long\":\"" + std::string(200000, 'x') + "\"}"})
        EXPECT_EQ(readManifest(write("a", image, figure, manifest)), manifest);
    EXPECT_EQ(bytesOf(write("a", image, figure, kManifest)), bytesOf(write("b", image, figure, kManifest)))
        << "a file does not depend on the time";
    EXPECT_EQ(ram_.usedBytes(), 0u);
}

TEST_P(Pages, HaveTheSizeOfPixelsAtTheirResolution) {
    Figure figure = test::fullFigure({300, 150}, {});
    figure.dpi = 150;
    const std::string bytes = bytesOf(write("a", picture({300, 150}, 1), figure, "{}"));
    if (GetParam() == std::string(".pdf"))
        EXPECT_NE(bytes.find("/MediaBox [ 0 0 144 72 ]"), std::string::npos);
    else
        EXPECT_NE(bytes.find("width=\"2.000in\" height=\"1.000in\" viewBox=\"0 0 300 150\""),
                  std::string::npos);
}

TEST_P(Pages, ThatEndTooSoonAreRefused) {
    const std::string whole =
        bytesOf(write("a", picture({40, 30}, 1), test::fullFigure({40, 30}, {}), kManifest));
    const fs::path cut = file("cut");
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 150);
    for (std::size_t size = 0; size + 8 < whole.size(); size += step) {
        writeBytes(cut, whole.substr(0, size));
        EXPECT_THAT(test::refusalOf([&] { readManifest(cut); }),
                    testing::StartsWith(cut.string() + ": expected a readable figure, found "))
            << size;
    }
}

// Bytes that lie: whatever is read is the manifest, nothing, or a refusal.
TEST_P(Pages, ThatLieAreRefusedOrHaveNoManifest) {
    const std::string whole =
        bytesOf(write("a", picture({8, 6}, 1), test::fullFigure({8, 6}, {}), kManifest));
    const fs::path changed = file("changed");
    std::size_t refused = 0;
    for (std::size_t at = 0; at < whole.size(); at += at + 1200 < whole.size() ? whole.size() / 100 + 1 : 3)
        for (const char byte : {'9', '(', '\0'}) {
            std::string bytes = whole;
            bytes[at] = byte;
            writeBytes(changed, bytes);
            try {
                readManifest(changed);
            } catch (const InputError& e) {
                ++refused;
                EXPECT_THAT(e.what(), testing::HasSubstr("expected a readable figure, found"));
            }
        }
    EXPECT_GT(refused, 20u);
}

TEST_P(Pages, OfOtherProgramsHaveNone) {
    const fs::path other = file("other");
    writeBytes(other, "<svg xmlns=\"http://www.w3.org/2000/svg\"><metadata>x</metadata></svg>");
    if (GetParam() == std::string(".svg"))
        EXPECT_EQ(readManifest(other), "");
    else
        EXPECT_THAT(test::refusalOf([&] { readManifest(other); }), testing::HasSubstr("not a PDF"));
    writeBytes(other, "");
    EXPECT_THAT(test::refusalOf([&] { readManifest(other); }), testing::HasSubstr("another file, not a"));
    EXPECT_THROW(readManifest(file("missing")), Error);
}

TEST_P(Pages, TooLargeForCairoAreRefused) {
    EXPECT_THAT(test::refusalOf([&] {
                    write("a", Image({kMostPagePixels + 1, 1}), {}, "{}");
                }),
                testing::HasSubstr("at most 32767 pixels"));
    MemoryBudget little("RAM", "--ram", 1000);
    const Figure figure{{40, 30}, 96, {}};
    EXPECT_THAT(test::refusalOf([&] {
                    writePage(file("a"), Image({40, 30}), figure, "{}", little);
                }),
                testing::HasSubstr("--ram"));
    EXPECT_FALSE(fs::exists(file("a")));
}

INSTANTIATE_TEST_SUITE_P(All, Pages, testing::Values(".pdf", ".svg"),
                         [](const auto& which) { return std::string(which.param + 1); });

/// The bytes of base64 after a mark.
std::string decoded(const std::string& text, const std::string& mark) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t word = 0, bits = 0;
    for (std::size_t i = text.find(mark) + mark.size(); digits.find(text[i]) != std::string::npos; ++i) {
        word = word << 6 | static_cast<std::uint32_t>(digits.find(text[i]));
        if (bits += 6; bits >= 8)
            bytes += static_cast<char>(word >> (bits -= 8) & 255);
    }
    return bytes;
}

class SvgPages : public Pages {};

TEST_P(SvgPages, HoldThePictureAsPng) {
    for (const float alpha : {1.0f, 0.6f}) {
        const Image image = picture({357, 233}, alpha);
        const std::string svg = bytesOf(write("a", image, test::fullFigure(image.size, {}), "{}"));
        const std::string png = decoded(svg, "data:image/png;base64,");
        EXPECT_EQ(png.substr(png.size() - 8), "IEND\xae\x42\x60\x82") << "to its last byte";
        writeBytes(folder_ / "inside.png", png);
        writeImage(folder_ / "alone.png", image, "{}");
        const Image inside = readImage(folder_ / "inside.png"), alone = readImage(folder_ / "alone.png");
        ASSERT_EQ(inside.size, alone.size);
        // Transparent pixels are stored by their alpha, so they lose a code.
        for (std::size_t i = 0; i < alone.pixels.size(); ++i)
            ASSERT_LT(glm::length(inside.pixels[i] - alone.pixels[i]), alpha == 1 ? 1e-7f : 0.02f);
        EXPECT_NE(svg.find(">HU</text>"), std::string::npos) << "words are text";
    }
}

// Base64 of any number of bytes: whole groups of four, filled up with "=".
TEST_P(SvgPages, HoldAllBytesOfThePicture) {
    std::set<std::size_t> rests;
    for (int width = 1; width < 30; ++width) {
        const std::string svg =
            bytesOf(write("a", picture({width, 3}, 1), test::fullFigure({width, 3}, {}), "{}"));
        const std::string mark = "data:image/png;base64,";
        const std::size_t from = svg.find(mark) + mark.size();
        const std::string text = svg.substr(from, svg.find('"', from) - from), png = decoded(svg, mark);
        EXPECT_EQ(text.size() % 4, 0U);
        EXPECT_EQ(text.size(), (png.size() + 2) / 3 * 4);
        EXPECT_EQ(png.substr(png.size() - 8), "IEND\xae\x42\x60\x82");
        rests.insert(png.size() % 3);
    }
    EXPECT_EQ(rests.size(), 3U);
}

INSTANTIATE_TEST_SUITE_P(All, SvgPages, testing::Values(".svg"), [](const auto&) { return "svg"; });

class PdfPages : public Pages {};

// Poppler finds the picture's own pixels in the page, words as text, and draws what Cairo draws over
// pictures.
TEST_P(PdfPages, AreReadByPoppler) {
    if (std::system("command -v pdftoppm pdftotext pdfimages > /dev/null") != 0)
        GTEST_SKIP() << "no poppler-utils";
    Figure figure = test::fullFigure({1200, 960}, {});
    figure.dpi = 300;
    const Image image = picture({1200, 960}, 1);
    const std::string pdf = write("a", image, figure, kManifest).string(), out = (folder_ / "out").string();
    for (const std::string& command :
         {"pdftoppm -png -r 300 -singlefile " + pdf + " " + out, "pdftotext " + pdf + " " + out + ".txt",
          "pdfimages -png " + pdf + " " + out})
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
    for (const char* words : {"A title", "HU", "240", "liver", "a lesion"})
        EXPECT_THAT(bytesOf(out + ".txt"), testing::HasSubstr(words));
    writeImage(folder_ / "picture.png", image, "{}");
    EXPECT_EQ(readImage(out + "-000.png").pixels, readImage(folder_ / "picture.png").pixels);
    Image annotated = image;
    drawAnnotations(figure, annotated);
    const Image page = readImage(out + ".png");
    ASSERT_EQ(page.size, image.size);
    double apart = 0, annotation = 0; // sums of differences
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        apart += static_cast<double>(glm::length(page.pixels[i] - annotated.pixels[i]));
        annotation += static_cast<double>(glm::length(image.pixels[i] - annotated.pixels[i]));
    }
    EXPECT_LT(apart, 0.35 * annotation) << "letters have softer edges";
}

INSTANTIATE_TEST_SUITE_P(All, PdfPages, testing::Values(".pdf"), [](const auto&) { return "pdf"; });

} // namespace
} // namespace tessera
