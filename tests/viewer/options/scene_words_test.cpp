// tests/viewer/options/scene_words_test.cpp: names of options as keys of a scene, for tables and --set: what
// they set, what their values may be, and the key that a refusal names.
#include "viewer/cli/options/scene_words.h"

#include "core/base/error.h"
#include "core/scene/scene_fields.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/options/scene_options.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

Scene volumeScene() {
    return tessera::sceneOf(std::filesystem::path("v.zarr"));
}

/// Camera and slice; none: it is refused.
template <typename Change> std::optional<json> changed(Scene scene, const Change& change) {
    try {
        change(scene);
    } catch (const InputError&) {
        return std::nullopt;
    }
    const json whole = json::parse(sceneJson(scene));
    return json{whole.value("camera", json()), whole.value("slice", json())};
}

// A word does what the option of its name does, in a table as after --set, and by its key.
TEST(SceneWords, DoWhatTheirOptionsDo) {
    struct Case {
        std::string option;
        std::string RenderArguments::*text;
        std::vector<std::string> texts;
    };
    const std::vector<Case> cases = {
        {"view",
         &RenderArguments::view,
         {"superior", "top", "30,15", "-20.5,10", "sideways", "30", "0x10,5", "30,100", "1,2,3"}},
        {"projection", &RenderArguments::projection, {"parallel", "perspective", "oblique"}},
        {"fit", &RenderArguments::fit, {"volume", "kept", "shown", "tight"}},
    };
    Scene slice = volumeScene(), sided = volumeScene();
    slice.mode = Mode::slice;
    std::get<FittedView>(sided.camera).named = true;
    for (const Scene& before : {volumeScene(), slice, sided}) {
        const auto expectAlike = [&](const std::string& option, const std::string& text,
                                     const std::optional<json>& expected) {
            SCOPED_TRACE(option + "=" + text + ", mode " + nameOf(before.mode));
            for (const std::string& name : {option, "--" + option, keyNamed(option)})
                EXPECT_EQ(
                    changed(before,
                            [&](Scene& scene) { setKeyFromText(scene, keyNamed(name), text, "t.csv:2"); }),
                    expected)
                    << name;
            EXPECT_EQ(changed(before, [&](Scene& scene) { applySets({option + "=" + text}, scene); }),
                      expected);
        };
        for (const Case& one : cases)
            for (const std::string& text : one.texts)
                expectAlike(one.option, text, changed(before, [&](Scene& scene) {
                                RenderArguments arguments;
                                arguments.*one.text = text;
                                applyArguments(arguments, scene, CommonOptions());
                            }));
        for (const double mm : {0.5, 2.0})
            expectAlike("mm-per-pixel", std::to_string(mm), changed(before, [&](Scene& scene) {
                            RenderArguments arguments;
                            arguments.mmPerPixel = mm;
                            applyArguments(arguments, scene, CommonOptions());
                        }));
        if (facesThinVolume(before, false) || before.mode == Mode::slice)
            for (const std::string text : {"5", "5 mm", "3:maximum", "0:average", "-1", "5:sum", "x"})
                expectAlike("slab", text, changed(before, [&](Scene& scene) {
                                RenderArguments arguments;
                                arguments.mode.slab = text;
                                applyArguments(arguments, scene, CommonOptions());
                            }));
    }
    EXPECT_FALSE(changed(volumeScene(), [](Scene& s) { setKeyFromText(s, "camera.mmPerPixel", "0", "t"); }));
}

// Values in JSON stay what they are for a key.
TEST(SceneWords, KeysTakeTheirOwnValues) {
    Scene scene = volumeScene();
    setKeyFromText(scene, keyNamed("view"), "[30,15]", "t");
    EXPECT_EQ(std::get<FittedView>(scene.camera).angles->rise, 15);
    setKeyFromText(scene, keyNamed("--projection"), "true", "t");
    EXPECT_EQ(std::get<FittedView>(scene.camera).projection, Projection::parallel);
    applySets({"step=0.25", "slice={\"plane\":\"coronal\"}", "camera.view=[10,5]"}, scene);
    EXPECT_EQ(scene.quality.stepVoxels, 0.25);
    EXPECT_EQ(scene.slice.orientation, Orientation::coronal);
    EXPECT_EQ(std::get<FittedView>(scene.camera).angles->turn, 10);
    scene.camera = Camera();
    setKeyFromText(scene, "camera.view", "left", "t"); // takes the place of a camera by position
    EXPECT_EQ(std::get<FittedView>(scene.camera).view, View::left);
}

/// What a value is refused with; "" where it is taken.
std::string refusalOf(const std::string& key, const std::string& text) {
    Scene scene = volumeScene();
    const std::string before = sceneJson(scene);
    try {
        setKeyFromText(scene, key, text, "t.csv:2");
    } catch (const InputError& e) {
        EXPECT_EQ(sceneJson(scene), before) << key;
        return e.what();
    }
    return "";
}

// Every number of a scene is decimal, and every truth may be in capitals, as spreadsheets write it.
TEST(SceneWords, ValuesAreWhatSpreadsheetsWrite) {
    int numbers = 0, truths = 0;
    for (const KeyRow& row : sceneKeys()) {
        if (row.path.find("[]") != std::string::npos)
            continue;
        SCOPED_TRACE(row.path);
        const std::string type = row.schema.value("type", "");
        if (type == "number" || type == "integer") {
            ++numbers;
            for (const char* text :
                 {"0x1", "0X1F", "01", "007", "nan", "NaN", "inf", "-Infinity", "1e", "1.2.3", "1 2"})
                EXPECT_NE(refusalOf(row.path, text), "") << text;
            for (const char* text : {"0,5", "1,5", "-1,25"})
                EXPECT_THAT(refusalOf(row.path, text), HasSubstr("a decimal comma is not read")) << text;
        }
        if (type == "boolean" && refusalOf(row.path, "true").empty()) {
            ++truths;
            for (const bool truth : {true, false})
                for (const std::string& text : truth
                                                   ? std::vector<std::string>{"true", "TRUE", "True", "tRuE"}
                                                   : std::vector<std::string>{"false", "FALSE", "False"}) {
                    Scene a = volumeScene(), b = a;
                    setSceneKey(a, row.path, truth, "t");
                    setKeyFromText(b, row.path, text, "t");
                    EXPECT_EQ(sceneJson(a), sceneJson(b)) << text;
                }
            EXPECT_NE(refusalOf(row.path, "WAHR"), "");
            EXPECT_NE(refusalOf(row.path, "yes"), "");
        }
    }
    EXPECT_GT(numbers, 20);
    EXPECT_GT(truths, 3);
}

// A name that is none is refused with a key that there is, and with none where nothing is near.
TEST(SceneWords, HintsNameKeys) {
    for (const char* option :
         {"isosurface", "crop", "crop-voxels", "cut-plane", "mesh", "mesh-colour", "mesh-opacity",
          "mesh-space", "mesh-contours", "label-preset", "add", "add-preset"})
        for (const std::string& name : {std::string(option), "--" + std::string(option)}) {
            EXPECT_EQ(keyNamed(name), "") << name;
            const std::string key = keyInPlaceOf(name);
            EXPECT_EQ(keyNamed(key), key) << name;
            EXPECT_EQ(keyHint(name), "; nearest: \"" + key + "\"");
        }
    for (const KeyRow& row : sceneKeys()) {
        const std::string last = row.path.substr(row.path.rfind('.') + 1);
        if (last.size() < 4 || !keyNamed(last + "q").empty())
            continue;
        const std::string hint = keyHint(last + "q"); // a slip of a finger
        ASSERT_THAT(hint, HasSubstr("; nearest: \"")) << row.path;
        const std::string key = hint.substr(12, hint.size() - 13);
        EXPECT_NE(keyNamed(key), "") << key;
    }
    EXPECT_EQ(keyNamed("--no-shading"), "") << "true would turn it on";
    EXPECT_EQ(keyHint("no-shading"), "; nearest: \"shading.shade\"");
    Scene scene = volumeScene();
    EXPECT_THROW(applySets({"crop=0,1,0,1,0,1"}, scene), InputError);
    for (const char* far : {"comment", "patient birthday", "x", "remarks2019"})
        EXPECT_EQ(keyHint(far), "") << far;
}

} // namespace
} // namespace tessera
