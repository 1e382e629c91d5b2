// tests/core/animation/blend_test.cpp: everything that goes over between keyframes does so by its share, ends
// are met exactly, and what cannot go over changes at the later keyframe.
#include "core/animation/blend.h"

#include "core/animation/film.h"
#include "core/base/error.h"

#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

void expectNear(const glm::dvec3& found, const glm::dvec3& expected) {
    EXPECT_LT(glm::length(found - expected), 1e-12) << found.x << " " << found.y << " " << found.z;
}

Lighting lit(double n) {
    Lighting lighting;
    Light light;
    light.kind = LightKind::point;
    light.frame = LightFrame::patient;
    light.direction = {n, 1, 2 * n};
    light.position = {10 * n, 20, 30 * n};
    light.attenuation = {1 + n, 0.1 * n, 0.01 * n};
    light.intensity = 1 + n;
    light.colour = {0.1 * n, 0.2, 0.1 + 0.1 * n};
    light.softness = 5 * n;
    light.scatter = 0.5 * n;
    lighting.lights = {Light{}, light};
    lighting.occlusion = Occlusion{OcclusionMethod::local, 32, 10 + n, n, 0.1 * n, 0.5 + 0.1 * n, 0.2 * n};
    lighting.occlusion->weights = DirectionWeights{{n, 2, 1 - n}, 3 * n};
    lighting.shadowMap = {ShadowMapKind::first, 0.25 + 0.125 * n, 2};
    lighting.scatterRadiusMm = 8 + n;
    lighting.lightMap = {64, 0.125 * n};
    lighting.surfaceOcclusion = SurfaceOcclusion{16, 12 + n, true};
    lighting.transport =
        Transport{TransportResponse::physical,
                  8,
                  {PhaseKind::henyeyGreenstein, 0.1 * n, -0.1 * n, 0.2 * n},
                  SurfaceScattering{{10 * n, 20 + 10 * n}, {0.1 * n, 0.2 + 0.1 * n, 0.2 * n, 3 * n}}};
    lighting.environment = Environment{Sky::twoTone,    1 + n,         {0.1 * n, 0.2, 0},
                                       {0, 0.2 * n, 1}, {n, 1, 2 * n}, {"/a/sky.hdr", nullptr},
                                       10 * n};
    return lighting;
}

TEST(BlendOfLights, EveryNumberGoesOverByItsShare) {
    const Lighting a = lit(0), b = lit(4);
    for (const double share : {0.25, 0.5, 0.875})
        EXPECT_EQ(blend(a, b, share), lit(4 * share)) << share; // all of these numbers are exact
    EXPECT_EQ(blend(a, b, 0), a);
    EXPECT_EQ(blend(a, b, 1), b);
    EXPECT_EQ(blend(a, b, -1), a);
    EXPECT_EQ(blend(a, b, 2), b);
}

TEST(BlendOfLights, WhatCannotGoOverStays) {
    const Lighting a = lit(0);
    const std::vector<std::function<void(Lighting&)>> changes = {
        [](Lighting& l) { l.lights[1].kind = LightKind::directional; },
        [](Lighting& l) { l.lights[1].frame = LightFrame::camera; },
        [](Lighting& l) { l.lights[1].shadow = true; }, [](Lighting& l) { l.lights.pop_back(); }};
    for (const auto& change : changes) {
        Lighting b = lit(4);
        change(b);
        EXPECT_EQ(blend(a, b, 0.5).lights, a.lights);
        EXPECT_EQ(blend(a, b, 0.5).occlusion, lit(2).occlusion) << "the rest goes over";
    }
    const std::vector<std::function<void(Lighting&)>> others = {
        [](Lighting& l) { l.occlusion->method = OcclusionMethod::positional; },
        [](Lighting& l) { l.occlusion->rays = 8; }, [](Lighting& l) { l.occlusion.reset(); }};
    for (const auto& change : others) {
        Lighting b = lit(4);
        change(b);
        EXPECT_EQ(blend(a, b, 0.5).occlusion, a.occlusion);
        EXPECT_EQ(blend(b, a, 0.5).occlusion, b.occlusion);
        EXPECT_EQ(blend(a, b, 0.5).lights, lit(2).lights);
    }
    Lighting b = lit(4);
    b.environment->sky = Sky::uniform;
    EXPECT_EQ(blend(a, b, 0.5).environment, a.environment);
    b.environment = lit(4).environment, b.environment->file.path = "/a/another.hdr";
    EXPECT_EQ(blend(a, b, 0.5).environment, a.environment);
    b.environment = lit(4).environment, b.environment->frame = LightFrame::camera;
    EXPECT_EQ(blend(a, b, 0.5).environment, a.environment);
    Lighting rays = a, maps = a; // a light that only rays scatter has no map to look up
    rays.scatterBy = ScatterSource::rays, maps.scatterBy = ScatterSource::map;
    rays.lights[0].scatter = 2, maps.lights[0].scatter = 0;
    EXPECT_EQ(blend(maps, rays, 0.5).lights[0].scatter, 0);
    maps.scatterBy = ScatterSource::rays;
    EXPECT_EQ(blend(maps, rays, 0.5).lights[0].scatter, 1);
    b.surfaceOcclusion->rays = 8;
    EXPECT_EQ(blend(a, b, 0.5).surfaceOcclusion, a.surfaceOcclusion);
    b.surfaceOcclusion.reset();
    EXPECT_EQ(blend(a, b, 0.5).surfaceOcclusion, a.surfaceOcclusion);
}

TransferFunction withMaterial(std::vector<Material> materials) {
    TransferFunction f = TransferFunction::fromOpacity({{0, 0}, {100, 1}}, {}, 1);
    f.setMaterials(std::move(materials), "test");
    return f;
}

TEST(BlendOfFunctions, MaterialsGoOverWhereTheirRangesAreTheSame) {
    const Material x{0, 50, 0.25, 0.5, 0.75, 10, {0, 0.5, 1}}, y{0, 50, 0.75, 0, 0.25, 21, {1, 0.5, 0}};
    const Material mean = blend(withMaterial({x}), withMaterial({y}), 0.5).materials()[0];
    EXPECT_EQ(mean, (Material{0, 50, 0.5, 0.25, 0.5, 16, {0.5, 0.5, 0.5}}));
    EXPECT_EQ(blend(withMaterial({x}), withMaterial({y}), 0.25).materials()[0].specularPower, 13);
    for (const auto& [from, to] : {std::pair{0.0, 60.0}, {-10.0, 50.0}}) {
        Material other = y;
        other.from = from, other.to = to;
        EXPECT_EQ(blend(withMaterial({x}), withMaterial({other}), 0.5).materials()[0], x) << from;
    }
    EXPECT_EQ(blend(withMaterial({x}), withMaterial({}), 0.5).materials().size(), 1u);
}

TEST(BlendOfFunctions, TissuesGoOverWhereTheirRangesAreTheSame) {
    const auto with = [](std::vector<Tissue> tissues) {
        TransferFunction f = withMaterial({});
        f.setTissues(std::move(tissues));
        return f;
    };
    const Tissue x{0, 50, Phase{PhaseKind::schlick, 0.5}, SurfaceFinish{0, 0.25, 0.5, 10}},
        y{0, 50, Phase{PhaseKind::schlick, -0.5}, SurfaceFinish{1, 0.75, 0, 30}}, bare{0, 50, {}, {}},
        other{0, 60, {}, {}};
    EXPECT_EQ(blend(with({x}), with({y}), 0.25).tissues(),
              (std::vector<Tissue>{
                  {0, 50, Phase{PhaseKind::schlick, 0.25}, SurfaceFinish{0.25, 0.375, 0.375, 15}}}));
    for (const Tissue& to : {bare, other})
        EXPECT_EQ(blend(with({x}), with({to}), 0.75).tissues(), std::vector<Tissue>{x});
}

/// A step of one function, between, before and after the other's points.
TEST(BlendOfFunctions, StepsStayStepsWithBothLimits) {
    const auto of = [](std::vector<OpacityPoint> points, std::vector<ColourPoint> colours) {
        return TransferFunction::fromExtinction(std::move(points), std::move(colours));
    };
    const TransferFunction a = of({{0, 1}, {10, 3}, {10, 5}, {20, 7}}, {{5, {1, 0, 0}}, {5, {0, 0, 1}}});
    for (const auto& b : {of({{-5, 2}, {30, 9}}, {{0, {0, 1, 0}}}), of({{10, 4}, {10, 6}, {10, 8}}, {}),
                          of({{12, 4}}, {{5, {0, 1, 0}}, {5, {1, 1, 1}}}), of({}, {})}) {
        // Points of extinction count as opacities here, which numbers above 1 do not survive: halve them.
        const auto scaled = [](const TransferFunction& f) {
            std::vector<OpacityPoint> points = f.opacityPoints();
            for (OpacityPoint& p : points)
                p.opacity /= 16;
            return TransferFunction::fromOpacity(points, f.colourPoints(), 1);
        };
        const TransferFunction x = scaled(a), y = scaled(b), m = blend(x, y, 0.25);
        const auto opacity = [](const TransferFunction& f, double v) {
            return -std::expm1(-f.extinction(v));
        };
        for (const double v :
             {-9.0, -5.0, 0.0, 4.999999, 5.0, 7.0, 9.999999, 10.0, 11.0, 12.0, 19.0, 20.0, 40.0}) {
            EXPECT_NEAR(opacity(m, v), 0.75 * opacity(x, v) + 0.25 * opacity(y, v), 1e-6) << v;
            expectNear(m.colour(v), 0.75 * x.colour(v) + 0.25 * y.colour(v));
        }
    }
}

TEST(BlendOfCuts, BoxesGoOverSideBySide) {
    Cuts a, b;
    a.boxes = {{{0, 10, 20}, {100, 110, 120}}, {{1, 2, 3}, {4, 5, 6}, CropBox::Space::voxels, Keep::outside}};
    b.boxes = {{{8, 18, 24}, {120, 118, 124}},
               {{5, 6, 7}, {8, 13, 10}, CropBox::Space::voxels, Keep::outside}};
    const Cuts m = blend(a, b, 0.25);
    ASSERT_EQ(m.boxes.size(), 2u);
    EXPECT_EQ(m.boxes[0], (CropBox{{2, 12, 21}, {105, 112, 121}}));
    EXPECT_EQ(m.boxes[1], (CropBox{{2, 3, 4}, {5, 7, 7}, CropBox::Space::voxels, Keep::outside}));
    EXPECT_EQ(blend(a, b, 1), b);
    EXPECT_EQ(blend(a, b, 0), a);
    b.boxes[1].keep = Keep::inside;
    EXPECT_EQ(blend(a, b, 0.5).boxes, a.boxes);
    b.boxes[1].keep = Keep::outside, b.boxes[0].space = CropBox::Space::voxels;
    EXPECT_EQ(blend(a, b, 0.5).boxes, a.boxes);
    a.planes = {{{0, 0, 0}, {0, 0, 4}, Keep::inside}}, b.planes = {{{4, 8, 0}, {2, 0, 0}, Keep::inside}};
    EXPECT_EQ(blend(a, b, 0.5).planes[0], (CutPlane{{2, 4, 0}, {0.5, 0, 0.5}, Keep::inside}));
    b.planes[0].normal = {0, 0, -1};
    EXPECT_EQ(blend(a, b, 0.5).planes[0].normal, glm::dvec3(0, 0, 1)) << "opposite ones have no middle";
    b.planes[0].keep = Keep::outside;
    EXPECT_EQ(blend(a, b, 0.5).planes, a.planes);
}

/// A natural spline: through its values, continuous in slope and curvature, straight at its ends, and exact
/// for what is linear.
TEST(Splines, AreSmoothThroughTheirValues) {
    const std::vector<double> places = {0, 1, 2.5, 3, 7};
    std::vector<std::vector<double>> values;
    for (const double p : places)
        values.push_back({3 * p - 2, std::sin(2 * p)});
    const Spline spline(places, values);
    constexpr double h = 1e-4;
    const auto second = [&](double p) {
        return (spline.at(p + h)[1] - 2 * spline.at(p)[1] + spline.at(p - h)[1]) / (h * h);
    };
    for (std::size_t i = 0; i < places.size(); ++i)
        EXPECT_NEAR(spline.at(places[i])[1], values[i][1], 1e-12);
    for (double p = 0; p <= 7; p += 0.13)
        EXPECT_NEAR(spline.at(p)[0], 3 * p - 2, 1e-9);
    for (const double p : {1.0, 2.5, 3.0}) {
        const double before = (spline.at(p)[1] - spline.at(p - h)[1]) / h,
                     after = (spline.at(p + h)[1] - spline.at(p)[1]) / h;
        EXPECT_NEAR(before, after, 1e-2 * (1 + std::abs(after)));
        EXPECT_NEAR(second(p - 3 * h), second(p + 3 * h), 1e-2 * (1 + std::abs(second(p))));
    }
    EXPECT_NEAR(second(2 * h), 0, 1e-2);
    EXPECT_NEAR(second(7 - 2 * h), 0, 1e-2);
    EXPECT_EQ(spline.at(-3), spline.at(0));
    EXPECT_EQ(spline.at(9), spline.at(7));
    EXPECT_EQ(Spline({2}, {{5, 6}}).at(100), (std::vector<double>{5, 6}));
}

Camera lookingFrom(const glm::dvec3& position, const glm::dvec3& up) {
    Camera camera;
    camera.position = position;
    camera.focalPoint = {1, 2, 3};
    camera.viewUp = up;
    camera.viewAngle = 40;
    camera.parallelScale = 70;
    return camera;
}

/// Keyframes' cameras come back from the curve whatever way they look: each axis of the frame is the longest
/// once.
TEST(CameraCurves, MeetTheirKeyframesWhereverTheyLook) {
    std::vector<Camera> cameras;
    for (const glm::dvec3 way : {glm::dvec3(0, -300, 0),
                                 {0, 300, 0},
                                 {300, 0, 0},
                                 {-300, 0, 0},
                                 {0, 1, 300},
                                 {0, 1, -300},
                                 {200, -100, 90}})
        for (const glm::dvec3 up : {glm::dvec3(0.1, 0.2, 1), {0.1, 0.3, -1}, {1, 0.9, 0.2}, {-1, 0.9, 0.1}})
            cameras.push_back(lookingFrom(glm::dvec3(1, 2, 3) + way, up));
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        cameras[i].viewAngle = 30 + static_cast<double>(i);
        cameras[i].parallelScale = 50 + 3 * static_cast<double>(i);
    }
    std::vector<double> times;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        times.push_back(2 * static_cast<double>(i));
    const CameraCurve curve(times, cameras, std::vector<Easing>(cameras.size(), Easing::linear), "test");
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const Camera exact = curve.at(times[i]);
        EXPECT_EQ(exact, cameras[i]);
        if (i + 1 == cameras.size())
            break;
        const Camera near = curve.at(times[i] + 1e-7); // not the keyframe, but the curve beside it
        EXPECT_LT(glm::length(near.position - exact.position), 1e-2) << i;
        EXPECT_LT(glm::length(near.focalPoint - exact.focalPoint), 1e-2);
        const glm::dmat3 a = patientFromCamera(near), b = patientFromCamera(exact);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_LT(glm::length(a[axis] - b[axis]), 1e-4) << i << " " << axis;
        EXPECT_NEAR(near.viewAngle, exact.viewAngle, 1e-3);
        EXPECT_NEAR(near.parallelScale, exact.parallelScale, 1e-2);
    }
}

/// Three cameras side by side that look the same way: between them the camera goes along their line, as fast
/// all the way from one to the next, however far apart they are and however wide they see.
TEST(CameraCurves, GoStraightAndEvenlyAlongALine) {
    const glm::dvec3 way = glm::normalize(glm::dvec3(2, -1, 0.5));
    for (const double angle : {10.0, 40.0, 120.0}) {
        std::vector<Camera> cameras(3, lookingFrom({1, -300, 3}, {0, 0, 1}));
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3 off = way * std::array{0.0, 10.0, 100.0}[i];
            cameras[i].position += off, cameras[i].focalPoint += off;
            cameras[i].viewAngle = angle;
        }
        const CameraCurve curve({0, 1, 2}, cameras, std::vector<Easing>(3, Easing::linear), "test");
        for (double t = 0; t < 2; t += 0.125) {
            const double along = t < 1 ? 10 * t : 10 + 90 * (t - 1);
            EXPECT_LT(glm::length(curve.at(t).position - cameras[0].position - along * way), 1e-6) << t;
            EXPECT_NEAR(curve.at(t).viewAngle, angle, 1e-9);
        }
    }
}

/// Turned paths are turned films: a symmetry.
TEST(CameraCurves, TurnWithTheirKeyframes) {
    const auto turned = [](const glm::dvec3& v) { return glm::dvec3(v.y, v.z, v.x); };
    std::vector<Camera> cameras = {lookingFrom({1, -300, 3}, {0, 0, 1}),
                                   lookingFrom({250, 40, 60}, {0, 0.2, 1}),
                                   lookingFrom({100, 200, 200}, {0.3, 0, 1})};
    cameras[1].focalPoint = {10, 0, 5};
    std::vector<Camera> others = cameras;
    for (Camera& c : others)
        c.position = turned(c.position), c.focalPoint = turned(c.focalPoint), c.viewUp = turned(c.viewUp);
    const std::vector<Easing> easings = {Easing::through, Easing::smooth, Easing::through};
    const CameraCurve a({0, 1, 3}, cameras, easings, "a"), b({0, 1, 3}, others, easings, "b");
    for (double t = 0; t <= 3; t += 0.1) {
        expectNear(1e-9 * turned(a.at(t).position), 1e-9 * b.at(t).position);
        EXPECT_LT(glm::length(turned(a.at(t).position) - b.at(t).position), 1e-6) << t;
        EXPECT_LT(glm::length(turned(a.at(t).focalPoint) - b.at(t).focalPoint), 1e-6) << t;
        EXPECT_LT(glm::length(turned(patientFromCamera(a.at(t))[1]) - patientFromCamera(b.at(t))[1]), 1e-6)
            << t;
    }
}

TEST(Turns, HaveTheirFramesAtTheirMoments) {
    const Camera first = lookingFrom({1, -297, 103}, {0, 0, 1});
    for (const double degrees : {360.0, -90.0, 720.0, 45.0}) {
        const Path path = turntable(first, degrees, 7, 12.5);
        ASSERT_EQ(path.keyframes.size(), 7u);
        EXPECT_EQ(path.framesPerSecond, 12.5);
        const double step = degrees / (std::fmod(degrees, 360) == 0 ? 7 : 6);
        for (std::size_t n = 0; n < 7; ++n) {
            const double angle = glm::radians(step * static_cast<double>(n));
            EXPECT_DOUBLE_EQ(*path.keyframes[n].timeS, static_cast<double>(n) / 12.5);
            const glm::dvec3 way = path.keyframes[n].camera->position - first.focalPoint;
            expectNear(1e-3 * way, 1e-3 * glm::dvec3(299 * std::sin(angle), -299 * std::cos(angle), 100));
        }
        EXPECT_EQ(Film(path, Scene{}, {}, "f").frames(), 7u);
    }
    EXPECT_EQ(turntable(first, 3600, 2, 1).keyframes.size(), 2u);
    EXPECT_THROW(turntable(first, 3601, 2, 1), InputError);
    EXPECT_THROW(turntable(first, 0, 2, 1), InputError);
    EXPECT_THROW(turntable(first, 90, 1, 1), InputError);
    EXPECT_EQ(turntable(first, 90, Path::kMostKeyframes, 1).keyframes.size(), Path::kMostKeyframes);
    EXPECT_THROW(turntable(first, 90, Path::kMostKeyframes + 1, 1), InputError);
}

TEST(Flights, AreWhatTheyAreWithoutAWord) {
    const Flight flight;
    EXPECT_EQ(flight.route, std::vector<std::size_t>{0});
    EXPECT_FALSE(flight.backwards);
    EXPECT_EQ(flight.fromMm, 0);
    EXPECT_FALSE(flight.toMm);
    EXPECT_EQ(flight.speedMmPerS, 20);
    EXPECT_EQ(flight.viewAngle, 90);
    EXPECT_EQ(flight.lookAheadMm, 15);
    EXPECT_EQ(flight.clearanceMm, 1);
    EXPECT_EQ(Path{}.framesPerSecond, 25);
}

} // namespace
} // namespace tessera
