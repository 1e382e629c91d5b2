// The parts of `tessera bench` that compute: the gradient of figure 2.24, true errors of bricks, rank
// correlation, and the page.
#include "tests/bench/lod/brick_truth.h"
#include "tests/bench/lod/edge_functions.h"
#include "tests/bench/lod/pictures.h"
#include "tests/bench/report/page.h"

#include "bricking/import/importer.h"
#include "bricking/levels/selection.h"
#include "bricking/statistics/brick_rays.h"
#include "core/base/program_folders.h"
#include "core/image/image_metrics.h"
#include "core/scene/preset.h"
#include "datasets/phantom.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <numeric>

namespace tessera::bench {
namespace {

// As in figure 2.24, maximum distance gives the smoothest picture, the nearest brick alone the roughest.
TEST(GradientOfRandomLevels, MaximumDistanceIsTheSmoothest) {
    constexpr unsigned kSeeds = 4;
    const std::vector<EdgeFunctionRow> rows = compareEdgeFunctions(kSeeds);
    ASSERT_EQ(rows.size(), 4 * kSeeds);
    for (std::size_t first = 0; first < rows.size(); first += 4) {
        const EdgeFunctionRow &nearest = rows[first], &minimum = rows[first + 1], &split = rows[first + 2],
                              &maximum = rows[first + 3];
        EXPECT_EQ(nearest.function, EdgeFunction::nearest);
        EXPECT_EQ(maximum.function, EdgeFunction::maximum);
        EXPECT_LT(maximum.rmsBend, split.rmsBend);
        EXPECT_LT(split.rmsBend, minimum.rmsBend);
        EXPECT_LT(minimum.rmsBend, nearest.rmsBend);
        EXPECT_LT(maximum.largestBend, 0.5 * split.largestBend);
        for (const EdgeFunctionRow* row : {&nearest, &minimum, &split, &maximum}) {
            EXPECT_GT(row->mean, 0);
            EXPECT_LE(row->mean, row->p99);
            EXPECT_LE(row->p99, row->largest);
        }
    }
}

// All blocks at full resolution: the gradient itself. All at one coarse level: exact inside, because the
// gradient is linear; only the outermost half sample is clamped.
TEST(GradientOfRandomLevels, OneLevelForAllIsExactInside) {
    const GreyPicture original = rotatedGradient();
    const auto worstInside = [&](int level, int margin) {
        const GreyPicture picture = rebuilt(original, std::vector<int>(64, level), EdgeFunction::maximum);
        double worst = 0;
        for (int y = margin; y < kGradientPixels - margin; ++y)
            for (int x = margin; x < kGradientPixels - margin; ++x) {
                const auto at = static_cast<std::size_t>(y * kGradientPixels + x);
                worst = std::max(worst, std::abs(picture[at] - original[at]));
            }
        return worst;
    };
    EXPECT_EQ(worstInside(0, 0), 0);
    EXPECT_LT(worstInside(3, 4), 1e-12);
    EXPECT_GT(worstInside(3, 0), 1e-3);
}

TEST(GreyDifferences, AreLuvDistances) {
    // Between greys only lightness differs: black to white is 100.
    EXPECT_NEAR(greyDifferences({0}, {1}).front(), 100, 0.05);
    EXPECT_EQ(greyDifferences({0.3}, {0.3}).front(), 0);
}

TEST(LuvDifferences, HaveTheMeanThatCompareGives) {
    Image truth(glm::ivec2(8, 4)), image(glm::ivec2(8, 4));
    for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
        const float x = static_cast<float>(i) / 40;
        truth.pixels[i] = i % 5 == 0 ? glm::vec4(0) : glm::vec4(x, 0.5f * x, 0.2f, 1);
        image.pixels[i] = glm::vec4(0.3f, x, x, 1);
    }
    const std::vector<double> d = luvDifferences(image, truth);
    const ImageDifference all = compare(image, truth);
    const double sum = std::accumulate(d.begin(), d.end(), 0.0);
    EXPECT_NEAR(sum / static_cast<double>(all.maskedPixels), all.luvMean, 1e-9);
    EXPECT_EQ(d.front(), 0) << "the truth shows nothing there";
}

TEST(RankCorrelation, KnowsOrderTiesAndNothing) {
    EXPECT_DOUBLE_EQ(rankCorrelation({1, 2, 3, 10}, {0.1, 0.2, 5, 6}), 1);
    EXPECT_DOUBLE_EQ(rankCorrelation({1, 2, 3, 10}, {4, 3, 2, 1}), -1);
    EXPECT_TRUE(std::isnan(rankCorrelation({1, 2, 3}, {7, 7, 7})));
    // Ranks 0, 1.5, 1.5, 3 against 0, 1, 2, 3: 4.5 / sqrt(4.5 * 5).
    EXPECT_NEAR(rankCorrelation({1, 2, 2, 3}, {1, 2, 3, 4}), 4.5 / std::sqrt(4.5 * 5), 1e-12);
}

class TrueErrors : public testing::Test {
  protected:
    void SetUp() override {
        ImportOptions options;
        options.durable = false;
        importToStore(*makePhantom("torso", {70, 50, 75}), folder_ / "v.zarr", ram_, options);
        store_ = std::make_unique<StoreReader>(folder_ / "v.zarr", ram_);
        statistics_ = loadStatistics(*store_, ram_, 0);
        table_ = makeTable(presetFunction("soft-tissue", {-1024, 2000, true, 1, {}}));
        for (const std::uint8_t level :
             cullBricks(statistics_, table_, store_->info(), 0, Culling::unlit).levels)
            shows_.push_back(level != Selection::kEmpty);
    }
    const ScratchFolder folder_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{256} << 20};
    std::unique_ptr<StoreReader> store_;
    Statistics statistics_;
    TransferTable table_;
    std::vector<std::uint8_t> shows_;
};

// The prediction is the truth from a sample of its rays: no bias, and much the same order.
TEST_F(TrueErrors, AreWhatSampledRaysPredict) {
    const WholeLevels volume = loadLevels(*store_);
    const std::vector<std::uint8_t>& shows = shows_;
    const LevelErrors real = trueErrors(volume, shows, table_, 0);
    BrickRays rays = noBrickRays(store_->info(), kBrickRayParts, ram_);
    addBrickRays(*store_, shows, rays, ram_);
    const LevelErrors predicted = predictErrors(rays, shows, table_, store_->info());
    double sumReal = 0, sumPredicted = 0;
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        std::vector<double> a, b;
        for (std::size_t n = 0; n < shows.size(); ++n) {
            if (!shows[n]) {
                EXPECT_EQ(real.errors[n][level], 0);
                continue;
            }
            a.push_back(static_cast<double>(real.errors[n][level]));
            b.push_back(static_cast<double>(predicted.errors[n][level]));
            sumReal += a.back();
            sumPredicted += b.back();
        }
        ASSERT_GE(a.size(), 8u);
        EXPECT_GT(rankCorrelation(a, b), 0.6) << "level " << level;
    }
    EXPECT_NEAR(sumPredicted / sumReal, 1, 0.25);
}

TEST_F(TrueErrors, OfDataGrowWithTheLevel) {
    const WholeLevels volume = loadLevels(*store_);
    const LevelErrors data = dataErrors(volume, shows_, 0);
    for (std::size_t n = 0; n < data.shows.size(); ++n)
        for (std::size_t level = 1; data.shows[n] && level < kLevelCount; ++level)
            EXPECT_GT(data.errors[n][level], 0);
}

Table smallTable() {
    return {"numbers", "Some numbers:", {"what", "value"}, {{"a, b", 0.12345}, {"c", 12.0}}, true};
}

TEST(Page, TablesKeepAllDigitsInCsvAndFewOnThePage) {
    EXPECT_EQ(csvText(smallTable()), "what,value\n\"a, b\",0.12345\nc,12\n");
    EXPECT_EQ(markdownText(smallTable()), "| what | value |\n|---|---|\n| a, b | 0.123 |\n| c | 12 |\n");
    EXPECT_EQ(formatCell(1234567.0), "1234567");
    EXPECT_EQ(formatCell(1234.5678), "1235");
    EXPECT_EQ(formatCell(-0.5), "-0.5");
}

TEST(Page, SectionsAreReplacedAndKeepTheirOrder) {
    const std::vector<std::string> order = {"one", "two", "three"};
    const auto section = [](const std::string& name, const std::string& text) {
        Report report;
        report.name = name;
        report.title = text;
        return sectionText(report, {"command", "machine", "0"}, "files", {});
    };
    std::string page = mergedPage("", "# Head\n", "three", section("three", "third"), order);
    page = mergedPage(page, "# Head\n", "one", section("one", "first"), order);
    page = mergedPage(page, "# Head\n", "two", section("two", "second"), order);
    const std::string again = mergedPage(page, "# Head\n", "one", section("one", "renewed"), order);
    EXPECT_EQ(page.rfind("# Head\n", 0), 0u);
    EXPECT_LT(page.find("## first"), page.find("## second"));
    EXPECT_LT(page.find("## second"), page.find("## third"));
    EXPECT_EQ(again.find("## first"), std::string::npos);
    EXPECT_LT(again.find("## renewed"), again.find("## second"));
    EXPECT_EQ(mergedPage(again, "# Head\n", "one", section("one", "first"), order), page);
}

TEST(Page, ReportsAreWritten) {
    const ScratchFolder scratch;
    const std::filesystem::path folder = scratch / "report";
    Report report;
    report.name = "one";
    report.title = "Title";
    report.tables = {smallTable()};
    writeReport(report, {"command", "machine", "0"}, {folder, "page", "# Head\n", {"one"}});
    EXPECT_TRUE(std::filesystem::exists(folder / "page.md"));
    EXPECT_TRUE(std::filesystem::exists(folder / "page" / "numbers.csv"));
}

TEST(ColourMapped, GrowsBrighter) {
    const Image image = colourMapped({-1, 0, 1, 2, 3, 99}, {6, 1}, 3);
    EXPECT_EQ(image.pixels[0], image.pixels[1]) << "clamped below";
    EXPECT_EQ(image.pixels[4], image.pixels[5]) << "clamped above";
    const auto luminance = [](const glm::vec4& p) { return 0.2126f * p.r + 0.7152f * p.g + 0.0722f * p.b; };
    for (std::size_t i = 1; i < 4; ++i)
        EXPECT_LT(luminance(image.pixels[i]), luminance(image.pixels[i + 1]));
}

} // namespace
} // namespace tessera::bench
