// tests/core/animation/film_test.cpp: flights against a helix that is known in closed form, keyframes against
// what lies between them by hand, and films whose frames follow from their numbers.
#include "core/animation/film.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

/// A helix about z, by arc length: radius 30 mm, rising 8 mm a radian.
constexpr double kRadius = 30, kRise = 8;
const double kSpeed = std::hypot(kRadius, kRise); // mm a radian
glm::dvec3 helix(double mm) {
    const double a = mm / kSpeed;
    return {kRadius * std::cos(a), kRadius * std::sin(a), kRise * a};
}

CentreLine helixLine(double lengthMm, double spacing, double wall) {
    CentreLine line;
    const int count = static_cast<int>(std::lround(lengthMm / spacing)) + 1;
    line.spacingMm = lengthMm / (count - 1);
    for (int i = 0; i < count; ++i) {
        line.points.push_back(helix(i * line.spacingMm));
        line.radiusMm.push_back(wall);
    }
    return line;
}

TEST(Flight, FollowsTheLineEvenlyWithoutATwist) {
    Flight flight;
    flight.lookAheadMm = 10;
    const FlightCurve curve({helixLine(200, 1, 6)}, flight);
    EXPECT_NEAR(curve.lengthMm(), 200, 0.1);
    constexpr double kStep = 0.37;                         // falls on no point, and on no node
    const double turn = kStep / kSpeed * kRadius / kSpeed; // of the direction, radians a step: the curvature
    Pose before = curve.at(20 - kStep), last = curve.at(20 - 2 * kStep);
    double twist = 0, unevenTurn = 0;
    for (double mm = 20; mm < 180; mm += kStep) {
        const Pose pose = curve.at(mm);
        EXPECT_LT(glm::length(pose.at - helix(mm * 200 / curve.lengthMm())), 0.02);
        EXPECT_NEAR(glm::length(pose.at - before.at), kStep, 1e-4 * kStep);
        EXPECT_NEAR(glm::dot(pose.direction, pose.up), 0, 1e-12);
        EXPECT_NEAR(glm::length(pose.up), 1, 1e-12);
        // no jitter: what the direction turns by is the curvature's, from step to step
        EXPECT_NEAR(glm::length(pose.direction - before.direction), turn, 0.01 * turn);
        unevenTurn =
            std::max(unevenTurn, glm::length(pose.direction - 2.0 * before.direction + last.direction));
        // rotation-minimising: up does not move sideways
        const glm::dvec3 right =
            glm::normalize(glm::cross(before.direction + pose.direction, before.up + pose.up));
        twist = std::max(twist, std::abs(glm::dot(pose.up - before.up, right)));
        last = before, before = pose;
    }
    EXPECT_LT(unevenTurn, 1.05 * turn * kStep / kSpeed + 1e-6);
    EXPECT_LT(twist, 1e-6);
}

TEST(Flight, IsHeldWithinTheWall) {
    Flight flight;
    flight.clearanceMm = 1.5;
    CentreLine line = helixLine(150, 0.5, 5);
    for (std::size_t i = 0; i < line.radiusMm.size(); ++i) // narrow in the middle: 2 mm
        line.radiusMm[i] = 5 - 3 * std::exp(-std::pow((0.5 * static_cast<double>(i) - 75) / 6, 2));
    const FlightCurve curve({line}, flight);
    double widest = 0;
    for (double mm = 0; mm <= curve.lengthMm(); mm += 0.21) {
        const Pose pose = curve.at(mm);
        const double wall = 5 - 3 * std::exp(-std::pow((mm - 75) / 6, 2));
        EXPECT_LE(pose.freeMm, wall + 0.02) << mm;
        const Camera camera = cameraOf(pose, {0, 0, {3, -4}}, flight);
        const double beside = glm::length(camera.position - pose.at);
        EXPECT_LE(beside, std::max(0.0, wall - 1.5) + 0.02) << mm;
        widest = std::max(widest, beside);
        EXPECT_EQ(cameraOf(pose, {}, flight).position, pose.at);
    }
    EXPECT_NEAR(widest, 3.25, 0.05); // room that is there is used: the bound knows half a spacing less
    // a small request is granted in full
    EXPECT_NEAR(glm::length(cameraOf(curve.at(20), {0, 0, {1, 0}}, flight).position - curve.at(20).at), 1,
                1e-12);
}

/// The room of a camera beside the line is that of the places around it, whichever way one flies.
TEST(Flight, TheWayBackIsAsFree) {
    CentreLine line = helixLine(60, 0.73, 0);
    for (std::size_t i = 0; i < line.radiusMm.size(); ++i) // narrowest at its ends
        line.radiusMm[i] =
            3 + 2 * std::sin(M_PI * static_cast<double>(i) / static_cast<double>(line.radiusMm.size() - 1));
    Flight flight, back;
    back.backwards = true;
    const FlightCurve there({line}, flight), again({line}, back);
    for (double mm = 0; mm <= there.lengthMm(); mm += 0.31)
        EXPECT_NEAR(there.at(mm).freeMm, again.at(there.lengthMm() - mm).freeMm, 1e-6) << mm;
}

TEST(Flight, LooksAround) {
    const Pose pose{{1, 2, 3}, {0, 1, 0}, {0, 0, 1}, 5};
    Flight flight;
    flight.viewAngle = 130;
    const Camera right = cameraOf(pose, {90, 0, {0, 0}}, flight);
    EXPECT_LT(glm::length(glm::normalize(right.focalPoint - right.position) - glm::dvec3(1, 0, 0)), 1e-12);
    const Camera up = cameraOf(pose, {0, 60, {0, 0}}, flight);
    const glm::dvec3 view = glm::normalize(up.focalPoint - up.position);
    EXPECT_NEAR(view.z, std::sin(glm::radians(60.0)), 1e-12);
    EXPECT_NEAR(view.y, 0.5, 1e-12);
    EXPECT_NEAR(glm::dot(view, up.viewUp), 0, 1e-12);
    EXPECT_EQ(up.viewAngle, 130);
    for (const glm::dvec3& place : {glm::dvec3(4, 3, 5), glm::dvec3(-3, -9, 2), glm::dvec3(1, 2, 9)}) {
        const Camera at = cameraOf(pose, lookTowards(pose, place), flight);
        EXPECT_LT(glm::length(glm::normalize(at.focalPoint - at.position) - glm::normalize(place - pose.at)),
                  1e-12);
    }
}

TEST(Flight, BackwardsAndInPart) {
    Flight flight, back;
    flight.fromMm = back.fromMm = 30.3;
    flight.toMm = back.toMm = 90.1;
    back.backwards = true;
    const std::vector<CentreLine> lines = {helixLine(200, 1, 6)};
    const FlightCurve there(lines, flight), again(lines, back);
    EXPECT_NEAR(there.lengthMm(), 59.8, 0.05);
    EXPECT_NEAR(again.lengthMm(), there.lengthMm(), 1e-9);
    EXPECT_LT(glm::length(there.at(0).at - helix(30.3)), 0.02);
    for (double mm = 0; mm < 59; mm += 3.7)
        EXPECT_LT(glm::length(there.at(mm).at - again.at(there.lengthMm() - mm).at), 1e-3) << mm;
    EXPECT_LT(glm::dot(there.tangent(20), again.tangent(there.lengthMm() - 20)), -0.999);
}

/// A trunk and a branch at right angles: the corner is rounded, and stays within half the radius.
TEST(Flight, TakesABranchRoundTheCorner) {
    CentreLine trunk, branch;
    for (int i = 0; i <= 60; ++i) {
        trunk.points.emplace_back(0.5 * i, 0, 0);
        trunk.radiusMm.push_back(4);
        branch.points.emplace_back(20, 0.5 * i, 0);
        branch.radiusMm.push_back(3);
    }
    trunk.spacingMm = branch.spacingMm = 0.5;
    branch.parent = 0;
    branch.leavesAtMm = 20;
    Flight flight;
    flight.route = {0, 1};
    flight.lookAheadMm = 5;
    const FlightCurve curve({trunk, branch}, flight);
    EXPECT_NEAR(curve.lengthMm(), 50, 1.5);
    double sharpest = 0;
    for (double mm = 0.1; mm < curve.lengthMm(); mm += 0.1) {
        const glm::dvec3 p = curve.at(mm).at;
        const double off = p.x < 20 - p.y ? std::abs(p.y) : std::abs(p.x - 20);
        EXPECT_LE(off, 1.6) << mm;
        sharpest = std::max(sharpest, glm::length(curve.tangent(mm) - curve.tangent(mm - 0.1)) / 0.1);
    }
    EXPECT_LT(sharpest, 1 / 1.3); // a bend of more than 1.3 mm, where the corner had none
    EXPECT_GT(sharpest, 1 / 8.0);
}

TEST(Pace, EasesBetweenKeyframes) {
    using enum Easing;
    const Pace pace({0, 1, 2, 4, 5}, {0, 2, 3, 10, 11}, {through, linear, smooth, hold, through});
    double before = -1;
    for (double t = -0.5; t < 5.5; t += 0.01) {
        EXPECT_GE(pace.at(t).value, before - 1e-12) << t;
        before = pace.at(t).value;
    }
    EXPECT_EQ(pace.at(1).value, 2);
    EXPECT_EQ(pace.at(1).key, 1U);
    EXPECT_NEAR(pace.at(1.25).value, 2.25, 1e-12); // linear
    EXPECT_NEAR(pace.at(3).value, 6.5, 1e-12);     // smooth: half of it halfway
    EXPECT_NEAR(pace.at(2.01).value, 3, 1e-3);     // and at rest at its ends
    EXPECT_EQ(pace.at(4.9).value, 10);             // hold
    EXPECT_EQ(pace.at(5).value, 11);
    // through: the speed has no jump where both neighbours go through
    const Pace on({0, 1, 3}, {0, 1, 9}, {through, through, through});
    const double h = 1e-5;
    EXPECT_NEAR((on.at(1).value - on.at(1 - h).value) / h, (on.at(1 + h).value - on.at(1).value) / h, 1e-3);
}

Camera turntable(double degrees) {
    const double a = glm::radians(degrees);
    Camera camera;
    camera.focalPoint = {10, 20, 30};
    camera.position = camera.focalPoint + glm::dvec3(300 * std::sin(a), -300 * std::cos(a), 60);
    return camera;
}

TEST(Cameras, GoRoundWhatTheyLookAt) {
    std::vector<double> times;
    std::vector<Camera> cameras;
    for (int k = 0; k <= 4; ++k) {
        times.push_back(k);
        cameras.push_back(turntable(90 * k));
    }
    const CameraCurve curve(times, cameras, std::vector<Easing>(5, Easing::through), "test");
    for (std::size_t k = 0; k < 5; ++k)
        EXPECT_EQ(curve.at(static_cast<double>(k)), cameras[k]);
    const double far = glm::length(cameras[0].position - cameras[0].focalPoint);
    Camera before = curve.at(0);
    for (double t = 0.01; t < 4; t += 0.01) {
        const Camera c = curve.at(t);
        EXPECT_NEAR(glm::length(c.position - c.focalPoint), far, 1e-6 * far);
        EXPECT_LT(glm::length(c.focalPoint - cameras[0].focalPoint), 1e-9);
        const double way = glm::length(c.position - before.position);
        EXPECT_NEAR(way, 2 * M_PI * 300 / 400, 0.12 * way) << t; // all round in 400 steps, evenly
        EXPECT_NEAR(glm::dot(patientFromCamera(c)[0], glm::dvec3(0, 0, 1)), 0, 0.04) << t; // level
        before = c;
    }
    // from one side to the other: round it, not through it
    const CameraCurve across({0, 1}, {turntable(0), turntable(180)}, {Easing::linear, Easing::linear},
                             "test");
    for (double t = 0; t <= 1; t += 0.05)
        EXPECT_NEAR(glm::length(across.at(t).position - cameras[0].focalPoint), far, 1e-6 * far);
    std::vector<Camera> both = {turntable(0), turntable(90)};
    both[1].projection = Projection::parallel;
    EXPECT_THROW(CameraCurve({0, 1}, both, {Easing::linear, Easing::linear}, "p.json"), InputError);
}

TEST(Blend, FunctionsAreMixedValueByValue) {
    const TransferFunction a = TransferFunction::fromOpacity({{0, 0}, {100, 0}, {100, 0.8}, {300, 0.2}},
                                                             {{0, {1, 0, 0}}, {200, {0, 1, 0}}}, 2);
    const TransferFunction b =
        TransferFunction::fromOpacity({{-50, 0.1}, {150, 0.5}, {400, 1}}, {{100, {0, 0, 1}}}, 2);
    const TransferFunction m = blend(a, b, 0.25);
    const auto opacity = [](const TransferFunction& f, double v) {
        return -std::expm1(-2 * f.extinction(v));
    };
    for (const double v : {-100.0, -20.0, 50.0, 99.999, 100.0, 120.0, 150.0, 290.0, 350.0, 500.0}) {
        EXPECT_NEAR(opacity(m, v), 0.75 * opacity(a, v) + 0.25 * opacity(b, v), 1e-6) << v;
        EXPECT_LT(glm::length(m.colour(v) - (0.75 * a.colour(v) + 0.25 * b.colour(v))), 1e-12) << v;
    }
    EXPECT_EQ(blend(a, b, 0).opacityPoints().size(), a.opacityPoints().size());
    EXPECT_THROW(blend(a, TransferFunction::fromOpacity({{0, 1}}, {}, 1), 0.5), InputError);
    // Gradient opacity: point by point; none is 1 at the other's points.
    TransferFunction graded = b, other = b;
    graded.setGradientOpacity(GradientOpacity::fromPoints({{0, 0.5}, {40, 1}}));
    other.setGradientOpacity(GradientOpacity::fromPoints({{20, 0}, {60, 0.5}}));
    EXPECT_EQ(blend(a, graded, 0.5).gradientOpacity(), GradientOpacity::fromPoints({{0, 0.75}, {40, 1}}));
    EXPECT_EQ(blend(graded, a, 0.5).gradientOpacity(), GradientOpacity::fromPoints({{0, 0.75}, {40, 1}}));
    EXPECT_EQ(blend(graded, other, 0.5).gradientOpacity(),
              GradientOpacity::fromPoints({{10, 0.25}, {50, 0.75}}));
    EXPECT_TRUE(blend(a, b, 0.5).gradientOpacity().isOne());
}

TEST(Blend, LightsAndCuts) {
    Lighting a, b;
    a.lights = {{LightKind::directional, LightFrame::patient, {1, 0, 0}}};
    b.lights = {{LightKind::directional, LightFrame::patient, {0, 1, 0}}};
    b.lights[0].intensity = 3;
    const Lighting half = blend(a, b, 0.5);
    EXPECT_EQ(half.lights[0].intensity, 2);
    EXPECT_EQ(half.lights[0].direction, glm::dvec3(0.5, 0.5, 0));
    b.lights.push_back({});
    EXPECT_EQ(blend(a, b, 0.99).lights.size(), 1U); // another number: at the later keyframe
    EXPECT_EQ(blend(a, b, 1).lights.size(), 2U);
    Cuts low, high;
    low.planes = {{{0, 0, 0}, {0, 0, 2}, Keep::inside}};
    high.planes = {{{0, 0, 10}, {0, 0, 1}, Keep::inside}};
    EXPECT_EQ(blend(low, high, 0.3).planes[0].point, glm::dvec3(0, 0, 3));
    EXPECT_EQ(blend(low, high, 0.3).planes[0].normal, glm::dvec3(0, 0, 1));
}

TEST(Film, FramesFollowFromTheirNumbers) {
    Path path;
    path.lines = {helixLine(100, 1, 6)};
    path.flight = Flight{};
    path.flight->speedMmPerS = 10;
    path.framesPerSecond = 5;
    Keyframe first, second;
    first.placeMm = 20;
    first.easing = Easing::linear;
    first.transferFunction = std::string("bone");
    first.look = LookAround{};
    second.timeS = 4;
    second.transferFunction = TransferFunction::fromOpacity({{0, 1}}, {}, 1);
    second.look = LookAround{40, 0, {0, 0}};
    path.keyframes = {first, second};
    Scene scene;
    scene.volumes.push_back({"x.zarr", std::string("skin")});
    int asked = 0;
    const auto presets = [&](const std::string& name) {
        EXPECT_EQ(name, "bone");
        ++asked;
        return TransferFunction::fromOpacity({{0, 0.5}}, {}, 1);
    };
    const Film film(path, scene, presets, "p.json");
    EXPECT_EQ(film.frames(), 50U); // just less than 10 s: the curve cuts the polygon's corners
    EXPECT_FALSE(film.onlyCameraMoves());
    EXPECT_EQ(std::get<std::string>(film.scene(3).volumes[0].transferFunction), "bone"); // before the first
    EXPECT_EQ(asked, 0);
    const auto half = std::get<TransferFunction>(film.scene(15).volumes[0].transferFunction);
    EXPECT_NEAR(half.opacityPoints()[0].opacity, 0.75, 1e-12); // 3 s, between 2 s and 4 s
    EXPECT_EQ(
        std::get<TransferFunction>(film.scene(45).volumes[0].transferFunction).opacityPoints()[0].opacity, 1);
    for (const std::size_t i : {0U, 7U, 49U}) {
        const Camera camera = std::get<Camera>(film.scene(i).camera);
        EXPECT_LT(glm::length(camera.position - helix(2.0 * static_cast<double>(i))), 0.1) << i;
        EXPECT_EQ(camera, std::get<Camera>(Film(path, scene, presets, "p").scene(i).camera)) << i;
    }
    // 40 degrees to the right of the view without keyframes
    Path plain = path;
    plain.keyframes.clear();
    const Film straight(plain, scene, presets, "p");
    EXPECT_TRUE(straight.onlyCameraMoves());
    const Camera turned = std::get<Camera>(film.scene(30).camera),
                 ahead = std::get<Camera>(straight.scene(30).camera);
    EXPECT_NEAR(glm::dot(glm::normalize(turned.focalPoint - turned.position),
                         glm::normalize(ahead.focalPoint - ahead.position)),
                std::cos(glm::radians(40.0)), 1e-9);
    plain.flight.reset();
    EXPECT_THROW(Film(plain, scene, presets, "p"), InputError);
}

/// A keyframe at a place takes effect when the camera is at that place, on the way there and back.
TEST(Film, KeyframesAtPlacesComeWhereTheCameraIs) {
    for (const bool backwards : {false, true}) {
        Path path;
        path.lines = {helixLine(100, 1, 6)};
        path.flight = Flight{};
        path.flight->fromMm = 10, path.flight->toMm = 70;
        path.flight->speedMmPerS = 10;
        path.flight->backwards = backwards;
        path.framesPerSecond = 10;
        std::vector<double> places = {20, 40, 65};
        if (backwards)
            std::reverse(places.begin(), places.end());
        for (std::size_t n = 0; n < places.size(); ++n) {
            Keyframe key;
            key.placeMm = places[n];
            key.easing = Easing::linear;
            key.transferFunction = TransferFunction::fromOpacity({{0, 0.01 * places[n]}}, {}, 1);
            path.keyframes.push_back(key);
        }
        Scene scene;
        scene.volumes.push_back({"x.zarr", std::string("skin")});
        const Film film(path, scene, {}, "p.json");
        EXPECT_NEAR(film.seconds(), 6, 0.05) << "the curve cuts the polygon's corners";
        for (double time = 0; time < 6; time += 0.25) {
            const double place = backwards ? 70 - 10 * time : 10 + 10 * time;
            const auto function = std::get<TransferFunction>(film.sceneAt(time).volumes[0].transferFunction);
            EXPECT_NEAR(function.opacityPoints()[0].opacity, 0.01 * std::clamp(place, 20.0, 65.0), 1e-9)
                << time << (backwards ? " backwards" : "");
            EXPECT_LT(glm::length(film.cameraAt(time).position - helix(place)), 0.1) << time;
        }
    }
}

// A turntable's frames: as many as were asked for, at equal angles, at one distance.
TEST(Turntable, FramesGoAroundAtEqualAngles) {
    Camera first;
    first.position = {30, -500, 200};
    first.focalPoint = {30, 20, 80};
    for (const double degrees : {360.0, 90.0, -720.0, 200.0})
        for (const std::size_t frames : {2u, 7u, 120u}) {
            const Film film(turntable(first, degrees, frames, 30), Scene{}, {}, "turn");
            ASSERT_EQ(film.frames(), frames);
            const double whole = static_cast<double>(std::fmod(degrees, 360) == 0 ? frames : frames - 1);
            for (std::size_t n = 0; n < frames; ++n) {
                const Camera camera = film.cameraAt(film.timeOf(n));
                const glm::dvec3 at = camera.position - camera.focalPoint;
                EXPECT_LT(glm::length(camera.focalPoint - first.focalPoint), 1e-6);
                EXPECT_NEAR(at.z, 120, 1e-6) << "it neither rises nor falls";
                EXPECT_NEAR(glm::length(glm::dvec2(at)), 520, 1e-6);
                // From the front towards the patient's left, which is +x.
                const double angle = glm::radians(degrees * static_cast<double>(n) / whole);
                EXPECT_NEAR(at.x, 520 * std::sin(angle), 1e-5) << degrees << " " << n;
                EXPECT_NEAR(at.y, -520 * std::cos(angle), 1e-5) << degrees << " " << n;
                EXPECT_GT(camera.viewUp.z, 0.5);
            }
        }
    EXPECT_THROW(turntable(first, 0, 10, 25), InputError);
    EXPECT_THROW(turntable(first, std::nan(""), 10, 25), InputError);
    EXPECT_THROW(turntable(first, 360, 1, 25), InputError);
    EXPECT_THROW(turntable(first, 360, 10001, 25), InputError);
}

} // namespace
} // namespace tessera
