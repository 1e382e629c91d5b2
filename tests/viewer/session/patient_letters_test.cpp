// tests/viewer/session/patient_letters_test.cpp: the letters at a picture's edges are the patient's
// directions there, from any side and however the camera is tilted.
#include "viewer/session/patient_letters.h"

#include "core/scene/scene.h"
#include "viewer/session/view_geometry.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <random>

namespace tessera {
namespace {

glm::dvec3 towards(char letter) {
    static const std::map<char, glm::dvec3> axes = {{'L', {1, 0, 0}},  {'R', {-1, 0, 0}}, {'P', {0, 1, 0}},
                                                    {'A', {0, -1, 0}}, {'S', {0, 0, 1}},  {'I', {0, 0, -1}}};
    return axes.at(letter);
}

Camera seenFromSide(const ViewAxes& axes, Projection projection) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(40, 50, 60);
    return fitCamera(info, axes, projection, {200, 150});
}

TEST(PatientLetters, OfTheSixSides) {
    const std::map<View, EdgeLetters> expected = {
        {View::anterior, {"R", "L", "S", "I"}}, {View::posterior, {"L", "R", "S", "I"}},
        {View::left, {"A", "P", "S", "I"}},     {View::right, {"P", "A", "S", "I"}},
        {View::superior, {"L", "R", "A", "P"}}, {View::inferior, {"R", "L", "A", "P"}}};
    for (const auto& [view, letters] : expected)
        for (const Projection projection : {Projection::perspective, Projection::parallel})
            EXPECT_EQ(edgeLetters(seenFromSide(viewAxes(view), projection)), letters)
                << namesOf<View>().all()[static_cast<std::size_t>(view)];
}

// DICOM C.7.6.1.1.1: the principal direction first; signs of patient coordinates by C.7.6.2.1.1.
TEST(PatientLetters, OfDirections) {
    EXPECT_EQ(directionLetters({1, 0, 0}), "L") << "rows of an axial slice";
    EXPECT_EQ(directionLetters({0, 1, 0}), "P") << "its columns";
    EXPECT_EQ(directionLetters({0, 0, -1}), "I") << "columns of a coronal slice";
    EXPECT_EQ(directionLetters({-0.9, -0.4, 0}), "RA");
    EXPECT_EQ(directionLetters({-0.4, -0.9, 0}), "AR");
    EXPECT_EQ(directionLetters({0, 0.5, 30}), "S") << "a tilt of one degree";
    EXPECT_EQ(directionLetters({0, -6, 30}), "SA") << "of eleven";
    EXPECT_EQ(directionLetters({1, 1, 1}), "LP") << "two at most";
    EXPECT_EQ(directionLetters({0, 0, 0}), "");
    EXPECT_EQ(directionLetters({NAN, 0, 0}), "");
    for (const double scale : {1e-9, 1.0, 1e9})
        EXPECT_EQ(directionLetters(scale * glm::dvec3(0, -2, 1)), "AS");
}

// A place beside the focal point, moved as the first letter says, moves towards the letter's edge.
TEST(PatientLetters, AreWherePlacesMoveTo) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1, 1);
    const glm::ivec2 size(200, 150);
    for (int n = 0; n < 500; ++n) {
        Camera camera = seenFromSide(viewAxes(ViewAngles{180 * unit(random), 85 * unit(random)}),
                                     n % 2 ? Projection::parallel : Projection::perspective);
        camera = rolled(camera, std::numbers::pi * unit(random));
        const EdgeLetters letters = edgeLetters(camera);
        const auto move = [&](char letter) {
            glm::dvec2 from(0), to(0);
            EXPECT_TRUE(pictureFromPatient(camera, size, camera.focalPoint, from));
            EXPECT_TRUE(pictureFromPatient(camera, size, camera.focalPoint + 0.01 * towards(letter), to));
            return glm::normalize(to - from);
        };
        const double least = 1 / std::sqrt(3.0) - 1e-3; // of the largest of three parts
        EXPECT_LT(move(letters.left[0]).x, -least);
        EXPECT_GT(move(letters.right[0]).x, least);
        EXPECT_LT(move(letters.top[0]).y, -least);
        EXPECT_GT(move(letters.bottom[0]).y, least);
        for (const std::string& two : {letters.left, letters.right, letters.top, letters.bottom})
            if (two.size() == 2) {
                EXPECT_NE(towards(two[0]), towards(two[1]));
                EXPECT_EQ(glm::dot(towards(two[0]), towards(two[1])), 0);
            }
        // Opposite edges have opposite letters.
        ASSERT_EQ(letters.left.size(), letters.right.size());
        for (std::size_t i = 0; i < letters.left.size(); ++i)
            EXPECT_EQ(towards(letters.left[i]), -towards(letters.right[i]));
    }
}

// The volume's axes are no matter: a voxel's place in the patient is, whether axes are permuted or mirrored.
TEST(PatientLetters, AreThoseOfVoxelsPlaces) {
    const glm::ivec2 size(300, 300);
    for (int turn = 0; turn < 3; ++turn)
        for (int mirror = 0; mirror < 8; ++mirror)
            for (const View view :
                 {View::anterior, View::posterior, View::left, View::right, View::superior, View::inferior}) {
                VolumeInfo info;
                info.extentVoxels = {60, 60, 60};
                info.patientFromVoxel = glm::dmat4(0);
                info.patientFromVoxel[3] = {5, -7, 11, 1};
                for (int axis = 0; axis < 3; ++axis)
                    info.patientFromVoxel[axis][(axis + turn) % 3] = mirror >> axis & 1 ? -1.0 : 1.0;
                const Camera camera = fitCamera(info, view, Projection::parallel, size);
                const EdgeLetters letters = edgeLetters(camera);
                const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(30, 30, 30, 1));
                for (int axis = 0; axis < 3; ++axis) {
                    glm::dvec4 voxel(30, 30, 30, 1);
                    voxel[axis] = 55;
                    const glm::dvec3 place(info.patientFromVoxel * voxel);
                    const std::string letter = directionLetters(place - middle);
                    glm::dvec2 at(0);
                    ASSERT_TRUE(pictureFromPatient(camera, size, place, at));
                    const glm::dvec2 by = at - glm::dvec2(size) / 2.0;
                    if (std::abs(by.x) > 10) {
                        EXPECT_EQ(letter, by.x > 0 ? letters.right : letters.left);
                    }
                    if (std::abs(by.y) > 10) {
                        EXPECT_EQ(letter, by.y > 0 ? letters.bottom : letters.top);
                    }
                }
            }
}

} // namespace
} // namespace tessera
