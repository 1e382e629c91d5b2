// tests/render/contract/hostile_numbers_test.cpp: scenes with numbers that no hand would write: each number
// of a scene is made huge, tiny, or what float cannot hold. Whatever is read is drawn: finite, and the native
// engine has the float mirror's bits; else it is refused in a sentence.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/support/extreme_cases.h"
#include "tests/support/native_fixture.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;
using nlohmann::json;

/// Ends of what floats, their squares, and doubles hold, and what lies beyond.
const std::vector<double>& hostileNumbers() {
    static const std::vector<double> numbers = [] {
        std::vector<double> out = {0, -0.0, 16777217, 1e12, 9.9e12};
        for (const double size : {5e-324,
                                  2.3e-308,
                                  1e-300,
                                  1e-200,
                                  1e-154,
                                  1e-100,
                                  1e-46,
                                  1.4e-45,
                                  1e-38,
                                  1e-30,
                                  1e-20,
                                  1e-9,
                                  1e9,
                                  1e19,
                                  1e20,
                                  1e30,
                                  1.7e38,
                                  3.3e38,
                                  3.4028234663852886e38,
                                  3.5e38,
                                  1e46,
                                  1e47,
                                  1e80,
                                  1e100,
                                  1e154,
                                  1e155,
                                  1e200,
                                  1e300,
                                  1e308,
                                  1.7976931348623157e308}) {
            out.push_back(size);
            out.push_back(-size);
        }
        return out;
    }();
    return numbers;
}

/// Every number of a scene by its pointer.
void numbersOf(const json& value, const std::string& at, std::vector<std::string>& out) {
    if (value.is_number_float() || value.is_number_integer())
        out.push_back(at);
    if (value.is_object())
        for (const auto& [key, item] : value.items())
            if (key != "tesseraScene" && key != "size")
                numbersOf(item, at + "/" + key, out);
    if (value.is_array())
        for (std::size_t i = 0; i < value.size(); ++i)
            numbersOf(value[i], at + "/" + std::to_string(i), out);
}

/// Scenes that have every kind of number between them; all of a volume whose box is [0,20] mm or so.
std::vector<json> ordinaryScenes() {
    const json function = json::parse(
        R"({"scalarOpacityUnitDistance":1,"scalarOpacity":[[-900,0],[0,0.1],[0,0.3],[900,0.9]],
            "rgbTransferFunction":[[-500,1,0.5,0.25],[500,0,0.5,1]]})");
    const json camera =
        json::parse(R"({"position":[40,-60,50],"focalPoint":[10,10,8],"viewUp":[0,0,1],"viewAngle":30})");
    const auto scene = [&](const char* more) {
        json out = {{"tesseraScene", 1},
                    {"volumes", {{{"path", "/v.zarr"}, {"transferFunction", function}}}},
                    {"camera", camera},
                    {"quality", {{"stepVoxels", 0.5}, {"integrator", "midpoint"}, {"fetch", "exact"}}},
                    {"image", {{"size", {9, 8}}}}};
        out.update(json::parse(more), true);
        return out;
    };
    return {
        scene(R"({"quality":{"integrator":"pre-integrated"}})"),
        scene(R"({"isosurfaces":[{"value":-300,"opacity":0.5},{"value":200.5}],
                  "shading":{"gradientWeight":[2,80]}})"),
        scene(R"({"mode":"isosurface","isosurfaces":[{"value":10}]})"),
        scene(R"({"mode":"maximum","window":[40,400]})"),
        scene(R"({"mode":"average","valueColour":"transferFunction"})"),
        scene(R"({"mode":"slice","window":[40,400],"slice":{"plane":"oblique","point":[9,8,7],
                  "normal":[0.3,0.5,1],"thickness":3,"reduction":"minimum"}})"),
        scene(R"({"mode":"slice","slice":{"plane":"axial","position":8}})"),
        scene(R"({"cuts":{"boxes":[{"low":[1,2,3],"high":[12,13,9]},
                    {"low":[4,4,4],"high":[9,9,9],"space":"voxels","keep":"outside"}],
                  "planes":[{"point":[9,9,9],"normal":[1,1,0]}]}})"),
        scene(R"({"cuts":{"scissors":[{"camera":{"position":[40,-60,50],"focalPoint":[10,10,8],
                    "parallelProjection":true,"parallelScale":20},"aspect":1.2,
                    "outline":[[0.1,0.1],[0.8,0.2],[0.4,0.9]]}]}})"),
        scene(R"({"camera":{"parallelProjection":true,"parallelScale":15}})"),
        scene(R"({"lighting":{"lights":[{"kind":"directional","direction":[-1,1,2],"intensity":0.5},
                    {"kind":"point","frame":"patient","position":[10,-30,20],"attenuation":[1,0.1,0.01]}]},
                  "shading":{"model":"blinn-phong","gradientWeight":[2,80]}})"),
        [&] {
            json graded = scene("{}");
            graded["volumes"][0]["transferFunction"].update(json::parse(
                R"({"materials":[{"from":-100,"to":300,"ambient":0.3,"diffuse":0.5,"specular":0.1,
                      "specularPower":9}],"gradientOpacity":[[0,0.1],[20,0.5],[200,1]],
                    "gradientOpacityUnit":"voxel"})"));
            return graded;
        }(),
    };
}

/// A volume of smooth values, -1000 to 1000, sheared.
struct SmoothVolume {
    SmoothVolume() {
        info = plainInfo({40, 35, 34}, ValueType::i16);
        info.patientFromVoxel = patientFromVoxelOf({-1, 0.5, 0.25}, {0.5, 0, 0}, {0.1, 0.5, 0}, {0, 0, 0.5});
        HashSource source(info, [](int x, int y, int z) {
            return std::round(1000 * std::sin(0.31 * x + 0.2) * std::cos(0.23 * y) * std::sin(0.19 * z + 1));
        });
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        ImportOptions options;
        options.durable = false;
        importToStore(source, folder / "v.zarr", ram, options);
    }
    std::string path() const { return (folder / "v").string(); }
    ScratchFolder folder;
    VolumeInfo info;
};

void expectFinite(const Image& image, const char* what) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c)
            ASSERT_TRUE(std::isfinite(image.pixels[i][c])) << what << ": pixel " << i << ", component " << c;
}

/// Draws what a text says by the native engine and the mirror, or checks how it is refused.
/// @return whether it was drawn
bool drawnOrRefused(const std::string& text, const SmoothVolume& volume) {
    Scene scene;
    try {
        scene = parseScene(text, "/", "s.json");
    } catch (const InputError& refused) {
        const std::string message = refused.what();
        EXPECT_EQ(message.rfind("s.json: ", 0), 0u) << message;
        EXPECT_LT(message.size(), 300u) << message; // numbers are written short
        return false;
    }
    try {
        Prepared prepared(volume.path(), scene);
        const Image mirror = mirrorPicture(prepared);
        expectFinite(mirror, "mirror");
        NativeChoices choices;
        choices.target = nativeTargets().back();
        choices.threads = 1;
        const Image native = nativePicture(prepared, choices).image;
        expectFinite(native, "native");
        EXPECT_EQ(differing(native, mirror), 0u);
    } catch (const InputError& refused) {
        ADD_FAILURE() << "read, but not drawn: " << refused.what();
    }
    return true;
}

// Each number of each scene by itself.
TEST(HostileNumbers, EachIsDrawnOrRefused) {
    const SmoothVolume volume;
    std::mt19937 random(5);
    const std::vector<double>& numbers = hostileNumbers();
    int drawn = 0, refused = 0;
    std::map<std::string, int> seen; // numbers that scenes share are tried once
    for (const json& ordinary : ordinaryScenes()) {
        ASSERT_TRUE(drawnOrRefused(ordinary.dump(), volume)) << ordinary.dump();
        std::vector<std::string> places;
        numbersOf(ordinary, "", places);
        for (const std::string& place : places) {
            const bool value = place.find("/0/0") == std::string::npos;
            const int tries = seen[place]++ == 0 ? (value ? 6 : 12) : 1;
            for (int n = 0; n < tries; ++n) {
                json hostile = ordinary;
                hostile[json::json_pointer(place)] = numbers[random() % numbers.size()];
                SCOPED_TRACE(hostile.dump());
                ++(drawnOrRefused(hostile.dump(), volume) ? drawn : refused);
                if (HasFailure())
                    return;
            }
        }
    }
    std::printf("%d drawn, %d refused\n", drawn, refused);
    EXPECT_GE(drawn, 200);
    EXPECT_GE(refused, 100);
}

// Points of functions and surfaces that span anything: what crashed were spans, not single numbers.
TEST(HostileNumbers, FunctionsOfAnySpanAreDrawnOrRefused) {
    const SmoothVolume volume;
    std::mt19937 random(11);
    const std::vector<double>& numbers = hostileNumbers();
    const auto any = [&] { return numbers[random() % numbers.size()]; };
    const std::vector<json> scenes = ordinaryScenes();
    int drawn = 0;
    for (int n = 0; n < 240; ++n) {
        json hostile = scenes[random() % scenes.size()];
        json& function = hostile["volumes"][0]["transferFunction"];
        const double most = n % 3 == 0 ? 1.7976931348623157e308 : 3.4028234663852886e38;
        const auto within = [&] { return std::clamp(any(), -most, most); };
        function["scalarOpacity"] = {{within(), 0.0}, {within(), 1.0}, {within(), 0.5}};
        if (n % 2 == 0)
            function["rgbTransferFunction"] = {{within(), 1, 0.5, 0.25}, {within(), 0, 0.5, 1}};
        if (hostile.contains("isosurfaces"))
            for (json& surface : hostile["isosurfaces"])
                surface["value"] = within();
        if (hostile.contains("window"))
            hostile["window"] = {within(), std::abs(within())};
        SCOPED_TRACE(hostile.dump());
        drawn += drawnOrRefused(hostile.dump(), volume) ? 1 : 0;
        if (HasFailure())
            return;
    }
    std::printf("%d drawn\n", drawn);
    EXPECT_GE(drawn, 80);
}

// The whole renderer, with its searches and measurements, of what was once a segmentation fault.
TEST(HostileNumbers, TheRendererSurvivesFunctionsOfTheWidestSpan) {
    const SmoothVolume volume;
    for (const EngineKind engine : {EngineKind::native, EngineKind::mirror, EngineKind::reference})
        for (const double end : {1.0, 1e30, 3.4028234663852886e38}) {
            SCOPED_TRACE(end);
            json text = ordinaryScenes()[0];
            text["volumes"][0]["transferFunction"]["scalarOpacity"] = {{-end, 0.0}, {end, 1.0}};
            text["quality"] = json::object();
            Scene scene = parseScene(text.dump(), "/", "s.json");
            scene.volumes[0].path = volume.path() + ".zarr";
            MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
                gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
            const StoreReader store(scene.volumes[0].path, ram);
            RenderOptions options;
            options.engine = engine;
            options.threads = 1;
            options.searching = true;
            options.verify = Verify::quick;
            options.checking = true;
            expectFinite(renderScene(scene, store, ram, gpu, options).image, "renderer");
        }
    const std::string text = R"({"tesseraScene":1,"volumes":[{"path":"/v.zarr","transferFunction":
        {"scalarOpacity":[[-1e308,0],[1e308,1]]}}]})";
    try {
        parseScene(text, "/", "s.json");
        ADD_FAILURE() << "read";
    } catch (const InputError& refused) {
        EXPECT_STREQ(refused.what(), "s.json: $.volumes[0].transferFunction: expected a point's value within "
                                     "+-3.40282e+38, which a voxel can hold, found -1e+308");
    }
}

} // namespace
} // namespace tessera
