// tests/core/scene/scene_test.cpp: scenes read strictly and written back without loss, the published schema,
// presets.
#include "core/scene/scene.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/nearest_name.h"
#include "core/scene/look.h"
#include "core/scene/preset.h"
#include "core/scene/preset_file.h"
#include "tests/support/every_scene_key.h"

#include <cmath>
#include <ctime>
#include <functional>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace tessera {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
constexpr auto kFitted = test::kFittedScene, kFree = test::kFreeScene;

Scene parse(const std::string& text) {
    return parseScene(text, "/folder", "s.json");
}

std::string messageOf(const std::string& text) {
    try {
        parse(text);
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("s.json"));
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return error.what();
    }
    ADD_FAILURE() << "accepted: " << text;
    return {};
}

/// A small valid scene with one thing replaced at a JSON pointer.
std::string with(const std::string& pointer, const json& value) {
    json scene = json::parse(kFitted);
    scene[json::json_pointer(pointer)] = value;
    return scene.dump();
}

TEST(Scene, EveryKeyIsRead) {
    const Scene scene = parse(kFitted);
    ASSERT_EQ(scene.volumes.size(), 1u);
    EXPECT_EQ(scene.volumes[0].path, "/folder/a/x.zarr");
    const auto& function = std::get<TransferFunction>(scene.volumes[0].transferFunction);
    EXPECT_EQ(function.referenceLengthMm(), 2.5);
    EXPECT_DOUBLE_EQ(function.extinction(50), -std::log1p(-0.5) / 2.5);
    EXPECT_DOUBLE_EQ(function.colour(0).g, 0.2);
    EXPECT_EQ(std::get<FittedView>(scene.camera).view, View::left);
    EXPECT_EQ(std::get<FittedView>(scene.camera).projection, Projection::parallel);
    EXPECT_EQ(std::get<FittedView>(scene.camera).mmPerPixel, 0.75);
    EXPECT_FALSE(scene.shading.on);
    EXPECT_EQ(scene.shading.ambient, 0.1);
    EXPECT_EQ(scene.shading.diffuse, 0.7);
    EXPECT_EQ(scene.shading.specular, 0.3);
    EXPECT_EQ(scene.shading.specularPower, 40);
    EXPECT_EQ(scene.quality.stepVoxels, 0.25);
    EXPECT_EQ(scene.shading.gradient, Gradient::sobel);
    ASSERT_EQ(function.materials().size(), 2u);
    EXPECT_EQ(function.materials()[1], (Material{0, 40.5, 0.125, 0.25, 0.5, 64, {1, 0.5, 0.25}}));
    EXPECT_EQ(function.gradientOpacity(),
              GradientOpacity::fromPoints({{0, 0}, {12.5, 0.25}, {12.5, 0.5}, {60, 1}},
                                          GradientOpacity::Per::voxel));
    EXPECT_EQ(scene.shading.model, ShadingModel::blinnPhong);
    EXPECT_EQ(scene.shading.gradientWeight, (GradientWeight{2, 8.5}));
    ASSERT_EQ(scene.lighting.lights.size(), 3u);
    EXPECT_EQ(scene.lighting.lights[0].kind, LightKind::head);
    EXPECT_EQ(scene.lighting.lights[0].intensity, 0.5);
    Light sun{LightKind::directional, LightFrame::patient, {0, -1, 2}};
    sun.intensity = 1.5, sun.colour = {1, 0.5, 0.25}, sun.shadow = true, sun.softness = 2.5;
    EXPECT_EQ(scene.lighting.lights[1], sun);
    Light lamp{LightKind::point, LightFrame::camera, {0, 0, 1}, {-100, 200, 0}, {1, 0.25, 0.125}};
    lamp.intensity = 2, lamp.colour = {0, 0, 1};
    EXPECT_EQ(scene.lighting.lights[2], lamp);
    EXPECT_EQ(scene.lighting.occlusion, (Occlusion{OcclusionMethod::positional, 64, 20, 0.5, 0.2, 0.75, 3}));
    EXPECT_EQ(scene.lighting.surfaceOcclusion, (SurfaceOcclusion{24, 7.5, false}));
    EXPECT_EQ(scene.lighting.finestLevel, 2);
    EXPECT_EQ(scene.mode, Mode::slice);
    EXPECT_EQ(std::get<GreyWindow>(scene.window), (GreyWindow{40.5, 400}));
    EXPECT_EQ(scene.valueColour, ValueColour::transferFunction);
    SlicePlane plane{Orientation::oblique, {}, {1, 2, 3.5}, {0, 1, 1}, 5, Reduction::maximum};
    EXPECT_EQ(scene.slice, plane);
    EXPECT_EQ(parse(kFree).slice.orientation, Orientation::coronal);
    EXPECT_EQ(parse(kFree).slice.positionMm, 12.5);
    ASSERT_EQ(scene.cuts.boxes.size() + scene.cuts.planes.size() + scene.cuts.scissors.size(), 3u);
    EXPECT_EQ(scene.cuts.boxes[0],
              (CropBox{{1, 2, 3}, {10, 20, 30.5}, CropBox::Space::voxels, Keep::outside}));
    EXPECT_EQ(scene.cuts.planes[0], (CutPlane{{4, 5, 6}, {0, 0, -1}, Keep::inside}));
    EXPECT_EQ(scene.cuts.scissors[0].camera.parallelScale, 80.5);
    EXPECT_EQ(scene.cuts.scissors[0].outline[1], glm::dvec2(1, 0.25));
    EXPECT_EQ(scene.cuts.scissors[0].keep, Keep::outside);
    ASSERT_EQ(scene.measurements.size(), 2u);
    EXPECT_EQ(valueOf(scene.measurements[0]), 3);
    EXPECT_EQ(scene.measurements[1].kind, MeasurementKind::circle);
    EXPECT_EQ(parse(kFree).lighting, Lighting{});
    EXPECT_EQ(parse(kFree).shading.model, ShadingModel::phong);
    ASSERT_EQ(scene.surfaces.size(), 2u);
    EXPECT_EQ(scene.surfaces[0], (Isosurface{-300, glm::dvec3(0.9, 0.5, 0.25), 0.5}));
    EXPECT_EQ(scene.surfaces[1], (Isosurface{200, glm::dvec3(1), 1}));
    EXPECT_EQ(scene.quality.integrator, Integrator::preintegrated);
    EXPECT_EQ(scene.quality.fetch, Fetch::exact);
    EXPECT_EQ(scene.quality.terminationTransmittance, 0);
    EXPECT_FALSE(scene.quality.skipping);
    EXPECT_EQ(scene.quality.edgeFunction, EdgeFunction::split);
    EXPECT_EQ(scene.quality.sampling, Sampling::naive);
    EXPECT_EQ(scene.quality.maxError, 2.5);
    EXPECT_FALSE(parse(kFree).quality.maxError.has_value());
    EXPECT_EQ(scene.imageSize, glm::ivec2(640, 480));
    EXPECT_NEAR(scene.background->r, 0.0331, 1e-4); // 0x33 is 0.2 in sRGB

    const Camera camera = std::get<Camera>(parse(kFree).camera);
    EXPECT_EQ(camera.position, glm::dvec3(1, 2, 3.25));
    EXPECT_EQ(camera.focalPoint, glm::dvec3(4, 5, 6));
    EXPECT_EQ(camera.viewUp, glm::dvec3(0, 0.1, 1));
    EXPECT_EQ(camera.viewAngle, 110.5);
    EXPECT_EQ(camera.parallelScale, 77.7);
    EXPECT_EQ(std::get<std::string>(parse(kFree).volumes[0].transferFunction), "lung");
    EXPECT_FLOAT_EQ(parse(kFree).background->b, 0.3f);
}

TEST(Scene, WrittenAndReadBackIsTheSame) {
    for (const char* text : {kFitted, kFree}) {
        const Scene scene = parse(text);
        const Scene again = parse(sceneJson(scene));
        EXPECT_EQ(sceneJson(again), sceneJson(scene));
        EXPECT_EQ(again.background, scene.background);
        EXPECT_EQ(again.volumes[0].path, scene.volumes[0].path);
        EXPECT_EQ(again.imageSize, scene.imageSize);
    }
    // Every key that was written survives, with its value (paths become absolute).
    json before = json::parse(kFitted), after = json::parse(sceneJson(parse(kFitted)));
    before["volumes"][0]["path"] = "/folder/a/x.zarr";
    EXPECT_EQ(before, after);
    Scene transparent;
    transparent.volumes.push_back({"/x.zarr", "bone"});
    transparent.background.reset();
    EXPECT_FALSE(parse(sceneJson(transparent)).background);
}

TEST(Scene, WhatOfASourceIsMeantIsKept) {
    Scene scene;
    scene.volumes.push_back({"/scans/a", "bone"});
    EXPECT_EQ(json::parse(sceneJson(scene))["volumes"][0].size(), 3u) << "nothing chosen, nothing said";
    SourceChoice& source = scene.volumes[0].source;
    const auto expectKept = [&] { EXPECT_EQ(parse(sceneJson(scene)).volumes[0].source, source); };
    source.series = 3;
    expectKept();
    source.phase = 2, source.largest = true;
    expectKept();
    source.resampleZ = source.allowMissing = true;
    expectKept();
    EXPECT_THAT(messageOf(with("/volumes/0/series", 0)), HasSubstr("$.volumes[0].series"));
    EXPECT_THAT(messageOf(with("/volumes/0/serie", 1)), HasSubstr("nearest: \"series\""));
}

TEST(Scene, RefusalsNameThePathAndTheNearestKey) {
    EXPECT_THAT(messageOf(with("/shading/spekular", 1)),
                AllOf(HasSubstr("$.shading"), HasSubstr("spekular"), HasSubstr("nearest: \"specular\"")));
    EXPECT_THAT(messageOf(with("/camra", 1)), AllOf(HasSubstr("$:"), HasSubstr("nearest: \"camera\"")));
    EXPECT_THAT(messageOf(with("/volumes/0/transferFunction/scalarOpacity/1/1", "0.5")),
                AllOf(HasSubstr("$.volumes[0].transferFunction.scalarOpacity[1][1]"), HasSubstr("a number")));
    EXPECT_THAT(messageOf(with("/quality/fetch", "exakt")), HasSubstr("nearest: \"exact\""));
    EXPECT_THAT(messageOf(with("/camera/view", "front")), HasSubstr("anterior, posterior"));
    EXPECT_THAT(messageOf(with("/camera/viewAngle", 30)), HasSubstr("\"view\" and \"viewAngle\""));
    EXPECT_THAT(messageOf(with("/a\nb", 1)), HasSubstr("\\n"));
}

TEST(Scene, IllTypedAndOutOfRangeValuesAreRefused) {
    for (const auto& [pointer, value] : std::vector<std::pair<std::string, json>>{
             {"/tesseraScene", 2},
             {"/tesseraScene", "1"},
             {"/volumes", json::array()},
             {"/volumes", json::object()},
             {"/volumes/1", {{"path", "b"}}},
             {"/volumes/0/path", 7},
             {"/volumes/0/path", ""},
             {"/volumes/0/transferFunction", 7},
             {"/volumes/0/transferFunction/scalarOpacityUnitDistance", 0},
             {"/volumes/0/transferFunction/scalarOpacity/0", {1, 2, 3}},
             {"/camera", "anterior"},
             {"/camera/parallelProjection", 1},
             {"/shading/shade", "yes"},
             {"/shading/ambient", -0.1},
             {"/shading/specularPower", nullptr},
             {"/shading/model", "gouraud"},
             {"/shading/gradientWeight", {3, 2}},
             {"/shading/gradientWeight", {-1, 2}},
             {"/lighting/lights", json::array()},
             {"/lighting/lights", json::array({{{"kind", "head"}},
                                               {{"kind", "head"}},
                                               {{"kind", "head"}},
                                               {{"kind", "head"}},
                                               {{"kind", "head"}}})},
             {"/lighting/lights/0/kind", "spot"},
             {"/lighting/lights/0/frame", "camera"},
             {"/lighting/lights/0/position", {1, 2, 3}},
             {"/lighting/lights/1/attenuation", {1, 0, 0}},
             {"/lighting/lights/2/direction", {1, 0, 0}},
             {"/lighting/lights/2/attenuation", {0, 0, 1}},
             {"/lighting/lights/1/intensity", -1},
             {"/lighting/lights/1/colour", {0, 0, 2}},
             {"/lighting/lights/1/softness", 61},
             {"/lighting/finestLevel", -1},
             {"/lighting/occlusion/method", "remote"},
             {"/lighting/occlusion/rays", 33},
             {"/lighting/occlusion/radius", 0},
             {"/lighting/occlusion/gamma", 9},
             {"/lighting/surfaceOcclusion/rays", 0},
             {"/lighting/surfaceOcclusion/rays", 257},
             {"/lighting/surfaceOcclusion/radius", 0},
             {"/lighting/surfaceOcclusion/filter", 1},
             {"/lighting/surfaceOcclusion/bias", 1},
             {"/volumes/0/transferFunction/materials/1/from", -1},
             {"/volumes/0/transferFunction/materials/1/to", 0},
             {"/volumes/0/transferFunction/materials/0", {{"from", 1}, {"to", 2}}},
             {"/volumes/0/transferFunction/materials/0/specularPower", 2.5},
             {"/volumes/0/transferFunction/materials/1/emission", {1, 0.5}},
             {"/volumes/0/transferFunction/materials/1/emission", {1, 0.5, 2}},
             {"/volumes/0/transferFunction/gradientOpacity", 0.5},
             {"/volumes/0/transferFunction/gradientOpacity", {0, 1}},
             {"/volumes/0/transferFunction/gradientOpacity/1", {-1, 0.5}},
             {"/volumes/0/transferFunction/gradientOpacity/1", {1, 0.5, 0.5}},
             {"/volumes/0/transferFunction/gradientOpacity", std::vector<std::vector<double>>(17, {1, 0.5})},
             {"/volumes/0/transferFunction/gradientOpacityUnit", "cm"},
             {"/quality/stepVoxels", 0},
             {"/quality/stepVoxels", 17},
             {"/quality/samples", 0},
             {"/quality/samples", 257},
             {"/quality/samples", "many"},
             {"/quality/samples", 2.5},
             {"/quality/seed", -1},
             {"/quality/terminationTransmittance", 1},
             {"/image/size", {640}},
             {"/image/size", {640, 0}},
             {"/image/size", {640.5, 480}},
             {"/image/size", {640, 1000000000000LL}},
             {"/image/background", "blueish"},
             {"/image/background", "#12345g"},
             {"/image/background", {0, 0, 2}}})
        EXPECT_FALSE(messageOf(with(pointer, value)).empty()) << pointer << " " << value;
    json camera = json::parse(kFree);
    camera["camera"]["viewAngle"] = 180;
    messageOf(camera.dump());
    camera["camera"]["viewAngle"] = 30;
    camera["camera"]["focalPoint"] = camera["camera"]["position"];
    messageOf(camera.dump());
}

// What a hostile file costs: every list that has a bound, with many times as many, and lists that have none.
TEST(Scene, LongListsAreReadInTimeThatGrowsWithThem) {
    constexpr int kMany = 100000;
    const auto listOf = [](const json& item) {
        json list = json::array();
        for (int i = 0; i < kMany; ++i)
            list.push_back(item);
        return list;
    };
    for (const char* pointer :
         {"/isosurfaces", "/lighting/lights", "/cuts/boxes", "/cuts/planes", "/cuts/scissors",
          "/cuts/scissors/0/outline", "/measurements", "/volumes", "/volumes/0/transferFunction/materials",
          "/volumes/0/transferFunction/gradientOpacity"}) {
        const std::string text = with(pointer, listOf(json::object()));
        const std::clock_t start = std::clock();
        EXPECT_THAT(messageOf(text), HasSubstr("100000")) << pointer;
        EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 3) << pointer;
    }
    const std::string points = with("/volumes/0/transferFunction/scalarOpacity", listOf({1, 0.5}));
    const std::clock_t start = std::clock();
    parse(points);
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 3);
}

TEST(Scene, TextThatIsNoSceneIsRefused) {
    for (const std::string text : {"", "[]", "7", "{", "{\"tesseraScene\":1}", "{\"tesseraScene\":NaN}",
                                   "{\"tesseraScene\":1e999}", "// x\n{}", "\xff\xfe"})
        messageOf(text);
    EXPECT_THAT(messageOf(R"({"tesseraScene":1,"image":{},"image":{}})"), HasSubstr("\"image\" twice"));
    EXPECT_THAT(messageOf(std::string(1000, '[')), HasSubstr("nested"));
    EXPECT_THAT(messageOf(std::string(kMaxJsonBytes + 1, ' ')), HasSubstr("16 MiB"));
    // Every prefix of a good scene ends in a clean refusal.
    const std::string good = kFitted;
    for (std::size_t n = 0; n < good.size(); n += 7)
        EXPECT_THROW(parse(good.substr(0, n)), InputError);
    EXPECT_THROW(loadScene("/no/such/scene.json"), InputError);
}

TEST(Scene, CamerasByAnglesAndByScaleAreReadAndWritten) {
    const auto camera = [](const std::string& text) {
        const Scene scene =
            parse(R"({"tesseraScene":1,"volumes":[{"path":"x"}],"mode":"slice","camera":)" + text + "}");
        const Scene again = parse(sceneJson(scene));
        EXPECT_EQ(sceneJson(again), sceneJson(scene)) << text;
        return std::get<FittedView>(again.camera);
    };
    EXPECT_EQ(camera(R"({"view":[-30,15.5],"fit":"kept"})").angles, (ViewAngles{-30, 15.5}));
    EXPECT_EQ(camera(R"({"view":[-30,15.5],"fit":"kept"})").fit, Fit::kept);
    EXPECT_TRUE(camera(R"({"view":[0,0]})").named);
    EXPECT_EQ(camera(R"({"view":"left","parallelProjection":true,"mmPerPixel":0.5})").mmPerPixel, 0.5);
    const FittedView slice = camera(R"({"parallelProjection":true,"mmPerPixel":0.5})");
    EXPECT_EQ(slice.mmPerPixel, 0.5);
    EXPECT_FALSE(slice.named) << "it is looked at along its normal";
    EXPECT_THROW(camera(R"({"view":"left","mmPerPixel":0.5})"), InputError) << "perspective";
    EXPECT_THROW(camera(R"({"view":[361,0]})"), InputError);
    EXPECT_THROW(camera(R"({"view":[0,90.1]})"), InputError);
    EXPECT_THROW(camera(R"({"view":[1,2,3]})"), InputError);
    EXPECT_THROW(camera(R"({"parallelProjection":true,"mmPerPixel":0})"), InputError);
    EXPECT_THROW(camera(R"({"position":[0,0,0],"parallelProjection":true,"mmPerPixel":1})"), InputError);
}

TEST(Scene, AxesOfAViewWinOverAnglesAndAnglesOverItsSide) {
    FittedView view;
    view.view = View::posterior;
    EXPECT_EQ(axesOf(view).towards, viewAxes(View::posterior).towards);
    view.angles = ViewAngles{90, 0};
    EXPECT_EQ(axesOf(view).towards, viewAxes(View::left).towards);
    view.axes = viewAxes(View::superior);
    EXPECT_EQ(axesOf(view).towards, viewAxes(View::superior).towards);
}

TEST(Shading, OfAllThreeKindsOfLightIsTheBrightest) {
    Shading shading;
    shading.on = true;
    shading.ambient = 0.25, shading.diffuse = 0.75, shading.specular = 0.5;
    EXPECT_EQ(brightest(shading), 1.5);
    shading.diffuse = 0.125;
    EXPECT_EQ(brightest(shading), 1) << "colours come unlit where nothing can be shaded";
    shading.diffuse = 0.75, shading.on = false;
    EXPECT_EQ(brightest(shading), 1);
}

// A point light is brightest at its place; the channel with most light counts.
TEST(Shading, EveryLightAndMaterialMakesItBrighter) {
    Shading shading;
    shading.ambient = 0.25, shading.diffuse = 0.5, shading.specular = 0.25;
    Lighting lighting;
    lighting.lights = {Light{}, Light{LightKind::point, LightFrame::camera, {}, {1, 2, 3}, {0.5, 1, 1}},
                       Light{LightKind::directional}};
    lighting.lights[1].colour = {0.25, 1, 0};
    lighting.lights[2].intensity = 0;
    EXPECT_EQ(brightest(shading, lighting), 0.25 + 3 * 0.75);
    EXPECT_EQ(brightest(shading, lighting, {{0, 1, 0.5, 1, 0.5, 3}, {2, 3, 0, 0, 0, 1}}), 0.5 + 3 * 1.5);
    shading.on = false;
    EXPECT_EQ(brightest(shading, lighting, {{0, 1, 0.5, 1, 0.5, 3}}), 1);
}

TEST(Look, AllAreReadableAndKeepWhatTheyAreNotAbout) {
    for (const std::string& name : lookNames()) {
        Scene scene;
        scene.volumes = {SceneVolume{"volume.zarr"}};
        scene.shading.gradient = Gradient::sobel;
        scene.shading.specularPower = 77;
        scene.lighting.finestLevel = 3;
        applyLook(name, scene);
        EXPECT_EQ(scene.shading.gradient, Gradient::sobel) << name;
        EXPECT_TRUE(scene.shading.on);
        EXPECT_NE(scene.shading.specularPower, 77) << name; // a look starts from what is there by default
        const int channels = name == "plain" || name == "endoscope" ? 0 : name.rfind("soft", 0) == 0 ? 1 : 2;
        EXPECT_EQ(lightChannels(scene.lighting), channels) << name;
        EXPECT_EQ(name == "plain", isHeadLightAlone(scene.lighting.lights)) << name;
        const Scene again = parseScene(sceneJson(scene), "/", "look");
        EXPECT_EQ(again.lighting, scene.lighting) << name;
    }
}

// In a lumen all is in shadow of what is around it: the lamp is at the eye, and what is deep is dark.
TEST(Look, TheEndoscopesLampIsAtTheEyeAndFallsOff) {
    Scene scene;
    scene.volumes = {SceneVolume{"volume.zarr"}};
    applyLook("endoscope", scene);
    ASSERT_EQ(scene.lighting.lights.size(), 1u);
    const Light& lamp = scene.lighting.lights[0];
    EXPECT_EQ(lamp.kind, LightKind::point);
    EXPECT_EQ(lamp.frame, LightFrame::camera);
    EXPECT_LE(glm::length(lamp.position), 2);
    EXPECT_FALSE(lamp.shadow);
    const auto light = [&](double mm) {
        return lamp.intensity / glm::dot(lamp.attenuation, glm::dvec3(1, mm, mm * mm));
    };
    EXPECT_GT(light(10), 0.8);
    EXPECT_LT(light(60), 0.5 * light(10));
}

TEST(Look, RefusalsHelp) {
    Scene scene;
    try {
        applyLook("studioo", scene);
        FAIL();
    } catch (const InputError& e) {
        EXPECT_THAT(e.what(), testing::HasSubstr("nearest: \"studio\""));
    }
}

TEST(NearestName, IsTheOneThatWasMeant) {
    EXPECT_EQ(editDistance("kitten", "sitting"), 3u);
    EXPECT_EQ(editDistance("", "abc"), 3u);
    EXPECT_EQ(editDistance("abc", ""), 3u);
    EXPECT_EQ(editDistance("overview", "view"), 4u);
    EXPECT_EQ(editDistance("View", "view"), 0u);
    EXPECT_EQ(nearestName("bne", {"auto", "bone", "lung"}), "bone");
    EXPECT_EQ(nearestName("x", {}), "");
}

TEST(Preset, AllAreReadableAndShowWhatTheyAreNamedAfter) {
    EXPECT_EQ(presetNames(), (std::vector<std::string>{"airways", "auto", "bone", "bone-1", "lung", "lung-1",
                                                       "metal", "mr-brain", "muscle", "pet", "skin", "skin-1",
                                                       "soft-tissue", "vessels", "vessels-1"}));
    const ValueSummary hu{-1024, 3071, true, 1, {}};
    for (const std::string& name : presetNames()) {
        EXPECT_EQ(presetFunction(name, hu).extinction(-1024), 0) << name; // air shows in none
        EXPECT_FALSE(presetDescription(name).empty()) << name;
        EXPECT_GT(makeTable(presetFunction(name, hu)).entries.size(), 1u);
    }
    const auto opacity = [&](const char* name, double value) {
        return -std::expm1(-presetFunction(name, hu).extinction(value)); // over 1 mm
    };
    EXPECT_EQ(opacity("bone", 60), 0);
    EXPECT_GT(opacity("bone", 500), 0.5);
    EXPECT_GT(opacity("skin", -50), 0.5);
    EXPECT_EQ(opacity("skin", -800), 0); // lung and noisy air stay clear
    EXPECT_LT(opacity("skin", -500),
              0.1); // a ramp as wide as a surface is blurred, or it would show terraces
    EXPECT_GT(opacity("soft-tissue", 60), 5 * opacity("soft-tissue", -80)); // muscle over fat
    EXPECT_GT(opacity("soft-tissue", -80), 0);
    EXPECT_GT(opacity("lung", -400), opacity("lung", -800)); // vessels and walls over parenchyma
    EXPECT_EQ(opacity("lung", 60), 0);                       // the chest wall is out of the way
    EXPECT_GT(opacity("vessels-1", 250), 5 * opacity("vessels-1", 700));
}

/// A line through tissue, HU at a place in mm: from one value to another, or a sheet between two of one, as
/// blurred as a scan (a Gaussian's deviation, mm).
using Profile = std::function<double(double)>;
double rise(double x, double blur) {
    return 0.5 * std::erfc(-x / blur / std::sqrt(2.0));
}
Profile edge(double from, double to, double blur = 1.2) {
    return [=](double x) { return from + (to - from) * rise(x, blur); };
}
Profile sheet(double around, double inside, double width, double blur = 1.2) {
    return [=](double x) {
        return around + (inside - around) * (rise(x + width / 2, blur) - rise(x - width / 2, blur));
    };
}
/// What a ray along 40 mm of it has of opacity, by the exact function.
double opacityAlong(const std::string& preset, const Profile& profile) {
    const TransferFunction f = presetFunction(preset, {-1024, 3071, true, 1, {}});
    const GradientOpacity factor = f.gradientOpacity().perMm(1);
    constexpr double kStep = 0.02;
    double depth = 0;
    for (double x = -20; x < 20; x += kStep) {
        const double slope = (profile(x + 0.01) - profile(x - 0.01)) / 0.02;
        depth += f.extinction(profile(x)) * (factor.isOne() ? 1 : factor.factor(std::abs(slope))) * kStep;
    }
    return -std::expm1(-depth);
}

// Lungs were red fog: skin, clothes and the pleura were as much seen as what is in the lungs.
TEST(Preset, LungShowsWhatIsInTheLungsAndNotWhatIsAroundThem) {
    const double skin = opacityAlong("lung", edge(-1000, -90));
    EXPECT_LT(skin, 0.05);
    EXPECT_GT(opacityAlong("lung", sheet(-850, 40, 1.5)), 4 * skin) << "a vessel";
    EXPECT_GT(opacityAlong("lung", sheet(-850, 40, 2)), 6 * skin) << "a larger one";
    EXPECT_GT(opacityAlong("lung", sheet(-850, 0, 1)), skin) << "a fissure";
    EXPECT_EQ(opacityAlong("lung", edge(-100, 60)), 0) << "fat and muscle";
    EXPECT_EQ(opacityAlong("lung", edge(60, 1000)), 0) << "bone";
    const double lung = opacityAlong("lung", [](double) { return -850.0; });
    EXPECT_GT(lung, 0.01);
    EXPECT_LT(lung, 0.1) << "a veil";
}

// Of a scan with contrast agent: vessels are as bright as thin bone, but softer at their edges.
TEST(Preset, BoneLeavesOutVesselsAndVesselsLeaveOutTheEdgesOfBone) {
    const Profile aorta = sheet(50, 190, 20), kidney = sheet(50, 210, 60), rib = sheet(40, 900, 3),
                  cortex = sheet(40, 1200, 4);
    EXPECT_LT(opacityAlong("bone", aorta), 0.2);
    EXPECT_LT(opacityAlong("bone", kidney), 0.25);
    EXPECT_GT(opacityAlong("bone", rib), 0.8);
    EXPECT_GT(opacityAlong("bone", cortex), 0.9);
    EXPECT_GT(opacityAlong("vessels", aorta), 0.95);
    EXPECT_GT(opacityAlong("vessels", sheet(50, 350, 4)), 0.8) << "an artery";
    EXPECT_GT(opacityAlong("bone-1", kidney), 0.9) << "what they were";
    // Bone is ivory: hardly redder than it is blue.
    const auto redness = [](const char* preset, double value) {
        const glm::dvec3 colour = presetFunction(preset, {-1024, 3071, true, 1, {}}).colour(value);
        return colour.r / colour.b;
    };
    EXPECT_GT(redness("vessels", 220), 8);
    EXPECT_LT(redness("vessels", 600), 2);
    EXPECT_LT(redness("bone", 220), 3);
}

TEST(Preset, MuscleLeavesOutSkinAndFat) {
    const double skin = opacityAlong("muscle", sheet(-100, 30, 1.5));
    EXPECT_LT(skin, 0.3);
    EXPECT_GT(opacityAlong("muscle", edge(-100, 60)), 0.95);
    EXPECT_EQ(opacityAlong("muscle", [](double) { return -100.0; }), 0);
}

TEST(Preset, MetalIsOpaqueAndBoneBeforeItAVeil) {
    EXPECT_GT(opacityAlong("metal", sheet(60, 3000, 6)), 0.9);
    EXPECT_LT(opacityAlong("metal", sheet(60, 1400, 6)), 0.2);
}

// What was built in before is there, number for number.
TEST(Preset, EarlierOnesAreKept) {
    const std::map<std::string, std::size_t> sizes = {
        {"bone-1", 10}, {"lung-1", 18}, {"skin-1", 10}, {"vessels-1", 12}};
    for (const auto& [name, points] : sizes) {
        const Preset preset = builtInPreset(name);
        EXPECT_EQ(preset.function.opacityPoints().size() + preset.function.colourPoints().size(), points)
            << name;
        EXPECT_TRUE(preset.function.gradientOpacity().isOne()) << name;
        EXPECT_EQ(preset.look, "{}") << name;
    }
    const TransferFunction bone = builtInPreset("bone-1").function, lung = builtInPreset("lung-1").function,
                           skin = builtInPreset("skin-1").function,
                           vessels = builtInPreset("vessels-1").function;
    EXPECT_EQ(bone.opacityPoints()[1].value, 220);
    EXPECT_EQ(bone.opacityPoints()[1].opacity, 0.08);
    EXPECT_EQ(lung.opacityPoints()[4].opacity, 0.06);
    EXPECT_EQ(skin.opacityPoints()[3].opacity, 0.85);
    EXPECT_EQ(vessels.colourPoints()[2].colour, glm::dvec3(0.7454, 0.0452, 0.0252));
}

// A preset over shares of an object takes what lies above the background, without its brightest voxels:
// a bladder of 40 in a body of 1 to 9 does not make the picture black.
TEST(Preset, PetTakesTheValuesOfTheBody) {
    std::vector<double> counts(80, 0); // half a unit a bin
    counts[0] = 1e6, counts[1] = 1e3;
    for (int bin = 2; bin < 18; ++bin)
        counts[static_cast<std::size_t>(bin)] = 1e4;
    counts[79] = 200;
    const ValueSummary body{0, 40, false, 1, counts};
    EXPECT_GE(objectRange(body).x, 0.5);
    EXPECT_LE(objectRange(body).x, 1);
    EXPECT_NEAR(objectRange(body).y, 0.98 * 8 + 1, 0.2);
    const TransferFunction f = presetFunction("pet", body);
    EXPECT_NEAR(f.opacityPoints().back().value, 1.2 * 9, 0.4);
    EXPECT_EQ(f.colour(0), glm::dvec3(1)) << "white";
    EXPECT_EQ(f.colour(25), glm::dvec3(0)) << "black";
    // Without a histogram the upper four fifths; gradients scale with it.
    const ValueSummary unknown{0, 40, false, 1, {}};
    EXPECT_EQ(objectRange(unknown), glm::dvec2(8, 40));
    const auto lengths = [](const ValueSummary& values) {
        return presetFunction("mr-brain", values).gradientOpacity().points();
    };
    EXPECT_NEAR(lengths(unknown).back().length, 0.5 * 32, 1e-9);
    EXPECT_EQ(presetFunction("bone", {-1024, 3071, true, 1, {}}).gradientOpacity().per(),
              GradientOpacity::Per::voxel);
    EXPECT_NO_THROW(presetFunction("pet", {5, 5, false, 1, {}}));
    Scene scene;
    scene.volumes.push_back({});
    Preset preset = builtInPreset("pet");
    preset.unit = PresetUnit::any;
    applyPreset(preset, scene);
    EXPECT_EQ(scene.mode, Mode::maximum);
    EXPECT_EQ(scene.valueColour, ValueColour::inverse);
}

// Whatever was chosen before, a built-in preset looks as it does on a scene of its own.
TEST(Preset, ABuiltInOneLooksTheSameAfterAnyOther) {
    const auto lookOf = [](const Scene& scene) { return presetOf(scene, "").look; };
    const auto take = [](const std::string& name, Scene& scene) {
        applyBuiltInPreset(name, presetFunction(name, {}), scene);
    };
    for (const std::string& second : presetNames()) {
        Scene alone;
        alone.volumes.push_back({});
        take(second, alone);
        for (const std::string& first : presetNames()) {
            Scene scene;
            scene.volumes.push_back({});
            take(first, scene);
            take(second, scene);
            EXPECT_EQ(lookOf(scene), lookOf(alone)) << second << " after " << first;
            scene.mode = Mode::average; // a hand's
            take(second, scene);
            EXPECT_EQ(scene.mode, alone.mode) << second;
        }
    }
}

// What no preset brought is the user's, and stays: light, a window, cuts, a plane.
TEST(Preset, ABuiltInOneLeavesWhatTheUserSet) {
    Scene scene;
    scene.volumes.push_back({});
    applyLook("studio", scene);
    const Shading studio = scene.shading;
    scene.window = GreyWindow{300, 600};
    scene.slice.thicknessMm = 7;
    scene.cuts.boxes.push_back({glm::dvec3(1), glm::dvec3(5), CropBox::Space::patient, Keep::inside});
    scene.surfaces.push_back({300, {1, 0.5, 0}, 0.5});
    const Scene before = scene;
    applyBuiltInPreset("bone", std::string("bone"), scene);
    EXPECT_EQ(scene.shading, studio);
    EXPECT_EQ(scene.lighting, before.lighting);
    EXPECT_EQ(scene.window, before.window);
    EXPECT_EQ(scene.slice, before.slice);
    EXPECT_EQ(scene.cuts.boxes.size(), 1u);
    EXPECT_EQ(scene.surfaces, before.surfaces);
    EXPECT_EQ(std::get<std::string>(scene.volumes.front().transferFunction), "bone");
    EXPECT_THROW(applyBuiltInPreset("bonne", std::string("bonne"), scene), InputError);
}

TEST(Preset, RefusalsHelp) {
    const auto message = [](const char* name, bool isHu) -> std::string {
        try {
            presetFunction(name, {0, 255, isHu, 1, {}});
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(message("bonne", true), AllOf(HasSubstr("nearest: \"bone\""), HasSubstr("soft-tissue")));
    EXPECT_THAT(message("bone", false), HasSubstr("auto"));
    EXPECT_EQ(message("auto", false), "");
}

// A NIfTI file cannot say HU; presets were refused for every CT that came through a converter.
TEST(Preset, ValuesThatLookLikeHuAreTaken) {
    const auto summary = [](double lowest, double highest,
                            const std::vector<std::pair<double, double>>& peaks) {
        ValueSummary values{lowest, highest, false, 1, std::vector<double>(64)};
        for (const auto& [value, count] : peaks)
            values.histogram[static_cast<std::size_t>((value - lowest) / (highest - lowest) * 63.99)] +=
                count;
        return values;
    };
    const auto ct = summary(-1024, 3071, {{-1000, 40}, {40, 55}, {900, 5}});
    EXPECT_TRUE(looksLikeHu(ct));
    EXPECT_NO_THROW(presetFunction("bone", ct));
    EXPECT_TRUE(
        looksLikeHu(summary(-3024, 3071, {{-3024, 20}, {-1000, 20}, {40, 60}}))); // outside the circle
    EXPECT_TRUE(looksLikeHu(summary(-1024, 30000, {{-1000, 40}, {40, 59}, {29000, 1}}))); // metal
    EXPECT_FALSE(looksLikeHu(summary(0, 4095, {{24, 40}, {1064, 60}})));                  // not rescaled
    EXPECT_FALSE(looksLikeHu(summary(0, 255, {{1, 60}, {90, 40}})));
    EXPECT_FALSE(looksLikeHu(summary(-32768, 32767, {{-32000, 60}, {-1000, 5}, {20000, 35}})));
    EXPECT_FALSE(looksLikeHu({-1000, -1000, false, 1, std::vector<double>(64, 1)}));
    EXPECT_FALSE(looksLikeHu({-1024, 3071, false, 1, {}}));
}

// Quantiles lie within bins: of an object whose values are all in the last of four, half are above its
// middle.
TEST(Preset, AutoFindsItsQuantilesWithinBins) {
    const TransferFunction function = presetFunction("auto", {0, 400, false, 1, {100, 0, 0, 300}});
    ASSERT_EQ(function.opacityPoints().size(), 5u);
    EXPECT_DOUBLE_EQ(function.opacityPoints()[0].value, 100);
    EXPECT_DOUBLE_EQ(function.opacityPoints()[2].value, 350);
    EXPECT_DOUBLE_EQ(function.opacityPoints()[4].value, 398);
    // Of an object of nearly one value, a fiftieth of the range is kept between middle and end.
    ValueSummary narrow{0, 400, false, 1, std::vector<double>(200)};
    narrow.histogram[0] = 100, narrow.histogram[150] = 50;
    const auto points = presetFunction("auto", narrow).opacityPoints();
    EXPECT_DOUBLE_EQ(points[2].value, 301);
    EXPECT_DOUBLE_EQ(points[4].value, 301 + 8);
}

TEST(Preset, AutoLeavesTheBackgroundOutAndShowsTheRest) {
    ValueSummary values{0, 255, false, 0.5, std::vector<double>(64)};
    for (int i = 0; i < 64; ++i) // noise around 0, then an object around bin 30
        values.histogram[static_cast<std::size_t>(i)] =
            1e6 * std::exp(-i * i / 8.0) + 1e3 * std::exp(-(i - 30) * (i - 30) / 20.0);
    const TransferFunction function = presetFunction("auto", values);
    EXPECT_EQ(function.referenceLengthMm(), 0.5);
    EXPECT_EQ(function.extinction(8), 0); // one standard deviation of the noise
    EXPECT_GT(function.extinction(120), 0);
    EXPECT_GT(function.extinction(140), function.extinction(110));
    EXPECT_EQ(presetFunction("auto", {5, 5, false, 1, {}}).extinction(5), 0);
    // Without a histogram, from the range alone; and at any scale.
    EXPECT_GT(presetFunction("auto", {0, 1e-6, false, 1, {}}).extinction(9e-7), 0);
    EXPECT_EQ(presetFunction("auto", {0, 1e9, false, 1, {}}).extinction(1e8), 0);
    // One single bin holds everything; still a function that makes sense.
    values.histogram.assign(64, 0);
    values.histogram[0] = 10;
    EXPECT_EQ(presetFunction("auto", values).extinction(0), 0);
}

} // namespace
} // namespace tessera
