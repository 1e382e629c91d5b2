// tests/core/scene/preset_test.cpp: presets show what they are named after, and no more.
#include "core/scene/preset.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene.h"
#include "core/scene/scene_presets.h"

#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>

namespace tessera {
namespace {

using ::testing::HasSubstr;

TEST(Preset, AllAreReadableAndShowWhatTheyAreNamedAfter) {
    EXPECT_EQ(presetNames(), (std::vector<std::string>{"airways", "auto", "bone", "bone-1", "hot", "lung",
                                                       "lung-1", "metal", "mr-brain", "muscle", "pet", "skin",
                                                       "skin-1", "soft-tissue", "vessels", "vessels-1"}));
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

/// A line through tissue, HU at a place in mm: from one value to another, or a sheet between equal ones. It
/// is as blurred as a scan (a Gaussian's deviation, mm).
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
/// The opacity of a ray along 40 mm of it, by the exact function.
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

// Earlier built-in presets are there, number for number.
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

// A preset over shares of an object takes the values above the background, without the brightest voxels. A
// bladder of 40 in a body of 1 to 9 does not make the picture black.
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

// Whatever was chosen before, a built-in preset gives the settings that it gives on a scene of its own.
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

// Settings that no preset brought are the user's, and stay: light, a window, cuts, a plane.
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

// The largest values that a voxel can hold leave no room above them.
TEST(Presets, AutoSuitsTheLargestValues) {
    constexpr double kMost = std::numeric_limits<float>::max();
    for (const double lowest : {-kMost, 0.0, 0.9 * kMost})
        for (const std::size_t peak : {std::size_t{0}, std::size_t{63}}) {
            ValueSummary values;
            values.lowest = lowest, values.highest = kMost;
            values.histogram.assign(64, 0);
            values.histogram[0] = 1000, values.histogram[peak] += 10;
            const TransferFunction function = presetFunction("auto", values);
            EXPECT_GT(function.extinction(kMost), 0) << lowest << " " << peak;
        }
}

} // namespace
} // namespace tessera
