// tests/viewer/annotations/figure_part_test.cpp: what a figure takes of its scene and of what was drawn.
#include "viewer/annotations/figure_part.h"

#include "core/base/program_folders.h"
#include "tests/support/bricking_store_tools.h"

#include <algorithm>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <vector>

namespace tessera {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kFlags = 5;
/// A scene with some of what figures ask of it, by the bits of a number.
Scene sceneOf(unsigned asked, std::size_t volumes) {
    Scene scene;
    for (std::size_t n = 0; n < volumes; ++n)
        scene.volumes.push_back({{}, std::string("auto")});
    Annotations& a = scene.annotations;
    a.measurements = (asked & 1) != 0;
    a.error = (asked & 2) != 0;
    a.legend = (asked & 4) != 0;
    a.title = (asked & 8) != 0 ? "A title" : "";
    scene.background = (asked & 16) != 0 ? std::optional(glm::vec3(0.9F)) : std::nullopt;
    scene.measurements = {{MeasurementKind::distance, {{0, 0, 0}, {1, 0, 0}}}};
    return scene;
}

TEST(FigureParts, HaveWhatTheirSceneAsksFor) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", test::kPlenty);
    std::vector<std::unique_ptr<StoreReader>> readers;
    for (const bool known : {true, false}) {
        VolumeInfo info = test::obliqueInfo();
        info.orientationKnown = known;
        info.unit = known ? "HU" : "Bq";
        test::HashSource source(info);
        const std::filesystem::path path = folder / (known ? "known.zarr" : "unknown.zarr");
        test::import(path, source);
        readers.push_back(std::make_unique<StoreReader>(path, ram));
    }
    RenderResult result;
    result.image = Image({30, 20});
    result.camera.parallelScale = 77;
    for (unsigned asked = 0; asked < 1U << kFlags; ++asked)
        for (const std::vector<const StoreReader*>& stores :
             {std::vector<const StoreReader*>{readers[0].get()},
              {readers[1].get()},
              {readers[0].get(), readers[1].get()},
              {readers[0].get(), readers[0].get()}}) {
            const Scene scene = sceneOf(asked, stores.size());
            const FigureMaker maker(scene, stores, ram, 1);
            const Figure figure{result.image.size, scene.annotations.dpi, {maker.part(scene, result)}};
            ASSERT_EQ(figure.parts.size(), 1U);
            EXPECT_EQ(figure.size, glm::ivec2(30, 20));
            EXPECT_EQ(figure.dpi, scene.annotations.dpi);
            const FigurePart& part = figure.parts[0];
            EXPECT_EQ(part.from, glm::ivec2(0));
            EXPECT_EQ(part.size, glm::ivec2(30, 20));
            EXPECT_EQ(part.camera, result.camera);
            EXPECT_EQ(part.annotations, scene.annotations);
            EXPECT_EQ(part.onLight, (asked & 16) != 0);
            EXPECT_EQ(part.orientationKnown, stores.back() == readers[0].get()) << "of all volumes";
            EXPECT_EQ(part.measurements, (asked & 1) != 0 ? scene.measurements : std::vector<Measurement>());
            EXPECT_EQ(part.error, (asked & 2) != 0 ? "measured error: not measured" : "");
            EXPECT_EQ(part.mark, "");
            ASSERT_EQ(part.legend.size(), (asked & 4) != 0 ? stores.size() : 0U);
            for (std::size_t n = 0; n < part.legend.size(); ++n) {
                EXPECT_EQ(part.legend[n].unit, stores[n] == readers[0].get() ? "HU" : "Bq");
                EXPECT_EQ(part.legend[n].name, stores.size() > 1 ? "volume " + std::to_string(n + 1) : "");
                EXPECT_FALSE(part.legend[n].colours.empty());
            }
        }
}

// A slice is as thick as a voxel at least, and a circle has the values in it.
TEST(FigureParts, OfSlicesHaveTheirPlaneAndCirclesTheirValues) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", test::kPlenty);
    VolumeInfo info = test::obliqueInfo();
    info.unit = "HU";
    test::HashSource source(info);
    test::import(folder / "v.zarr", source);
    const StoreReader reader(folder / "v.zarr", ram);
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    Scene scene = sceneOf(1, 1);
    scene.measurements.push_back(
        {MeasurementKind::circle,
         {middle + glm::dvec3(3, 0, 0), middle + glm::dvec3(0, 3, 0), middle - glm::dvec3(3, 0, 0)}});
    scene.measurements.push_back(
        {MeasurementKind::circle,
         {glm::dvec3(9e4, 0, 0), glm::dvec3(9e4 + 1, 1, 0), glm::dvec3(9e4 + 2, 0, 0)}});
    RenderResult result;
    result.image = Image({30, 20});
    const FigureMaker maker(scene, std::vector<const StoreReader*>{&reader}, ram, 1);
    FigurePart part = maker.part(scene, result);
    EXPECT_FALSE(part.plane);
    ASSERT_EQ(part.values.size(), 3U);
    EXPECT_EQ(part.values[0], "") << "of a length";
    EXPECT_THAT(part.values[1], ::testing::MatchesRegex("mean .* HU, deviation .*"));
    EXPECT_EQ(part.values[2], "") << "outside of the volume";
    scene.mode = Mode::slice;
    for (const double thickness : {0.0, 40.0})
        for (const glm::dvec3& normal : {glm::dvec3(0, 0, 1), glm::dvec3(1, -2, 3)}) {
            scene.slice = {.orientation = Orientation::oblique,
                           .point = {1, 2, 3},
                           .normal = normal,
                           .thicknessMm = thickness};
            part = maker.part(scene, result);
            ASSERT_TRUE(part.plane);
            EXPECT_LT(glm::length(part.plane->normal - glm::normalize(normal)), 1e-12);
            double low = 0, high = 0; // of a voxel's corners along the normal
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 edge(corner & 1, corner >> 1 & 1, corner >> 2);
                const double at = glm::dot(glm::dmat3(info.patientFromVoxel) * edge, glm::normalize(normal));
                low = std::min(low, at), high = std::max(high, at);
            }
            EXPECT_NEAR(part.plane->halfMm, thickness > 0 ? 20 : (high - low) / 2, 1e-9);
        }
}

TEST(FigureParts, SayTheirErrorOrWhyThereIsNone) {
    RenderResult result;
    EXPECT_EQ(errorCaption(result), "measured error: not measured");
    result.measured.emplace();
    EXPECT_EQ(errorCaption(result), "measured error: not measured, because too few pixels show something");
    result.measured->all.luvMean = Estimate{0.5, 0.25, 0.75};
    EXPECT_EQ(errorCaption(result), "measured error: 0.5 (0.25 to 0.75) L*u*v* in the mean");
    result.measured->all.luvP99 = Estimate{2, 1, 3.25};
    EXPECT_EQ(errorCaption(result), "measured error: 2 (1 to 3.2) L*u*v* at the 99th percentile");
    result.measured->whyNot = "it is a film";
    EXPECT_EQ(errorCaption(result), "measured error: not measured, because it is a film");
}

// Words are light on what is dark for the eye, and on nothing.
TEST(FigureParts, AreOnLightByTheirLuminance) {
    EXPECT_FALSE(isLight(std::nullopt));
    EXPECT_FALSE(isLight(glm::vec3(0)));
    EXPECT_TRUE(isLight(glm::vec3(1)));
    EXPECT_FALSE(isLight(glm::vec3(0.17F)));
    EXPECT_TRUE(isLight(glm::vec3(0.19F))) << "a lightness of half";
    EXPECT_TRUE(isLight(glm::vec3(1, 0, 0)));
    EXPECT_TRUE(isLight(glm::vec3(0, 1, 0)));
    EXPECT_FALSE(isLight(glm::vec3(0, 0, 1)));
    EXPECT_FALSE(isLight(glm::vec3(0.5F, 0, 1)));
}

TEST(FigureParts, NameWhatIsAskedForFirst) {
    EXPECT_EQ(firstAnnotation({}), "");
    EXPECT_FALSE(Annotations().any());
    struct Case {
        void (*ask)(Annotations&);
        const char* option;
    };
    const Case cases[] = {{[](Annotations& a) { a.scaleBar = true; }, "--scale-bar"},
                          {[](Annotations& a) { a.directions = Directions::cube; }, "--directions"},
                          {[](Annotations& a) { a.legend = true; }, "--legend"},
                          {[](Annotations& a) { a.labelLegend = true; }, "--label-legend"},
                          {[](Annotations& a) { a.measurements = true; }, "--measurements"},
                          {[](Annotations& a) { a.error = true; }, "--error-caption"},
                          {[](Annotations& a) { a.title = "x"; }, "--title"},
                          {[](Annotations& a) { a.caption = "x"; }, "--caption"},
                          {[](Annotations& a) { a.arrows.resize(1); }, "annotations.arrows"}};
    for (const Case& one : cases) {
        Annotations annotations;
        one.ask(annotations);
        EXPECT_TRUE(annotations.any());
        EXPECT_EQ(firstAnnotation(annotations), one.option);
        Figure figure;
        figure.parts.resize(2);
        EXPECT_FALSE(figure.any());
        figure.parts[1].annotations = annotations;
        EXPECT_TRUE(figure.any());
    }
}

} // namespace
} // namespace tessera
