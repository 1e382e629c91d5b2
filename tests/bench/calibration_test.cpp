// The experiment "calibration": the truth that it finds by itself, how it counts what holds, its figure.
#include "tests/bench/lod/calibration.h"

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "datasets/phantom.h"
#include "render/picture/render_scene.h"
#include "tests/bench/report/page.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <sstream>

namespace tessera::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

CalibrationCase caseOf(double is, std::optional<Estimate> measured, std::optional<double> bound,
                       std::optional<double> asked = {}, const std::string& shortfall = "") {
    CalibrationCase c;
    c.is.luvP99 = is;
    c.predictedP99 = 2;
    c.measured.luvP99 = measured;
    c.measured.luvP99Bound = bound;
    c.asked = asked;
    c.shortfall = shortfall;
    return c;
}

TEST(CalibrationShares, CountWhatHoldsOfWhatWasSaid) {
    const std::vector<CalibrationCase> cases = {
        caseOf(4, Estimate{5, 4, 6}, 6),                      // just within
        caseOf(3.9, Estimate{5, 4, 6}, 6),                    // below the interval, within the bound
        caseOf(7, Estimate{5, 4, 6}, 6, 3.0, "it could not"), // above both, and said so
        caseOf(2.9, std::nullopt, 3, 3.0),                    // kept, not measured
        caseOf(3.1, Estimate{2.5, 2, 4}, 2.9, 3.0)};          // not kept
    std::vector<const CalibrationCase*> all;
    for (const CalibrationCase& c : cases)
        all.push_back(&c);
    const CalibrationShares s = sharesOf(all);
    EXPECT_EQ(s.cases, 5);
    EXPECT_EQ(s.maxError.hold, 1);
    EXPECT_EQ(s.maxError.of, 2);
    EXPECT_EQ(s.notReached, 1);
    EXPECT_EQ(s.p99.hold, 2);
    EXPECT_EQ(s.p99.of, 4);
    EXPECT_EQ(s.noP99, 1);
    EXPECT_EQ(s.bound.hold, 3);
    EXPECT_EQ(s.bound.of, 5);
    EXPECT_EQ(s.mean.of, 0);
    EXPECT_NEAR(s.trueToP99, 0.5 * (4 / 5.0 + 3.1 / 2.5), 1e-12); // of 0.78, 0.8, 1.24 and 1.4
    EXPECT_NEAR(s.trueToGuess, 3.9 / 2, 1e-12);
    EXPECT_TRUE(std::isnan(sharesOf({}).trueToP99));
}

TEST(CalibrationPlot, TellsEachMaxErrorApart) {
    const Plot plot =
        calibrationPlot({caseOf(4, Estimate{5, 4, 6}, 6), caseOf(2, Estimate{3, 1, 4}, 4, 3.0),
                         caseOf(8, std::nullopt, 9, 10.0), caseOf(0, Estimate{0, 0, 1}, 1, 1.0)});
    using Points = std::vector<std::pair<double, double>>;
    const auto pointsOf = [&](const std::string& label) {
        for (const Plot::Curve& curve : plot.curves)
            if (curve.label == label)
                return curve.points;
        ADD_FAILURE() << label;
        return Points();
    };
    EXPECT_EQ(pointsOf("predicted").size(), 4u);
    EXPECT_EQ(pointsOf("measured, by memory"), Points({{4, 5}}));
    EXPECT_EQ(pointsOf("measured, --max-error 3"), Points({{2, 3}}));
    EXPECT_TRUE(pointsOf("measured, --max-error 10").empty()) << "it was not measured";
    EXPECT_GT(pointsOf("measured, --max-error 1").at(0).first, 0) << "zero has no place on the axis";
}

// Against the reference's area means, which know nothing of the truth's places.
TEST(AreaTruths, AreTheReferencesAreaMeans) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    ImportOptions importing;
    importing.durable = false;
    importToStore(*makePhantom("torso", {70, 50, 75}), folder / "v.zarr", ram, importing);
    Scene scene;
    scene.volumes = {{folder / "v.zarr", std::string("bone-1")}};
    scene.imageSize = {32, 24};
    scene.shading.on = true;
    scene.quality.pixels = {128, PixelFilter::box, 5};
    const StoreReader store(folder / "v.zarr", ram);
    RenderOptions options;
    options.engine = EngineKind::reference;
    const RenderResult reference = renderScene(scene, store, ram, gpu, options);

    scene.camera = reference.camera;
    scene.quality.stepVoxels = 8; // the picture's, not the truth's
    scene.quality.pixels.samples = 1;
    AreaTruthEffort effort;
    effort.stepVoxels = 1.0 / 8;
    effort.referencePixels = 50;
    const AreaTruth truth = areaTruth(scene, effort, std::size_t{256} << 20);
    const ImageDifference off = compare(truth.means, reference.image);
    EXPECT_GT(truth.shown, 100u);
    EXPECT_NEAR(static_cast<double>(truth.shown), static_cast<double>(off.maskedPixels), 4)
        << "noise at borders";
    EXPECT_EQ(truth.referencePixels, 50);
    EXPECT_LT(truth.referenceLuvP99, 0.3);
    EXPECT_LT(truth.referenceRms, 1e-3);
    EXPECT_LT(off.luvMean, 0.25) << "noise of both, no more";
    EXPECT_LT(off.luvP99, 1.5);
    EXPECT_LT(std::abs(off.bias), 4e-4);
    EXPECT_GT(truth.noisy, 0u);
    EXPECT_GT(truth.noiseLuvP99, 0.2 * off.luvP99) << "what it says of its noise is what it has";
    EXPECT_LT(truth.noiseLuvP99, 2 * off.luvP99);
}

// A truth with as much noise as the picture has errors: mean and rms are the picture's alone.
TEST(AreaTruths, ComparisonsAreFreedOfTheTruthsNoise) {
    std::mt19937_64 random(3);
    const auto off = [&] { return 0.02f * (static_cast<float>(random() >> 40) * 0x1p-23f - 1); };
    AreaTruth truth;
    Image image({120, 120});
    Image exact = image;
    truth.means = truth.halves[0] = truth.halves[1] = image;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        exact.pixels[i] = glm::vec4(0.4f, 0.5f, 0.3f, 0.9f);
        const auto noisy = [&] { return exact.pixels[i] + glm::vec4(off(), off(), off(), off()); };
        image.pixels[i] = noisy();
        for (Image& half : truth.halves)
            half.pixels[i] = noisy();
        truth.means.pixels[i] = 0.5f * (truth.halves[0].pixels[i] + truth.halves[1].pixels[i]);
    }
    const ImageDifference is = compare(image, exact), with = compare(image, truth.means),
                          without = differenceTo(truth, image);
    EXPECT_GT(with.rms, 1.2 * is.rms);
    EXPECT_GT(with.luvMean, 1.2 * is.luvMean);
    EXPECT_NEAR(without.rms / is.rms, 1, 0.02);
    EXPECT_NEAR(without.luvMean / is.luvMean, 1, 0.02);
    EXPECT_EQ(without.luvP99, with.luvP99);
}

std::string textOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

// A figure that could not be drawn is said to be missing, and no page links it.
TEST(Page, SaysWhichFiguresAreMissing) {
    const ScratchFolder folder;
    Report report;
    report.name = "one";
    report.title = "Title";
    report.plots = {calibrationPlot({caseOf(4, Estimate{5, 4, 6}, 6)})};
    const PagePlace place{folder / "report", "page", "# Head\n", {"one"}};
    const std::string path = std::getenv("PATH");
    ASSERT_EQ(::setenv("PATH", "/nonexistent", 1), 0);
    const std::size_t missing = writeReport(report, {"command", "machine", "0"}, place);
    const std::string said = withoutFigures(missing);
    ASSERT_EQ(::setenv("PATH", path.c_str(), 1), 0);
    EXPECT_EQ(missing, 1u);
    EXPECT_THAT(said, HasSubstr("gnuplot is not installed"));
    EXPECT_THAT(textOf(folder / "report/page.md"), Not(HasSubstr("calibration.svg")));
    EXPECT_EQ(withoutFigures(0), "");
    if (std::system("command -v gnuplot > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "gnuplot is not installed: no figure is drawn";
    EXPECT_EQ(writeReport(report, {"command", "machine", "0"}, place), 0u);
    EXPECT_THAT(textOf(folder / "report/page.md"), HasSubstr("calibration.svg"));
    EXPECT_THAT(textOf(folder / "report/page/calibration.svg"), HasSubstr("measured, by memory"));
}

} // namespace
} // namespace tessera::bench
