// tests/render/light/shadow_test.cpp: deep shadow maps within their own error: of functions in closed form,
// and of scans against rays of shadow by the reference's quadrature.
#include "core/base/progress.h" // secondsSince
#include "render/backends/native/native_shadows.h"
#include "render/contract/lattice.h"
#include "render/light/shadow_maps.h"
#include "tests/support/graded.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <random>

namespace tessera::test {
namespace {

/// Light along a ray as a function of mm, at equal distances.
template <typename Function> std::vector<LightLeft> sampled(const Function& light, double mm, int steps) {
    std::vector<LightLeft> samples;
    for (int n = 0; n <= steps; ++n)
        samples.push_back({static_cast<float>(mm * n / steps), static_cast<float>(light(mm * n / steps))});
    return samples;
}

template <typename Function> void expectWithin(const Function& light, double mm, const char* what) {
    for (const float error : {0.1f, 0.03f, 0.01f, 0.003f, 1e-4f}) {
        DeepShadowMap map(1);
        const std::vector<LightLeft> samples = sampled(light, mm, 400);
        const float made = map.fit({0, 0}, samples, error);
        EXPECT_GE(made, error);
        double largest = 0;
        for (const LightLeft& s : samples)
            largest =
                std::max(largest, static_cast<double>(std::abs(map.nearest({0.5f, 0.5f}, s.mm) - s.light)));
        EXPECT_LE(largest, static_cast<double>(made) * 1.001 + 1e-6) << what << " at " << error;
        EXPECT_LE(map.layersOf({0, 0}), DeepShadowMap::kLayers);
        if (error >= 0.03f) { // eight places are enough for these
            EXPECT_EQ(made, error) << what;
        }
        EXPECT_EQ(map.nearest({0.5f, 0.5f}, -5), samples.front().light);
        EXPECT_NEAR(map.nearest({0.5f, 0.5f}, static_cast<float>(2 * mm)), samples.back().light, made);
    }
}

// What budgets are charged is what numbers() holds: of every ray its places, and the light there.
TEST(DeepShadowMap, BytesAreThoseOfItsNumbers) {
    for (const int size : {1, 7, 256})
        EXPECT_EQ(DeepShadowMap::bytes(size),
                  static_cast<std::size_t>(size * size) * 2 * DeepShadowMap::kLayers * sizeof(float));
    Light light;
    light.kind = LightKind::directional;
    ShadowQuality quality;
    quality.mapSize = 64;
    const std::size_t one = ShadowMaps::bytes(light, quality);
    EXPECT_EQ(one, DeepShadowMap::bytes(64));
    light.kind = LightKind::point;
    EXPECT_EQ(ShadowMaps::bytes(light, quality), 6 * one) << "a side of a cube each";
}

TEST(DeepShadowMap, IsWithinItsErrorOnClosedForms) {
    expectWithin([](double s) { return std::exp(-0.3 * s); }, 20, "a slab");                            // T1
    expectWithin([](double s) { return std::exp(-(1 - std::exp(-s / 4)) * 3); }, 20, "falling");        // T3
    expectWithin([](double s) { return std::exp(-1.5 * (1 + std::erf((s - 10) / 3))); }, 20, "a blob"); // T5
    expectWithin([](double s) { return s < 7 ? 1.0 : s < 7.2 ? 1 - 5 * (s - 7) * 0.99 : 0.01; }, 20, "thin");
}

TEST(DeepShadowMap, FewerPlacesThanStepsMakeALargerErrorThatIsKnown) {
    // Twenty thin sheets, each taking a tenth: more steps than places.
    const auto sheets = [](double s) { return std::pow(0.9, std::floor(s)); };
    DeepShadowMap map(1);
    const std::vector<LightLeft> samples = sampled(sheets, 20, 2000);
    const float made = map.fit({0, 0}, samples, 0.001f);
    EXPECT_GT(made, 0.001f);
    for (const LightLeft& s : samples)
        EXPECT_NEAR(map.nearest({0.5f, 0.5f}, s.mm), s.light, made * 1.001);
}

/// Fewer places, more error, of which each map still tells.
TEST(DeepShadowMap, ErrsByNoMoreThanItSaysWithFewerLayers) {
    const std::vector<LightLeft> samples =
        sampled([](double s) { return std::exp(-(1 - std::exp(-s / 4)) * 3); }, 20, 2000);
    float before = std::numeric_limits<float>::infinity();
    for (const int layers : {2, 3, 4, 6, 8}) {
        DeepShadowMap map(1, layers);
        const float made = map.fit({0, 0}, samples, 1e-4f);
        EXPECT_LE(map.layersOf({0, 0}), layers);
        EXPECT_LE(made, before) << layers;
        for (const LightLeft& s : samples)
            ASSERT_NEAR(map.nearest({0.5f, 0.5f}, s.mm), s.light, made * 1.001f) << layers;
        before = made;
    }
    EXPECT_LT(before, 0.02f);
}

TEST(DeepShadowMap, NothingInTheWayAndBeyondTheEdgesIsAllLight) {
    DeepShadowMap map(4);
    EXPECT_EQ(map.nearest({2, 2}, 100), 1);
    EXPECT_EQ(map.between({-3, 9}, 100), 1);
    const std::vector<LightLeft> dark = {{10, 1}, {11, 0}};
    for (int n = 0; n < 16; ++n)
        map.fit({n % 4, n / 4}, dark, 0.01f);
    EXPECT_NEAR(map.between({2, 2}, 20), 0, 0.02);
    EXPECT_NEAR(map.between({2, 2}, 10.5f), 0.5, 0.02);
    EXPECT_EQ(map.between({2, 2}, 9), 1);
    EXPECT_EQ(map.nearest({4.5f, 2}, 20), 1);
}

/// Light that gets to a place from a light, by the midpoint rule in double with short segments.
double lightByRay(const LightPath& path, const glm::dvec3& place, const glm::dvec3& towards, double farMm) {
    const glm::dmat4 voxels = glm::inverse(path.info->patientFromVoxel);
    const double step = 0.05;
    double depth = 0;
    withCacheField<double>(*path.cache, *path.info, *path.selection, path.levels, Gradient::central,
                           [&](auto& field) {
                               for (double t = step / 2; t < farMm; t += step) {
                                   const glm::dvec3 p(voxels * glm::dvec4(place + t * towards, 1));
                                   if (glm::any(glm::lessThan(p, glm::dvec3(0))) ||
                                       glm::any(glm::greaterThan(p, glm::dvec3(path.info->extentVoxels))))
                                       break;
                                   depth += step * lookUp(*path.optics, field.value(p)).a;
                               }
                           });
    return std::exp(-depth);
}

struct ShadowCase {
    const char *store, *preset;
    bool isPoint, inside;
    double mostMean, most; // differences; the largest at edges of shadows, where a map's rays lie beside
    double offset = 0;     // voxels, from a place towards the light: what lies between takes nothing
};

void expectAsByRays(const ShadowCase& c) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(c.store), ram).info();
    Prepared prepared(c.store, sceneOn(info, c.preset, 0, {16, 16}));
    const FramePlan& p = prepared.p;
    const LightPath path{p.layer().cache.get(), &p.info(),           &p.layer().selection, nullptr,
                         &p.layer().optics,     &p.layer().occupancy};
    PlacedLight light;
    light.isPoint = c.isPoint;
    light.towards = glm::normalize(glm::dvec3(0.4, -0.7, 0.5));
    const glm::dvec3 extent(info.extentVoxels);
    light.position = glm::dvec3(
        info.patientFromVoxel *
        glm::dvec4(extent * (c.inside ? glm::dvec3(0.5, 0.45, 0.55) : glm::dvec3(0.3, -0.8, 1.4)), 1));
    ShadowQuality quality;
    quality.mapSize = 256;
    quality.stepVoxels = 0.25;
    quality.offset = c.offset;
    const double offsetMm =
        c.offset * std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
    ShadowMaps maps(light, path, quality);
    maps.build(path, 0);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> anywhere(0.02, 0.98);
    double sum = 0, shade = 0;
    int far = 0;
    constexpr int kPlaces = 300;
    for (int n = 0; n < kPlaces; ++n) {
        const glm::dvec3 voxel = extent * glm::dvec3(anywhere(random), anywhere(random), anywhere(random));
        const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(voxel, 1));
        const glm::dvec3 to = c.isPoint ? light.position - place : light.towards * 1e4;
        const glm::dvec3 from = place + offsetMm * glm::normalize(to);
        const double truth = lightByRay(path, from, glm::normalize(to), glm::length(to) - offsetMm);
        const double difference = std::abs(static_cast<double>(maps.light(place)) - truth);
        sum += difference;
        shade += 1 - truth;
        far += difference > c.most ? 1 : 0;
    }
    EXPECT_LT(sum / kPlaces, c.mostMean) << c.store;
    EXPECT_LE(far, kPlaces / 50) << c.store;
    EXPECT_GT(shade / kPlaces, 0.05) << c.store; // else nothing was compared
}

TEST(ShadowMaps, AreWhatRaysOfShadowSay) {
    expectAsByRays({"torso", "soft-tissue", false, false, 0.02, 0.2});
    expectAsByRays({"torso", "soft-tissue", true, false, 0.02, 0.2});
    expectAsByRays({"torso", "soft-tissue", true, true, 0.02, 0.2});
    expectAsByRays({"sphere", "bone-1", false, false, 0.02, 0.2});
    if (!std::filesystem::exists(storePath("abdomen")))
        GTEST_SKIP() << "the rest: no store of the abdomen";
    expectAsByRays({"abdomen", "bone-1", false, false, 0.03, 0.3});
}

/// Piecewise propagation (course notes 6.1.1): light that gets to the nodes of a grid from its side, each by
/// a segment of the way to the next; and to places by a segment of their own.
struct Propagated {
    /// @param between  optical depth of a segment: of a place in voxels, to the light
    Propagated(const glm::dvec3& extent, int nodes, const glm::dvec3& segment,
               const std::function<double(const glm::dvec3&)>& between)
        : extent_(extent), segment_(segment), between_(between), nodes_(nodes),
          depths_(static_cast<std::size_t>(nodes) * nodes * nodes, 0) {
        std::vector<std::size_t> order(depths_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return glm::dot(placeOf(a), segment) > glm::dot(placeOf(b), segment);
        });
        for (const std::size_t node : order) {
            const glm::dvec3 p = placeOf(node);
            depths_[node] = between_(p) + at(p + segment);
        }
    }
    double light(const glm::dvec3& p) const { return std::exp(-between_(p) - at(p + segment_)); }

  private:
    glm::dvec3 placeOf(std::size_t n) const {
        const auto edge = static_cast<std::size_t>(nodes_);
        return (glm::dvec3(n % edge, n / edge % edge, n / edge / edge) + 0.5) * extent_ / double(nodes_);
    }
    /// In depths, so in the logarithm of light; 0 beyond the volume.
    double at(const glm::dvec3& p) const {
        if (glm::any(glm::lessThan(p, glm::dvec3(0))) || glm::any(glm::greaterThan(p, extent_)))
            return 0;
        const glm::dvec3 x = glm::clamp(p * double(nodes_) / extent_ - 0.5, 0.0, nodes_ - 1.0);
        const glm::ivec3 low = glm::min(glm::ivec3(x), glm::ivec3(std::max(0, nodes_ - 2)));
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 side(corner & 1, corner >> 1 & 1, corner >> 2);
            const glm::dvec3 part =
                glm::mix(1.0 - (x - glm::dvec3(low)), x - glm::dvec3(low), glm::dvec3(side));
            sum += part.x * part.y * part.z * depths_[linearIndex(low + side, glm::ivec3(nodes_))];
        }
        return sum;
    }
    glm::dvec3 extent_, segment_;
    std::function<double(const glm::dvec3&)> between_;
    int nodes_;
    std::vector<double> depths_;
};

/// TESSERA_TELL=1 tells what the fit's error costs and brings, and what piecewise propagation does, of places
/// where something shows.
TEST(ShadowMaps, TellsWhatTheyTakeAndErrBy) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL is not set";
    for (const auto& [store, preset] :
         {std::pair{"torso", "soft-tissue"}, {"abdomen", "bone-1"}, {"head", "skin-1"}}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        const VolumeInfo info = StoreReader(storePath(store), ram).info();
        Prepared prepared(store, sceneOn(info, preset, 0, {16, 16}));
        const FramePlan& p = prepared.p;
        const LightPath path{p.layer().cache.get(), &p.info(),           &p.layer().selection, nullptr,
                             &p.layer().optics,     &p.layer().occupancy};
        PlacedLight light;
        light.towards = glm::normalize(glm::dvec3(0.4, -0.7, 0.5));
        const glm::dvec3 extent(info.extentVoxels);
        const glm::dmat3 toVoxels = glm::inverse(glm::dmat3(info.patientFromVoxel));
        const glm::dvec3 perMm = toVoxels * light.towards;
        const double voxelMm = 1 / glm::length(perMm), offsetMm = 2 * voxelMm;
        withCacheField<double>(
            *path.cache, info, *path.selection, nullptr, Gradient::central, [&](auto& field) {
                const auto extinction = [&](const glm::dvec3& v) {
                    return glm::any(glm::lessThan(v, glm::dvec3(0))) || glm::any(glm::greaterThan(v, extent))
                               ? 0.0
                               : lookUp(*path.optics, field.value(v)).a;
                };
                std::mt19937 random(7);
                std::uniform_real_distribution<double> anywhere(0.02, 0.98);
                std::vector<glm::dvec3> places;
                std::vector<double> truth;
                for (int n = 0; places.size() < 400 && n < 400000; ++n) {
                    const glm::dvec3 voxel =
                        extent * glm::dvec3(anywhere(random), anywhere(random), anywhere(random));
                    if (!(extinction(voxel) > 0.01))
                        continue;
                    const glm::dvec3 from = voxel + offsetMm * perMm,
                                     place(info.patientFromVoxel * glm::dvec4(from, 1));
                    const double left = lightByRay(path, place, light.towards, 1e4);
                    if (left < 0.02)
                        continue; // deep inside
                    places.push_back(voxel);
                    truth.push_back(left);
                }
                const auto rms = [&](const std::function<double(const glm::dvec3&)>& lightAt) {
                    double sum = 0;
                    for (std::size_t n = 0; n < places.size(); ++n)
                        sum += std::pow(lightAt(places[n]) - truth[n], 2);
                    return std::sqrt(sum / static_cast<double>(places.size()));
                };
                for (const float error : {0.00005f, 0.0005f, 0.005f, 1.0f / 128, 0.01f, 0.05f}) {
                    ShadowQuality quality;
                    quality.error = error;
                    ShadowMaps maps(light, path, quality);
                    const auto start = std::chrono::steady_clock::now();
                    maps.build(path, 0);
                    const double seconds = secondsSince(start);
                    const auto& map = dynamic_cast<const DeepShadowMap&>(*maps.maps().front());
                    double layers = 0;
                    for (int y = 0; y < map.size(); ++y)
                        for (int x = 0; x < map.size(); ++x)
                            layers += map.layersOf({x, y});
                    tell("%s, %s, deep map, error %g: %.2f points a ray, %.1f %% of rays need more than 8, "
                         "rms %.4f, %.2f s\n",
                         store, preset, double{error}, layers / map.size() / map.size(),
                         100 * maps.shareOfMore(), rms([&](const glm::dvec3& v) {
                             return double{maps.light(glm::dvec3(info.patientFromVoxel * glm::dvec4(v, 1)))};
                         }),
                         seconds);
                }
                for (const double segment : {4.0, 8.0, 16.0, 32.0}) { // a segment of its own, then the map
                    ShadowQuality quality;
                    quality.offset = 2 + segment;
                    ShadowMaps maps(light, path, quality);
                    maps.build(path, 0);
                    tell("%s, %s, a segment of %g voxels before the deep map: rms %.4f\n", store, preset,
                         segment, rms([&](const glm::dvec3& v) {
                             double depth = 0;
                             const int steps = static_cast<int>(segment);
                             for (int n = 0; n < steps; ++n)
                                 depth += extinction(v + (offsetMm + (n + 0.5) * voxelMm) * perMm) * voxelMm;
                             return std::exp(-depth) *
                                    double{maps.light(glm::dvec3(info.patientFromVoxel * glm::dvec4(v, 1)))};
                         }));
                }
                for (const int nodes : {32, 64, 128, 192})
                    for (const double segment : {4.0, 8.0, 16.0, 32.0}) {
                        const glm::dvec3 way = segment * perMm * voxelMm; // voxels
                        std::size_t values = 0;
                        const auto between = [&](const glm::dvec3& from) {
                            double sum = 0;
                            const int steps = static_cast<int>(segment);
                            for (int n = 0; n < steps; ++n, ++values)
                                sum += extinction(from + (n + 0.5) / steps * way);
                            return sum * segment / steps * voxelMm;
                        };
                        const Propagated grid(extent, nodes, way, between);
                        const std::size_t forGrid = values;
                        tell("%s, %s, propagated, %d^3 nodes, segment %g voxels: rms %.4f; %.1f million "
                             "values for the grid, %g "
                             "a place\n",
                             store, preset, nodes, segment,
                             rms([&](const glm::dvec3& v) { return grid.light(v + offsetMm * perMm); }),
                             1e-6 * static_cast<double>(forGrid), segment);
                    }
            });
    }
}

/// A medium within the offset before a place does not shade it: neither from a directional light nor from a
/// point light.
TEST(ShadowMaps, LookFromBeforeAPlace) {
    for (const double offset : {2.0, 6.0})
        for (const bool isPoint : {false, true})
            expectAsByRays({"torso", "soft-tissue", isPoint, false, 0.02, 0.2, offset});
}

LightPath pathOf(const FramePlan& p) {
    LightPath path;
    path.cache = p.layer().cache.get();
    path.info = &p.info();
    path.selection = &p.layer().selection;
    path.levels = p.layer().mixed() ? &p.layer().levels : nullptr;
    path.optics = &p.layer().optics;
    path.occupancy = p.layer().occupancy.exists() ? &p.layer().occupancy : nullptr;
    return path;
}

/// Maps of any number of rows, cast a few at a time, come to an end, and are those that are cast at once.
TEST(ShadowMaps, CastInPartsAreTheSame) {
    Prepared prepared("torso", sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16}));
    const VolumeInfo& info = prepared.p.info();
    const LightPath path = pathOf(prepared.p);
    for (const int size : {16, 20}) {
        ShadowQuality quality;
        quality.mapSize = size;
        const PlacedLight light{false, glm::normalize(glm::dvec3(0.4, -0.7, 0.5))};
        ShadowMaps whole(light, path, quality), parts(light, path, quality);
        whole.build(path, 1);
        int rounds = 1;
        while (!parts.buildUntil(path, 1, std::chrono::steady_clock::time_point()) && rounds < size)
            ++rounds;
        EXPECT_EQ(rounds, (size + 7) / 8) << "eight rows at a time";
        for (int n = 0; n < 200; ++n) {
            const glm::dvec3 at =
                glm::dvec3(info.extentVoxels) * glm::dvec3(n % 7 + 0.5, n % 5 + 0.5, n % 11 + 0.5) / 11.0;
            const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(at, 1));
            ASSERT_EQ(parts.light(place), whole.light(place)) << n;
        }
    }
}

/// A run of places has the bits of one place after the other: inside the maps, across their edges, and far
/// outside.
TEST(ShadowMaps, ARunIsPlaceByPlace) {
    Prepared prepared("torso", sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16}));
    const VolumeInfo& info = prepared.p.info();
    const LightPath path = pathOf(prepared.p);
    ShadowQuality quality;
    quality.mapSize = 32;
    const glm::dvec3 extent(info.extentVoxels);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> anywhere(-0.4, 1.4), step(-0.1, 0.1);
    for (const PlacedLight& light :
         {PlacedLight{false, glm::normalize(glm::dvec3(0.4, -0.7, 0.5))},
          PlacedLight{false, {0, 0, 1}, {}, 20},
          PlacedLight{true, {0, 0, 1}, info.patientFromVoxel * glm::dvec4(0.5 * extent, 1)}}) {
        ShadowMaps maps(light, path, quality);
        maps.build(path, 0);
        std::size_t shaded = 0;
        for (int n = 0; n < 300; ++n) {
            const double wide = n < 290 ? 1 : 1e7;
            const glm::dvec3 at =
                wide * extent * glm::dvec3(anywhere(random), anywhere(random), anywhere(random));
            const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(at, 1));
            const glm::dvec3 along(glm::dmat3(info.patientFromVoxel) *
                                   (extent * glm::dvec3(step(random), step(random), step(random))));
            for (const native::PacketTarget* target : nativeTargets()) {
                float found[native::kOcclusionRun];
                maps.light(place, along, n % 3, *target, found);
                for (int k = 0; k < native::kOcclusionRun; ++k) {
                    ASSERT_EQ(found[k], maps.light(place + double(k) * along, n % 3))
                        << target->name << " at place " << k << " of run " << n;
                    shaded += found[k] < 1 ? 1 : 0;
                }
            }
        }
        EXPECT_GT(shaded, 500u); // else nothing was compared
    }
}

/// Rays through an engine's bricks in packets make the maps that rays through the cache make, bit for bit.
void expectPacketsCastTheSame(Prepared& prepared, const std::string& what) {
    Planner& p = prepared.p;
    ASSERT_TRUE(NativeShadows::canCast(p)) << what;
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    ShadowQuality quality = p.view.shadowQuality;
    quality.mapSize = 48;
    const std::size_t numbers = std::size_t{48} * 48 * native::kNumbersOfRay;
    for (const bool ghostLayers : {true, false}) {
        p.layer().pageEdge = ghostLayers ? kGhostedEdge : kBrickExtent;
        NativeEngine engine(0, prepared.budgets.gpu, prepared.budgets.ram);
        Work work;
        loadBricks(engine, p, prepared.budgets.gpu, work);
        const HostPlane& plane = engine.settled();
        LightPath path = pathOf(p);
        for (const PlacedLight& light :
             {PlacedLight{false, glm::normalize(glm::dvec3(0.4, -0.7, 0.5))},
              PlacedLight{true, {0, 0, 1}, p.info().patientFromVoxel * glm::dvec4(20, 18, 15, 1)}}) {
            path.rays = nullptr;
            ShadowMaps one(light, path, quality);
            one.build(path, 0);
            std::size_t shaded = 0;
            for (const native::PacketTarget* target : nativeTargets()) {
                const NativeShadows rays(p, plane, {}, *target);
                path.rays = &rays;
                ShadowMaps other(light, path, quality);
                other.build(path, 0);
                ASSERT_EQ(one.maps().size(), other.maps().size());
                for (std::size_t m = 0; m < one.maps().size(); ++m)
                    for (std::size_t n = 0; n < numbers; ++n) {
                        ASSERT_EQ(one.maps()[m]->numbers()[n], other.maps()[m]->numbers()[n])
                            << what << ", " << target->name << ", map " << m << ", number " << n;
                        shaded += other.maps()[m]->numbers()[n] < 1 ? 1 : 0;
                    }
                EXPECT_EQ(one.largestError(), other.largestError());
                EXPECT_EQ(one.shareOfMore(), other.shareOfMore());
            }
            EXPECT_GT(shaded, 300u) << what; // else nothing was compared
        }
    }
}

TEST(ShadowMaps, PacketsCastTheSameRays) {
    for (const bool byGradient : {false, true})
        for (const bool skipping : {true, false})
            for (const bool mixed : {false, true}) {
                Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16});
                if (byGradient)
                    grade(scene);
                scene.quality.skipping = skipping;
                Prepared prepared("torso", scene);
                if (mixed)
                    prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 3));
                expectPacketsCastTheSame(prepared, std::string(byGradient ? "by gradient" : "plain") +
                                                       (skipping ? ", skipping" : "") +
                                                       (mixed ? ", mixed" : ""));
            }
}

/// Where a brick is not there, rays go on through the cache.
TEST(ShadowMaps, PacketsThatLackABrickLeaveTheRest) {
    Prepared prepared("torso", sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16}));
    const FramePlan& p = prepared.p;
    struct Lacking : ShadowRays {
        std::size_t mostAtOnce() const override { return 7; }
        bool along(std::span<const SegmentedRay<float>> rays, std::span<const float>, float,
                   std::vector<LightLeft>&, std::span<std::span<const LightLeft>>) const override {
            EXPECT_LE(rays.size(), 7u);
            return false;
        }
    } lacking;
    LightPath path = pathOf(p);
    ShadowQuality quality;
    quality.mapSize = 24;
    const PlacedLight light{false, {0, 0, 1}};
    ShadowMaps one(light, path, quality), other(light, path, quality);
    one.build(path, 0);
    path.rays = &lacking;
    other.build(path, 0);
    for (std::size_t n = 0; n < std::size_t{24} * 24 * native::kNumbersOfRay; ++n)
        ASSERT_EQ(one.maps()[0]->numbers()[n], other.maps()[0]->numbers()[n]);
}

/// Extremes: all finite, bounded, no hang.
TEST(ShadowMaps, BearExtremes) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("sphere"), ram).info();
    Prepared prepared("sphere", sceneOn(info, "bone-1", 0, {16, 16}));
    const FramePlan& p = prepared.p;
    const LightPath path{p.layer().cache.get(), &p.info(), &p.layer().selection, nullptr,
                         &p.layer().optics,     nullptr};
    ShadowQuality quality;
    quality.mapSize = 16;
    const glm::dvec3 corner(info.patientFromVoxel * glm::dvec4(32, 32, 32, 1)); // of bricks
    for (const glm::dvec3& position :
         {corner, glm::dvec3(info.patientFromVoxel * glm::dvec4(0, 0, 0, 1)), glm::dvec3(1e7)})
        for (const double softness : {0.0, 60.0}) {
            PlacedLight light{true, {0, 0, 1}, position, softness};
            ShadowMaps maps(light, path, quality);
            maps.build(path, 1);
            for (const glm::dvec3& place : {corner, position, glm::dvec3(0), glm::dvec3(-1e6)}) {
                const float got = maps.light(place);
                EXPECT_TRUE(got >= 0 && got <= 1) << got;
            }
        }
    for (const glm::dvec3& towards : {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0)}) {
        ShadowMaps maps({false, towards, {}, 30}, path, quality);
        maps.build(path, 1);
        EXPECT_TRUE(maps.light(corner) >= 0 && maps.light(corner) <= 1);
    }
}

} // namespace
} // namespace tessera::test
