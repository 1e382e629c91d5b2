// tests/render/pixels/pixels_test.cpp: pixels as means over their areas: the positions of samples and their
// means. The reported error is the real one, and a picture depends only on its samples.
#include "core/image/image_metrics.h"
#include "render/backends/mirror/mirror_engine.h"
#include "render/backends/native/native_engine.h"
#include "render/backends/reference/reference_engine.h"
#include "render/picture/render_scene.h"
#include "render/pixels/area_picture.h"
#include "render/pixels/pixel_places.h"
#include "render/pixels/pixel_sums.h"
#include "tests/support/places.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <set>

namespace tessera {
namespace {

using namespace tessera::test;

// Of the first 2^m samples of a set, and of every 2^m after those.
TEST(PixelPlaces, AreNetsInTheirPixel) {
    const PixelPlaces places(7, PixelFilter::box);
    for (int bits = 0; bits <= 7; ++bits)
        for (std::uint32_t set = 0; set < 100; ++set) {
            const int count = 1 << bits, first = count * static_cast<int>(set % (128u >> bits));
            const glm::ivec2 pixel(static_cast<int>(set) % 5, 3);
            std::vector<glm::vec2> at(static_cast<std::size_t>(count));
            places.put(pixel, set, first, at);
            for (int across = 0; across <= bits; ++across) { // 2^across boxes along x, the rest along y
                std::set<std::pair<int, int>> boxes;
                for (const glm::vec2& p : at) {
                    const glm::dvec2 in = glm::dvec2(p) - glm::dvec2(pixel);
                    ASSERT_GE(std::min(in.x, in.y), 0);
                    ASSERT_LE(std::max(in.x, in.y), 1);
                    boxes.insert({static_cast<int>(in.x * (1 << across)),
                                  static_cast<int>(in.y * (1 << (bits - across)))});
                }
                ASSERT_EQ(boxes.size(), at.size()) << bits << " bits, set " << set;
            }
        }
}

/// Sets that are larger than a net go on in another one.
TEST(PixelPlaces, GoOnInFurtherNets) {
    const PixelPlaces places(7, PixelFilter::box);
    std::vector<glm::vec2> first(128), second(128), far(128);
    places.put({2, 3}, 0, 0, first);
    places.put({2, 3}, 0, 128, second);
    places.put({2, 3}, 0, 128 * 200, far);
    for (const std::vector<glm::vec2>* at : {&second, &far}) {
        std::set<int> columns, rows;
        for (const glm::vec2& p : *at) {
            columns.insert(static_cast<int>((p.x - 2) * 128));
            rows.insert(static_cast<int>((p.y - 3) * 128));
        }
        EXPECT_EQ(columns.size(), 128u);
        EXPECT_EQ(rows.size(), 128u);
        EXPECT_NE(*at, first);
    }
    EXPECT_NE(second, far);
    std::vector<glm::vec2> part(8);
    places.put({2, 3}, 0, 130, part);
    EXPECT_TRUE(std::equal(part.begin(), part.end(), second.begin() + 2));
}

TEST(PixelPlaces, AreTheSameInParts) {
    const PixelPlaces places(1, PixelFilter::gaussian);
    std::vector<glm::vec2> whole(100), part(37);
    places.put({3, 8}, 1, 0, whole);
    places.put({3, 8}, 1, 20, part);
    EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + 20));
}

// Means over sets of x, y, x², xy and an edge: those of the pixel, as independent sets have them.
TEST(PixelPlaces, AreAnywhereAlikeAndSetsIndependent) {
    const PixelPlaces places(3, PixelFilter::box);
    const std::function<double(glm::dvec2)> functions[] = {
        [](glm::dvec2 p) { return p.x - 0.5; }, [](glm::dvec2 p) { return p.y - 0.5; },
        [](glm::dvec2 p) { return p.x * p.x - 1.0 / 3; }, [](glm::dvec2 p) { return p.x * p.y - 0.25; },
        [](glm::dvec2 p) { return (p.x + 0.3 * p.y < 0.5 ? 1.0 : 0.0) - 0.35; }};
    for (const int count : {1, 2, 4, 8, 16}) {
        constexpr int kSets = 20000;
        std::vector<glm::vec2> at(static_cast<std::size_t>(count));
        for (std::size_t f = 0; f < std::size(functions); ++f) {
            double sum = 0, squares = 0, neighbours = 0, before = 0;
            for (std::uint32_t set = 0; set < kSets; ++set) {
                places.put({11, 4}, set, 0, at);
                double mean = 0;
                for (const glm::vec2& p : at)
                    mean += functions[f](glm::dvec2(p) - glm::dvec2(11, 4)) / count;
                sum += mean;
                squares += mean * mean;
                neighbours += mean * before;
                before = mean;
            }
            const double deviation = std::sqrt(squares / kSets);
            EXPECT_LT(std::abs(sum / kSets), 4 * deviation / std::sqrt(kSets)) << count << ", " << f;
            EXPECT_LT(std::abs(neighbours / squares), 4 / std::sqrt(kSets)) << count << ", " << f;
        }
    }
}

TEST(PixelPlaces, FollowTheFilter) {
    const double root = std::sqrt(2.0);
    const auto part = [&](double x) { return 0.5 * std::erf(x / kFilterDeviation / root); };
    for (int i = 0; i < 4096; ++i) {
        const double unit = (i + 0.5) / 4096, x = filteredOffset(unit, PixelFilter::gaussian);
        ASSERT_NEAR((part(x) + part(kFilterReach)) / (2 * part(kFilterReach)), unit, 1e-8);
        ASSERT_LE(std::abs(x), kFilterReach);
        ASSERT_EQ(filteredOffset(unit, PixelFilter::box), unit - 0.5);
    }
}

TEST(PixelPlaces, DependOnPixelSetAndSeed) {
    const auto first = [](std::uint32_t seed, glm::ivec2 pixel, std::uint32_t set) {
        std::vector<glm::vec2> at(16);
        PixelPlaces(seed, PixelFilter::box).put(pixel, set, 0, at);
        return at[0] - glm::vec2(pixel);
    };
    const glm::vec2 one = first(0, {5, 9}, 0);
    EXPECT_EQ(one, first(0, {5, 9}, 0));
    EXPECT_NE(one, first(1, {5, 9}, 0));
    EXPECT_NE(one, first(0, {9, 5}, 0));
    EXPECT_NE(one, first(0, {5, 9}, 1));
}

TEST(RayArray, HoldsEachRayOnceAndNeighboursTogether) {
    for (const std::size_t rays : {1ul, 16ul, 40ul, 256ul, 4000ul}) {
        const glm::ivec2 size = rayArraySize(rays);
        ASSERT_GE(rayCount(size), rays);
        EXPECT_LE(rayCount(size), rays + kPatchRays * kPatchesAcross);
        std::vector<int> met(rayCount(size), 0);
        for (std::size_t k = 0; k < met.size(); ++k)
            ++met.at(raySlot(k, size));
        EXPECT_EQ(std::set<int>(met.begin(), met.end()), std::set<int>{1});
    }
    const glm::ivec2 size = rayArraySize(4000);
    for (const std::size_t lanes : {8ul, 16ul, 32ul}) // packets of 4x2, 4x4, 8x4
        for (std::size_t k = 0; k < 4000 / lanes * lanes; k += lanes) {
            std::set<std::pair<int, int>> packets;
            for (std::size_t i = 0; i < lanes; ++i) {
                const auto slot = static_cast<int>(raySlot(k + i, size));
                packets.insert({slot % size.x / (lanes == 32 ? 8 : 4), slot / size.x / (lanes == 8 ? 2 : 4)});
            }
            ASSERT_EQ(packets.size(), 1u);
        }
    std::set<std::pair<int, int>> pixels;
    forEachPixel({7, 5}, [&](const glm::ivec2& at) { EXPECT_TRUE(pixels.insert({at.x, at.y}).second); });
    EXPECT_EQ(pixels.size(), 35u);
}

constexpr glm::ivec2 kEdges(64, 48);
/// A picture of edges at many angles: a star of 24 rays, brighter to the right.
glm::vec4 star(const glm::dvec2& place) {
    const glm::dvec2 p = place - glm::dvec2(31.3, 22.7);
    const bool inside = std::sin(12 * std::atan2(p.y, p.x)) > 0;
    const float bright = inside ? static_cast<float>(0.2 + 0.6 * place.x / kEdges.x) : 0.05f;
    return {bright, bright * 0.8f, bright * 0.5f, inside ? 1.0f : 0.5f};
}

Rays ofSize(const glm::ivec2& size) {
    Rays rays;
    rays.frame.imageSize = size;
    return rays;
}

using Light = glm::vec4 (*)(const glm::dvec2&);

/// Draws what is left of a picture; at most so many arrays.
void drawLight(AreaPicture& picture, Light light, int arrays = 1 << 20) {
    for (std::optional<Rays> rays; arrays > 0 && (rays = picture.next()); --arrays) {
        const glm::ivec2 size = rays->size();
        ASSERT_LE(rays->places.size(), AreaPicture::mostRays(picture.image().size));
        Image drawn(size);
        for (std::size_t i = 0; i < drawn.pixels.size(); ++i) {
            const auto n = static_cast<int>(i);
            drawn.pixels[i] = light(rays->places.empty() ? glm::dvec2(n % size.x, n / size.x) + 0.5
                                                         : glm::dvec2(rays->places[i]));
        }
        picture.add(drawn);
    }
}
void drawStar(AreaPicture& picture, int arrays = 1 << 20) {
    drawLight(picture, star, arrays);
}

Image truthOf(Light light) {
    constexpr int kEach = 64;
    Image image(kEdges);
    for (int y = 0; y < kEdges.y; ++y)
        for (int x = 0; x < kEdges.x; ++x) {
            glm::dvec4 sum(0);
            for (int i = 0; i < kEach * kEach; ++i)
                sum += glm::dvec4(
                    light(glm::dvec2(x, y) + (glm::dvec2(i % kEach, i / kEach) + 0.5) / double{kEach}));
            image.at(x, y) = glm::vec4(sum / double{kEach * kEach});
        }
    return image;
}
const Image& starTruth() {
    static const Image truth = truthOf(star);
    return truth;
}

TEST(AreaPicture, TellsTheErrorThatItMakes) {
    double before = 1, two = 0;
    for (const int samples : {2, 3, 4, 8, 16, 64, 256}) {
        SCOPED_TRACE(samples);
        AreaPicture picture(ofSize(kEdges), {samples, PixelFilter::box, 4});
        drawStar(picture);
        const ImageDifference made = compare(picture.image(), starTruth());
        const PixelReport report = picture.report();
        ASSERT_TRUE(report.error);
        EXPECT_EQ(report.taken, samples);
        EXPECT_EQ(report.most, samples);
        EXPECT_NEAR(report.error->rms / made.rms, 1, 0.12);
        if (samples >= 8) { // two or three sets of one or two samples are off by one of few amounts
            EXPECT_NEAR(report.error->luvMean / made.luvMean, 1, 0.25);
            EXPECT_NEAR(report.error->luvP99 / made.luvP99, 1, 0.25);
        }
        EXPECT_LT(made.rms, before);
        before = made.rms;
        if (samples == 2)
            two = made.rms;
    }
    EXPECT_LT(before, two / std::sqrt(128.0) / 3); // strata pay
}

// The mean over seeds is the pixel's; the square of what one set is told to be off is its variance.
TEST(AreaPicture, IsUnbiased) {
    constexpr int kSeeds = 200;
    std::vector<glm::dvec4> sum(starTruth().pixels.size(), glm::dvec4(0));
    double made = 0, told = 0;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
        AreaPicture picture(ofSize(kEdges), {16, PixelFilter::box, seed});
        drawStar(picture);
        const Image image = picture.image();
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += glm::dvec4(image.pixels[i]) / double{kSeeds};
            const glm::dvec4 off(image.pixels[i] - starTruth().pixels[i]);
            made += glm::dot(off, off);
            told += glm::dot(glm::dvec4(picture.sums().offset(i)), glm::dvec4(picture.sums().offset(i)));
        }
    }
    EXPECT_NEAR(told / made, 1, 0.02);
    double bias = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        const glm::dvec4 off = sum[i] - glm::dvec4(starTruth().pixels[i]);
        bias += glm::dot(off, off);
    }
    EXPECT_LT(bias, 2 * made / kSeeds / kSeeds); // so many seeds leave one; the rest is the truth's own
}

TEST(AreaPicture, IsThereAtAnyTimeAndGetsBetter) {
    AreaPicture picture(ofSize(kEdges), {64, PixelFilter::box, 1});
    drawStar(picture, 2 + 2 + 4 + 8); // 2, 4, 8 and 16 samples of each pixel
    const double early = compare(picture.image(), starTruth()).rms;
    EXPECT_EQ(picture.report().taken, 16);
    drawStar(picture, 8); // half of the next 16
    EXPECT_EQ(picture.report().taken, 24);
    EXPECT_NEAR(picture.share(0), 24.0 / 64, 0.01);
    EXPECT_LT(compare(picture.image(), starTruth()).rms, early);
    drawStar(picture);
    EXPECT_LT(compare(picture.image(), starTruth()).rms, 0.5 * early);
    EXPECT_EQ(picture.report().most, 64);
    EXPECT_EQ(picture.share(0), 1);
    EXPECT_FALSE(picture.next());
}

PixelSampling automatic(std::uint32_t seed = 0) {
    return {PixelSampling::kAutomatic, PixelFilter::box, seed};
}

/// Six sectors on a ramp: most pixels are smooth.
glm::vec4 wheel(const glm::dvec2& place) {
    const glm::dvec2 p = place - glm::dvec2(31.3, 22.7);
    const bool inside = std::sin(3 * std::atan2(p.y, p.x) + 0.2) > 0;
    const float bright = inside ? static_cast<float>(0.2 + 0.6 * place.x / kEdges.x) : 0.05f;
    return {bright, bright * 0.8f, bright * 0.5f, inside ? 1.0f : 0.5f};
}

TEST(AutomaticSamples, GoWherePixelsNeedThem) {
    const Image truth = truthOf(wheel);
    AreaPicture picture(ofSize(kEdges), automatic());
    drawLight(picture, wheel, 1);
    Image middles(kEdges);
    for (int y = 0; y < kEdges.y; ++y)
        for (int x = 0; x < kEdges.x; ++x)
            middles.at(x, y) = wheel(glm::dvec2(x, y) + 0.5);
    EXPECT_TRUE(bitEqual(picture.image(), middles)) << "the first picture is one ray through each middle";
    drawLight(picture, wheel);
    const PixelReport report = picture.report();
    EXPECT_FALSE(report.error); // samples that decided certify nothing
    EXPECT_LT(report.taken, 40);
    EXPECT_EQ(report.most, 64);
    // Uniform samples of as many rays
    AreaPicture uniform(ofSize(kEdges), {static_cast<int>(std::ceil(report.taken)), PixelFilter::box, 0});
    drawLight(uniform, wheel);
    const Image drawn = picture.image();
    EXPECT_LT(compare(drawn, truth).rms, 0.6 * compare(uniform.image(), truth).rms);
    EXPECT_LT(compare(drawn, truth).luvP99, 0.6 * compare(uniform.image(), truth).luvP99);
    EXPECT_LT(compare(drawn, truth).luvP99, 3);
    std::size_t edges = 0, edgesSampled = 0, flat = 0, flatSampled = 0;
    for (int y = 1; y < kEdges.y - 1; ++y)
        for (int x = 1; x < kEdges.x - 1; ++x) {
            const auto i = static_cast<std::size_t>(y * kEdges.x + x);
            bool near = false;
            for (int k = 0; k < 9; ++k)
                near =
                    near || std::abs(truth.at(x + k % 3 - 1, y + k / 3 - 1).a - middles.pixels[i].a) > 0.01f;
            const bool on = std::abs(truth.pixels[i].a - middles.pixels[i].a) > 0.1f;
            edges += on, edgesSampled += on && picture.sums().samples(i) > 8;
            flat += !near, flatSampled += !near && picture.sums().samples(i) > 0;
            if (picture.sums().samples(i) == 0) {
                EXPECT_EQ(drawn.pixels[i], middles.pixels[i]);
            }
        }
    EXPECT_GT(edges, 80u);
    EXPECT_GE(static_cast<double>(edgesSampled), 0.9 * static_cast<double>(edges));
    EXPECT_GT(flat, 500u);
    EXPECT_LT(flatSampled, flat / 50);
}

// A picture that was good enough for one goal goes on to another: as good as one that was drawn for it, and
// no ray is taken twice.
TEST(AutomaticSamples, GoOnToAnotherGoal) {
    const Image truth = truthOf(wheel);
    const auto goalOf = [](float lightness) {
        PixelGoal goal;
        goal.target.linear *= lightness / static_cast<float>(goal.target.lightness);
        goal.target.lightness = lightness;
        return goal;
    };
    AreaPicture coarse(ofSize(kEdges), automatic(), 0, goalOf(4)),
        fine(ofSize(kEdges), automatic(), 0, goalOf(0.5f));
    drawLight(coarse, wheel);
    drawLight(fine, wheel);
    const Image before = coarse.image();
    const PixelSums had = coarse.sums();
    const double taken = coarse.report().taken;
    coarse.goOn(goalOf(0.5f));
    drawLight(coarse, wheel);
    EXPECT_LT(compare(coarse.image(), truth).rms, 0.7 * compare(before, truth).rms);
    EXPECT_LT(compare(coarse.image(), truth).rms, 1.25 * compare(fine.image(), truth).rms);
    EXPECT_GT(coarse.report().taken, taken);
    EXPECT_LT(coarse.report().taken, 1.1 * fine.report().taken);
    std::size_t grown = 0;
    for (std::size_t i = 0; i < had.count(); ++i) {
        grown += coarse.sums().samples(i) > had.samples(i);
        ASSERT_GE(coarse.sums().samples(i), had.samples(i));
        if (coarse.sums().samples(i) == had.samples(i)) {
            ASSERT_EQ(coarse.image().pixels[i], before.pixels[i]);
        }
    }
    EXPECT_GT(grown, 100u);
}

/// A disk that only the picture's last corner shows a part of: the last pixels of the last patch.
glm::vec4 corner(const glm::dvec2& place) {
    return glm::distance(place, glm::dvec2(kEdges) + 2.0) < 5.5 ? glm::vec4(0.7f, 0.6f, 0.5f, 1)
                                                                : glm::vec4(0);
}
/// A box's outline against nothing: silhouettes at all of a picture's patches.
glm::vec4 box(const glm::dvec2& place) {
    const glm::dvec2 p = place - glm::dvec2(32, 24), q(0.9 * p.x - 0.44 * p.y, 0.44 * p.x + 0.9 * p.y);
    return std::abs(q.x) < 17.3 && std::abs(q.y) < 11.7 ? glm::vec4(0.3f, 0.25f, 0.2f, 0.4f) : glm::vec4(0);
}
/// A line a tenth of a pixel wide: one ray of ten through its pixels hits it.
glm::vec4 thread(const glm::dvec2& place) {
    return std::abs(place.y - 11 - 0.41 * place.x) < 0.054 ? glm::vec4(1) : glm::vec4(0);
}

double lightOf(const Image& image) {
    double sum = 0;
    for (const glm::vec4& p : image.pixels)
        sum += static_cast<double>(p.r);
    return sum;
}

// Scenes that other renderers leave out: a tile of which a volume clips a corner, silhouettes, parts that few
// rays hit.
TEST(AutomaticSamples, LeaveOutNoScene) {
    const auto drawn = [](Light light, std::uint32_t seed) {
        AreaPicture picture(ofSize(kEdges), automatic(seed));
        drawLight(picture, light);
        return picture.image();
    };
    const auto middles = [](Light light) {
        AreaPicture picture(ofSize(kEdges), automatic());
        drawLight(picture, light, 1);
        return picture.image();
    };
    for (const Light light : {corner, box}) {
        const Image truth = truthOf(light);
        EXPECT_LT(compare(drawn(light, 0), truth).rms, 0.25 * compare(middles(light), truth).rms);
        EXPECT_NEAR(lightOf(drawn(light, 0)) / lightOf(truth), 1, 0.02);
    }
    const Image truth = truthOf(thread);
    double light = 0;
    for (std::uint32_t seed = 0; seed < 10; ++seed)
        light += lightOf(drawn(thread, seed)) / lightOf(truth) / 10;
    EXPECT_NEAR(light, 1, 0.25);
    EXPECT_LT(compare(drawn(thread, 0), truth).rms, 0.5 * compare(middles(thread), truth).rms);
}

TEST(AutomaticSamples, TakeNoneWhereLightIsSmoothOrThereIsNone) {
    for (const Light light :
         {Light{[](const glm::dvec2&) { return glm::vec4(0); }},
          Light{[](const glm::dvec2& p) { return glm::vec4(glm::dvec4(p.x / 16, p.y / 12, 0.5, 1)); }}}) {
        AreaPicture picture(ofSize(kEdges), automatic());
        drawLight(picture, light);
        EXPECT_EQ(picture.report().taken, 1);
    }
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(2, 1), glm::ivec2(1, 40), glm::ivec2(5, 2)}) {
        AreaPicture picture(ofSize(size), automatic());
        drawStar(picture);
        EXPECT_LE(picture.report().taken, 65);
    }
}

// Two sets that are alike by chance stop no pixel among others that differ.
TEST(AutomaticSamples, ListenToNeighbours) {
    PixelSums sums({5, 5}, 4);
    for (std::size_t i = 0; i < sums.count(); ++i)
        for (int set = 0; set < 2; ++set)
            sums.add(i, set, glm::vec4(i == 12 || set == 0 ? 2 : 1), 4);
    const std::vector<float> needs = sampleNeeds(sums, PixelTarget());
    EXPECT_EQ(sums.offset(12), glm::vec4(0));
    EXPECT_GT(needs[12], 1);
    EXPECT_LT(needs[12], needs[6]);
}

VolumeInfo infoOf(const std::string& store) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    return StoreReader(storePath(store), ram).info();
}

RenderResult drawn(const Scene& scene, EngineKind engine, int threads = 2, const Slicing& slicing = {},
                   std::size_t gpuBytes = std::size_t{256} << 20) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    options.threads = threads;
    options.slicing = slicing;
    return renderScene(scene, reader, ram, gpu, options);
}

Scene sampled(int samples, const glm::ivec2& size) {
    Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, size);
    scene.quality.pixels.samples = samples;
    return scene;
}

/// Pixels as means of 32 x 32 rays on a grid, by the native engine.
Image gridMeans(const Scene& scene) {
    Prepared prepared("torso", scene);
    Planner& p = prepared.p;
    NativeEngine engine(2, prepared.budgets.gpu, prepared.budgets.ram);
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    Work work;
    loadBricks(engine, p, prepared.budgets.gpu, work);
    const auto caster = engine.caster({}, prepared.budgets.gpu);
    constexpr int kEach = 32;
    const Places places = middles(scene.imageSize, kEach);
    caster->begin(places.of(p.view.frame, p.strides()));
    drawToTheEnd(*caster, engine, p, Slicing{}, work);
    const Image fine = caster->image();
    Image image(scene.imageSize);
    for (int y = 0; y < fine.size.y; ++y)
        for (int x = 0; x < fine.size.x; ++x)
            image.at(x / kEach, y / kEach) += fine.at(x, y) / static_cast<float>(kEach * kEach);
    return image;
}

TEST(SampledPictures, ComeToTheMeanOfThePixel) {
    constexpr glm::ivec2 size(22, 18);
    const Scene one = sampled(1, size);
    const Image truth = gridMeans(one);
    const double single = compare(drawn(one, EngineKind::native).image, truth).rms;
    for (const int samples : {4, 16}) { // more than the grid itself is right to would tell nothing
        const RenderResult result = drawn(sampled(samples, size), EngineKind::native);
        const double made = compare(result.image, truth).rms;
        EXPECT_LT(made, 1.5 * single / std::sqrt(samples)); // a ray through the middle is a good one of one
        EXPECT_NEAR(result.pixels.error->rms / made, 1, 0.25) << samples;
    }
    const RenderResult decided = drawn(sampled(PixelSampling::kAutomatic, size), EngineKind::native);
    EXPECT_LE(decided.pixels.taken, 65);
    EXPECT_LT(compare(decided.image, truth).rms, 0.1 * single);
}

TEST(SampledPictures, AreTheSameOnEveryEngineAndHoweverTheyAreCut) {
    const Scene scene = sampled(16, {21, 18});
    const Image mirror = drawn(scene, EngineKind::mirror).image;
    EXPECT_FALSE(isBlank(mirror));
    EXPECT_TRUE(bitEqual(drawn(scene, EngineKind::native, 1).image, mirror));
    EXPECT_TRUE(bitEqual(drawn(scene, EngineKind::native, 3).image, mirror));
    Slicing shreds;
    shreds.fixedTile = 16;
    shreds.fixedIterations = 9;
    EXPECT_TRUE(bitEqual(drawn(scene, EngineKind::native, 2, shreds).image, mirror));
    const Image gpu = drawn(scene, EngineKind::gpu).image;
    EXPECT_LE(compare(gpu, mirror).maxAbs, 1e-3); // rays of its own, which may miss a voxel's corner
    EXPECT_TRUE(bitEqual(drawn(scene, EngineKind::gpu, 2, shreds).image, gpu));
    Scene other = scene;
    other.quality.pixels.seed = 1;
    EXPECT_FALSE(bitEqual(drawn(other, EngineKind::mirror).image, mirror));
    const RenderResult reference = drawn(scene, EngineKind::reference);
    ASSERT_TRUE(reference.pixels.error);
    EXPECT_GT(reference.pixels.error->rms, 0);
    EXPECT_LT(compare(reference.image, mirror).rms, 0.03);
}

TEST(SampledPictures, AreTheSameAtEveryBudget) {
    for (const EngineKind engine : {EngineKind::native, EngineKind::gpu}) {
        Scene scene = sampled(4, {24, 24});
        scene.quality.maxError = 0;
        const RenderResult ample = drawn(scene, engine);
        const RenderResult scarce = drawn(scene, engine, 2, {}, std::size_t{3} << 20);
        EXPECT_EQ(ample.passes, 1);
        EXPECT_GT(scarce.passes, 1);
        EXPECT_TRUE(bitEqual(scarce.image, ample.image)) << name(engine);
        scene.quality.pixels.samples = PixelSampling::kAutomatic;
        const Image decided = drawn(scene, engine).image;
        EXPECT_FALSE(bitEqual(decided, ample.image));
        EXPECT_TRUE(bitEqual(drawn(scene, engine, 1, {}, std::size_t{3} << 20).image, decided));
        if (engine == EngineKind::native) {
            EXPECT_TRUE(bitEqual(drawn(scene, EngineKind::mirror).image, decided));
        }
    }
}

// At the floor that a refusal states, for RAM, even of pictures with fewer pixels than a packet has rays.
TEST(SampledPictures, NeedTheMemoryThatTheySay) {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(40, 30)}) {
        const Scene scene = sampled(16, size);
        MemoryBudget first("RAM", "--ram", std::size_t{64} << 20);
        const VolumeInfo info = StoreReader(storePath("torso"), first).info();
        const std::size_t floor =
            renderFloorBytes(info, size, pictureBytesPerPixel(EngineKind::native, scene.quality.pixels), 2);
        MemoryBudget ram("RAM", "--ram", floor), gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
        const StoreReader reader(storePath("torso"), ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = 2;
        EXPECT_NO_THROW(renderScene(scene, reader, ram, gpu, options));
        const std::size_t plain = renderFloorBytes(info, size, pictureBytesPerPixel(EngineKind::native), 2);
        EXPECT_GE(floor - plain, rayCount(size) * PixelSums::bytesPerPixel(4));
    }
}

} // namespace
} // namespace tessera
