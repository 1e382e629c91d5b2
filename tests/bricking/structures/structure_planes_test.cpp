// tests/bricking/structures/structure_planes_test.cpp: the planes that contours lie in: their direction,
// places, distances and widths, in every direction; and how far points may lie off.
#include "bricking/import/structures/structure_planes.h"
#include "core/base/error.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A rectangle of 6 x 4 mm at a height, along the axes of a frame.
std::vector<glm::dvec3> rectangle(const glm::dmat3& frame, double height, double rise = 0, double scale = 1) {
    std::vector<glm::dvec3> ring;
    for (const auto& [x, y] : {std::pair(10.0, 20.0), {16.0, 20.0}, {16.0, 24.0}, {10.0, 24.0}})
        ring.push_back(frame * glm::dvec3(scale * x, scale * y, height + (x > 12 ? rise : 0)));
    return ring;
}

class Planes : public testing::Test {
  protected:
    void add(const std::vector<glm::dvec3>& ring, ContourForm form = ContourForm::ring) {
        structure.contours.push_back({form, ring});
    }
    std::vector<double> heights() {
        std::vector<double> all;
        for (const StructurePlane& plane : planesOf(structure, ram).planes)
            all.push_back(plane.at);
        return all;
    }
    Structure structure{{5, "GTV"}, {}};
    MemoryBudget ram{"RAM", "--ram", std::size_t{1} << 24};
    const glm::dmat3 axial{1};
};

// Right-handed, the normal towards the patient's left, back or head; the first axis of a plane is that of the
// patient which follows the normal's.
TEST_F(Planes, OfEveryDirection) {
    for (int main = 0; main < 3; ++main)
        for (const double tilt : {0.0, 0.3, -0.3})
            for (const double sign : {1.0, -1.0}) {
                glm::dvec3 normal(0), first(0);
                normal[main] = std::cos(tilt), normal[(main + 2) % 3] = std::sin(tilt);
                first[(main + 1) % 3] = 1;
                const glm::dmat3 frame(first, glm::cross(normal, first), normal);
                structure.contours.clear();
                auto ring = rectangle(frame, 7);
                if (sign < 0)
                    std::reverse(ring.begin(), ring.end());
                add(ring);
                add(rectangle(frame, 5, 0, 0.5));
                const StructurePlanes planes = planesOf(structure, ram);
                for (int column = 0; column < 3; ++column)
                    EXPECT_LT(glm::distance(planes.patientFromPlane[column], frame[column]), 1e-12)
                        << main << tilt;
                ASSERT_EQ(planes.planes.size(), 2u);
                EXPECT_NEAR(planes.planes[0].at, 5, 1e-9);
                EXPECT_NEAR(planes.planes[1].at, 7, 1e-9);
                EXPECT_NEAR(planes.spacingMm, 2, 1e-9);
                EXPECT_NEAR(planes.widthMm, 2 * 24.0 / 20, 1e-9) << "the second of two";
                const auto& corners = planes.planes[1].rings.at(0);
                EXPECT_LT(glm::distance(corners[sign > 0 ? 0 : 3], glm::dvec2(10, 20)), 1e-9);
                EXPECT_LT(glm::distance(corners[sign > 0 ? 1 : 2], glm::dvec2(16, 20)), 1e-9);
                EXPECT_THAT(planes.otherContours, IsEmpty());
            }
}

TEST_F(Planes, PointsLieATenthOfAMillimetreOffAtMost) {
    add(rectangle(axial, 0, 0, 2)); // decides the direction
    add(rectangle(axial, 3, 0.19));
    add(rectangle(axial, 6, -0.19));
    add(rectangle(axial, 9, 0.21));
    add(rectangle(axial, 12, -0.21));
    add(rectangle(axial, 15), ContourForm::line);
    add({{0, 0, 18}, {1, 0, 18}});
    add({{0, 0, 21}, {1, 0, 21}, {0, 1, 21}});
    EXPECT_THAT(planesOf(structure, ram).otherContours, ElementsAre(3, 4, 5, 6));
    EXPECT_THAT(heights(),
                ElementsAre(0, testing::DoubleNear(3.095, 1e-9), testing::DoubleNear(5.905, 1e-9), 21));
}

// Planes that are nearer to the one before than a twentieth of a millimetre are one.
TEST_F(Planes, NearOnesAreOne) {
    for (const double height : {4.0, 0.0, 0.04, 4.06, 8.0, 8.049, 8.09})
        add(rectangle(axial, height));
    EXPECT_THAT(heights(), ElementsAre(0, 4, 4.06, 8, 8.09));
    const StructurePlanes planes = planesOf(structure, ram);
    EXPECT_EQ(planes.planes[0].rings.size(), 2u);
    EXPECT_EQ(planes.planes[3].rings.size(), 2u);
    // Distances 4, 0.06, 3.94, 0.09: the third of four in their order.
    EXPECT_NEAR(planes.spacingMm, 3.94, 1e-9);
}

TEST_F(Planes, WithoutRingsThereAreNone) {
    EXPECT_THAT(heights(), IsEmpty());
    add({{1, 2, 3}}, ContourForm::points);
    add({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}); // without area
    const StructurePlanes planes = planesOf(structure, ram);
    EXPECT_THAT(planes.planes, IsEmpty());
    EXPECT_THAT(planes.otherContours, ElementsAre(0, 1));
    EXPECT_EQ(planes.spacingMm, 0);
    EXPECT_EQ(planes.widthMm, 0);
    add(rectangle(axial, 5));
    EXPECT_EQ(planesOf(structure, ram).spacingMm, 0) << "of one plane";
    MemoryBudget small("RAM", "--ram", 16);
    EXPECT_THROW(planesOf(structure, small), Error);
}

} // namespace
} // namespace tessera
