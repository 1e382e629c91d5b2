// tests/render/light/histogram_light_test.cpp: occlusion by local histograms in closed forms and beside
// occlusion along rays; engines agree, edits are followed, what does not go with it is refused, and scenes
// without it pay nothing.
#include "core/scene/preset.h"
#include "render/contract/lattice.h"
#include "render/light/histogram_light.h"
#include "render/light/scene_light.h"
#include "render/picture/render_scene.h"
#include "tests/support/interactive_fixture.h"
#include "tests/support/lit_picture.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/reference_light.h"
#include "tests/support/refusals.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numeric>
#include <string>
#include <utility>

namespace tessera::test {
namespace {

using testing::HasSubstr;

Lighting byHistograms(double radiusMm = 10, double bleeding = 0) {
    Lighting lighting;
    lighting.occlusion =
        Occlusion{.method = OcclusionMethod::histogram, .radiusMm = radiusMm, .bleeding = bleeding};
    return lighting;
}

Light casting() {
    Light light;
    light.kind = LightKind::directional;
    light.direction = {-1, 1, 1};
    light.shadow = true;
    return light;
}

/// The light of a formula's samples, without bias and gamma.
struct LitFormula {
    LitFormula(const Formula& value, const TransferFunction& function, double radiusMm, double bleeding = 0)
        : stored(value, {64, 64, 64}, true), lighting(byHistograms(radiusMm, bleeding)) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction = function;
        scene.lighting = lighting;
        prepared = stored.prepare(scene);
        const Layer& layer = prepared->p.layer();
        light = std::make_unique<HistogramLight>(layer.info(), *layer.histograms, *lighting.occlusion);
        light->functionChanged(layer.table, layer.optics);
    }
    HistogramLight::Row at(const glm::ivec3& sample) const {
        const LocalHistograms& histograms = *prepared->p.layer().histograms;
        return light->rows()[histograms.numbers[linearIndex(sample, histograms.extent)]];
    }
    Stored stored;
    Lighting lighting;
    std::unique_ptr<Prepared> prepared;
    std::unique_ptr<HistogramLight> light;
};

TEST(HistogramLight, OfAnEvenMediumIsItsClosedForm) {
    for (const double extinction : {1e-6, 0.05, 3.0}) {
        const LitFormula lit([](const glm::dvec3&) { return 1.0; },
                             TransferFunction::fromExtinction({{0, extinction}, {2, extinction}}, {}), 8);
        const double depth = 8 * extinction;
        EXPECT_NEAR(lit.at({8, 8, 8}).open, (1 - std::exp(-depth)) / depth, 1e-5);
        EXPECT_NEAR(lit.at({0, 0, 0}).open, (1 - std::exp(-depth)) / depth, 1e-5) << "at the border";
    }
}

TEST(HistogramLight, OfAHalfSpaceIsHalfAtItsPlane) {
    const LitFormula lit([](const glm::dvec3& p) { return p.x > 32 ? 1.0 : 0.0; },
                         TransferFunction::fromExtinction({{0.6, 0}, {0.61, 1e4}}, {}), 10);
    ASSERT_EQ(lit.prepared->p.layer().histograms->level, 1);
    EXPECT_NEAR(0.5f * (lit.at({15, 16, 16}).open + lit.at({16, 16, 16}).open), 0.5f, 0.01f);
    for (int n = 0; n < 6; ++n) { // a ball's cap, as bricking's test has it
        const double u = (2 * n + 1) / 10.0;
        EXPECT_NEAR(lit.at({15 - n, 16, 16}).open, u < 1 ? 1 - 0.5 * (1 - u + u * std::log(u)) : 1,
                    n == 0 ? 0.05 : 0.03)
            << n;
    }
}

/// A white wall takes the red of a sphere before it, until the function shows none (figure 6.14).
TEST(HistogramLight, ColoursBleedWhileTheyShow) {
    const Formula scene = [](const glm::dvec3& p) {
        return p.x > 40 ? 1.0 : glm::length(p - glm::dvec3(28, 32, 32)) < 10 ? 2.0 : 0.0;
    };
    const std::vector<ColourPoint> colours = {
        {1, {1, 1, 1}}, {1.6, {1, 1, 1}}, {1.7, {1, 0, 0}}, {2, {1, 0, 0}}};
    const auto wall = [&](double ofSphere) {
        const LitFormula lit(scene,
                             TransferFunction::fromExtinction(
                                 {{0.4, 0}, {0.6, 10}, {1.4, 10}, {1.6, ofSphere}, {2, ofSphere}}, colours),
                             12, 1);
        return lit.at({20, 16, 16});
    };
    const HistogramLight::Row red = wall(10), none = wall(0);
    EXPECT_GT(red.colour.r, red.colour.g + 0.02f);
    EXPECT_EQ(red.colour.g, red.colour.b);
    EXPECT_NEAR(none.colour.r, none.colour.g, 0.004f);
    EXPECT_GT(none.open, red.open + 0.02f);
}

/// One level and mixed; alone, with colours, beside a shadow, whose light is finer.
TEST(HistogramLight, NativeIsTheMirror) {
    Lighting shadowed = byHistograms(9);
    shadowed.lights = {Light{}, casting()};
    Lighting all = byHistograms(9, 0.5);
    all.lights = shadowed.lights;
    int n = 0;
    for (const Lighting& lighting : {byHistograms(9), shadowed, all})
        for (const bool mixed : {false, true}) {
            Scene scene = sceneOn(infoOf("torso"), "soft-tissue", n++ % 3, {24, 24});
            scene.lighting = lighting;
            Prepared prepared("torso", scene);
            Planner& p = prepared.p;
            p.view.shadowQuality.mapSize = 64;
            if (mixed)
                p.setSelection(randomShownLevels(p.layer().selection, 3));
            const Image mirror = mirrorLit(prepared);
            for (const native::PacketTarget* target : nativeTargets())
                for (const bool ghostLayers : {true, false}) {
                    NativeChoices choices;
                    choices.target = target;
                    choices.ghostLayers = ghostLayers;
                    EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u)
                        << n << ", " << target->name;
                }
            NativeChoices one;
            one.threads = 1;
            EXPECT_EQ(differing(nativePicture(prepared, one).image, mirror), 0u);
        }
}

/// An edit's first picture has whole light, and the bits of a fresh renderer's.
TEST(HistogramLight, FollowsAnEdit) {
    Scene before = interactiveScene("bone-1", 0, {24, 24});
    before.lighting = byHistograms(9);
    Scene after = before;
    after.volumes[0].transferFunction = "skin-1";
    Session edited(before, std::size_t{64} << 20, {}, storePath("torso"), true);
    edited.converge();
    edited.renderer.setFunction(presetFunction("skin-1", {-1000, 2000, true, 1, {}}));
    edited.converge();
    Session fresh(after, std::size_t{64} << 20, {}, storePath("torso"), true);
    fresh.converge();
    EXPECT_EQ(differing(edited.renderer.picture(), fresh.renderer.picture()), 0u);
}

/// Of what TESSERA_TELL=1 tells: the torso, or the store that TESSERA_HISTOGRAM_STORE names.
std::filesystem::path storeToTell() {
    const char* const other = std::getenv("TESSERA_HISTOGRAM_STORE");
    return other ? other : storePath("torso").string();
}

/// TESSERA_TELL=1 tells of the processor's seconds from an edit to whole light, of another store too.
TEST(HistogramLight, TellsWhatAnEditTakes) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL is not set";
    const std::filesystem::path store = storeToTell();
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const VolumeInfo info = StoreReader(store, ram).info();
    Lighting local;
    local.occlusion = Occlusion{};
    const std::pair<const char*, Lighting> lights[] = {
        {"no light", {}}, {"local", local}, {"histogram", byHistograms(16)}};
    for (const auto& [name, lighting] : lights) {
        Scene scene = sceneOn(info, "soft-tissue", 0, {256, 256});
        scene.lighting = lighting;
        Session session(scene, std::size_t{1} << 30, {}, store, true);
        session.converge();
        for (const char* preset : {"bone-1", "soft-tissue", "bone-1", "soft-tissue"}) {
            const std::clock_t start = std::clock();
            session.renderer.setFunction(presetFunction(preset, {-1000, 2000, true, 1, {}}));
            session.converge();
            tell("%s, to %s: %.2f CPU s to whole light\n", name, preset,
                 static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
        }
    }
}

/// A function that is dragged: many edits, of which pictures show some.
TransferFunction dragged(int edit) {
    const double at = 150 + 40 * std::sin(0.4 * edit);
    return TransferFunction::fromOpacity({{at - 200, 0}, {at - 100, 0.05}, {at, 0.3}, {at + 200, 0.9}},
                                         {{at - 100, {0.9, 0.5, 0.3}}, {at, {1, 0.9, 0.8}}}, 4);
}

TEST(HistogramLight, ManyEditsLeaveNoStaleLight) {
    for (const bool histograms : {true, false}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {48, 48});
        scene.lighting = byHistograms(12);
        if (!histograms)
            scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 12};
        scene.lighting.lights = {casting()};
        scene.volumes[0].transferFunction = dragged(0);
        Session session(scene, std::size_t{256} << 20, {}, storePath("torso"), true);
        session.converge();
        std::size_t ram = 0, gpu = 0;
        for (int edit = 1; edit <= 120; ++edit) {
            session.renderer.setFunction(dragged(edit));
            session.renderer.advance(InteractiveRenderer::Clock::now() + std::chrono::milliseconds(3));
            session.checkStep();
            if (edit == 40)
                ram = session.ram.peakBytes(), gpu = session.gpu.peakBytes();
        }
        EXPECT_EQ(session.ram.peakBytes(), ram) << "memory grows";
        EXPECT_EQ(session.gpu.peakBytes(), gpu) << "memory grows";
        session.converge();
        scene.volumes[0].transferFunction = dragged(120);
        Session fresh(scene, std::size_t{256} << 20, {}, storePath("torso"), true);
        fresh.converge();
        EXPECT_EQ(differing(session.renderer.picture(), fresh.renderer.picture()), 0u)
            << (histograms ? "histograms" : "local");
    }
}

// The entries of its table are the same.
TEST(HistogramLight, AFunctionThatIsShiftedOrGradedIsFollowed) {
    InteractiveOptions atOnce;
    atOnce.coarseLightFirst = false;
    for (const bool histograms : {true, false}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {24, 24});
        scene.lighting = byHistograms(12);
        if (!histograms)
            scene.lighting.occlusion = Occlusion{.rays = 4, .radiusMm = 5};
        scene.lighting.lights = {casting()};
        TransferFunction graded = dragged(7);
        graded.setGradientOpacity(GradientOpacity::fromPoints({{0, 0.2}, {60, 1}}));
        scene.volumes[0].transferFunction = dragged(0);
        Session session(scene, std::size_t{256} << 20, atOnce, storePath("torso"), true);
        session.converge();
        for (const TransferFunction& function : {dragged(7), graded}) {
            session.renderer.setFunction(function);
            session.converge();
            scene.volumes[0].transferFunction = function;
            Session fresh(scene, std::size_t{256} << 20, atOnce, storePath("torso"), true);
            fresh.converge();
            EXPECT_EQ(differing(session.renderer.picture(), fresh.renderer.picture()), 0u)
                << (histograms ? "histograms" : "local");
        }
    }
}

/// TESSERA_TELL=1 tells of 30 edits a second for ten seconds.
TEST(HistogramLight, TellsOfADrag) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL is not set";
    const std::filesystem::path store = storeToTell();
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const VolumeInfo info = StoreReader(store, ram).info();
    using RendererClock = InteractiveRenderer::Clock;
    for (const char* kind : {"histogram", "local", "no light"}) {
        Scene scene = sceneOn(info, "soft-tissue", 0, {512, 512});
        scene.quality.stepVoxels = 1;
        if (kind[0] != 'n')
            scene.lighting = byHistograms(16);
        if (kind[0] == 'l')
            scene.lighting.occlusion = Occlusion{};
        scene.volumes[0].transferFunction = dragged(0);
        Session session(scene, std::size_t{1} << 30, {}, store, true);
        session.converge();
        session.renderer.setHaste(InteractiveRenderer::Haste{{256, 256}, 2});
        const auto start = RendererClock::now();
        int pictures = 0;
        double longest = 0;
        auto last = start;
        std::size_t ramEarly = 0;
        for (int edit = 1; edit <= 300; ++edit) {
            session.renderer.setFunction(dragged(edit));
            for (const auto next = start + std::chrono::microseconds(33333) * edit;
                 RendererClock::now() < next;)
                if (session.renderer.advance(next).newPicture) {
                    ++pictures;
                    longest =
                        std::max(longest, std::chrono::duration<double>(RendererClock::now() - last).count());
                    last = RendererClock::now();
                }
            if (edit == 30)
                ramEarly = session.ram.peakBytes();
        }
        const double seconds = std::chrono::duration<double>(RendererClock::now() - start).count();
        session.renderer.setHaste(std::nullopt);
        session.converge();
        scene.volumes[0].transferFunction = dragged(300);
        Session fresh(scene, std::size_t{1} << 30, {}, store, true);
        fresh.converge();
        tell("%s: 300 edits in %.2f s, %d pictures of 256x256, the longest %.3f s apart; peak of RAM grew by "
             "%zu bytes after "
             "a second; %zu pixels differ from a fresh picture's\n",
             kind, seconds, pictures, longest, session.ram.peakBytes() - ramEarly,
             differing(session.renderer.picture(), fresh.renderer.picture()));
    }
}

/// TESSERA_TELL=1 tells how pictures after an edit differ from those with whole local occlusion, and when
/// they come.
TEST(HistogramLight, TellsHowPicturesFollowAnEdit) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL is not set";
    const std::filesystem::path store = storeToTell();
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const VolumeInfo info = StoreReader(store, ram).info();
    Lighting local;
    local.occlusion = Occlusion{};
    const ValueSummary values{-1000, 2000, true, 1, {}};
    using RendererClock = InteractiveRenderer::Clock;
    struct Shown {
        double seconds, cpu;
        bool coarse, here; // light is coarse; all bricks are here
        Image image;
    };
    const auto pictures = [&](const Lighting& lighting, const char* from, const char* to) {
        Scene scene = sceneOn(info, from, 0, {512, 512});
        scene.quality.stepVoxels = 1;
        scene.lighting = lighting;
        Session session(scene, std::size_t{1} << 30, {}, store, true);
        session.converge();
        session.renderer.setFunction(presetFunction(to, values)); // its bricks are read once
        session.converge();
        session.renderer.setFunction(presetFunction(from, values));
        session.converge();
        std::vector<Shown> shown;
        const auto start = RendererClock::now();
        const std::clock_t before = std::clock();
        session.renderer.setFunction(presetFunction(to, values));
        for (bool converged = false; !converged;) {
            const auto progress =
                session.renderer.advance(RendererClock::now() + std::chrono::milliseconds(20));
            converged = progress.converged;
            if (progress.newPicture)
                shown.push_back({std::chrono::duration<double>(RendererClock::now() - start).count(),
                                 static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC,
                                 progress.lightIsCoarse, progress.movesLeft == 0 && !progress.choosing,
                                 session.renderer.picture()});
        }
        return shown;
    };
    for (const auto& [from, to] : {std::pair{"soft-tissue", "bone-1"}, {"bone-1", "soft-tissue"}}) {
        const auto byRays = pictures(local, from, to), histograms = pictures(byHistograms(16), from, to),
                   none = pictures({}, from, to);
        const Image& truth = byRays.back().image;
        const auto rms = [&](const Image& image) { return compare(image, truth).rms; };
        const auto say = [&](const char* what, const std::vector<Shown>& shown) {
            std::vector<Shown> told{shown.front()};
            for (std::size_t n = 1; n + 1 < shown.size(); ++n)
                if (shown[n].here && !shown[n - 1].here)
                    told.push_back(shown[n]); // the first with all bricks
            told.push_back(shown.back());
            for (const Shown& s : told)
                tell("%s to %s, %s: %.3f s, %.2f CPU s, rms %.4f%s\n", from, to, what, s.seconds, s.cpu,
                     rms(s.image), s.coarse ? ", light is coarse" : "");
        };
        say("local", byRays);
        say("histogram", histograms);
        say("no light", none);
    }
}

/// Samples of local occlusion and of histograms where something shows and light gets.
struct Compared {
    double rms = 0, mean = 0, rank = 0;
    std::size_t places = 0;
};

std::vector<double> ranksOf(const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return values[a] < values[b]; });
    std::vector<double> ranks(values.size());
    for (std::size_t first = 0; first < order.size();) {
        std::size_t end = first;
        while (end < order.size() && values[order[end]] == values[order[first]])
            ++end;
        for (std::size_t n = first; n < end; ++n)
            ranks[order[n]] = 0.5 * static_cast<double>(first + end - 1);
        first = end;
    }
    return ranks;
}

/// @param histograms  null: the layer's own
Compared comparedTo(const Planner& p, BrickCache& cache, const LocalHistograms& histograms) {
    const Layer& layer = p.layer();
    Lighting by[2];
    by[0].occlusion = Occlusion{.rays = 32, .radiusMm = histograms.settings.radiusMm, .bias = 0, .gamma = 1};
    by[1].occlusion = by[0].occlusion;
    by[1].occlusion->method = OcclusionMethod::histogram;
    std::vector<std::uint8_t> levels(layer.selection.levels.size(),
                                     static_cast<std::uint8_t>(histograms.level));
    std::vector<BrickToLight> bricks;
    for (std::size_t b = 0; b < levels.size(); b += 4)
        if (layer.selection.levels[b] != Selection::kEmpty)
            bricks.push_back({b, histograms.level, histograms.level});
    const int edge = kBrickExtent >> histograms.level;
    std::vector<std::vector<std::uint16_t>> texels[2];
    for (int n = 0; n < 2; ++n) {
        texels[n].resize(levels.size());
        VoxelLight light(p.info(), layer.statistics, by[n], 0, &histograms);
        light.functionChanged(layer.table, layer.optics);
        light.light(bricks, levels, kAllLight, cache,
                    [&](const BrickToLight& b, int, const Chunk& chunk, int) {
                        const auto* from = reinterpret_cast<const std::uint16_t*>(chunk.bytes.get());
                        for (int z = 0; z < edge; ++z)
                            for (int y = 0; y < edge; ++y)
                                for (int x = 0; x < edge; ++x)
                                    texels[n][b.brick].push_back(
                                        from[linearIndex({x, y, z}, glm::ivec3(kChunkExtent))]);
                    });
    }
    LatticeReader values(cache, p.info(), histograms.level, nullptr);
    std::vector<double> local, found;
    Compared result;
    for (const BrickToLight& b : bricks)
        for (std::size_t n = 0; n < texels[0][b.brick].size(); ++n) {
            const glm::ivec3 sample =
                gridPosition(b.brick, layer.selection.bricks) * edge + gridPosition(n, glm::ivec3(edge));
            if (glm::any(glm::greaterThanEqual(sample, histograms.extent)) ||
                !(occlusionExtinction(layer.optics, values.at(sample)) > 0))
                continue;
            const double a = texels[0][b.brick][n] / 16384.0, h = texels[1][b.brick][n] / 16384.0;
            if (a < 0.05)
                continue; // deep inside
            local.push_back(a);
            found.push_back(h);
            result.rms += (a - h) * (a - h);
            result.mean += h - a;
        }
    result.places = local.size();
    result.rms = std::sqrt(result.rms / static_cast<double>(local.size()));
    result.mean /= static_cast<double>(local.size());
    const std::vector<double> x = ranksOf(local), y = ranksOf(found);
    const double middle = 0.5 * static_cast<double>(local.size() - 1);
    double xy = 0, xx = 0, yy = 0;
    for (std::size_t n = 0; n < x.size(); ++n) {
        xy += (x[n] - middle) * (y[n] - middle);
        xx += (x[n] - middle) * (x[n] - middle);
        yy += (y[n] - middle) * (y[n] - middle);
    }
    result.rank = xy / std::sqrt(xx * yy);
    return result;
}

/// TESSERA_TELL=1 TESSERA_HISTOGRAM_STORE=a.zarr tells of another store.
TEST(HistogramLight, IsNearLocalOcclusion) {
    const char* const other = std::getenv("TESSERA_HISTOGRAM_STORE");
    const std::string store = other ? other : storePath("torso").string();
    for (const char* preset : {"soft-tissue", "bone-1"}) {
        MemoryBudget ram("RAM", "--ram", std::size_t{2} << 30);
        const StoreReader reader(store, ram);
        Scene scene = sceneOn(reader.info(), preset, 0, {24, 24});
        scene.volumes[0].path = store;
        scene.lighting = byHistograms(24);
        const Budgets budgets;
        Prepared prepared(store.substr(0, store.size() - 5), scene);
        const Planner& p = prepared.p;
        BrickCache cache(p.layer().voxels(), ram, std::size_t{256} << 20, 2);
        const auto tellOf = [&](const LocalHistogramSettings& settings) {
            const LocalHistograms made = makeLocalHistograms(reader, p.layer().statistics, settings, ram, 0);
            const Compared c = comparedTo(p, cache, made);
            tell("%s, %d representatives, %d bins: rms %.4f, mean %+.4f, rank %.4f, %zu places, %zu bytes\n",
                 preset, settings.representatives, settings.bins, c.rms, c.mean, c.rank, c.places,
                 made.bytes());
            std::fflush(stdout);
            return c;
        };
        const Compared c = tellOf({.radiusMm = 24});
        EXPECT_GT(c.places, 1000u);
        if (preset == std::string("soft-tissue")) { // bone is thinner here than a sample of the level
            EXPECT_LT(c.rms, 0.2);
            EXPECT_GT(c.rank, 0.7);
        }
        if (std::getenv("TESSERA_TELL")) {
            for (const int most : {64, 256, 1024, 4096})
                tellOf({.radiusMm = 24, .representatives = most});
            for (const int bins : {8, 16, 32})
                tellOf({.radiusMm = 24, .bins = bins});
        }
    }
}

TEST(HistogramLight, RefusesWhatItDoesNotGoWith) {
    const Scene plain = [] {
        Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, {24, 24});
        scene.lighting = byHistograms();
        return scene;
    }();
    const auto glowing = [] {
        TransferFunction f = presetFunction("bone-1", {-1000, 2000, true, 1, {}});
        f.setMaterials({{-2000, 4000, 0, 0, 0, 1, {1, 1, 1}}});
        return f;
    };
    const std::pair<std::function<void(Scene&)>, const char*> refused[] = {
        {[&](Scene& s) {
             s.lighting.occlusion->emission = 1;
             s.volumes[0].transferFunction = glowing();
         },
         "emission needs method \"local\""},
        {[](Scene& s) {
             s.lighting.occlusion->method = OcclusionMethod::local;
             s.lighting.occlusion->bleeding = 0.5;
         },
         "bleeding needs method \"histogram\""},
        {[](Scene& s) { s.lighting.occlusion->directions = OcclusionDirections::hemisphere; },
         "a method of rays with directions"},
        {[](Scene& s) { s.lighting.occlusion->weights.emplace(); }, "a method of rays with weights"},
        {[&](Scene& s) {
             s.lighting.occlusion = Occlusion{.emission = 1, .directions = OcclusionDirections::hemisphere};
             s.volumes[0].transferFunction = glowing();
         },
         "expected sphere with emission"},
        {[](Scene& s) { s.volumes[0].labels.path = "labels.nii"; }, "no labels"},
        {[](Scene& s) { s.volumes.push_back(s.volumes[0]); }, "one volume"},
        {[](Scene& s) { s.lighting.occlusion->radiusMm = 9000; }, "8 samples of the coarsest level"},
    };
    for (const auto& [change, expected] : refused) {
        Scene scene = plain;
        change(scene);
        EXPECT_THAT(refusalOf([&] { const Prepared prepared("torso", scene); }), HasSubstr(expected));
    }
    // Of single values there is no light: nothing is made.
    Scene values = plain;
    values.mode = Mode::maximum;
    EXPECT_FALSE(Prepared("torso", values).p.layer().histograms);
    // The reference integrates rays.
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.engine = EngineKind::reference;
    EXPECT_THAT(refusalOf([&] { renderScene(plain, reader, ram, gpu, options); }),
                HasSubstr("by histograms"));
}

TEST(HistogramLight, CostsNothingWhereItIsNotAskedFor) {
    const Stored stored([](const glm::dvec3& p) { return p.x; });
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{10, 0}, {20, 1}}, {});
    scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
    const std::filesystem::path kept = stored.folder / "v.zarr/stats/histograms";
    EXPECT_FALSE(stored.prepare(scene)->p.layer().histograms);
    EXPECT_FALSE(std::filesystem::exists(kept));
    // What was kept for one scene changes no other.
    const auto before = stored.prepare(scene);
    const NativePicture one = nativePicture(*before);
    Scene by = scene;
    by.lighting = byHistograms(6);
    EXPECT_TRUE(stored.prepare(by)->p.layer().histograms);
    EXPECT_TRUE(std::filesystem::exists(kept));
    const auto after = stored.prepare(scene);
    const NativePicture other = nativePicture(*after);
    EXPECT_EQ(differing(one.image, other.image), 0u);
    EXPECT_EQ(before->budgets.ram.peakBytes(), after->budgets.ram.peakBytes());
    EXPECT_EQ(before->budgets.gpu.peakBytes(), after->budgets.gpu.peakBytes());
}

} // namespace
} // namespace tessera::test
