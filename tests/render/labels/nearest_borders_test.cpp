// tests/render/labels/nearest_borders_test.cpp: nearest borders (docs/sampling.md, "Labels"): a place has the
// factors of the sample that holds it.
#include "render/labels/label_field.h"
#include "render/plan/planner.h"
#include "tests/support/label_tools.h"
#include "tests/support/labelled.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/reference_light.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr double kOpacity = 0.03; // per mm

/// Every other voxel is labelled, at random.
struct Noise {
    Noise() : volume([](const glm::dvec3& p) { return 3 * p.x; }, glm::ivec3(44, 70, 48)) {
        HeldLayer layer(volume.info, Values(cellCount(volume.info.extentVoxels)));
        std::mt19937 random(11);
        for (auto& value : layer.values)
            value = random() % 2;
        isLabelled = layer.values;
        LabelFile file = fileOf({layer});
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        importLabels(file, volume.info, folder / "l.zarr", ram, quickly());
    }
    Scene scene() const {
        Scene s = volume.scene({}, 1, 24);
        s.shading.on = false;
        label(s, folder / "l.zarr");
        Labels& labels = s.volumes[0].labels;
        labels.opacity = kOpacity;
        labels.borders = LabelBorders::nearest;
        labels.show = {"1"};
        return s;
    }
    bool at(const glm::ivec3& voxel) const {
        return isLabelled[linearIndex(voxel, volume.info.extentVoxels)] == 1;
    }
    const ScratchFolder folder;
    Stored volume;
    Values isLabelled;
};

glm::dvec3 anywhereIn(const glm::ivec3& extent, std::mt19937& random) {
    const auto unit = [&] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
    return glm::dvec3(unit(), unit(), unit()) * glm::dvec3(extent);
}

TEST(NearestBorders, APlaceHasTheLabelOfItsVoxel) {
    const Noise noise;
    const auto prepared = noise.volume.prepare(noise.scene());
    const Layer& layer = prepared->p.layer();
    const glm::ivec3 e = noise.volume.info.extentVoxels;
    const Selection finest = atLevel0(layer.selection);
    LabelField field(*layer.labelBricks, finest, nullptr, e);
    std::mt19937 random(3);
    for (int i = 0; i < 5000; ++i) {
        const glm::dvec3 p = anywhereIn(e, random);
        ASSERT_EQ(field.shares(p).solid, noise.at(glm::ivec3(p)) ? 1.0 : 0.0) << i;
    }
}

// Wherever levels mix, one sample of the brick has one factor.
TEST(NearestBorders, ASampleOfAnyLevelHasOneFactor) {
    const Noise noise;
    const auto prepared = noise.volume.prepare(noise.scene());
    Planner& p = prepared->p;
    const glm::ivec3 e = noise.volume.info.extentVoxels;
    for (const unsigned seed : {1u, 2u, 3u}) {
        p.setSelection(randomShownLevels(p.layer().selection, seed));
        ASSERT_TRUE(p.layer().mixed());
        const Selection& selection = p.layer().selection;
        LabelField field(*p.layer().labelBricks, selection, &p.layer().levels, e);
        std::mt19937 random(seed);
        for (int i = 0; i < 3000; ++i) {
            const glm::dvec3 place = anywhereIn(e, random);
            const int level =
                selection.levels[linearIndex(glm::ivec3(place) / kBrickExtent, selection.bricks)];
            ASSERT_NE(level, Selection::kEmpty);
            const double pitch = std::ldexp(1.0, level);
            const glm::dvec3 low = glm::floor(place / pitch) * pitch,
                             other = glm::min(low + pitch * glm::fract(place * 7.3), glm::dvec3(e) - 1e-9);
            ASSERT_EQ(field.shares(place).solid, field.shares(other).solid) << i;
        }
    }
}

/// Length of a ray in labelled voxels, mm.
double labelledMm(const Noise& noise, const glm::dvec3& entry, const glm::dvec3& step, double segments,
                  double segmentMm) {
    std::vector<double> faces = {0, segments};
    for (int axis = 0; axis < 3; ++axis)
        for (int face = 0; face <= noise.volume.info.extentVoxels[axis]; ++face)
            if (const double t = (face - entry[axis]) / step[axis]; t > 0 && t < segments)
                faces.push_back(t);
    std::sort(faces.begin(), faces.end());
    double sum = 0;
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        const glm::dvec3 middle = entry + 0.5 * (faces[i] + faces[i + 1]) * step;
        const glm::ivec3 voxel =
            glm::clamp(glm::ivec3(glm::floor(middle)), glm::ivec3(0), noise.volume.info.extentVoxels - 1);
        sum += noise.at(voxel) ? faces[i + 1] - faces[i] : 0;
    }
    return sum * segmentMm;
}

TEST(NearestBorders, TheReferenceHasTheLengthInVoxels) {
    const Noise noise;
    const Scene scene = noise.scene();
    const auto prepared = noise.volume.prepare(scene);
    ReferenceInput input = referenceInput(*prepared, scene);
    input.labels = prepared->p.layer().labelBricks.get();
    const Image image = referencePicture(input, *prepared);
    int met = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const auto ray = segmentedRay(prepared->p.view.frame, glm::dvec2(static_cast<double>(i % 24) + 0.5,
                                                                         static_cast<double>(i / 24) + 0.5));
        const double segments = ray.count == 0 ? 0 : ray.count - 1 + static_cast<double>(ray.tail);
        const double mm = labelledMm(noise, ray.entry, ray.step, segments, ray.segmentMm);
        EXPECT_NEAR(image.pixels[i].a, -std::expm1(mm * std::log1p(-kOpacity)), 1e-4) << i;
        met += mm > 5 ? 1 : 0;
    }
    EXPECT_GT(met, 100);
}

} // namespace
} // namespace tessera
