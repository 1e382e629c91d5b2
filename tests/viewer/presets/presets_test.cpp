// tests/viewer/presets/presets_test.cpp: functions of other programs' files, against what those programs'
// formulas say of them; and ours, written for them and read again.
#include "core/base/error.h"
#include "core/image/colour.h"
#include "core/scene/preset.h"
#include "viewer/presets/foreign_preset.h"

#include <cmath>
#include <ctime>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

double opacityOf(const TransferFunction& f, double value) {
    return -std::expm1(-f.extinction(value) * f.referenceLengthMm());
}
glm::dvec3 screenOf(const TransferFunction& f, double value) {
    const glm::dvec3 c = f.colour(value);
    return {srgbFromLinear(c.r), srgbFromLinear(c.g), srgbFromLinear(c.b)};
}
Preset only(const std::vector<ForeignPreset>& all) {
    EXPECT_EQ(all.size(), 1u);
    return all.at(0).preset;
}
void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance, double value) {
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(a[c], b[c], tolerance) << "component " << c << " at " << value;
}
template <typename Act> std::string refusal(const Act& act) {
    try {
        act();
    } catch (const InputError& e) {
        return e.what();
    }
    return "not refused";
}

// The example of Slicer's own documentation: CT-AAA.
constexpr const char* kVp = "1\n1\n0.9\n0.1\n0.2\n10\n"
                            "14 -3024 0 -86.9767 0 45.3791 0.169643 139.919 0.589286 347.907 0.607143 "
                            "1224.16 0.607143 3071 0.616071\n"
                            "4 0 1 255 1\n"
                            "28 -3024 0 0 0 -86.9767 0 0.25098 1 45.3791 1 0 0 139.919 1 0.894893 0.894893 "
                            "347.907 1 1 0.25098 1224.16 1 1 1 3071 0.827451 0.658824 1\n";

TEST(ForeignPresets, SlicersLinesAreStraightAsScreensShowThem) {
    const auto all = readForeignPresets(kVp, PresetFormat::slicerText, "aaa.vp");
    EXPECT_THAT(all.at(0).leftOut, IsEmpty());
    const TransferFunction& f = all.at(0).preset.function;
    EXPECT_EQ(f.referenceLengthMm(), 1);
    EXPECT_NEAR(opacityOf(f, 45.3791), 0.169643, 1e-9);
    EXPECT_NEAR(opacityOf(f, -20.7988), 0.169643 / 2, 1e-4); // between two points
    // Half-way between (0, .25098, 1) and (1, 0, 0), in what a screen shows; in linear light it would be
    // 0.735.
    expectNear(screenOf(f, -20.7988), {0.5, 0.12549, 0.5}, 2 * kColourError, -20.7988);
    expectNear(screenOf(f, 4000), {0.827451, 0.658824, 1}, 1e-9, 4000);
    const auto look = nlohmann::json::parse(all.at(0).preset.look);
    EXPECT_EQ(look["shading"]["diffuse"], 0.9);
    EXPECT_EQ(look["shading"]["ambient"], 0.1);
    EXPECT_EQ(look["shading"]["specularPower"], 10);
}

TEST(ForeignPresets, MrmlNamesItsProperties) {
    const std::string xml = "<MRML><VolumeProperty name=\"One\" shade=\"0\" scalarOpacity=\"4 0 0 100 1\" "
                            "colorTransfer=\"8 0 0 0 0 100 1 1 1\" gradientOpacity=\"4 0 0 60 1\"/>"
                            "<VolumeProperty name=\"InAFile\"/>"
                            "<VolumeProperty name=\"Two\" scalarOpacity=\"2 7 0.5\"/></MRML>";
    const auto all = readForeignPresets(xml, PresetFormat::slicerXml, "p.xml");
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].preset.name, "One");
    EXPECT_EQ(all[1].preset.name, "Two");
    EXPECT_THAT(all[0].leftOut, IsEmpty());
    EXPECT_EQ(all[0].preset.function.gradientOpacity(),
              GradientOpacity::fromPoints({{0, 0}, {60, 1}}, GradientOpacity::Per::voxel));
    EXPECT_TRUE(all[1].preset.function.gradientOpacity().isOne());
    EXPECT_EQ(nlohmann::json::parse(all[0].preset.look)["shading"]["shade"], false);
    EXPECT_NEAR(opacityOf(all[1].preset.function, -1e6), 0.5, 1e-9);
}

// Lengths are told by VTK's unit, a voxel; switched off it is none; and what bends gets points, 16 at most.
TEST(ForeignPresets, OpacityByGradient) {
    const auto text = [](const nlohmann::json& points, bool disabled) {
        return nlohmann::json({{"volumeProperties",
                                {{{"components",
                                   {{{"disableGradientOpacity", disabled},
                                     {"scalarOpacity", {{"points", {{{"x", 0}, {"y", 0.2}}}}}},
                                     {"gradientOpacity", {{"points", points}}}}}}}}}})
            .dump();
    };
    const nlohmann::json straight = {{{"x", -3}, {"y", 0}}, {{"x", 10}, {"y", 0.25}}, {{"x", 90}, {"y", 1}}};
    const Preset preset =
        only(readForeignPresets(text(straight, false), PresetFormat::slicerJson, "p.vp.json"));
    const GradientOpacity expected =
        GradientOpacity::fromPoints({{0, 0}, {10, 0.25}, {90, 1}}, GradientOpacity::Per::voxel);
    EXPECT_EQ(preset.function.gradientOpacity(), expected);
    EXPECT_TRUE(only(readForeignPresets(text(straight, true), PresetFormat::slicerJson, "p.vp.json"))
                    .function.gradientOpacity()
                    .isOne());
    const ForeignText written = writeForeignPreset(preset, PresetFormat::slicerJson);
    EXPECT_THAT(written.leftOut, IsEmpty());
    EXPECT_EQ(only(readForeignPresets(written.text, PresetFormat::slicerJson, "p.vp.json"))
                  .function.gradientOpacity(),
              expected);
    EXPECT_THAT(writeForeignPreset(preset, PresetFormat::paraView).leftOut,
                ::testing::Contains("gradient opacity"));

    Preset perMm = preset;
    perMm.function.setGradientOpacity(GradientOpacity::fromPoints({{0, 0}, {30, 1}}));
    EXPECT_THAT(writeForeignPreset(perMm, PresetFormat::slicerJson).leftOut,
                ElementsAre(HasSubstr("is per mm")));

    const nlohmann::json bent = {{{"x", 0}, {"y", 0}, {"midpoint", 0.5}, {"sharpness", 0.5}},
                                 {{"x", 100}, {"y", 1}}};
    const auto all = readForeignPresets(text(bent, false), PresetFormat::slicerJson, "p.vp.json");
    const GradientOpacity smooth = all.at(0).preset.function.gradientOpacity();
    EXPECT_LE(smooth.points().size(), GradientOpacity::kMostPoints);
    EXPECT_GT(smooth.points().size(), 8u);
    EXPECT_THAT(all.at(0).leftOut, ElementsAre(HasSubstr("beyond 16")));
    EXPECT_NEAR(smooth.factor(50), 0.5, 0.01);
    EXPECT_NEAR(smooth.factor(30) + smooth.factor(70), 1.0, 0.04);
    EXPECT_LT(smooth.factor(20), 0.03);
    nlohmann::json many = nlohmann::json::array();
    for (int i = 0; i < 257; ++i)
        many.push_back({{"x", i}, {"y", 0.5}});
    EXPECT_THAT(
        refusal([&] { readForeignPresets(text(many, false), PresetFormat::slicerJson, "p.vp.json"); }),
        HasSubstr("at most 256 points"));
}

// Points of VTK bend by midpoint and sharpness. At sharpness 0 the curve is two straight lines that meet half
// way up where the midpoint lies; at 1 it is a step there.
TEST(ForeignPresets, MidpointsAndSharpnessBendCurves) {
    const auto text = [](double midpoint, double sharpness) {
        return nlohmann::json(
                   {{"volumeProperties",
                     {{{"components",
                        {{{"scalarOpacityUnitDistance", 2.5},
                          {"scalarOpacity",
                           {{"points",
                             {{{"x", 0}, {"y", 0.2}, {"midpoint", midpoint}, {"sharpness", sharpness}},
                              {{"x", 100}, {"y", 0.8}}}}}}}}}}}}})
            .dump();
    };
    const Preset bent = only(readForeignPresets(text(0.25, 0), PresetFormat::slicerJson, "p.vp.json"));
    EXPECT_EQ(bent.function.referenceLengthMm(), 2.5);
    EXPECT_NEAR(opacityOf(bent.function, 25), 0.5, 2 * kOpacityError);
    EXPECT_NEAR(opacityOf(bent.function, 12.5), 0.35, 2 * kOpacityError);
    EXPECT_NEAR(opacityOf(bent.function, 62.5), 0.65, 2 * kOpacityError);
    const Preset step = only(readForeignPresets(text(0.25, 1), PresetFormat::slicerJson, "p.vp.json"));
    EXPECT_NEAR(opacityOf(step.function, 24.9), 0.2, 1e-6);
    EXPECT_NEAR(opacityOf(step.function, 25.1), 0.8, 1e-6);
    // Hermite in between: symmetric about the midpoint, flat at the ends.
    const Preset smooth = only(readForeignPresets(text(0.5, 0.5), PresetFormat::slicerJson, "p.vp.json"));
    EXPECT_NEAR(opacityOf(smooth.function, 50), 0.5, 2 * kOpacityError);
    EXPECT_NEAR(opacityOf(smooth.function, 30) + opacityOf(smooth.function, 70), 1.0, 4 * kOpacityError);
    EXPECT_LT(opacityOf(smooth.function, 20), 0.21);
}

TEST(ForeignPresets, ParaViewsColourSpaces) {
    const auto map = [](const char* space) {
        return std::string("[{\"Name\": \"m\", \"ColorSpace\": \"") + space +
               "\", \"RGBPoints\": [0, 1, 0, 0, 1, 0, 0, 1], \"Points\": [0, 0, 0.5, 0, 1, 1, 0.5, 0]}]";
    };
    const auto middle = [&](const char* space) {
        const Preset p = only(readForeignPresets(map(space), PresetFormat::paraView, "m.json"));
        EXPECT_EQ(p.unit, PresetUnit::share);
        return screenOf(p.function, 0.5);
    };
    expectNear(middle("RGB"), {0.5, 0, 0.5}, 2 * kColourError, 0.5);
    // Hue 0 to 2/3, without wrapping half way is 1/3: green; the short way round, 5/6: magenta.
    expectNear(middle("HsvNoWrap"), {0, 1, 0}, 2 * kColourError, 0.5);
    expectNear(middle("HSV"), {1, 0, 1}, 2 * kColourError, 0.5);
    // A step takes the colour of the point above it.
    expectNear(middle("Step"), {0, 0, 1}, 2 * kColourError, 0.5);
    // CIELAB of red is (53.2, 80.1, 67.2), of blue (32.3, 79.2, -107.9): the mean is (42.8, 79.6, -20.3).
    expectNear(middle("Lab"), {0.792, 0, 0.537}, 0.012, 0.5);
}

TEST(ForeignPresets, SharesOfARangeWantARange) {
    const std::string text = "[{\"ColorSpace\": \"RGB\", \"RGBPoints\": [0, 0, 0, 0, 1, 1, 1, 1]}]";
    const auto all = readForeignPresets(text, PresetFormat::paraView, "grey.json");
    EXPECT_THAT(all.at(0).leftOut, ElementsAre(HasSubstr("a ramp from 0 to 1")));
    Scene scene;
    scene.volumes.push_back({});
    EXPECT_THAT(refusal([&] { applyPreset(all.at(0).preset, scene); }), HasSubstr("shares of a range"));
    const Preset ranged = overRange(all.at(0).preset, -1000, 3000);
    EXPECT_NEAR(opacityOf(ranged.function, 0), 0.25, 1e-9);
    EXPECT_NO_THROW(applyPreset(ranged, scene));
    EXPECT_THAT(refusal([&] { overRange(ranged, 3, 3); }), HasSubstr("a range of values"));
}

// Our presets through another program's file look the same.
TEST(ForeignPresets, OursComeBack) {
    for (const std::string name : {"bone", "lung", "skin", "soft-tissue", "vessels"})
        for (const PresetFormat format : {PresetFormat::slicerJson, PresetFormat::paraView}) {
            SCOPED_TRACE(name);
            Preset preset;
            preset.name = name;
            preset.function = presetFunction(name, {});
            const Preset back =
                only(readForeignPresets(writeForeignPreset(preset, format).text, format, "written"));
            for (double value = -1100; value < 3100; value += 0.7) {
                EXPECT_NEAR(opacityOf(back.function, value), opacityOf(preset.function, value), 1e-6)
                    << value;
                expectNear(screenOf(back.function, value), screenOf(preset.function, value),
                           2.1 * kColourError, value);
            }
        }
}

TEST(ForeignPresets, StepsComeBack) {
    Preset preset;
    preset.name = "steps";
    preset.function = TransferFunction::fromOpacity({{10, 0}, {10, 0.5}, {20, 0.5}, {20, 0.1}},
                                                    {{10, {1, 0, 0}}, {10, {0, 1, 0}}}, 1);
    for (const PresetFormat format : {PresetFormat::slicerJson, PresetFormat::paraView}) {
        const Preset back =
            only(readForeignPresets(writeForeignPreset(preset, format).text, format, "written"));
        for (const double value : {9.999, 10.001, 19.999, 20.001}) {
            EXPECT_NEAR(opacityOf(back.function, value), opacityOf(preset.function, value), 1e-9) << value;
            expectNear(screenOf(back.function, value), screenOf(preset.function, value), 1e-9, value);
        }
    }
}

TEST(ForeignPresets, TwoPointsAtOnePlaceAreAStep) {
    const std::string xml = "<MRML><VolumeProperty name=\"Steps\" shade=\"0\" "
                            "scalarOpacity=\"12 10 0 10 0.5 20 0.5 20 0.1 30 0.1 30 0.8\" "
                            "colorTransfer=\"8 10 1 0 0 10 0 1 0\"/></MRML>";
    const TransferFunction f = only(readForeignPresets(xml, PresetFormat::slicerXml, "p.xml")).function;
    for (const auto& [value, opacity] :
         {std::pair(9.99, 0.0), {10.01, 0.5}, {19.99, 0.5}, {20.01, 0.1}, {29.99, 0.1}, {30.01, 0.8}})
        EXPECT_NEAR(opacityOf(f, value), opacity, 1e-9) << value;
    expectNear(screenOf(f, 9.99), {1, 0, 0}, 1e-9, 9.99);
    expectNear(screenOf(f, 10.01), {0, 1, 0}, 1e-9, 10.01);
}

TEST(ForeignPresets, WhatTheyCannotSayIsSaid) {
    Preset preset;
    preset.function = presetFunction("bone-1", {});
    preset.look = R"({"mode": "maximum", "window": "auto", "lighting": {}, "shading": {"ambient": 0.5}})";
    EXPECT_THAT(writeForeignPreset(preset, PresetFormat::slicerJson).leftOut, ElementsAre("\"mode\""));
    EXPECT_THAT(writeForeignPreset(preset, PresetFormat::paraView).leftOut,
                ElementsAre("\"mode\"", "\"shading\""));
    preset.function.setTissues({{0, 1, Phase{}, {}}});
    for (const PresetFormat format : {PresetFormat::slicerJson, PresetFormat::paraView})
        EXPECT_THAT(writeForeignPreset(preset, format).leftOut, Contains("tissues"));
}

// Curves of many points cost VTK the square of their number.
TEST(ForeignPresets, LongCurvesAreRefusedAndTheLongestAreQuick) {
    const auto slicer = [](std::size_t count) {
        std::string points;
        for (std::size_t i = 0; i < count; ++i)
            points += (i > 0 ? "," : "") +
                      ("{\"x\":" + std::to_string(i) + ",\"y\":0." + std::to_string(i % 10) + "}");
        return "{\"volumeProperties\":[{\"components\":[{\"scalarOpacity\":{\"points\":[" + points +
               "]}}]}]}";
    };
    const auto paraView = [](std::size_t count) {
        std::string numbers;
        for (std::size_t i = 0; i < count; ++i)
            numbers += (i > 0 ? "," : "") + std::to_string(i) + ",0.5,0.25,0." + std::to_string(i % 10);
        return "[{\"ColorSpace\":\"Lab\",\"RGBPoints\":[" + numbers + "]}]";
    };
    const std::clock_t start = std::clock();
    EXPECT_THAT(refusal([&] { readForeignPresets(slicer(100000), PresetFormat::slicerJson, "x"); }),
                HasSubstr("at most 2048 points"));
    EXPECT_THAT(refusal([&] { readForeignPresets(paraView(50000), PresetFormat::paraView, "x"); }),
                HasSubstr("at most 8192 numbers"));
    EXPECT_EQ(readForeignPresets(slicer(2048), PresetFormat::slicerJson, "x").size(), 1u);
    EXPECT_EQ(readForeignPresets(paraView(2048), PresetFormat::paraView, "x").size(), 1u);
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 8);
}

TEST(ForeignPresets, LiesAreRefused) {
    using F = PresetFormat;
    const std::string vp = kVp;
    const auto of = [](const std::string& text, F format) {
        return refusal([&] { readForeignPresets(text, format, "x"); });
    };
    EXPECT_THAT(of(vp.substr(0, vp.size() / 2), F::slicerText), HasSubstr("expected"));
    EXPECT_THAT(of("1\n1\n", F::slicerText), HasSubstr("nine lines"));
    std::string lie = vp;
    lie.replace(lie.find("14 -3024"), 2, "99");
    EXPECT_THAT(of(lie, F::slicerText), HasSubstr("14 numbers after the count 99"));
    std::string odd = vp;
    odd.replace(odd.find("nan") == std::string::npos ? odd.find("0.169643") : 0, 8, "infinity");
    EXPECT_THAT(of(odd, F::slicerText), HasSubstr("finite numbers"));
    EXPECT_THAT(of("<MRML><VolumeProperty", F::slicerXml), HasSubstr("XML"));
    EXPECT_THAT(of("<MRML/>", F::slicerXml), HasSubstr("VolumeProperty"));
    EXPECT_THAT(of("{\"volumeProperties\": []}", F::slicerJson), HasSubstr("at least one"));
    EXPECT_THAT(of("{\"volumeProperties\": [{\"components\": [{}]}]}", F::slicerJson),
                HasSubstr("scalarOpacity"));
    EXPECT_THAT(of("[{\"RGBPoints\": [0, 1, 0]}]", F::paraView), HasSubstr("groups of 4"));
    EXPECT_THAT(of("[{\"RGBPoints\": [0,0,0,0,1,1,1,1], \"ColorSpace\": \"CMYK\"}]", F::paraView),
                HasSubstr("RGB"));
    EXPECT_THAT(of("[{\"IndexedColors\": [1, 1, 1]}]", F::paraView), HasSubstr("RGBPoints"));
    EXPECT_THAT(of("[{\"RGBPoints\": [0,0,0,0,1e999,1,1,1]}]", F::paraView), HasSubstr("expected"));
}

// A preset saved as one's own keeps all visible settings of the scene, whatever the scene was that takes it.
TEST(OwnPresets, CarryAWholeLook) {
    Scene scene;
    scene.volumes.push_back({});
    scene.volumes.front().transferFunction = presetFunction("lung", {});
    scene.mode = Mode::maximum;
    scene.window = GreyWindow{40, 400};
    scene.shading.ambient = 0.6;
    scene.cuts.boxes.push_back({glm::dvec3(1), glm::dvec3(5), CropBox::Space::patient, Keep::inside});
    scene.surfaces.push_back({300, {1, 0.5, 0}, 0.5});
    const Preset mine = parsePreset(presetJson(presetOf(scene, "mine")), "mine", "mine.json");
    Scene other;
    other.volumes.push_back({});
    other.shading.on = false;
    other.lighting.occlusion.emplace();
    applyPreset(mine, other);
    Scene same = scene;
    EXPECT_EQ(sceneJson(other), sceneJson(same));
    // Settings that a preset does not name stay.
    const Preset bare = parsePreset(R"({"tesseraPreset": 1, "scalarOpacity": [[0, 0], [1, 1]]})", "b", "b");
    applyPreset(bare, other);
    EXPECT_EQ(other.mode, Mode::maximum);
    EXPECT_EQ(other.cuts.boxes.size(), 1u);
    EXPECT_THAT(refusal([] {
                    parsePreset(R"({"tesseraPreset": 1, "scalarOpacity": [], "mode": "x-ray"})", "b",
                                "b.json");
                }),
                HasSubstr("maximum"));
    EXPECT_THAT(
        refusal([] { parsePreset(R"({"tesseraPreset": 1, "scalarOpacity": [], "camera": 1})", "b", "b"); }),
        HasSubstr("camera"));
}

} // namespace
} // namespace tessera
