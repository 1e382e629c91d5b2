// tests/render/picture/determinism_test.cpp: the same picture whatever the run, the threads, the tiles and
// the dispatches. Work that is elided because a scene does not need it changes nothing, or at most its stated
// bound. A table of elisions compares the general path with the elided one for every integrator (SQLite's
// "disabled optimisation" test).
#include "core/base/error.h"
#include "render/backends/reference/reference.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <functional>
#include <gtest/gtest.h>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(29, 22); // no multiple of a work group
constexpr const char* kStore = "sphere";

constexpr const char* kManyBricks = "torso"; // more than one pass must hold

Scene plainScene(Integrator integrator, bool shading, const char* store = kStore) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const StoreReader reader(storePath(store), ram);
    Scene scene = sceneOn(reader.info(), "auto", 2, kSize);
    scene.shading.on = shading;
    scene.quality.integrator = integrator;
    return scene;
}

Image drawn(const Scene& scene, const Slicing& slicing = {}, bool generalPath = false) {
    Prepared prepared(kStore, scene);
    if (generalPath)
        prepared.p.mapLevels(true);
    return marchOn(prepared, marchFeatures(prepared.p, true), slicing).image;
}

/// The whole renderer, by options and a budget of GPU memory.
RenderResult rendered(const Scene& scene, RenderOptions options,
                      std::size_t gpuBytes = std::size_t{1} << 30) {
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(storePath(kManyBricks), ram);
    options.device.text = "software";
    return renderScene(scene, reader, ram, gpu, options);
}

/// The least budget of GPU memory that is accepted, within a part in a thousand.
std::size_t leastGpuBytes(Scene scene) {
    if (scene.quality.integrator == Integrator::preintegrated2d) { // its tables would be made at every try
        scene.quality.integrator = Integrator::preintegrated;
        return leastGpuBytes(scene) + Preintegration2d::bytes(kLevelCount);
    }
    std::size_t refused = 1, accepted = std::size_t{1} << 28;
    while (accepted - refused > accepted / 1000) {
        const std::size_t middle = refused + (accepted - refused) / 2;
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30), gpu("GPU memory", "--gpu-memory", middle);
        const StoreReader reader(storePath(kManyBricks), ram);
        try {
            planScene(scene, reader, TextureLimits{}, {ram, gpu, 1});
            accepted = middle;
        } catch (const InputError&) {
            refused = middle;
        }
    }
    return accepted;
}

/// Largest difference general - elided, and smallest.
struct Range {
    double lowest = 0, highest = 0;
};
Range difference(const Image& general, const Image& elided) {
    Range range;
    for (std::size_t i = 0; i < general.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            const double d =
                static_cast<double>(general.pixels[i][c]) - static_cast<double>(elided.pixels[i][c]);
            range.lowest = std::min(range.lowest, std::isnan(d) ? -INFINITY : d);
            range.highest = std::max(range.highest, d);
        }
    return range;
}

class Determinism : public testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(Integrators, Determinism,
                         testing::Values(Integrator::midpoint, Integrator::linear, Integrator::preintegrated,
                                         Integrator::preintegrated2d),
                         [](const auto& info) {
                             std::string name = integratorNames()[static_cast<std::size_t>(info.param)];
                             std::erase(name, '-');
                             return name;
                         });

TEST_P(Determinism, RunsTilesAndDispatchesChangeNoBit) {
    for (const Fetch fetch : {Fetch::exact, Fetch::hardware}) {
        Scene scene = plainScene(GetParam(), true);
        scene.quality.fetch = fetch;
        const auto once = [&](int tile, int iterations) {
            const GlContext context({"software"}); // a context of its own: another run
            Slicing slicing;
            slicing.fixedTile = tile;
            slicing.fixedIterations = iterations;
            return drawn(scene, slicing);
        };
        const Image first = once(0, 0);
        EXPECT_FALSE(isBlank(first));
        EXPECT_TRUE(bitEqual(first, once(0, 0))) << "another run";
        for (const auto& [tile, iterations] : {std::pair(8, 1 << 20), {13, 31}, {64, 3}})
            EXPECT_TRUE(bitEqual(first, once(tile, iterations))) << tile << ", " << iterations;
    }
}

TEST_P(Determinism, ThreadsChangeNoBit) {
    const Scene scene = plainScene(GetParam(), true);
    Prepared prepared(kStore, scene);
    Planner& p = prepared.p;
    const std::size_t count = static_cast<std::size_t>(kSize.x) * kSize.y;
    Work work;
    const auto single = [&](int threads) {
        return mirrorRays<float>(mirrorInput(p, true), count, frameRays(cast<float>(p.view.frame)), threads,
                                 work);
    };
    const auto twice = [&](int threads) {
        return mirrorRays<double>(mirrorInput(p, true), count, frameRays(p.view.frame), threads, work);
    };
    const auto oneSingle = single(1);
    const auto oneDouble = twice(1);
    for (const int threads : {2, 8}) {
        EXPECT_EQ(oneSingle, single(threads)) << threads << " threads, float mirror";
        EXPECT_EQ(oneDouble, twice(threads)) << threads << " threads, double mirror";
    }
    if (GetParam() != Integrator::midpoint)
        return; // the reference knows no integrator
    const auto truth = [&](int threads) {
        return renderReference(
            {p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, &p.layer().statistics},
            referenceRays(p.view.camera, p.info(), {9, 7}), threads);
    };
    const auto one = truth(1);
    for (const int threads : {2, 8})
        EXPECT_EQ(one, truth(threads)) << threads << " threads, reference";
}

TEST_P(Determinism, WhatIsLeftOutLeavesNoTrace) {
    const GlContext context({"software"});
    const Scene lit = plainScene(GetParam(), true), plain = plainScene(GetParam(), false);
    const Image image = drawn(lit);
    ASSERT_FALSE(isBlank(image));
    struct Row {
        std::string what;
        Image general, elided;
        double most = 0; // general - elided, per component: never below 0, at most this
    };
    std::vector<Row> table;

    Scene everySegment = lit;
    everySegment.quality.skipping = false;
    table.push_back({"no skipping", drawn(everySegment), image});

    table.push_back({"one level by the path of mixed levels", drawn(lit, {}, true), image});

    const Image unlit = drawn(plain);
    for (const Gradient gradient : {Gradient::forward, Gradient::central, Gradient::sobel, Gradient::analytic,
                                    Gradient::centralHalf, Gradient::cubic}) {
        Scene neutral = lit;
        neutral.shading.ambient = 1;
        neutral.shading.diffuse = neutral.shading.specular = 0;
        neutral.shading.gradient = gradient;
        table.push_back(
            {"light that changes nothing, by gradient " + gradientNames()[static_cast<std::size_t>(gradient)],
             drawn(neutral), unlit});
    }

    // A surface in the middle of the values, of no opacity.
    Scene invisible = lit;
    {
        const Prepared prepared(kStore, lit);
        const Statistics& v = prepared.p.layer().statistics;
        const VolumeInfo& info = prepared.reader.info();
        const double middle = 0.5 * (static_cast<double>(v.lowest) + static_cast<double>(v.highest));
        invisible.surfaces = {{info.rescaleSlope * middle + info.rescaleIntercept, glm::dvec3(1, 0, 0), 0}};
    }
    table.push_back({"a surface that is not seen", drawn(invisible), image});
    Scene seen = invisible;
    seen.surfaces[0].opacity = 0.5;
    EXPECT_GT(difference(drawn(seen), image).highest, 1e-4)
        << "a surface that is seen, behind most of the light";

    // Termination that never happens: compiled, but below what any ray is left with.
    Scene neverEnds = lit;
    neverEnds.quality.terminationTransmittance = 1e-30;
    table.push_back({"termination that never comes", drawn(neverEnds), image});
    for (const double epsilon : {1.0 / 510, 1e-4}) {
        Scene ends = lit;
        ends.quality.terminationTransmittance = epsilon;
        // The omitted light is positive and at most epsilon of the brightest there is; 1e-6 for sums of
        // floats.
        table.push_back({"termination at " + std::to_string(epsilon), image, drawn(ends),
                         epsilon * brightest(lit.shading) + 1e-6});
    }

    std::printf("%-60s %12s %12s\n", "left out", "lowest", "highest");
    for (const Row& row : table) {
        const Range d = difference(row.general, row.elided);
        std::printf("%-60s %12.3g %12.3g\n", row.what.c_str(), d.lowest, d.highest);
        EXPECT_EQ(d.lowest, 0) << row.what;
        EXPECT_LE(d.highest, row.most) << row.what;
    }
    // Teeth: the table would show a light that does change something, and ends that come too soon.
    EXPECT_GT(difference(image, unlit).highest - difference(image, unlit).lowest, 1e-3);
    Scene tooSoon = lit;
    tooSoon.quality.terminationTransmittance = 0.1;
    EXPECT_GT(difference(image, drawn(tooSoon)).highest, brightest(lit.shading) / 510);
}

TEST_P(Determinism, CountersAndPassesChangeNoBit) {
    Scene scene = plainScene(GetParam(), false, kManyBricks);
    scene.quality.maxError = 0; // all that a pixel can show, in as many passes as memory needs
    const RenderResult whole = rendered(scene, {});
    EXPECT_EQ(whole.passes, 1);
    RenderOptions uncounted;
    uncounted.counting = false;
    EXPECT_TRUE(bitEqual(whole.image, rendered(scene, uncounted).image)) << "counters";
    const RenderResult parts = rendered(scene, {}, leastGpuBytes(scene));
    EXPECT_GT(parts.passes, 1);
    EXPECT_TRUE(bitEqual(whole.image, parts.image)) << parts.passes << " passes";
}

} // namespace
} // namespace tessera
