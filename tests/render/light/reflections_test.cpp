// tests/render/light/reflections_test.cpp: isosurfaces that mirror and refract: closed forms, engines that
// agree, refusals, and no cost where there are none.
#include "core/base/error.h"
#include "render/backends/mirror/mirror.h"
#include "render/interactive/interactive_renderer.h"
#include "render/light/reflections.h"
#include "render/picture/render_scene.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/occluded_surfaces.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

TEST(Reflections, DirectionsAndSharesAreTheirFormulas) {
    const glm::dvec3 n(0, 0, 1);
    for (const double degrees : {0.0, 20.0, 41.0, 56.309932474, 80.0}) {
        const double phi = degrees * kDegree;
        const glm::dvec3 d(std::sin(phi), 0, -std::cos(phi));
        EXPECT_NEAR(glm::distance(mirroredDirection(d, n), glm::dvec3(d.x, 0, -d.z)), 0, 1e-15);
        const auto bent = refractedDirection(d, n, 1 / 1.5);
        ASSERT_TRUE(bent);
        EXPECT_NEAR(1.5 * bent->x, std::sin(phi), 1e-14); // Snell
        EXPECT_LT(bent->z, 0);
        // The way back takes the same share.
        EXPECT_NEAR(dielectricShare(-bent->z, 1.5), dielectricShare(std::cos(phi), 1 / 1.5), 1e-12);
    }
    EXPECT_NEAR(dielectricShare(1, 1 / 1.5), 0.04, 1e-12);
    EXPECT_NEAR(dielectricShare(0, 1 / 1.5), 1, 1e-12);
    // Brewster's angle: only what is polarised across is mirrored, ((n^2 - 1)/(n^2 + 1))^2 of it.
    EXPECT_NEAR(dielectricShare(std::cos(std::atan(1.5)), 1 / 1.5), 0.5 * std::pow(1.25 / 3.25, 2), 1e-12);
    const double critical = std::asin(1 / 1.5);
    EXPECT_NEAR(critical / kDegree, 41.81, 0.01);
    const auto from = [&](double phi) { return glm::dvec3(std::sin(phi), 0, -std::cos(phi)); };
    EXPECT_TRUE(refractedDirection(from(critical - 1e-6), n, 1.5));
    EXPECT_FALSE(refractedDirection(from(critical + 1e-6), n, 1.5));
    EXPECT_LT(dielectricShare(std::cos(critical - 1e-6), 1.5), 1);
    EXPECT_EQ(dielectricShare(std::cos(critical + 1e-6), 1.5), 1);
}

Image renderedBy(const Scene& scene, EngineKind engine) {
    Budgets budgets;
    const StoreReader store(scene.volumes[0].path.empty() ? storePath("torso") : scene.volumes[0].path,
                            budgets.ram);
    RenderOptions options;
    options.engine = engine;
    return renderScene(scene, store, budgets.ram, budgets.gpu, options).image;
}

/// Glass that mirrors nothing by itself.
Isosurface clear(double value, double ior) {
    Isosurface glass{value, glm::dvec3(1), 0};
    glass.reflection = Reflection{.strength = 0, .ior = ior, .transmits = true};
    return glass;
}

/// The ways that leave a picture's surfaces, by order, as the mirror finds them.
struct Followed {
    Followed(Planner& p, int orders) {
        p.view.lighting.reflectionOrder = orders;
        MirrorInput input = mirrorInput(p, true);
        const auto all = frameRays(cast<float>(p.view.frame));
        hits = mirrorHits<float>(input, rayCount(p.view.imageSize), all, 0);
        for (std::size_t n = 0; n < hits.size(); ++n)
            rays.push_back(glm::dvec3(all(n).direction));
        Work unused;
        const Reflections reflections(p, 0);
        image = reflections.added(
            hits, {}, p.view.imageSize,
            [&](std::span<const LightWay> ways, std::span<glm::vec4> colours, std::span<SurfaceHit> met) {
                const auto way = [&](std::size_t n) {
                    return segmentedWay<float>(ways[n], p.view.frame.segmentVoxels);
                };
                byOrder.emplace_back(ways.begin(), ways.end());
                const auto c = mirrorRays<float>(input, ways.size(), way, 0, unused);
                std::copy(c.begin(), c.end(), colours.begin());
                const auto h = mirrorHits<float>(input, ways.size(), way, 0);
                std::copy(h.begin(), h.end(), met.begin());
            });
    }
    std::vector<SurfaceHit> hits;
    std::vector<glm::dvec3> rays;
    std::vector<std::vector<LightWay>> byOrder;
    Image image;
};

Camera slanted(const glm::dvec3& from, const glm::dvec3& to, double angle) {
    Camera camera;
    camera.position = from;
    camera.focalPoint = to;
    camera.viewUp = {0, 1, 0};
    camera.viewAngle = angle;
    return camera;
}

/// A slab between z = 14 and 26 shifts every ray.
TEST(Reflections, ASlabShiftsRays) {
    const Stored stored([](const glm::dvec3& p) { return 6 - std::abs(p.z - 20); }, glm::ivec3(40), true);
    Scene scene = stored.scene({clear(0, 1.5)}, 0, 12);
    scene.camera = slanted({5, 20, 60}, {20, 20, 20}, 20);
    const auto prepared = stored.prepare(scene);
    const Followed followed(prepared->p, 2);
    ASSERT_EQ(followed.byOrder.size(), 2u);
    ASSERT_EQ(followed.byOrder[0].size(), 144u);
    ASSERT_EQ(followed.byOrder[1].size(), 144u);
    for (std::size_t n = 0; n < 144; ++n) {
        const glm::dvec3 d = followed.rays[n], at(followed.hits[n].position);
        const LightWay& out = followed.byOrder[1][n];
        EXPECT_NEAR(glm::distance(out.direction, d), 0, 1e-5);
        const double sine = std::hypot(d.x, d.y), cosine = std::abs(d.z);
        const double shift = 12 * sine * (1 - cosine / std::sqrt(1.5 * 1.5 - sine * sine));
        const glm::dvec3 off = out.from - at;
        EXPECT_NEAR(glm::length(off - glm::dot(off, d) * d), shift, 1e-3);
        EXPECT_GT(shift, 0.1);
    }
}

/// From inside glass light leaves below the critical angle alone.
TEST(Reflections, GlassKeepsLightBeyondTheCriticalAngle) {
    const Stored stored([](const glm::dvec3& p) { return 6 - std::abs(p.z - 20); }, glm::ivec3(40), true);
    Scene scene = stored.scene({clear(0, 1.5)}, 0, 64);
    scene.camera = slanted({20, 20, 18}, {20, 20, 30}, 110);
    const auto prepared = stored.prepare(scene);
    const Followed followed(prepared->p, 1);
    double mostThrough = 0, leastKept = 90;
    std::size_t way = 0;
    for (std::size_t n = 0; n < followed.hits.size(); ++n) {
        const SurfaceHit& hit = followed.hits[n];
        if (hit.surface == 0)
            continue;
        const double degrees =
            std::acos(-glm::dot(glm::normalize(followed.rays[n]), glm::dvec3(hit.normal))) / kDegree;
        const LightWay& left = followed.byOrder.at(0).at(way++);
        if (left.direction.z > 0)
            mostThrough = std::max(mostThrough, degrees);
        else
            leastKept = std::min(leastKept, degrees);
    }
    EXPECT_NEAR(mostThrough, 41.81, 0.6); // pixels are a degree and a half apart
    EXPECT_NEAR(leastKept, 41.81, 0.6);
    EXPECT_LT(mostThrough, 41.82);
    EXPECT_GT(leastKept, 41.80);
}

/// A ball bends rays by 2 (phi - theta).
TEST(Reflections, ABallBendsRays) {
    const Stored stored([](const glm::dvec3& p) { return 15 - glm::distance(p, glm::dvec3(20)); },
                        glm::ivec3(40), true);
    Scene scene = stored.scene({clear(0, 1.5)}, 0, 16);
    scene.camera = slanted({20, 20, 200}, {20, 20, 20}, 7);
    const auto prepared = stored.prepare(scene);
    const Followed followed(prepared->p, 2);
    std::size_t way = 0;
    for (std::size_t n = 0; n < followed.hits.size(); ++n) {
        if (followed.hits[n].surface == 0)
            continue;
        const glm::dvec3 d = followed.rays[n];
        const double sine =
            glm::length(glm::cross(d, glm::normalize(glm::dvec3(followed.hits[n].position) - 20.0)));
        const double bend = 2 * (std::asin(sine) - std::asin(sine / 1.5));
        const LightWay& out = followed.byOrder.at(1).at(way++);
        if (sine > 0.9)
            continue; // the lattice's normals at the rim
        EXPECT_NEAR(std::acos(std::clamp(glm::dot(d, out.direction), -1.0, 1.0)), bend, 0.02) << sine;
    }
    EXPECT_GT(way, 100u);
}

/// A mirror below a ball, both far from one another.
struct MirrorRoom {
    MirrorRoom() : stored(field(), glm::ivec3(44), true) {}
    static Formula field() {
        return [](const glm::dvec3& p) {
            return std::max(0.0, 12 - glm::distance(p, glm::dvec3(20, 21, 30))) - std::max(0.0, 9 - p.z);
        };
    }
    Scene direct() const {
        Isosurface mirror{-5, glm::dvec3(0), 1};
        mirror.reflection.emplace();
        Scene scene = stored.scene({mirror, {5, {0.9, 0.5, 0.3}, 1}}, 0, 40);
        scene.shading.specular = 0;
        scene.camera = slanted({20, 70, 60}, {20, 22, 8}, 24);
        scene.background = glm::vec3(0.1f, 0.2f, 0.3f);
        return scene;
    }
    /// As a camera behind the mirror sees the ball.
    Scene behind() const {
        Scene scene = direct();
        scene.surfaces.erase(scene.surfaces.begin());
        Camera& camera = std::get<Camera>(scene.camera);
        const auto flipped = [](const glm::dvec3& p) { return glm::dvec3(p.x, p.y, 2 * kPlane - p.z); };
        camera.position = flipped(camera.position);
        camera.focalPoint = flipped(camera.focalPoint);
        return scene;
    }
    static constexpr double kPlane = 4;
    Stored stored;
};

/// What a plane mirror shows is the picture of the mirrored camera.
TEST(Reflections, AMirrorShowsWhatTheMirroredCameraSees) {
    const MirrorRoom room;
    const auto compare = [&](bool volume, EngineKind engine, double most) {
        Scene direct = room.direct(), behind = room.behind();
        if (volume)
            for (Scene* scene : {&direct, &behind}) {
                scene->volumes[0].transferFunction =
                    TransferFunction::fromOpacity({{1, 0}, {6, 0.4}}, {{1, {0.2, 0.9, 0.4}}}, 3);
                scene->quality.automaticStep = false;
                scene->quality.stepVoxels = 0.5;
            }
        Scene black = direct;
        black.surfaces[0].reflection.reset();
        const Image seen = renderedBy(direct, engine), mirrored = renderedBy(behind, engine),
                    without = renderedBy(black, engine);
        std::size_t compared = 0, shows = 0;
        for (std::size_t y = 0; y < 40; ++y)
            for (std::size_t x = 0; x < 40; ++x) {
                if (without.pixels[y * 40 + x] != glm::vec4(0, 0, 0, 1))
                    continue; // no mirror, or something before it
                const glm::vec4& a = seen.pixels[y * 40 + x];
                const glm::vec4& b = mirrored.pixels[y * 40 + 39 - x]; // right and left are exchanged
                ++compared;
                shows += b.a > 0.5f;
                const glm::vec3 truth = glm::vec3(b) + (1 - b.a) * glm::vec3(0.1f, 0.2f, 0.3f);
                EXPECT_LT(static_cast<double>(glm::distance(glm::vec3(a), truth)), most) << x << "," << y;
            }
        EXPECT_GT(compared, 500u);
        EXPECT_GT(shows, 50u);
    };
    compare(false, EngineKind::reference, 1e-5);
    compare(false, EngineKind::mirror, 1e-3);
    compare(true, EngineKind::native, 2e-3);
}

/// In a closed box of white walls every order adds the share that is mirrored once more.
TEST(Reflections, AClosedBoxKeepsItsEnergy) {
    const Stored stored(
        [](const glm::dvec3& p) {
            const glm::dvec3 off = glm::abs(p - 20.0);
            return std::max({off.x, off.y, off.z});
        },
        glm::ivec3(40), true);
    Isosurface wall{14, glm::dvec3(1), 1};
    wall.reflection = Reflection{.strength = 0.5};
    Scene scene = stored.scene({wall}, 0, 24);
    scene.shading.ambient = 1, scene.shading.diffuse = 0, scene.shading.specular = 0;
    scene.camera = slanted({15, 23, 18}, {20, 20, 30}, 80);
    double sum = 1;
    for (int order = 1; order <= Lighting::kMostReflections; ++order) {
        scene.lighting.reflectionOrder = order;
        sum += std::ldexp(1.0, -order);
        const Image image = renderedBy(scene, EngineKind::native);
        std::size_t off = 0; // ways that begin beyond another wall, in the box's edges
        for (const glm::vec4& pixel : image.pixels)
            off += std::abs(static_cast<double>(pixel.g) - sum) > (order > 7 ? 5e-3 : 1e-5);
        EXPECT_LT(off, 24u * 24u / 5u) << order;
    }
}

Scene mirroring(Scene scene, const Reflection& inner, std::optional<Reflection> outer) {
    scene.surfaces = {{180, {0.9, 0.6, 0.5}, 0.4}, {250, {0.95, 0.9, 0.8}, 1}};
    scene.surfaces[1].reflection = inner;
    scene.surfaces[0].reflection = outer;
    return scene;
}

/// Bit by bit, whatever there is besides.
TEST(Reflections, NativeIsTheMirror) {
    const Reflection even{.strength = 0.6},
        glass{.kind = ReflectionKind::fresnel, .ior = 1.4, .transmits = true},
        steep{.kind = ReflectionKind::gradient, .gradient = {20, 200}};
    const Scene plain = torsoScene(0, false, Integrator::midpoint, {32, 32});
    Scene volume = torsoScene(1, true, Integrator::linear, {32, 32}), cut = mirroring(plain, even, glass),
          lit = cut, sampled = cut, sky = mirroring(volume, steep, glass);
    cut.cuts.boxes = {{{10, 10, 20}, {60, 60, 60}, CropBox::Space::voxels, Keep::outside}};
    lit.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 8};
    lit.lighting.lights = {{.kind = LightKind::directional, .direction = {1, 1, 1}, .shadow = true}};
    sampled.quality.pixels.samples = 4;
    sampled.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 4, .radiusMm = 6};
    sky.lighting.environment = Environment{.sky = Sky::twoTone};
    sky.quality.maxError = 8;
    std::size_t number = 0;
    for (const Scene& scene :
         {mirroring(plain, steep, even), cut, lit, sampled, sky, mirroring(volume, glass, glass)}) {
        const Image native = renderedBy(scene, EngineKind::native);
        EXPECT_EQ(differing(native, renderedBy(scene, EngineKind::mirror)), 0u) << number;
        Scene none = scene;
        none.lighting.reflectionOrder = 0;
        none.lighting.environment.reset();
        EXPECT_GT(differing(native, renderedBy(none, EngineKind::native)), 100u) << number++;
    }
}

TEST(Reflections, BudgetsThreadsAndCutsOfTheWorkDoNotMatter) {
    Scene scene = mirroring(torsoScene(1, true, Integrator::midpoint, {48, 48}), {.strength = 0.7},
                            Reflection{.kind = ReflectionKind::fresnel, .transmits = true});
    const auto drawn = [&](int threads, const Slicing& slicing) {
        Budgets budgets;
        const StoreReader store(storePath("torso"), budgets.ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = threads;
        options.slicing = slicing;
        return renderScene(scene, store, budgets.ram, budgets.gpu, options).image;
    };
    const Image one = drawn(1, {});
    EXPECT_EQ(differing(one, drawn(3, {})), 0u);
    EXPECT_EQ(differing(one, drawn(2, {.fixedIterations = 3})), 0u);
}

/// All kinds together, but for pixels where a ray meets another surface.
TEST(Reflections, ComesToTheReference) {
    const Stored waves(
        [](const glm::dvec3& p) {
            return 14 - glm::distance(p, glm::dvec3(20)) + 1.5 * std::sin(0.4 * p.x) * std::cos(0.35 * p.y);
        },
        glm::ivec3(40), true);
    for (const bool transmits : {false, true}) {
        Reflection outer{.kind = ReflectionKind::fresnel, .ior = 1.3, .transmits = transmits};
        Scene scene = waves.scene({}, 0, 32);
        scene.camera = slanted({60, 70, 90}, {20, 20, 20}, 22);
        scene.surfaces = {{0, {0.9, 0.6, 0.5}, 0.4}, {4, {0.95, 0.9, 0.8}, 1}};
        scene.surfaces[0].reflection = outer;
        scene.surfaces[1].reflection = Reflection{.strength = 0.6};
        scene.background = glm::vec3(0.4f, 0.6f, 0.9f);
        const Image native = renderedBy(scene, EngineKind::native),
                    truth = renderedBy(scene, EngineKind::reference);
        Scene none = scene;
        none.lighting.reflectionOrder = 0;
        const Image without = renderedBy(none, EngineKind::reference);
        std::vector<double> errors;
        double added = 0;
        for (std::size_t i = 0; i < truth.pixels.size(); ++i)
            if (truth.pixels[i].a > 0) {
                errors.push_back(static_cast<double>(
                    glm::distance(glm::vec3(native.pixels[i]), glm::vec3(truth.pixels[i]))));
                added += static_cast<double>(
                    glm::distance(glm::vec3(without.pixels[i]), glm::vec3(truth.pixels[i])));
            }
        ASSERT_GT(errors.size(), 100u);
        std::sort(errors.begin(), errors.end());
        EXPECT_GT(added / static_cast<double>(errors.size()), 0.02);
        EXPECT_LT(errors[errors.size() / 2], 1e-5) << transmits;
        EXPECT_LT(errors[errors.size() * 9 / 10], 1e-4) << transmits;
        if (std::getenv("TESSERA_TELL"))
            std::printf("median %.2g, ninth decile %.2g, most %.2g\n", errors[errors.size() / 2],
                        errors[errors.size() * 9 / 10], errors.back());
    }
}

/// Mirrors see what the camera does not.
TEST(Reflections, BricksBesideThePictureStay) {
    Scene scene = mirroring(torsoScene(0, false, Integrator::midpoint, {64, 64}), {}, {});
    std::get<Camera>(scene.camera).viewAngle = 2;
    EXPECT_EQ(unseenBricks(scene), 0u);
    EXPECT_GT(unseenBricks(withoutReflections(scene)), 0u);
}

TEST(Reflections, RefusalsHelp) {
    const auto refused = [](const Scene& scene, EngineKind engine = EngineKind::native) -> std::string {
        try {
            renderedBy(scene, engine);
        } catch (const InputError& e) {
            return e.what();
        }
        return "nothing was refused";
    };
    const Scene scene = mirroring(torsoScene(0, false, Integrator::midpoint, {8, 8}), {}, {});
    Scene paths = scene, reduced = scene;
    paths.lighting.transport.emplace();
    paths.quality.pixels.samples = 2;
    EXPECT_THAT(refused(paths), HasSubstr("no paths of light (lighting.transport), which have \"finish\""));
    EXPECT_THAT(refused(scene, EngineKind::gpu), HasSubstr("it follows no rays that isosurfaces mirror"));
    reduced.mode = Mode::maximum; // shows no isosurfaces
    EXPECT_EQ(refused(reduced), "nothing was refused");
    EXPECT_EQ(refused(scene), "nothing was refused");
}

TEST(Reflections, CostNothingWhereThereAreNone) {
    const auto drawn = [](const Scene& scene, std::size_t& ram, std::size_t& gpu) {
        Budgets budgets;
        const StoreReader store(storePath("torso"), budgets.ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        RenderResult result = renderScene(scene, store, budgets.ram, budgets.gpu, options);
        ram = budgets.ram.peakBytes(), gpu = budgets.gpu.peakBytes();
        return result;
    };
    const Scene with = mirroring(torsoScene(0, false, Integrator::midpoint, {48, 48}), {}, {});
    Scene none = with, off = with;
    none.surfaces[1].reflection.reset();
    off.lighting.reflectionOrder = 0;
    std::size_t ram[3], gpu[3];
    const RenderResult a = drawn(with, ram[0], gpu[0]), b = drawn(none, ram[1], gpu[1]),
                       c = drawn(off, ram[2], gpu[2]);
    EXPECT_TRUE(a.reflections && a.reflections->ways[0] > 100);
    EXPECT_FALSE(b.reflections || c.reflections);
    EXPECT_EQ(differing(b.image, c.image), 0u);
    EXPECT_EQ(ram[1], ram[2]);
    EXPECT_EQ(gpu[1], gpu[2]);
    EXPECT_EQ(gpu[0] - gpu[1], 48u * 48u * sizeof(SurfaceHit));
    EXPECT_GT(ram[0], ram[1]);
    Scene glass = with; // two rays leave a surface
    glass.surfaces[0].reflection = Reflection{.kind = ReflectionKind::fresnel, .transmits = true};
    std::size_t most = 0;
    EXPECT_GT(drawn(glass, ram[0], most).reflections->ways[0], 48u * 48u / 2);
    EXPECT_EQ(most, gpu[0]);
}

/// Windows have no reflections in motion, and show glass all the same.
TEST(Reflections, GlassIsSeenInMotion) {
    Scene scene = torsoScene(0, false, Integrator::midpoint, {16, 16});
    scene.mode = Mode::isosurface;
    scene.surfaces = {clear(-300, 1.1)};
    const Scene moving = asDrawn(withoutPaths(asDrawn(scene)));
    EXPECT_FALSE(reflects(moving));
    EXPECT_GT(moving.surfaces.at(0).opacity, 0);
    EXPECT_LT(moving.surfaces.at(0).opacity, 0.5);
    EXPECT_FALSE(isBlank(renderedBy(moving, EngineKind::native)));
}

/// Trials of the step see only what lies before glass.
TEST(Reflections, TheStepIsShortBehindGlass) {
    Scene scene = torsoScene(0, true, Integrator::midpoint, {32, 32});
    scene.surfaces = {clear(-300, 1.1)};
    scene.quality.automaticStep = true;
    Budgets budgets;
    const StoreReader store(storePath("torso"), budgets.ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.searching = true;
    EXPECT_LE(renderScene(scene, store, budgets.ram, budgets.gpu, options).stepVoxels, 1);
}

} // namespace
} // namespace tessera::test
