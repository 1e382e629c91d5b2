// tests/core/scene/scene_test.cpp: scenes read strictly and written back without loss.
#include "core/scene/scene.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/scene/preset.h"
#include "core/scene/scene_presets.h"

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

/// Scenes whose members are known, two because a camera is either fitted or free.
constexpr const char* kFitted = R"({"tesseraScene":1,
  "volumes":[{"path":"a/x.zarr","unit":"HU","transferFunction":{"scalarOpacityUnitDistance":2.5,
    "scalarOpacity":[[-100,0],[50,0.125],[50,0.5]],"rgbTransferFunction":[[0,0.1,0.2,0.3],[10,1,1,1]],
    "tissues":[{"from":-200,"to":0,"phase":{"g":0.25}},{"from":0,"to":90,"finish":{"roughness":0.75}}],
    "materials":[{"from":-100,"to":0,"ambient":0.3,"diffuse":0.5,"specular":0,"specularPower":1},
      {"from":0,"to":40.5,"ambient":0.125,"diffuse":0.25,"specular":0.5,"specularPower":64,
       "emission":[1,0.5,0.25]}],
    "gradientOpacity":[[0,0],[12.5,0.25],[12.5,0.5],[60,1]],"gradientOpacityUnit":"voxel"}}],
  "camera":{"view":"left","fit":"volume","parallelProjection":true,"mmPerPixel":0.75},
  "shading":{"shade":false,"ambient":0.1,"diffuse":0.7,"specular":0.3,"specularPower":40,
    "gradient":"sobel","model":"blinn-phong","gradientWeight":[2,8.5]},
  "lighting":{"lights":[
      {"kind":"head","intensity":0.5,"colour":[1,1,1],"shadow":false,"softness":0},
      {"kind":"directional","frame":"patient","direction":[0,-1,2],"intensity":1.5,"colour":[1,0.5,0.25],
       "shadow":true,"softness":2.5,"scatter":1.25},
      {"kind":"point","frame":"camera","position":[-100,200,0],"attenuation":[1,0.25,0.125],"intensity":2,
       "colour":[0,0,1],"shadow":false,"softness":0}],
    "occlusion":{"method":"positional","rays":64,"radius":20,"offset":0.5,"bias":0.2,"gamma":0.75,"emission":3,
      "weights":{"towards":[0,-1,0.5],"strength":2.5}},
    "surfaceOcclusion":{"rays":24,"radius":7.5,"filter":false,"scale":1,"resolution":64,"threshold":0.25},
    "transport":{"response":"physical","bounces":12,"phase":{"kind":"henyey-greenstein","g":0.5,"backG":-0.25,"backShare":0.125},
      "surface":{"gradient":[20,90.5],"mirrored":0.25,"roughness":0.5,"translucent":0.375,"translucentPower":20},"colours":"reflectance","preview":"squared"},
    "environment":{"sky":"two-tone","intensity":0.75,"colour":[1,0.5,0.25],"below":[0,0.25,0.5],"up":[0,-1,1],"file":"skies/studio.exr","rotation":-30,"frame":"camera"},
    "shadowMap":{"kind":"variance","threshold":0.25,"filter":3},"scatterBy":"map","scatterRadius":6.5,
    "lightMap":{"size":64,"g":0.25},"finestLevel":2},
  "isosurfaces":[{"value":-300,"rgb":[0.9,0.5,0.25],"opacity":0.5},{"value":200,"rgb":[1,1,1],"opacity":1,
    "finish":{"mirrored":0.125,"roughness":0.25,"translucent":0.75,"translucentPower":3}}],
  "mode":"slice","window":[40.5,400],"valueColour":"transferFunction",
  "slice":{"plane":"oblique","point":[1,2,3.5],"normal":[0,1,1],"thickness":5,"reduction":"maximum"},
  "cuts":{"boxes":[{"low":[1,2,3],"high":[10,20,30.5],"space":"voxels","keep":"outside"}],
    "planes":[{"point":[4,5,6],"normal":[0,0,-1],"keep":"inside"}],
    "scissors":[{"camera":{"position":[1,2,3],"focalPoint":[4,5,6],"viewUp":[0,0,1],"viewAngle":40,
      "parallelProjection":true,"parallelScale":80.5},"aspect":1.5,"outline":[[0,0],[1,0.25],[0.5,1]],"keep":"outside"}]},
  "measurements":[{"kind":"distance","points":[[0,0,0],[1,2,2]]},
    {"kind":"circle","points":[[1,0,0],[0,1,0],[-1,0,0.5]]}],
  "quality":{"stepVoxels":0.25,"integrator":"pre-integrated","fetch":"exact","terminationTransmittance":0,"skipping":false,
    "edgeFunction":"split","sampling":"naive","maxError":2.5,
    "samples":16,"denoise":true,"pixelFilter":"gaussian","seed":3},
  "image":{"size":[640,480],"background":"#336699"}})";
constexpr const char* kFree =
    R"({"tesseraScene":1,"volumes":[{"path":"/s/x.zarr","unit":"","transferFunction":"lung",
      "series":3,"phase":2,"largest":true,"resampleZ":true,"allowMissing":true}],
  "camera":{"position":[1,2,3.25],"focalPoint":[4,5,6],"viewUp":[0,0.1,1],"viewAngle":110.5,
    "parallelProjection":false,"parallelScale":77.7},"slice":{"plane":"coronal","position":12.5},
  "image":{"background":[0.1,0.2,0.3]}})";

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
    EXPECT_EQ(function.tissues(),
              (std::vector<Tissue>{{-200, 0, Phase{PhaseKind::henyeyGreenstein, 0.25}, {}},
                                   {0, 90, {}, SurfaceFinish{0.028, 0.75}}}));
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
    sun.intensity = 1.5, sun.colour = {1, 0.5, 0.25}, sun.shadow = true, sun.softness = 2.5,
    sun.scatter = 1.25;
    EXPECT_EQ(scene.lighting.lights[1], sun);
    Light lamp{LightKind::point, LightFrame::camera, {0, 0, 1}, {-100, 200, 0}, {1, 0.25, 0.125}};
    lamp.intensity = 2, lamp.colour = {0, 0, 1};
    EXPECT_EQ(scene.lighting.lights[2], lamp);
    EXPECT_EQ(scene.lighting.occlusion, (Occlusion{OcclusionMethod::positional, 64, 20, 0.5, 0.2, 0.75, 3, 0,
                                                   DirectionWeights{{0, -1, 0.5}, 2.5}}));
    EXPECT_EQ(scene.lighting.shadowMap, (ShadowMapping{ShadowMapKind::variance, 0.25, 3}));
    EXPECT_EQ(scene.lighting.surfaceOcclusion, (SurfaceOcclusion{24, 7.5, false, 1, 64, 0.25}));
    EXPECT_EQ(scene.lighting.transport, (Transport{TransportResponse::physical,
                                                   12,
                                                   {PhaseKind::henyeyGreenstein, 0.5, -0.25, 0.125},
                                                   SurfaceScattering{{20, 90.5}, {0.25, 0.5, 0.375, 20}},
                                                   TransportColours::reflectance,
                                                   PathPreview::squared}));
    EXPECT_EQ(scene.lighting.environment, (Environment{Sky::twoTone,
                                                       0.75,
                                                       {1, 0.5, 0.25},
                                                       {0, 0.25, 0.5},
                                                       {0, -1, 1},
                                                       {"/folder/skies/studio.exr", nullptr},
                                                       -30,
                                                       LightFrame::camera}));
    EXPECT_EQ(scene.lighting.scatterBy, ScatterSource::map);
    EXPECT_EQ(scene.lighting.scatterRadiusMm, 6.5);
    EXPECT_EQ(scene.lighting.lightMap, (LightMapping{64, 0.25}));
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
    EXPECT_EQ(scene.surfaces[1], (Isosurface{200, glm::dvec3(1), 1, SurfaceFinish{0.125, 0.25, 0.75, 3}}));
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
    // A file spells its defaults out, so that a later default changes no picture.
    const json plain = json::parse(sceneJson(parse(R"({"tesseraScene":1,"volumes":[{"path":"/x"}]})")));
    EXPECT_EQ(plain["shading"]["ambient"], 0.2);
    EXPECT_EQ(plain["quality"]["integrator"], "auto");
    EXPECT_EQ(plain["camera"]["fit"], "shown");
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
    source.fileLevel = 0, source.fileBox = FileBox{{1, 2, 3}, {4, 50, 600}};
    expectKept();
    source.fileLevel = SourceChoice::kAutoLevel;
    expectKept();
    EXPECT_THAT(messageOf(with("/volumes/0/fileLevel", -1)), HasSubstr("$.volumes[0].fileLevel"));
    EXPECT_THAT(messageOf(with("/volumes/0/fileBox", {3, 3, 0, 1, 0, 1})), HasSubstr("$.volumes[0].fileBox"));
    for (const char* const text :
         {"", "1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,3,4,5,-6", "2,1,3,4,5,6", "1,2,3,4,5,9999999999"})
        EXPECT_THROW(parseFileBox(text, "--file-box"), InputError) << text;
    EXPECT_EQ(parseFileBox("1,4,2,50,3,600", "--file-box"), source.fileBox);
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
             {"/volumes/1", {{"file", "b"}}},
             {"/volumes/0/opacity", 1.5},
             {"/volumes/0/transform", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
             {"/volumes/0/transform", {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0}},
             {"/volumes", std::vector<json>(9, {{"path", "b"}})},
             {"/fusion", "add"},
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
             {"/lighting/lights/1/scatter", 4.5},
             {"/lighting/lights/2/scatter", 1}, // of the camera, without a shadow
             {"/lighting/scatterRadius", 0},
             {"/lighting/scatterBy", "paths"},
             {"/lighting/lightMap/size", 15},
             {"/lighting/lightMap/size", 193},
             {"/lighting/lightMap/g", -0.1},
             {"/lighting/lightMap/g", 0.96},
             {"/lighting/finestLevel", -1},
             {"/lighting/occlusion/method", "remote"},
             {"/lighting/occlusion/weights/towards", {0, 0, 0}},
             {"/lighting/occlusion/weights/strength", -1},
             {"/lighting/shadowMap/kind", "shallow"},
             {"/lighting/shadowMap/threshold", 1},
             {"/lighting/shadowMap/threshold", 0},
             {"/lighting/shadowMap/filter", 9},
             {"/lighting/occlusion/directions", "cube"},
             {"/lighting/occlusion/rays", 33},
             {"/lighting/occlusion/radius", 0},
             {"/lighting/occlusion/gamma", 9},
             {"/lighting/surfaceOcclusion/rays", 0},
             {"/lighting/surfaceOcclusion/rays", 257},
             {"/lighting/surfaceOcclusion/radius", 0},
             {"/lighting/surfaceOcclusion/filter", 1},
             {"/lighting/surfaceOcclusion/scale", 3},
             {"/lighting/surfaceOcclusion/scale", 8},
             {"/lighting/surfaceOcclusion/resolution", 15},
             {"/lighting/surfaceOcclusion/resolution", 513},
             {"/lighting/surfaceOcclusion/threshold", 0.9},
             {"/lighting/surfaceOcclusion/bias", 1},
             {"/lighting/transport/response", "contract"},
             {"/lighting/transport/response", "cinematic"},
             {"/lighting/transport/bounces", 0},
             {"/lighting/transport/bounces", 257},
             {"/lighting/transport/phase/g", 1},
             {"/lighting/transport/phase/backShare", -0.1},
             {"/lighting/transport/phase/kind", "mie"},
             {"/lighting/transport/surface/gradient", {2, 1}},
             {"/lighting/transport/surface/gradient", 1},
             {"/lighting/transport/surface/roughness", 0.01},
             {"/lighting/transport/surface/mirrored", 1.5},
             {"/lighting/transport/surface/translucent", 1.5},
             {"/lighting/transport/preview", "cubed"},
             {"/lighting/transport/surface/translucentPower", -1},
             {"/isosurfaces/1/finish/translucent", -0.5},
             {"/isosurfaces/1/finish/gradient", {1, 2}},
             {"/lighting/transport", nullptr},
             {"/lighting/environment/up", {0, 0, 0}},
             {"/lighting/environment/intensity", -1},
             {"/lighting/environment/sky", "blue"},
             {"/lighting/environment/rotation", 361},
             {"/lighting/environment/frame", "voxels"},
             {"/lighting/environment/file", 1},
             {"/volumes/0/transferFunction/tissues/1/from", -1},
             {"/volumes/0/transferFunction/tissues/0/phase/g", 1},
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
             {"/quality/samples", 65537},
             {"/quality/noise", 0},
             {"/quality/noise", 1.5},
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

// The cost of a hostile file: every list that has a bound, with many times as many, and lists that have none.
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

// A light that tissue scatters, fixed to the camera at a point, casts shadows, so that it is placed anew.
TEST(Scene, ScatteredPointLightsOfTheCameraCastShadows) {
    const auto refused = [](const std::string& more) {
        try {
            parseScene(R"({"tesseraScene":1,"volumes":[{"path":"x"}],"lighting":{"lights":[{)" + more +
                           "}]}}",
                       "/", "s");
        } catch (const InputError&) {
            return true;
        }
        return false;
    };
    for (const char* scatter : {"0.001", "0.5", "1", "4"}) {
        const std::string light = R"("kind":"point","scatter":)" + std::string(scatter);
        EXPECT_TRUE(refused(light)) << scatter;
        EXPECT_FALSE(refused(light + R"(,"shadow":true)")) << scatter;
        EXPECT_FALSE(refused(light + R"(,"frame":"patient")")) << scatter;
    }
    EXPECT_FALSE(refused(R"("kind":"point","scatter":0)"));
    EXPECT_FALSE(refused(R"("kind":"directional","scatter":1)"));
}

// Keys of light that the default leaves out are written where they are not the default, and read again.
TEST(Scene, KeepsHowLightIsFound) {
    const auto parsed = [](const std::string& lighting) {
        return parseScene(R"({"tesseraScene":1,"volumes":[{"path":"/x"}],"lighting":)" + lighting + "}", "/",
                          "s");
    };
    const Scene scene = parsed(R"({"occlusion":{"directions":"hemisphere","weights":{"towards":[0,0,2]}},
                                   "shadowMap":{"kind":"first"},"scatterBy":"map","lightMap":{"g":0.5}})");
    EXPECT_EQ(scene.lighting.occlusion->directions, OcclusionDirections::hemisphere);
    EXPECT_EQ(scene.lighting.occlusion->weights, (DirectionWeights{{0, 0, 2}, 1}));
    EXPECT_EQ(scene.lighting.shadowMap, (ShadowMapping{ShadowMapKind::first, 0.5, 1}));
    EXPECT_EQ(scene.lighting.lightMap.g, 0.5);
    const std::string written = sceneJson(scene);
    EXPECT_EQ(parseScene(written, "/", "s").lighting, scene.lighting);
    const std::string plain = sceneJson(parsed(R"({"occlusion":{}})"));
    for (const char* key : {"directions", "weights", "shadowMap", "scatterBy", "lightMap"}) {
        EXPECT_NE(written.find(key), std::string::npos) << key;
        EXPECT_EQ(plain.find(key), std::string::npos) << key;
    }
}

// Light maps see what shadows do: of a light that casts none there is no map.
TEST(Scene, LightMapsNeedShadows) {
    const auto refusal = [](const std::string& light, const std::string& by) -> std::string {
        try {
            parseScene(R"({"tesseraScene":1,"volumes":[{"path":"/x"}],"lighting":{"scatterBy":")" + by +
                           R"(","lights":[)" + light + "]}}",
                       "/", "s");
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    const std::string open = R"({"kind":"directional","scatter":1})",
                      shaded = R"({"kind":"directional","scatter":1,"shadow":true})",
                      head = R"({"kind":"head","scatter":1,"shadow":true})",
                      off = R"({"kind":"directional","scatter":1,"intensity":0})";
    for (const std::string& light : {open, head, shaded + "," + open}) {
        EXPECT_NE(refusal(light, "map").find("\"shadow\": true of every light with \"scatter\""),
                  std::string::npos)
            << light;
        EXPECT_EQ(refusal(light, "rays"), "") << light;
    }
    EXPECT_EQ(refusal(shaded, "map"), "");
    EXPECT_EQ(refusal(shaded + "," + off, "map"), "");
}

// A volume may be made smaller and larger, mirrored and turned, but not flat: voxels of a millionth to a
// million times their volume.
TEST(Scene, TransformsCanBeInverted) {
    const auto refused = [](const std::string& x) {
        try {
            parseScene(R"({"tesseraScene":1,"volumes":[{"path":"x","transform":[)" + x +
                           ",0,0,5,0,1,0,6,0,0,1,7]}]}",
                       "/", "s");
        } catch (const InputError&) {
            return true;
        }
        return false;
    };
    for (const char* x : {"1", "-1", "0.0000010001", "-0.0000010001", "999999", "-999999"})
        EXPECT_FALSE(refused(x)) << x;
    for (const char* x : {"0", "0.00000099", "1000001", "-0.00000099"})
        EXPECT_TRUE(refused(x)) << x;
}

} // namespace
} // namespace tessera
