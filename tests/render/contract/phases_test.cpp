// tests/render/contract/phases_test.cpp: rays that take samples between one another's (RayFrame::phased), by
// every engine, and the step that pixels of several such rays are drawn with
// (render/picture/picture.h).
#include "core/image/image_metrics.h"
#include "render/backends/reference/reference.h"
#include "render/picture/picture.h"
#include "render/picture/render_scene.h"
#include "render/pixels/pixel_places.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/places.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kPicture(24, 18), kArray(36, 20);

Scene sceneOf(const std::string& preset, const glm::ivec2& size) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    Scene scene = sceneOn(StoreReader(storePath("torso"), ram).info(), preset, 0, size);
    scene.volumes[0].path = storePath("torso");
    return scene;
}

TEST(Phases, AreAllThereInEightsAndHalvesLieBetweenOneAnother) {
    const glm::ivec2 size(64, 12);
    for (std::size_t first = 0; first < rayCount(size); first += kPhases) {
        std::set<double> all;
        double sumOfHalf[2] = {0, 0};
        for (std::size_t k = 0; k < kPhases; ++k) {
            const auto slot = static_cast<int>(raySlot(first + k, size));
            const auto phase = phaseOf<double>(slot % size.x, slot / size.x);
            EXPECT_LT(std::abs(phase), 0.5);
            all.insert(phase);
            sumOfHalf[k / 4] += phase;
        }
        ASSERT_EQ(all.size(), static_cast<std::size_t>(kPhases));
        EXPECT_NEAR(*all.rbegin() - *all.begin(), 7.0 / 8, 1e-12); // an eighth from one to the next
        EXPECT_NEAR(sumOfHalf[0] + sumOfHalf[1], 0, 1e-12);
        EXPECT_NEAR(sumOfHalf[1] - sumOfHalf[0], 0.5, 1e-12); // a set of samples has no half of the range
    }
}

TEST(Phases, ShiftTheLatticeAndNotTheEnds) {
    const Prepared prepared("torso", sceneOf("soft-tissue", kPicture));
    const RayFrame<double>& frame = prepared.p.view.frame;
    const glm::dvec2 pixel(11.5, 9.5);
    const auto ray = segmentedRay(frame, pixel);
    ASSERT_GT(ray.count, 20);
    for (const double phase : {-7.0 / 16, -1.0 / 16, 3.0 / 16, 7.0 / 16}) {
        const auto other = segmentedRay(frame, pixel, phase);
        EXPECT_NEAR(glm::length(other.entry - (ray.entry + phase * ray.step)), 0, 1e-9);
        EXPECT_EQ(other.step, ray.step);
        // From a start to the exit, in segments.
        EXPECT_NEAR(other.count - 1 + other.tail, ray.count - 1 + ray.tail - phase, 1e-9);
        // The first sample is inside of the volume.
        EXPECT_GT(glm::dot(stridePosition(other, 0, 1.0) - ray.entry, ray.direction), 0);
    }
}

// A corner that is cut by less than a segment. Some phases take no sample, and none counts backwards. All
// together have the ray's length, except for the phases without a sample.
TEST(Phases, OfRaysShorterThanASegmentHaveTheirLengthInTheMean) {
    Prepared prepared("torso", sceneOf("soft-tissue", kPicture));
    RayFrame<double> frame = prepared.p.view.frame;
    const auto whole = segmentedRay(frame, glm::dvec2(11.5, 9.5));
    const double length = (whole.count - 1 + whole.tail) * frame.segmentVoxels;
    for (const double part : {0.1, 0.3, 0.45, 0.8}) { // of a segment
        frame.segmentVoxels = length / part;
        double sum = 0;
        for (int k = 0; k < kPhases; ++k) {
            const auto ray = segmentedRay(frame, glm::dvec2(11.5, 9.5), phaseOf<double>(k & 3, k >> 2));
            ASSERT_TRUE(ray.count == 0 || ray.count == 1 || ray.count == 2) << part << ", " << k;
            if (ray.count > 0) {
                EXPECT_GT(ray.tail, 0);
                EXPECT_LE(ray.tail, 1);
                sum += ray.count - 1 + ray.tail;
            }
        }
        EXPECT_NEAR(sum / kPhases, part, 0.1) << part;
    }
}

// With each instruction set, one level and mixed ones, lit and with distance maps.
TEST(Phases, NativePicturesHaveTheMirrorsBits) {
    for (const bool isMixed : {false, true}) {
        MixedScene scene("torso", "soft-tissue", 0, EdgeFunction::split, Sampling::limited, kPicture);
        if (isMixed)
            scene.choose(randomShownLevels(scene.p().layer().selection, 3));
        Planner& p = scene.p();
        const Places places = randomPlaces(kPicture, kArray, 21);
        NativeChoices choices;
        choices.rays = places.of(p.view.frame, p.strides());
        choices.rays->frame.phased = true;
        Work work;
        Image mirror(kArray), unphased(kArray);
        const auto mirrored = [&](const RayFrame<double>& frame) {
            return mirrorRays<float>(mirrorInput(p, true), places.all.size(),
                                     frameRays(cast<float>(frame), places.all, kArray.x), 0, work);
        };
        mirror.pixels = mirrored(choices.rays->frame);
        unphased.pixels = mirrored(p.view.frame);
        EXPECT_GT(compare(mirror, unphased).rms, 1e-4);
        for (const native::PacketTarget* target : nativeTargets()) {
            choices.target = target;
            EXPECT_TRUE(bitEqual(nativePicture(*scene.prepared, choices).image, mirror))
                << target->name << (isMixed ? ", mixed" : "");
        }
    }
}

TEST(Phases, MarchHasTheMirrorsRaysAndPicture) {
    const GlContext context({"software"});
    Prepared prepared("torso", sceneOf("soft-tissue", kPicture));
    Planner& p = prepared.p;
    const Places places = randomPlaces(kPicture, kArray, 22);
    Rays rays = places.of(p.view.frame, p.strides());
    rays.frame.phased = true;
    const auto own = gpuRays(rays, prepared.budgets.gpu);
    const auto theirs = frameRays(cast<float>(rays.frame), places.all, kArray.x);
    ASSERT_EQ(own.size(), places.all.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
        const auto ray = theirs(i);
        const auto length = [](const auto& r) { return static_cast<float>(r.count - 1) + r.tail; };
        ASSERT_NEAR(length(own[i]), length(ray), 2e-3) << "ray " << i;
        ASSERT_LT(glm::length(own[i].entry - ray.entry), 2e-3f) << "ray " << i;
    }
    Work work;
    Image mirror(kArray);
    mirror.pixels = mirrorRays<float>(
        mirrorInput(p, true), own.size(), [&](std::size_t i) { return own[i]; }, 0, work);
    GpuEngine engine(context, prepared.budgets.gpu, prepared.budgets.ram);
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    loadBricks(engine, p, prepared.budgets.gpu, work);
    const auto caster = engine.caster({false, false, false}, prepared.budgets.gpu);
    caster->begin(rays);
    drawToTheEnd(*caster, engine, p, Slicing{}, work);
    EXPECT_LE(compare(caster->image(), mirror).maxAbs, 1e-5);
    EXPECT_FALSE(isBlank(mirror));
}

// Their purpose: eight rays through one place err half as much as one.
TEST(Phases, MeansOfEightErrLessThanOne) {
    Scene scene = sceneOf("soft-tissue", kPicture);
    scene.shading.on = false;
    Prepared prepared("torso", scene);
    const FramePlan& p = prepared.p;
    Places eights{{}, rayArraySize(kPhases * rayCount(kPicture))};
    eights.all.resize(rayCount(eights.size));
    std::size_t slot = 0;
    forEachPixel(kPicture, [&](const glm::ivec2& at) {
        for (int n = 0; n < kPhases; ++n)
            eights.all[raySlot(slot++, eights.size)] = glm::vec2(at) + 0.5f;
    });
    const auto means = [&](double stepVoxels, bool phased) {
        RayFrame<double> frame = p.view.frame;
        frame.segmentVoxels = stepVoxels;
        frame.phased = phased;
        MirrorInput input = mirrorInput(p, true);
        input.strides.segmentVoxels = stepVoxels;
        Work work;
        const auto rays = mirrorRays<float>(
            input, eights.all.size(), frameRays(cast<float>(frame), eights.all, eights.size.x), 0, work);
        Image mean(kPicture);
        std::size_t from = 0;
        forEachPixel(kPicture, [&](const glm::ivec2& at) {
            for (int n = 0; n < kPhases; ++n)
                mean.at(at.x, at.y) += rays[raySlot(from++, eights.size)] / static_cast<float>(kPhases);
        });
        return mean;
    };
    const Image truth = means(1.0 / 16, false);
    EXPECT_FALSE(isBlank(truth));
    const double single = compare(means(1, false), truth).rms, phased = compare(means(1, true), truth).rms;
    EXPECT_GT(single, 0.005);
    EXPECT_LT(phased, single / 2);
}

RenderResult drawn(const Scene& scene) {
    Budgets budgets;
    const StoreReader reader(scene.volumes[0].path, budgets.ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.checking = true;
    options.levels = LevelChoice::oneForAll;
    return renderScene(scene, reader, budgets.ram, budgets.gpu, options);
}

TEST(StepOfMeans, IsLongerAndThePictureAsGood) {
    Scene scene = sceneOf("soft-tissue", {288, 256});
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    scene.quality.automaticStep = true;
    const RenderResult longer = drawn(scene);
    ASSERT_TRUE(longer.stepOfMeans);
    EXPECT_GE(*longer.stepOfMeans, 1.5 * longer.stepVoxels);
    EXPECT_LE(*longer.stepOfMeans, 4);
    scene.quality.automaticStep = false; // a step that is named is that of all rays
    scene.quality.stepVoxels = longer.stepVoxels;
    const RenderResult named = drawn(scene);
    EXPECT_FALSE(named.stepOfMeans);
    EXPECT_LT(longer.work.segments, named.work.segments);
    scene.quality.stepVoxels = 1.0 / 8;
    scene.quality.pixels.samples = 16;
    const Image truth = drawn(scene).image;
    const double with = compare(longer.image, truth).rms, without = compare(named.image, truth).rms;
    EXPECT_LT(with, std::hypot(without, 1.0 / 255)); // the allowed error of the step
}

TEST(StepOfMeans, IsNotTakenWhereRaysHaveNoPhases) {
    Scene scene = sceneOf("soft-tissue", {288, 256});
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    scene.quality.automaticStep = true;
    const auto refuses = [](const Scene& other, const char* what) {
        EXPECT_FALSE(drawn(other).stepOfMeans) << what;
    };
    Scene other = scene;
    other.quality.integrator = Integrator::linear;
    refuses(other, "an integrator that takes ends");
    other = scene;
    other.surfaces.push_back({.value = 300, .colour = glm::vec3(1), .opacity = 0.5});
    refuses(other, "a surface");
    other = scene;
    other.quality.pixels.samples = 4;
    refuses(other, "as many samples as are named");
    other = scene;
    other.imageSize = {128, 128};
    refuses(other, "a small picture");
}

} // namespace
} // namespace tessera
