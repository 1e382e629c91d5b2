// tests/render/pixels/area_rounds_test.cpp: rays of a picture that decides how many it takes add up, keep to
// what is allowed, and go first to pixels that middles may have overlooked.
#include "render/pixels/area_picture.h"

#include "render/pixels/pixel_places.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <set>

namespace tessera {
namespace {

constexpr glm::ivec2 kAcross(40, 30);
constexpr std::size_t kPixels = 1200;

/// Stripes in the left half; the rest shows nothing.
glm::vec4 stripes(const glm::dvec2& place) {
    if (place.x > 20)
        return glm::vec4(0);
    const bool bright = std::sin(2.3 * place.x + 1.1 * place.y) > 0;
    return bright ? glm::vec4(0.9f, 0.8f, 0.7f, 1.0f) : glm::vec4(0.1f, 0.1f, 0.1f, 0.5f);
}

struct Taken {
    std::size_t arrays = 0, rays = 0, padded = 0;
    std::vector<double> shares;
};

/// Draws all that is left.
Taken drawAll(AreaPicture& picture, const glm::ivec2& size, bool light = false) {
    Taken taken;
    while (const std::optional<Rays> rays = picture.next()) {
        const std::size_t before = static_cast<std::size_t>(std::lround(picture.report().taken * kPixels));
        taken.shares.push_back(picture.share(0));
        EXPECT_LE(picture.share(0), picture.share(0.9));
        Image drawn(rays->size());
        EXPECT_EQ(rays->size() == size, rays->places.empty());
        for (std::size_t i = 0; i < drawn.pixels.size(); ++i)
            drawn.pixels[i] =
                stripes(rays->places.empty()
                            ? glm::dvec2(static_cast<double>(i % 40), static_cast<double>(i / 40)) + 0.5
                            : glm::dvec2(rays->places[i]));
        EXPECT_LE(rays->places.size(), AreaPicture::mostRays(size));
        picture.add(drawn, std::span(&drawn, light ? 1 : 0));
        const auto now = static_cast<std::size_t>(std::lround(picture.report().taken * kPixels));
        taken.rays += now - before;
        taken.padded += drawn.pixels.size() - (now - before);
        EXPECT_LE(now - before, drawn.pixels.size()) << "rays that nobody cast";
        EXPECT_LT(drawn.pixels.size() - (now - before), kPatchRays * kPatchesAcross);
        ++taken.arrays;
    }
    return taken;
}
Rays raysOfSize(const glm::ivec2& size) {
    Rays rays;
    rays.frame.imageSize = size;
    return rays;
}
PixelGoal goalOf(std::size_t rays, int most = 64) {
    PixelGoal goal;
    goal.rays = rays;
    goal.most = most;
    return goal;
}
const PixelSampling kDecides{PixelSampling::kAutomatic, PixelFilter::box, 0};

TEST(AreaRounds, RaysAddUpAndKeepToWhatIsAllowed) {
    for (const std::size_t allowed : {0u, 7u, 100u, 3000u, 100000u})
        for (const int most : {8, 64}) {
            AreaPicture picture(raysOfSize(kAcross), kDecides, 2, goalOf(allowed, most));
            EXPECT_EQ(picture.share(0), 0);
            const Taken taken = drawAll(picture, kAcross);
            std::size_t samples = 0, visible = 0;
            int mostOfAny = 0;
            for (std::size_t i = 0; i < kPixels; ++i) {
                samples += static_cast<std::size_t>(picture.sums().samples(i));
                mostOfAny = std::max(mostOfAny, picture.sums().samples(i));
                visible += i % 40 < 20;
            }
            EXPECT_EQ(taken.rays, kPixels + samples) << "a ray through each middle, and samples";
            EXPECT_EQ(picture.report().taken, static_cast<double>(kPixels + samples) / kPixels);
            EXPECT_EQ(picture.report().most, std::max(1, mostOfAny));
            EXPECT_EQ(picture.report().asked, 0);
            EXPECT_FALSE(picture.report().error);
            EXPECT_LE(samples, allowed + visible);
            EXPECT_LE(mostOfAny, most);
            if (allowed == 100000) { // more than all of them need
                EXPECT_EQ(mostOfAny, most);
            }
            if (allowed == 3000) {
                EXPECT_GT(samples, 0.9 * static_cast<double>(allowed + visible)) << "not all of it is used";
            }
            EXPECT_TRUE(std::is_sorted(taken.shares.begin(), taken.shares.end()));
            EXPECT_EQ(picture.share(0), 1);
            EXPECT_FALSE(picture.next());
        }
}

TEST(AreaRounds, SamplesDoubleFromEight) {
    AreaPicture picture(raysOfSize(kAcross), kDecides, 2, goalOf(5000));
    drawAll(picture, kAcross);
    std::set<int> numbers;
    for (std::size_t i = 0; i < kPixels; ++i) {
        numbers.insert(picture.sums().samples(i));
        EXPECT_EQ(picture.sums().samplesOf(i, 0), picture.sums().samplesOf(i, 1)) << "two equal sets";
    }
    for (const int n : numbers)
        EXPECT_TRUE(n == 0 || (n >= 8 && (n & (n - 1)) == 0)) << n;
    EXPECT_GE(numbers.size(), 3u);
}

TEST(AreaRounds, OverlookedPixelsComeFirstAndTakeHalfAtMost) {
    for (const std::size_t count : {0u, 1u, 20u, 450u}) {
        std::vector<std::uint32_t> overlooked; // in the half that shows nothing
        for (std::uint32_t i = 0; overlooked.size() < count; ++i)
            if (i % 40 >= 25)
                overlooked.push_back(i);
        int asked = 0;
        AreaPicture picture(raysOfSize(kAcross), kDecides, 2, goalOf(1600), [&](const Image& middles) {
            ++asked;
            EXPECT_EQ(middles.size, kAcross);
            EXPECT_EQ(middles.at(3, 4), stripes({3.5, 4.5}));
            return overlooked;
        });
        drawAll(picture, kAcross);
        EXPECT_EQ(asked, 1);
        std::vector<std::uint32_t> sampled;
        std::size_t seen = 0;
        for (std::uint32_t i = 0; i < kPixels; ++i) {
            const int samples = picture.sums().samples(i);
            if (i % 40 >= 25 && samples > 0) {
                sampled.push_back(i);
                EXPECT_EQ(samples, 8);
            }
            seen += i % 40 < 20 ? static_cast<std::size_t>(samples) : 0;
        }
        const std::size_t expected = std::min<std::size_t>(count, 1600 / 2 / 8);
        ASSERT_EQ(sampled.size(), expected);
        for (std::size_t n = 0; n < expected; ++n) // spread evenly
            EXPECT_EQ(sampled[n], overlooked[n * count / expected]);
        EXPECT_LE(seen + 8 * expected, 1600 + 20 * 30);
        EXPECT_GE(seen, 800u) << "the other half is for what shows";
    }
}

TEST(AreaRounds, RaysOfAnotherStepHavePhasesAndMiddlesHaveNot) {
    Rays rays = raysOfSize(kAcross);
    rays.frame.segmentVoxels = rays.strides.segmentVoxels = 0.5;
    for (const bool phased : {false, true}) {
        AreaPicture picture(rays, kDecides, 1, goalOf(1000), {}, phased ? std::optional(2.0) : std::nullopt);
        for (int n = 0; n < 3; ++n) {
            const std::optional<Rays> next = picture.next();
            ASSERT_TRUE(next);
            const bool other = phased && n > 0;
            EXPECT_EQ(next->frame.phased, other);
            EXPECT_EQ(next->frame.segmentVoxels, other ? 2.0 : 0.5);
            EXPECT_EQ(next->strides.segmentVoxels, other ? 2.0 : 0.5);
            EXPECT_EQ(next->places.size(), n == 0 ? 0 : rayCount(next->size()));
            Image drawn(next->size());
            for (std::size_t i = 0; i < drawn.pixels.size(); ++i)
                drawn.pixels[i] = stripes(
                    n == 0 ? glm::dvec2(static_cast<double>(i % 40), static_cast<double>(i / 40)) + 0.5
                           : glm::dvec2(next->places[i]));
            picture.add(drawn);
        }
    }
}

// Light that is added has the same samples, and decides nothing.
TEST(AreaRounds, LightHasTheMeansOfItsOwn) {
    for (const PixelSampling& sampling : {kDecides, PixelSampling{5, PixelFilter::box, 1}}) {
        AreaPicture plain(raysOfSize(kAcross), sampling, 2, goalOf(3000)),
            lit(raysOfSize(kAcross), sampling, 2, goalOf(3000), {}, {}, 1);
        drawAll(plain, kAcross);
        drawAll(lit, kAcross, true);
        EXPECT_EQ(lit.image().pixels, plain.image().pixels);
        EXPECT_EQ(lit.other(0).pixels, lit.image().pixels);
        EXPECT_EQ(lit.report().taken, plain.report().taken);
    }
}

TEST(AreaRounds, SamplesThatAreNamedAreTakenOfEveryPixel) {
    for (const int samples : {2, 3, 7, 64}) {
        AreaPicture picture(raysOfSize(kAcross), {samples, PixelFilter::box, 3});
        const Taken taken = drawAll(picture, kAcross);
        EXPECT_EQ(taken.rays, kPixels * static_cast<std::size_t>(samples));
        EXPECT_EQ(picture.report().taken, samples);
        EXPECT_EQ(picture.report().most, samples);
        for (std::size_t i = 0; i < kPixels; ++i) {
            ASSERT_EQ(picture.sums().samplesOf(i, 0), (samples + 1) / 2);
            ASSERT_EQ(picture.sums().samplesOf(i, 1), samples / 2);
        }
        EXPECT_TRUE(std::is_sorted(taken.shares.begin(), taken.shares.end()));
        EXPECT_NEAR(taken.shares.front(), 0, 1e-9);
        EXPECT_EQ(picture.share(0), 1);
    }
}

TEST(AreaRounds, ArraysHoldWholePatches) {
    for (int edge = 1; edge < 80; ++edge) {
        const std::size_t most = AreaPicture::mostRays({edge, 3}),
                          pixels = static_cast<std::size_t>(edge) * 3;
        EXPECT_EQ(most % kPatchRays, 0u);
        EXPECT_TRUE(most <= pixels || most == kPatchRays) << edge;
        EXPECT_GT(most + kPatchRays * kPatchesAcross, pixels) << "far fewer than there is memory for";
    }
}

} // namespace
} // namespace tessera
