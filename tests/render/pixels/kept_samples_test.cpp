// tests/render/pixels/kept_samples_test.cpp: a picture that goes on from kept samples has the bits of one
// that took all of them; files that are not what was written are refused. Sums of very many samples are
// exact.
#include "render/pixels/kept_samples.h"

#include "core/base/error.h"
#include "core/base/program_folders.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr glm::ivec2 kSize(7, 5);

Rays raysOfPaths(const glm::ivec2& size = kSize) {
    Rays rays;
    rays.frame.imageSize = size;
    rays.paths = true;
    return rays;
}

PixelSampling samplingOf(int samples, double noise = 0) {
    return {samples, PixelFilter::box, 5, noise};
}

/// Any function of a place.
glm::vec4 colourAt(const glm::vec2& place) {
    const float a = std::sin(37.0f * place.x + 91.0f * place.y);
    return {std::abs(a), a * a, std::abs(std::cos(53.0f * place.y)), 0.5f + 0.5f * a * a};
}

using Colour = std::function<glm::vec4(const glm::vec2&)>;

/// Draws the next array; false: there is none.
bool drawNext(AreaPicture& picture, const Colour& colour = colourAt, bool other = false) {
    const std::optional<Rays> rays = picture.next();
    if (!rays)
        return false;
    Image drawn(rays->size()), squares(rays->size());
    for (std::size_t i = 0; i < drawn.pixels.size(); ++i) {
        drawn.pixels[i] = colour(rays->places[i]);
        squares.pixels[i] = drawn.pixels[i] * drawn.pixels[i];
    }
    picture.add(drawn, std::span(&squares, other ? 1 : 0));
    return true;
}

AreaPicture pictureOf(const PixelSampling& sampling, std::size_t others = 0) {
    return AreaPicture(raysOfPaths(), sampling, 1, {}, {}, {}, others);
}

void expectSameBits(const Image& a, const Image& b) {
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    EXPECT_EQ(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(glm::vec4)), 0);
}

std::string bytesOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}
void writeBytes(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

class KeptFile : public ::testing::Test {
  protected:
    /// Draws a picture and keeps its samples, after every array as pictures do.
    void keep(int samples, std::size_t others = 0, int arrays = 1 << 30) {
        KeptSamples kept(path, parts);
        AreaPicture picture = pictureOf(samplingOf(samples), others);
        kept.restore(picture, samples, plan);
        while (arrays-- > 0 && drawNext(picture, colourAt, others > 0))
            kept.keep(picture);
    }
    int restored(AreaPicture& picture, int samples) {
        return KeptSamples(path, parts).restore(picture, samples, plan);
    }
    /// Both at once: as soon as the program starts, and when the picture is drawn.
    std::string refusal(int samples = 64) {
        try {
            AreaPicture picture = pictureOf(samplingOf(samples));
            restored(picture, samples);
        } catch (const InputError& e) {
            EXPECT_THAT(e.what(), HasSubstr(path.string()));
            return e.what();
        }
        return {};
    }

    const ScratchFolder folder;
    const fs::path path = folder / "kept";
    KeptSamples::Parts parts = {{"content", "abc"}, {"lighting.transport.bounces", "4"}};
    KeptSamples::Parts plan = {{"levels", "0 1"}};
};

TEST_F(KeptFile, APictureThatGoesOnHasTheBitsOfAWholeOne) {
    for (const int whole : {64, 100, 1000, 4096}) {
        AreaPicture all = pictureOf(samplingOf(whole), 1);
        while (drawNext(all, colourAt, true))
            ;
        for (const int before : {2, 3, 8, 50, 64, 700, 2048, 4096}) {
            if (before > whole)
                continue;
            fs::remove(path);
            keep(before, 1);
            AreaPicture rest = pictureOf(samplingOf(whole), 1);
            const int taken = restored(rest, whole);
            EXPECT_EQ(taken, 1 << static_cast<int>(std::log2(before))) << "whole rounds";
            EXPECT_NEAR(rest.share(0), static_cast<double>(taken) / whole, 1e-12);
            while (drawNext(rest, colourAt, true))
                ;
            SCOPED_TRACE(std::to_string(before) + " of " + std::to_string(whole));
            expectSameBits(rest.image(), all.image());
            expectSameBits(rest.other(0), all.other(0));
            expectSameBits(rest.sums().errors(), all.sums().errors());
            EXPECT_EQ(rest.report().taken, whole);
            EXPECT_EQ(rest.report().error->rms, all.report().error->rms);
        }
    }
}

/// A run that ends in the middle of a round leaves the round before; three runs are as good as two.
TEST_F(KeptFile, RunsThatWereInterruptedGoOnToo) {
    AreaPicture all = pictureOf(samplingOf(1024));
    while (drawNext(all))
        ;
    for (const int arrays : {1, 3, 10, 17, 18, 30}) {
        fs::remove(path);
        keep(1024, 0, arrays);
        keep(1024, 0, 5);
        AreaPicture rest = pictureOf(samplingOf(1024));
        EXPECT_GT(restored(rest, 1024), 0);
        while (drawNext(rest))
            ;
        expectSameBits(rest.image(), all.image());
    }
}

TEST_F(KeptFile, StopsAtTheNoiseAtWhichOneRunStops) {
    const PixelSampling sampling = samplingOf(4096, 0.04);
    AreaPicture all = pictureOf(sampling);
    while (drawNext(all))
        ;
    EXPECT_GT(all.report().taken, 32);
    EXPECT_LT(all.report().taken, 4096);
    keep(32);
    AreaPicture rest = pictureOf(sampling);
    EXPECT_EQ(restored(rest, 4096), 32);
    while (drawNext(rest))
        ;
    expectSameBits(rest.image(), all.image());
}

TEST_F(KeptFile, OtherPicturesAreRefusedByWhatDiffers) {
    keep(64);
    EXPECT_EQ(refusal(), "");
    EXPECT_EQ(refusal(100), "");
    EXPECT_THAT(refusal(32), HasSubstr("at most the 32 samples a pixel of --samples, found 64"));
    plan["levels"] = "1 1";
    EXPECT_THAT(refusal(), HasSubstr("with levels 1 1"));
    EXPECT_THAT(refusal(), HasSubstr("found 0 1"));
    plan["levels"] = "0 1";
    parts["lighting.transport.bounces"] = "8";
    EXPECT_THAT(refusal(), HasSubstr("with lighting.transport.bounces 8"));
    EXPECT_THAT(refusal(), HasSubstr("found 4"));
    EXPECT_THROW(KeptSamples(path, parts), InputError) << "before anything is drawn";
    parts.erase("lighting.transport.bounces");
    EXPECT_THAT(refusal(), HasSubstr("without lighting.transport.bounces"));
    parts = {{"content", "abc"}, {"lighting.transport.bounces", "4"}, {"more", "1"}};
    EXPECT_THAT(refusal(), HasSubstr("with more 1"));
    parts.erase("more");
    AreaPicture layered = pictureOf(samplingOf(64), 2);
    EXPECT_THROW(restored(layered, 64), InputError);
    AreaPicture larger(raysOfPaths({8, 5}), samplingOf(64));
    EXPECT_THROW(restored(larger, 64), InputError);
    EXPECT_EQ(refusal(), "") << "the file is as it was";
}

TEST_F(KeptFile, SpoiltFilesAreRefused) {
    keep(64);
    const std::string good = bytesOf(path);
    ASSERT_EQ(refusal(), "");
    for (std::size_t size = 0; size < good.size(); size += size < 200 ? 1 : 37) {
        writeBytes(path, good.substr(0, size));
        EXPECT_NE(refusal(), "") << size;
    }
    writeBytes(path, good + "x");
    EXPECT_NE(refusal(), "");
    for (std::size_t at = 0; at < good.size(); at += at < 200 ? 1 : 13) {
        std::string bad = good;
        bad[at] = static_cast<char>(bad[at] ^ 1 << at % 8);
        writeBytes(path, bad);
        EXPECT_NE(refusal(), "") << at;
    }
    writeBytes(path, std::string(5000, 'a'));
    EXPECT_THAT(refusal(), HasSubstr("another kind of file"));
    EXPECT_EQ(bytesOf(path), std::string(5000, 'a')) << "a user's file";
    fs::remove(path);
    fs::create_directory(path);
    EXPECT_NE(refusal(), "");
}

/// Files whose checksum is right, and whose header says what is not.
TEST_F(KeptFile, LyingHeadersAreRefused) {
    keep(64);
    const std::string good = bytesOf(path);
    const auto signedFile = [](std::string bytes) {
        const std::uint64_t sum = std::stoull(fingerprint(std::as_bytes(std::span(bytes))), nullptr, 16);
        return bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
    };
    const std::string body = good.substr(0, good.size() - 8);
    ASSERT_EQ(signedFile(body), good) << "nothing is tested";
    const auto changed = [&](const std::string& from, const std::string& to) {
        std::string bytes = body;
        const std::size_t at = bytes.find(from);
        EXPECT_NE(at, std::string::npos);
        bytes.replace(at, from.size(), to);
        return signedFile(bytes);
    };
    for (const std::string& bad :
         {changed("size\t7 5", "size\t9 9"), changed("size\t7 5", "size\t5 7"),
          changed("size\t7 5", "size\t0 5"), changed("size\t7 5", "size\t-7"),
          changed("samples\t64", "samples\t63"), changed("samples\t64", "samples\t-4"),
          changed("pictures\t1", "pictures\t2"), changed("pictures\t1", "pictures\t0"),
          changed("size\t7 5", "fize\t7 5"), changed("content\t", "samples\t"),
          changed("content\t", "content ")}) {
        writeBytes(path, bad);
        EXPECT_NE(refusal(), "");
    }
    for (const std::uint64_t length : {std::uint64_t{0}, std::uint64_t{1} << 19, ~std::uint64_t{0}}) {
        std::string bytes = body;
        std::memcpy(&bytes[18], &length, sizeof length);
        writeBytes(path, signedFile(bytes));
        EXPECT_NE(refusal(), "") << length;
    }
    for (const std::string& other : {body.substr(0, body.size() - 32), body + std::string(32, '\1')}) {
        writeBytes(path, signedFile(other));
        EXPECT_THAT(refusal(), HasSubstr("which are not those of 7 x 5 pixels"));
    }
    std::string bytes = body;
    const float nan = std::nanf("");
    std::memcpy(&bytes[bytes.size() - sizeof nan], &nan, sizeof nan);
    writeBytes(path, signedFile(bytes));
    EXPECT_THAT(refusal(), HasSubstr("sums that are numbers"));
}

/// The mean of one number is that number, of however many samples.
TEST(ManySamples, HaveExactMeans) {
    for (const float light : {0.1f, 0.7f, 1.0f / 3}) {
        AreaPicture picture = pictureOf(samplingOf(PixelSampling::kMost));
        const auto same = [&](const glm::vec2&) { return glm::vec4(light, 1, 1e-3f * light, 0.5f); };
        double before = 0;
        while (drawNext(picture, same)) {
            EXPECT_GT(picture.share(0), before) << "stalls";
            before = picture.share(0);
        }
        EXPECT_EQ(picture.report().most, PixelSampling::kMost);
        for (const glm::vec4& pixel : picture.image().pixels) {
            EXPECT_NEAR(pixel.r / light, 1, 2e-7);
            EXPECT_NEAR(pixel.b / (1e-3f * light), 1, 2e-7);
            EXPECT_EQ(pixel.a, 0.5f);
        }
    }
}

TEST(ManySamples, ShareIsThatOfSamples) {
    AreaPicture picture = pictureOf(samplingOf(3000));
    std::size_t arrays = 0;
    const auto half = [&](const glm::vec2& place) { // while an array is drawn
        EXPECT_GT(picture.share(0.5), picture.share(0));
        return colourAt(place);
    };
    while (drawNext(picture, half)) {
        ++arrays;
        const double share = picture.report().taken / 3000;
        EXPECT_NEAR(picture.share(0), share, 1e-9);
    }
    EXPECT_GT(arrays, 1000u) << "nothing is tested";
    EXPECT_EQ(picture.share(0), 1);
}

/// Of a square wave over the pixel: the mean is known, and nets have it to a part of a net.
TEST(ManySamples, ComeToAKnownMean) {
    AreaPicture picture = pictureOf(samplingOf(1 << 14));
    while (drawNext(picture, [](const glm::vec2& place) {
        return glm::vec4(place.x - std::floor(place.x) < 0.3f ? 1.0f : 0.0f);
    }))
        ;
    for (const glm::vec4& pixel : picture.image().pixels)
        EXPECT_NEAR(pixel.r, 0.3f, 1e-3f);
}

} // namespace
} // namespace tessera
