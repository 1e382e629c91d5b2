// tests/bricking/analysis/body_test.cpp: the box of a body: patients that are formulas, on tables that touch
// them.
#include "bricking/analysis/body/body_box.h"
#include "core/base/error.h"
#include "tests/support/lumen_tubes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

double ellipse(const glm::dvec3& p, const glm::dvec2& middle, const glm::dvec2& half) {
    return glm::length((glm::dvec2(p) - middle) / half);
}

/// A trunk with lungs, arms beside it that hang on nothing, and a nose; lying on its back, y = 100. mm.
double patient(const glm::dvec3& p) {
    const bool trunk = ellipse(p, {0, 0}, {160, 100}) < 1;
    const bool lungs =
        std::min(ellipse(p, {-75, 0}, {60, 75}), ellipse(p, {75, 0}, {60, 75})) < 1 && p.z > 60;
    const bool arms = std::min(ellipse(p, {-215, 60}, {40, 40}), ellipse(p, {215, 60}, {40, 40})) < 1;
    const bool nose = std::abs(p.x) < 8 && std::abs(p.z) < 20 && p.y > -122 && p.y < -95;
    return (trunk && !lungs) || arms || nose ? 40 : -1000;
}
const glm::dvec3 kPatientLow(-255, -122, -150), kPatientHigh(255, 100, 150);

/// The table under and beside the body, above the threshold.
struct Table {
    const char* name;
    double thicknessMm; // of what touches, which the box may hold
    Field hu;
};
const std::vector<Table>& tables() {
    static const std::vector<Table> all = {
        {"none", 0, [](const glm::dvec3&) { return -1000.0; }},
        {"a plate that touches", 6,
         [](const glm::dvec3& p) { return p.y > 100 && p.y < 106 ? 100. : -1000.; }},
        {"a shell that touches along the back", 6,
         [](const glm::dvec3& p) {
             const double r = ellipse(p, {0, -200}, {1, 1});
             return r > 300 && r < 306 && p.y > 0 ? 150. : -1000.;
         }},
        {"two plates and foam between", 6,
         [](const glm::dvec3& p) {
             const bool plates = (p.y > 102 && p.y < 106) || (p.y > 150 && p.y < 154);
             return plates ? 300. : p.y > 106 && p.y < 150 ? -850. : -1000.;
         }},
        {"a cushion between", 0,
         [](const glm::dvec3& p) {
             return p.y > 112 && p.y < 140 ? 0. : p.y > 100 && p.y < 112 ? -900. : -1000.;
         }},
        {"a blanket", 0, [](const glm::dvec3& p) { return p.y < -128 && p.y > -136 ? -150. : -1000.; }},
        {"a bar below", 0, [](const glm::dvec3& p) {
             return ellipse(p, {100, 160}, {15, 15}) < 1 ? 2000. : -1000.;
         }}};
    return all;
}

BodyBox found(const ChunkSource& source) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    const BodyBox box = findBody(source, ram);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), bodyBoxBytes(source.info()));
    return box;
}

TEST(Body, TheBoxHoldsThePatientAndNoTable) {
    const glm::dvec3 spacing(5, 5, 10);
    const VolumeInfo info = boxInfo({112, 64, 30}, spacing, {-280, -140, -150});
    for (const Table& table : tables()) {
        std::mt19937 random(7);
        std::normal_distribution<double> noise(0, 30);
        const FieldChunks scan(info, [&](const glm::dvec3& p) {
            return std::max(patient(p), table.hu(p)) + std::clamp(noise(random), -100., 100.);
        });
        const BodyBox box = found(scan);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_LE(box.low[axis], kPatientLow[axis]) << table.name << ", axis " << axis;
            EXPECT_GE(box.high[axis], kPatientHigh[axis]) << table.name << ", axis " << axis;
            EXPECT_GE(box.low[axis], kPatientLow[axis] - 1.3 * spacing[axis] - 1)
                << table.name << " " << axis;
            EXPECT_LE(box.high[axis],
                      kPatientHigh[axis] + 1.3 * spacing[axis] + 1 + (axis == 1 ? table.thicknessMm : 0))
                << table.name << ", axis " << axis;
        }
        EXPECT_NEAR(box.litres, 15.5, 0.8) << table.name;
    }
}

// The scale is the patient's own: a mouse in a tube as well.
TEST(Body, SizeDoesNotMatter) {
    const double scale = 0.08;
    const VolumeInfo info =
        boxInfo({112, 64, 30}, scale * glm::dvec3(5, 5, 10), scale * glm::dvec3(-280, -140, -150));
    const Table& table = tables()[1];
    const FieldChunks scan(
        info, [&](const glm::dvec3& p) { return std::max(patient(p / scale), table.hu(p / scale)); });
    const BodyBox box = found(scan);
    EXPECT_LE(box.high.y, scale * 113 + 0.2);
    EXPECT_GE(box.high.x, scale * 255);
}

TEST(Body, ObliqueVolumesGiveABoxOfThePatientsAxes) {
    VolumeInfo info = boxInfo(glm::ivec3(64), glm::dvec3(4), glm::dvec3(-128));
    const double c = std::cos(0.3), s = std::sin(0.3);
    info.patientFromVoxel =
        patientFromVoxelOf({-160, -80, -126}, {4 * c, 4 * s, 0}, {-4 * s, 4 * c, 0}, {0, 0, 4});
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(32, 32, 32, 1));
    const FieldChunks scan(info,
                           [&](const glm::dvec3& p) { return glm::length(p - middle) < 60 ? 40. : -1000.; });
    const BodyBox box = found(scan);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(box.low[axis], middle[axis] - 62, 6);
        EXPECT_NEAR(box.high[axis], middle[axis] + 62, 6);
    }
}

TEST(Body, NoAirIsTheWholeVolumeAndNoBodyIsSaid) {
    const VolumeInfo info = boxInfo({40, 33, 20}, {1, 2, 3}, {-7, 5, 9});
    const BodyBox box = found(FieldChunks(info, [](const glm::dvec3&) { return 40.; }));
    EXPECT_EQ(box.low, glm::dvec3(-7, 5, 9));
    EXPECT_EQ(box.high, glm::dvec3(33, 71, 69));
    MemoryBudget ram("RAM", "--ram", 256u << 20), few("RAM", "--ram", 1000);
    const FieldChunks air(info, [](const glm::dvec3&) { return -1000.; });
    EXPECT_THROW(findBody(air, ram), InputError);
    EXPECT_THROW(findBody(air, few), InputError);
}

// Whatever the volume's size, what is read is a level of 2^21 samples at most.
TEST(Body, LargeVolumesAreLookedAtCoarsely) {
    for (const glm::ivec3& extent : {glm::ivec3(128), glm::ivec3(129, 128, 128), glm::ivec3(512, 512, 134),
                                     glm::ivec3(2048), glm::ivec3(512, 512, 1)}) {
        const VolumeInfo info = boxInfo(extent, glm::dvec3(1), glm::dvec3(0));
        EXPECT_LE(bodyBoxBytes(info), 64u << 20) << extent.x;
    }
    const FieldChunks large(boxInfo({300, 200, 100}, glm::dvec3(1), glm::dvec3(0)), [](const glm::dvec3& p) {
        // chunks of level 1 are asked for as level 0's: the formula in halves
        return glm::length(p - glm::dvec3(75, 50, 25)) < 20 ? 40. : -1000.;
    });
    const BodyBox box = found(large);
    EXPECT_EQ(box.level, 1);
    EXPECT_NEAR(box.low.x, 2 * 55, 3);
    EXPECT_NEAR(box.high.z, 2 * 45, 3);
}

} // namespace
} // namespace tessera::test
