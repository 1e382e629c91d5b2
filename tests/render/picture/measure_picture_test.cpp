// tests/render/picture/measure_picture_test.cpp: pictures of which everything is known, measured by a source
// of pixels that stands in this file: their errors, the places of rays, and what is not measured, and why.
#include "render/picture/measure_picture.h"
#include "render/pixels/area_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using testing::HasSubstr;
using Colours = std::function<glm::vec4(const glm::vec2&)>;

/// Tells colours by their places, and remembers who asked.
struct KnownPixels : PixelSource {
    About about() const override { return says; }
    std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize, const Slicing&,
                              std::uint64_t mostBytes, Work& work) override {
        EXPECT_EQ(places.size(),
                  static_cast<std::size_t>(arraySize.x) * static_cast<std::size_t>(arraySize.y));
        limits.push_back(mostBytes);
        work.bytesUploaded += bytesOfDraw;
        if (work.bytesUploaded > mostBytes)
            return std::nullopt;
        Image image(arraySize);
        for (std::size_t i = 0; i < places.size(); ++i) {
            image.pixels[i] = (stage == 2 ? truth : stage == 1 ? ways : own)(places[i]);
            drawn[static_cast<std::size_t>(stage)]
                 [{static_cast<int>(places[i].x), static_cast<int>(places[i].y)}]
                     .insert({places[i].x, places[i].y});
        }
        return image;
    }
    std::string toSingleWays() override {
        stage = whyNoWays.empty() ? 1 : 0;
        return whyNoWays;
    }
    std::string toTruth() override {
        stage = 2;
        return whyNoTruth;
    }
    About says{true, false, 8};
    Colours own, ways, truth;
    std::string whyNoWays = "none here", whyNoTruth;
    std::uint64_t bytesOfDraw = 0;
    int stage = 0;
    std::vector<std::uint64_t> limits;
    using Pixel = std::pair<int, int>;
    std::map<Pixel, std::set<std::pair<float, float>>> drawn[3];
};

Image greyOf(const glm::ivec2& size) {
    Image image(size);
    for (glm::vec4& p : image.pixels)
        p = glm::vec4(0.5f, 0.5f, 0.5f, 1);
    return image;
}
Colours off(const glm::vec4& by) {
    return [by](const glm::vec2&) { return glm::vec4(0.5f, 0.5f, 0.5f, 1) + by; };
}
double rmsOf(const glm::vec4& v) {
    return std::sqrt((v.x * v.x + v.y * v.y + v.z * v.z + v.w * v.w) / 4);
}

struct Measured {
    explicit Measured(const glm::ivec2& size, Verify mode = Verify::quick) : image(greyOf(size)) {
        scene.volumes.resize(1);
        picture.mode = mode;
        source.own = off({0.03f, 0.01f, 0, 0});
        source.ways = off({0.03f, 0.01f, 0.04f, 0});
        source.truth = off({0.05f, -0.02f, 0.02f, 0});
    }
    PictureMeasurement operator()(std::size_t ramBytes = std::size_t{1} << 30) {
        MemoryBudget ram("RAM", "--ram", ramBytes);
        picture.pixels = pixelsOf(image);
        const PictureMeasurement m = measurePicture(picture, source, ram);
        EXPECT_EQ(ram.usedBytes(), 0u);
        return m;
    }
    Scene scene;
    Image image;
    DrawnPicture picture{scene, {}, 0, 1, Verify::quick, 0, 1, {}, false, {}};
    KnownPixels source;
};

// All pixels of a small picture: errors are those of the formulas; against the truth 3.5 % more to either
// side, which the truth may err by itself (docs/measurements/measured-errors.md).
TEST(MeasuredPictures, HaveTheErrorsThatTheyWereGiven) {
    Measured measured({21, 17});
    const PictureMeasurement m = measured();
    EXPECT_EQ(m.whyNot, "");
    EXPECT_EQ(m.mode, Verify::quick);
    EXPECT_EQ(m.all.pixels, 21 * 17);
    const auto expectIs = [](const std::optional<Estimate>& e, double value, double wider) {
        ASSERT_TRUE(e);
        EXPECT_NEAR(e->value, value, 1e-5);
        EXPECT_NEAR(e->low, value * (1 - wider), 2e-5);
        EXPECT_NEAR(e->high, value * (1 + wider), 2e-5);
    };
    expectIs(m.all.rms, rmsOf({0.05f, -0.02f, 0.02f, 0}), 0.035);
    expectIs(m.rays.rms, rmsOf({0.02f, -0.03f, 0.02f, 0}), 0.035);
    expectIs(m.sampling.rms, rmsOf({0.03f, 0.01f, 0, 0}), 0);
    ASSERT_TRUE(m.all.luvMean && m.all.luvP99 && m.all.luvP99Bound);
    EXPECT_NEAR(m.all.luvMean->value, m.all.luvP99->value, 1e-6) << "all pixels err alike";
    EXPECT_NEAR(m.all.luvP99->high, 1.035 * m.all.luvP99->value, 1e-3);
    EXPECT_TRUE(m.singleRays);
    EXPECT_FALSE(m.keptLight || m.keptRays || m.light);
    EXPECT_EQ(m.samples, 16);
    EXPECT_EQ(m.mostSamples, 16);
    // 16 places of every pixel, the same for both.
    ASSERT_EQ(measured.source.drawn[0].size(), 21u * 17);
    EXPECT_EQ(measured.source.drawn[0], measured.source.drawn[2]);
    for (const auto& [pixel, places] : measured.source.drawn[0])
        EXPECT_EQ(places.size(), 16u) << pixel.first << "," << pixel.second;
    for (const std::uint64_t limit : measured.source.limits)
        EXPECT_EQ(limit, std::numeric_limits<std::uint64_t>::max()) << "a small picture";
}

// Samples of the truth are four times the picture's, from 16 to 256; in mode full from 64.
TEST(MeasuredPictures, TakeFourTimesTheSamples) {
    for (const auto& [mode, taken, samples] : {std::tuple(Verify::quick, 1.0, 16),
                                               {Verify::quick, 4.0, 16},
                                               {Verify::quick, 6.4, 32},
                                               {Verify::quick, 16.0, 64},
                                               {Verify::quick, 200.0, 256},
                                               {Verify::full, 1.0, 64},
                                               {Verify::full, 32.0, 128}}) {
        Measured measured({9, 7}, mode);
        measured.picture.samplesPerPixel = taken;
        const PictureMeasurement m = measured();
        EXPECT_EQ(m.samples, samples) << taken;
        EXPECT_EQ(m.mostSamples, samples);
        EXPECT_EQ(m.singleRays, taken == 1);
        for (const auto& [pixel, places] : measured.source.drawn[2])
            ASSERT_EQ(places.size(), static_cast<std::size_t>(samples));
    }
}

// In mode full pixels that are too noisy are drawn again with four times the samples, and once more.
TEST(MeasuredPictures, DrawNoisyPixelsWithMore) {
    const auto noisyAt = [](const glm::vec4& by) {
        return [by](const glm::vec2& place) {
            glm::vec4 colour = glm::vec4(0.5f, 0.5f, 0.5f, 1) + by;
            if (static_cast<int>(place.x) == 3 && static_cast<int>(place.y) == 2)
                colour.g += std::sin(7919 * place.x + 104729 * place.y) > 0 ? 0.4f : -0.4f;
            return colour;
        };
    };
    for (const Verify mode : {Verify::quick, Verify::full}) {
        Measured measured({9, 7}, mode);
        measured.source.own = noisyAt({0.01f, 0.01f, 0, 0});
        measured.source.truth = noisyAt({0.02f, 0.01f, 0, 0});
        const PictureMeasurement m = measured();
        EXPECT_EQ(m.samples, mode == Verify::full ? 64 : 16);
        EXPECT_EQ(m.mostSamples, mode == Verify::full ? 1024 : 16);
        for (const auto& [pixel, places] : measured.source.drawn[2])
            EXPECT_EQ(places.size(), static_cast<std::size_t>(
                                         pixel == KnownPixels::Pixel(3, 2) ? m.mostSamples : m.samples));
        EXPECT_NEAR(m.rays.rms->value, rmsOf({0.01f, 0, 0, 0}), 1e-5) << "both go through the same places";
    }
}

// Of pictures of paths their own rays are the truth; light beside them by single ways, where these can be.
TEST(MeasuredPictures, KnowWhatTheyKeep) {
    Measured paths({9, 7});
    paths.scene.lighting.transport = Transport{};
    PictureMeasurement m = paths();
    EXPECT_TRUE(m.keptRays);
    EXPECT_FALSE(m.keptLight);
    EXPECT_NEAR(m.all.rms->value, rmsOf({0.03f, 0.01f, 0, 0}), 1e-5);
    EXPECT_EQ(paths.source.stage, 0);

    Measured lit({9, 7});
    lit.scene.lighting.occlusion = Occlusion{};
    m = lit();
    EXPECT_TRUE(m.keptLight);
    EXPECT_FALSE(m.light);
    EXPECT_EQ(m.whyNoLight, "") << "nobody asked";
    lit.source.stage = 0;
    lit.picture.light = true;
    EXPECT_EQ(lit().whyNoLight, "none here");
    lit.source.stage = 0;
    lit.source.whyNoWays.clear();
    m = lit();
    ASSERT_TRUE(m.light);
    EXPECT_NEAR(m.light->rms->value, rmsOf({0, 0, 0.04f, 0}), 1e-5);
    EXPECT_NEAR(m.all.rms->value, rmsOf({0.05f, -0.02f, 0.02f, 0}), 1e-5);
    EXPECT_EQ(lit.source.drawn[1], lit.source.drawn[0]);

    Measured surfaces({9, 7});
    surfaces.scene.lighting.surfaceOcclusion = SurfaceOcclusion{};
    EXPECT_TRUE(surfaces().keptLight);
    surfaces.source.stage = 0;
    surfaces.scene.mode = Mode::maximum;
    EXPECT_FALSE(surfaces().keptLight) << "of single values there is no light";
}

TEST(MeasuredPictures, SayWhyTheyAreNotMeasured) {
    Measured none({9, 7}, Verify::none);
    EXPECT_EQ(none().whyNot, "it was not asked for");
    Measured poor({9, 7});
    EXPECT_EQ(poor(100).whyNot, "RAM is too short for it");
    Measured untrue({9, 7});
    untrue.source.whyNoTruth = "no truth";
    EXPECT_EQ(untrue().whyNot, "no truth");
    Measured blank({9, 7});
    for (glm::vec4& p : blank.image.pixels)
        p = glm::vec4(0);
    blank.source.own = blank.source.truth = [](const glm::vec2&) { return glm::vec4(0); };
    EXPECT_THAT(blank().whyNot, HasSubstr("the picture shows nothing, nor do the 63 pixels"));
    blank.source.stage = 0;
    blank.source.truth = off(glm::vec4(0)); // what the picture missed
    EXPECT_EQ(blank().whyNot, "");
}

// A large picture pays a quarter of its bytes for quick, anything for full.
TEST(MeasuredPictures, OfLargePicturesPayAQuarterOfTheirBytes) {
    for (const int width : {512, 511}) {
        Measured measured({width, 512});
        measured.picture.bytes = 4003;
        measured.source.bytesOfDraw = 1;
        PictureMeasurement m = measured();
        EXPECT_EQ(m.whyNot, "");
        EXPECT_EQ(m.bytesRead, measured.source.limits.size());
        EXPECT_EQ(measured.source.limits.front(),
                  width == 512 ? 1000 : std::numeric_limits<std::uint64_t>::max());
        measured.source.stage = 0;
        measured.source.bytesOfDraw = 1001;
        m = measured();
        if (width == 512)
            EXPECT_THAT(m.whyNot, HasSubstr("more than a quarter of the picture's bytes"));
        else
            EXPECT_EQ(m.whyNot, "");
        measured.source.stage = 0;
        measured.picture.mode = Verify::full;
        measured.source.bytesOfDraw = 100000;
        EXPECT_EQ(measured().whyNot, "");
    }
}

// Where bricks must be read, clusters of pixels come first; pixels of their own follow if clusters left half
// of the bytes, and the percentile is told by these alone.
TEST(MeasuredPictures, PixelsOnTheirOwnFollowClusters) {
    const auto measuredWith = [](std::uint64_t bytes, bool passes) {
        Measured measured({512, 512});
        measured.source.says = {false, passes, 64};
        measured.picture.bytes = 1 << 20;
        measured.source.bytesOfDraw = bytes;
        return measured();
    };
    const PictureMeasurement both = measuredWith(1, false), clusters = measuredWith(1, true);
    EXPECT_EQ(clusters.whyNot, "");
    EXPECT_FALSE(clusters.all.luvP99);
    EXPECT_EQ(clusters.all.clusters, 64);
    EXPECT_EQ(both.whyNot, "");
    EXPECT_TRUE(both.all.luvP99);
    EXPECT_GE(both.all.pixels, 340);
    EXPECT_EQ(both.all.clusters, both.all.pixels);
}

} // namespace
} // namespace tessera
