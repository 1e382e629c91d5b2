// tests/render/contract/lights_test.cpp: the scene's own lights, by numbers that stand in this file and come
// from no code of ours. Planes that are known in patient space (lit_planes.h) are seen at an angle of 3, 4
// and 5, under lights at similarly simple angles. All engines draw them.
#include "render/backends/reference/reference.h"
#include "tests/support/lights.h"
#include "tests/support/lit_planes.h"
#include "tests/support/native_fixture.h"

#include <cmath>
#include <gtest/gtest.h>
#include <iterator>

namespace tessera {
namespace {

using namespace tessera::test;

/// The view is at this angle to the normal: in the camera's frame the normal is (0.6, 0, 0.8).
constexpr double kCosine = 0.8, kSine = 0.6;
constexpr double kAmbient = 0.1, kDiffuse = 0.6, kSpecular = 0.2; // of Planes::scene(), to the power of 3

Light directional(LightFrame frame, const glm::dvec3& direction, double intensity = 1,
                  const glm::dvec3& colour = glm::dvec3(1)) {
    Light light{LightKind::directional, frame, direction};
    light.intensity = intensity;
    light.colour = colour;
    return light;
}

/// A light and what it does on the planes, worked out by hand: n.l, and the cosine of its highlight.
struct Case {
    const char* name;
    Light light;
    double facing, phong, blinn;
};
const double kRootOf98 = 0.98994949366116653, kRootOf90 = 0.94868329805051381;
const Case kCases[] = {
    // r.v = 2 (n.l)(n.v) - l.v; n.h = (n.l + n.v) / |l + v|
    {"towards the viewer", directional(LightFrame::camera, {0, 0, 2}), 0.8, 0.28, 0.8},
    {"from the right", directional(LightFrame::camera, {1, 0, 0}), 0.6, 0.96, kRootOf98},
    {"from above and behind", directional(LightFrame::camera, {0, 4, -3}), 0, 0, 0},
    {"from the left", directional(LightFrame::camera, {-1, 0, 0}), 0, 0, 0},
    {"on the normal", directional(LightFrame::camera, {3, 0, 4}), 1, 0.8, kRootOf90},
    {"on the normal, patient", directional(LightFrame::patient, {1, 2, 2}), 1, 0.8, kRootOf90},
    {"behind, patient", directional(LightFrame::patient, {-1, -2, -2}), 0, 0, 0},
    {"none", directional(LightFrame::camera, {0, 0, 0}), 0, 0, 0},
    {"head", Light{}, 0.8, 0.28, 0.8},
};

/// Light as it should be, of a colour.
struct Sums {
    glm::dvec3 everywhere{0}, facing{0}, shine{0};
    void add(const Case& c, const glm::dvec3& power, ShadingModel model, int exponent = 3) {
        everywhere += power;
        facing += power * c.facing;
        shine += power * std::pow(model == ShadingModel::phong ? c.phong : c.blinn, exponent);
    }
    glm::dvec3 lit(double weight = 1, double ambient = kAmbient, double diffuse = kDiffuse,
                   double specular = kSpecular) const {
        const glm::dvec3 volume = kColour * (ambient + diffuse * everywhere);
        const glm::dvec3 surface = kColour * (ambient + diffuse * facing) + specular * shine;
        return volume + weight * (surface - volume);
    }
};

/// A medium of one colour, whatever its extinction does along the ray.
void setMedium(Scene& scene, double slope = 1) {
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
        {{-2 * std::abs(slope), 0}, {-0.6 * std::abs(slope), 0.9}, {2 * std::abs(slope), 0}}, {{0, kColour}});
}

Image referencePicture(const Scene& scene, Planner& p) {
    return pictureOf(renderReference({p.layer().cache.get(),
                                      &p.info(),
                                      &p.layer().function,
                                      scene.shading,
                                      nullptr,
                                      1,
                                      scene.surfaces,
                                      {},
                                      scene.lighting,
                                      p.view.camera},
                                     referenceRays(p.view.camera, p.info(), p.view.imageSize), 1));
}
Image doublePicture(const FramePlan& p) {
    Work work;
    return pictureOf(mirrorRays<double>(mirrorInput(p, true), 49, frameRays(p.view.frame), 1, work));
}

/// Every engine draws it lit so, everywhere.
void expectAllLit(const Planes& planes, const Scene& scene, const glm::dvec3& lit, double tolerance = 2e-5) {
    const auto prepared = planes.prepare(scene);
    Planner& p = prepared->p;
    expectLit(marchOn(*prepared, marchFeatures(p, true)).image, lit, tolerance, "march");
    const Image mirror = mirrorPicture(*prepared);
    expectLit(mirror, lit, tolerance, "float mirror");
    expectLit(doublePicture(p), lit, 1e-6, "double mirror");
    for (const native::PacketTarget* target : nativeTargets()) {
        NativeChoices choices;
        choices.target = target;
        EXPECT_EQ(differing(nativePicture(*prepared, choices).image, mirror), 0u) << target->name;
    }
    p.openCache();
    expectLit(referencePicture(scene, p), lit, 1e-6, "reference");
}

TEST(LitPlane, EveryLightOfTheScenesOwn) {
    const GlContext context({"software"});
    for (std::size_t i = 0; i < std::size(kCases); ++i) {
        const Case& c = kCases[i];
        const Planes planes(kSpaces[i % std::size(kSpaces)].patientFromVoxel);
        for (const ShadingModel model : {ShadingModel::phong, ShadingModel::blinnPhong}) {
            SCOPED_TRACE(testing::Message()
                         << c.name << ", " << shadingModelNames()[static_cast<std::size_t>(model)]);
            Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::parallel);
            setMedium(scene);
            scene.shading.model = model;
            scene.shading.gradient = kKinds[i % std::size(kKinds)];
            scene.lighting.lights = {c.light};
            scene.lighting.lights[0].intensity = 1.5;
            scene.lighting.lights[0].colour = {1, 0.5, 0.25};
            Sums sums;
            sums.add(c, {1.5, 0.75, 0.375}, model);
            expectAllLit(planes, scene, sums.lit());
        }
    }
}

// A surface's normal is on the viewer's side, and light from behind it is none.
TEST(LitPlane, FromBehindTheNormalIsTurned) {
    const GlContext context({"software"});
    const Planes planes(kSpaces[2].patientFromVoxel);
    Scene scene = planes.scene(-kCosine, kSine, 0.5, Projection::parallel);
    setMedium(scene);
    // The normal that faces the viewer is (-0.6, 0, 0.8), and against the planes' own.
    scene.lighting.lights = {directional(LightFrame::camera, {-1, 0, 0}, 1, {1, 0, 0}),
                             directional(LightFrame::camera, {1, 0, 0}, 1, {0, 1, 0}),
                             directional(LightFrame::patient, {-1, -2, -2}, 1, {0, 0, 1})};
    Sums sums;
    sums.add(kCases[1], {1, 0, 0}, ShadingModel::phong);
    sums.add(kCases[3], {0, 1, 0}, ShadingModel::phong);
    sums.add(kCases[5], {0, 0, 1}, ShadingModel::phong);
    expectAllLit(planes, scene, sums.lit());
}

TEST(LitPlane, LightsAddUpAndTheDarkAreLeftOut) {
    const GlContext context({"software"});
    const Planes planes(kSpaces[1].patientFromVoxel);
    Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::parallel);
    setMedium(scene);
    scene.lighting.lights = {directional(LightFrame::camera, {0, 0, 1}, 0),
                             directional(LightFrame::camera, {1, 0, 0}, 0.5, {0.2, 1, 0.4}),
                             directional(LightFrame::patient, {1, 2, 2}, 0.25), Light{}};
    Sums sums;
    sums.add(kCases[1], {0.1, 0.5, 0.2}, ShadingModel::phong);
    sums.add(kCases[5], glm::dvec3(0.25), ShadingModel::phong);
    sums.add(kCases[8], glm::dvec3(1), ShadingModel::phong);
    expectAllLit(planes, scene, sums.lit());
    EXPECT_EQ(planes.prepare(scene)->p.layer().optics.lighting.count, 3);
    for (Light& light : scene.lighting.lights)
        light.intensity = 0;
    expectAllLit(planes, scene, kColour * kAmbient);
}

// A plane's gradient is the slope of what is stored, in physical units per mm.
TEST(LitPlane, WeakGradientsAreLitAsAVolume) {
    const GlContext context({"software"});
    const struct {
        double slope, low, high, weight;
    } cases[] = {{1, 0.5, 1.5, 0.5},      // half way
                 {2, 1.5, 3.5, 0.15625},  // t = 1/4: 3/16 - 2/64
                 {-2, 0.5, 2.5, 0.84375}, // t = 3/4: 27/16 - 54/64
                 {2, 2.5, 3, 0},          {2, 1, 1.5, 1}, {2, 1.9, 1.9, 1}, {2, 2.1, 2.1, 0}};
    for (const auto& c : cases) {
        SCOPED_TRACE(testing::Message() << c.slope << ", " << c.low << " to " << c.high);
        const Planes planes(kSpaces[2].patientFromVoxel, c.slope);
        Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::parallel);
        setMedium(scene, c.slope);
        scene.shading.gradientWeight = GradientWeight{c.low, c.high};
        Sums sums;
        sums.add(kCases[8], glm::dvec3(1), ShadingModel::phong);
        expectAllLit(planes, scene, sums.lit(c.weight));
    }
}

TEST(LitPlane, MaterialsAnswerByTheirValues) {
    const GlContext context({"software"});
    const Planes planes(kSpaces[3].patientFromVoxel);
    const Material shiny{-3, 3, 0.3, 0.5, 0.4, 2}, elsewhere{3, 9, 1, 1, 1, 9};
    Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::parallel);
    scene.lighting.lights = {kCases[5].light};
    Sums sums;
    sums.add(kCases[5], glm::dvec3(1), ShadingModel::phong, 2);
    Sums plain;
    plain.add(kCases[5], glm::dvec3(1), ShadingModel::phong);
    for (const Integrator integrator :
         {Integrator::midpoint, Integrator::linear, Integrator::preintegrated}) {
        scene.quality.integrator = integrator;
        for (const bool inside : {true, false}) {
            SCOPED_TRACE(integratorNames()[static_cast<std::size_t>(integrator)]);
            setMedium(scene);
            auto& function = std::get<TransferFunction>(scene.volumes[0].transferFunction);
            function.setMaterials(inside ? std::vector{elsewhere, shiny} : std::vector{elsewhere});
            // Pre-integration takes one colour for one, to rounding of its sums.
            expectAllLit(planes, scene, inside ? sums.lit(1, 0.3, 0.5, 0.4) : plain.lit(), 5e-5);
        }
    }
    // Of values that the function's points do not reach: a dense medium, entered at a value above 20.
    for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated}) {
        SCOPED_TRACE(integratorNames()[static_cast<std::size_t>(integrator)]);
        scene.quality.integrator = integrator;
        auto function = TransferFunction::fromExtinction({{0, 50}, {1, 50}}, {{0, kColour}});
        function.setMaterials({{5, 100, 0.5, 0, 0, 1}});
        scene.volumes[0].transferFunction = function;
        expectAllLit(planes, scene, 0.5 * kColour);
    }
    // Surfaces by their own values: the border belongs to the range that begins there.
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    auto& function = std::get<TransferFunction>(scene.volumes[0].transferFunction);
    const Material dull{-1, 0.5, 0.2, 0.2, 0, 1};
    function.setMaterials({dull, {0.5, 2, 0.3, 0.5, 0.4, 2}});
    const auto colourOf = [&](double value) {
        return value < -1    ? plain.lit()
               : value < 0.5 ? plain.lit(1, 0.2, 0.2, 0)
                             : sums.lit(1, 0.3, 0.5, 0.4);
    };
    for (const double value : {-1.5, -0.25, 0.5, 1.0}) {
        SCOPED_TRACE(value);
        scene.surfaces = {{value, kColour, 1}};
        expectAllLit(planes, scene, colourOf(value));
    }
}

// A medium of one extinction, whose halves are of two materials: what lies behind is seen through what lies
// before it.
TEST(LitPlane, MaterialsChangeInSteps) {
    const Planes planes(kSpaces[0].patientFromVoxel);
    Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::parallel);
    const double extinction = 0.3, thickness = 2 / kCosine;
    auto function = TransferFunction::fromExtinction({{-2, 0}, {-2, extinction}, {2, extinction}, {2, 0}},
                                                     {{0, kColour}});
    function.setMaterials({{0, 5, 0.5, 0, 0, 1}, {-5, 0, 0, 1, 0, 1}});
    scene.volumes[0].transferFunction = function;
    scene.lighting.lights = {kCases[1].light};
    const double through = std::exp(-extinction * thickness);
    const glm::dvec3 colour = kColour * ((1 - through) * 0.5 + through * (1 - through) * kCases[1].facing) /
                              (1 - through * through);
    const auto prepared = planes.prepare(scene);
    expectLit(referencePicture(scene, prepared->p), colour, 1e-6, "reference");
    // Half a segment's width of the step is on the wrong side.
    expectLit(doublePicture(prepared->p), colour, 0.01, "double mirror");
}

// A point light is known on one ray: through the picture's middle, onto a plane at 0.4 mm.
TEST(LitPlane, PointLights) {
    const GlContext context({"software"});
    const double eye = 300, hit = 0.4 / kCosine; // mm from the focal point
    const glm::dvec3 attenuation(2, 0.1, 0.01);  // at 20 mm: 1/8
    for (const bool withCamera : {true, false})
        for (const bool onNormal : {true, false}) {
            SCOPED_TRACE(testing::Message() << withCamera << onNormal);
            const Planes planes(kSpaces[withCamera ? 2 : 3].patientFromVoxel);
            Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::parallel);
            scene.surfaces = {{0.4, kColour, 1}};
            const Camera camera = std::get<Camera>(scene.camera);
            const glm::dvec3 towards = kCosine * kNormal + kSine * kAlong;
            Light light{LightKind::point, withCamera ? LightFrame::camera : LightFrame::patient};
            light.attenuation = attenuation;
            light.intensity = 4;
            // On the normal, or to the picture's right, which in patient space is 0.6 n - 0.8 along.
            if (withCamera)
                light.position = glm::dvec3(0, 0, hit - eye) +
                                 20.0 * (onNormal ? glm::dvec3(0.6, 0, 0.8) : glm::dvec3(1, 0, 0));
            else
                light.position = camera.focalPoint + hit * towards +
                                 20.0 * (onNormal ? kNormal : kSine * kNormal - kCosine * kAlong);
            scene.lighting.lights = {light};
            Sums sums;
            sums.add(kCases[onNormal ? 4 : 1], glm::dvec3(0.5), ShadingModel::phong);
            const auto prepared = planes.prepare(scene);
            Planner& p = prepared->p;
            const auto middle = [&](const Image& image, double tolerance, const char* who) {
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(static_cast<double>(image.pixels[24][c]), sums.lit()[c], tolerance) << who;
            };
            middle(draw(*prepared).image, 2e-5, "march");
            const Image mirror = mirrorPicture(*prepared);
            middle(mirror, 2e-5, "float mirror");
            EXPECT_EQ(differing(nativePicture(*prepared).image, mirror), 0u);
            middle(doublePicture(p), 1e-6, "double mirror");
            p.openCache();
            middle(referencePicture(scene, p), 1e-6, "reference");
        }
}

// In a medium a point light's direction changes along the ray: what all steps tend to is the reference.
TEST(LitPlane, APointLightInsideAMedium) {
    const Planes planes(kSpaces[0].patientFromVoxel);
    Scene scene = planes.scene(kCosine, kSine, 4, Projection::parallel);
    setMedium(scene);
    const Camera camera = std::get<Camera>(scene.camera);
    Light light{LightKind::point, LightFrame::patient};
    light.position = camera.focalPoint + 0.7 * kNormal + 2.0 * kAside;
    light.attenuation = {1, 0.1, 0.05};
    scene.lighting.lights = {light};
    std::vector<double> errors;
    for (const double step : {0.25, 0.125, 0.0625}) {
        scene.quality.stepVoxels = step;
        const auto prepared = planes.prepare(scene);
        const Image mirror = doublePicture(prepared->p), truth = referencePicture(scene, prepared->p);
        double squares = 0;
        for (std::size_t i = 0; i < 49; ++i)
            for (int c = 0; c < 3; ++c)
                squares += std::pow(
                    static_cast<double>(mirror.pixels[i][c]) - static_cast<double>(truth.pixels[i][c]), 2);
        errors.push_back(std::sqrt(squares / 147));
    }
    EXPECT_LT(errors[0], 2e-2);
    EXPECT_LT(errors[1], 0.7 * errors[0]);
    EXPECT_LT(errors[2], 0.7 * errors[1]);
}

template <typename Real> void expectNoLightAtTheLightItself() {
    VolumeInfo info;
    info.patientFromVoxel = glm::dmat4(1);
    Lighting lighting;
    lighting.lights = {Light{LightKind::point, LightFrame::patient, {}, {1, 2, 3}, {0.5, 7, 9}}};
    Optics o = makeOptics(TransferTable{}, info, {}, 0);
    setLighting(o, {}, lighting, {}, {}, info);
    using Vec = glm::vec<3, Real>;
    const leaf::Material<Real> m{Real(0.25), Real(0.5), Real(0.125), 3};
    const Vec colour(Real(0.5)), gradient(1, 2, 3), direction(0, 0, 1);
    EXPECT_EQ(shade(o, colour, gradient, direction, Vec(1, 2, 3), m), colour * Real(0.25));
    // Without a gradient it is a volume's: 0.25 + 0.5 * 1/0.5.
    EXPECT_EQ(shade(o, colour, Vec(0), direction, Vec(1, 2, 3), m), colour * Real(1.25));
    // And halfway between a light behind and the viewer there is nothing.
    o.lighting.model.halfway = 1;
    o.lighting.lights[0] = {leaf::LightSort::directional, {0, 0, 1}, {1, 1, 1}, {1, 0, 0}};
    EXPECT_EQ(shade(o, colour, gradient, direction, Vec(1, 2, 3), m), colour * Real(0.25));
}
TEST(LitPlane, ALightAtTheSampleItselfIsFinite) {
    expectNoLightAtTheLightItself<float>();
    expectNoLightAtTheLightItself<double>();
}

// The most light that is possible, from a lamp inside a medium with and without a gradient: the picture is
// finite and no brighter than the stated bound.
TEST(LitPlane, TheMostLightThereCanBeIsFinite) {
    const GlContext context({"software"});
    const Planes planes(kSpaces[2].patientFromVoxel);
    Scene scene = planes.scene(kCosine, kSine, 4, Projection::perspective);
    const Camera camera = std::get<Camera>(scene.camera);
    Light lamp{LightKind::point, LightFrame::patient};
    lamp.position = camera.focalPoint;
    lamp.attenuation = {1e-6, 1e6, 1e6};
    lamp.intensity = 1e6;
    Light sun = directional(LightFrame::patient, {1e7, -1e7, 1e7}, 1e6);
    Light far{LightKind::point, LightFrame::camera, {}, {1e7, -1e7, 1e7}};
    scene.lighting.lights = {lamp, sun, far, Light{}};
    for (const bool weighed : {false, true}) {
        setMedium(scene);
        if (weighed)
            scene.shading.gradientWeight = GradientWeight{1e9, 1e9};
        const double most = brightest(scene.shading, scene.lighting);
        EXPECT_GT(most, 1e11);
        const auto prepared = planes.prepare(scene);
        const Image march = marchOn(*prepared, marchFeatures(prepared->p, true)).image,
                    mirror = mirrorPicture(*prepared);
        EXPECT_EQ(differing(nativePicture(*prepared).image, mirror), 0u);
        prepared->p.openCache();
        for (const Image& image : {march, mirror, referencePicture(scene, prepared->p)})
            for (const glm::vec4& pixel : image.pixels)
                for (int c = 0; c < 3; ++c) {
                    EXPECT_GE(pixel[c], 0.0f);
                    EXPECT_LE(static_cast<double>(pixel[c]),
                              most * static_cast<double>(pixel.a) * (1 + 1e-5));
                    EXPECT_GT(pixel[c], 100.0f) << "a sun of a million";
                }
    }
}

// Settings without effect are none: one head light, named in the scene, is the program of a scene without
// lights.
TEST(LitPlane, AHeadLightThatIsNamedIsTheOneThatIsNot) {
    const GlContext context({"software"});
    const Planes planes(kSpaces[2].patientFromVoxel);
    Scene scene = planes.scene(kCosine, kSine, 0.5, Projection::perspective);
    setMedium(scene);
    const auto without = planes.prepare(scene);
    scene.lighting.lights = {Light{}, directional(LightFrame::patient, {1, 0, 0}, 0)};
    const auto with = planes.prepare(scene);
    EXPECT_EQ(marchFeatures(with->p, false), marchFeatures(without->p, false));
    EXPECT_TRUE(bitEqual(marchOn(*with, marchFeatures(with->p, false)).image,
                         marchOn(*without, marchFeatures(without->p, false)).image));
    EXPECT_TRUE(bitEqual(mirrorPicture(*with), mirrorPicture(*without)));
    // Other lights are another program; a head light among them draws the same to rounding.
    scene.lighting.lights[1].intensity = 1e-9;
    const auto many = planes.prepare(scene);
    EXPECT_EQ(marchFeatures(many->p, false) ^ marchFeatures(with->p, false), std::uint32_t{kFeatureLights});
    const Image plain = mirrorPicture(*without), same = mirrorPicture(*many);
    for (std::size_t i = 0; i < plain.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c)
            EXPECT_NEAR(plain.pixels[i][c], same.pixels[i][c], 1e-6f);
}

} // namespace
} // namespace tessera
