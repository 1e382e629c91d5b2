// tests/bench/lod/edge_functions.cpp: see edge_functions.h.
#include "tests/bench/lod/edge_functions.h"

#include "core/image/colour.h"
#include "render/contract/sampler.h"
#include "tests/bench/lod/pictures.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace tessera::bench {
namespace {

constexpr int kBlocks = kGradientPixels / kBrickExtent;
constexpr EdgeFunction kAllFunctions[] = {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::split,
                                          EdgeFunction::maximum};

/// A picture as a volume one brick deep, its levels 2x2 means, for interblockValue().
class PictureSamples {
  public:
    PictureSamples(const GreyPicture& picture, const LevelMap& map) : map_(map) {
        levels_[0] = picture;
        for (std::size_t level = 1; level < levels_.size(); ++level) {
            const int n = kGradientPixels >> level;
            const std::vector<double>& finer = levels_[level - 1];
            const auto at = [&](int x, int y) { return finer[static_cast<std::size_t>(2 * n * y + x)]; };
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x)
                    levels_[level].push_back((at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) +
                                              at(2 * x + 1, 2 * y + 1)) /
                                             4);
        }
    }
    const LevelMap& map() const { return map_; }
    double at(int level, const glm::ivec3& i) const {
        const int n = kGradientPixels >> level;
        return levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(n * i.y + i.x)];
    }
    double mean(const glm::ivec3& brick) const { return at(kLevelCount - 1, brick); }
    static bool isEmpty(const glm::ivec3&) { return false; }

  private:
    const LevelMap& map_;
    std::array<std::vector<double>, kLevelCount> levels_;
};

Image greyImage(const GreyPicture& picture) {
    Image image(glm::ivec2{kGradientPixels});
    for (std::size_t i = 0; i < picture.size(); ++i)
        image.pixels[i] = glm::vec4(glm::vec3(static_cast<float>(linearFromSrgb(picture[i]))), 1.0f);
    return image;
}

EdgeFunctionRow measured(const GreyPicture& original, const GreyPicture& picture) {
    EdgeFunctionRow row;
    std::vector<double> differences = greyDifferences(picture, original);
    for (const double d : differences)
        row.mean += d / static_cast<double>(differences.size());
    std::sort(differences.begin(), differences.end());
    row.p99 = differences[differences.size() * 99 / 100];
    row.largest = differences.back();
    double squares = 0;
    std::size_t count = 0;
    for (const std::size_t stride : {std::size_t{1}, std::size_t{kGradientPixels}})
        for (std::size_t line = 0; line < kGradientPixels; ++line)
            for (std::size_t i = 1; i + 1 < kGradientPixels; ++i) {
                const std::size_t at = line * (stride == 1 ? kGradientPixels : 1) + i * stride;
                const double bend =
                    255 * std::abs(picture[at - stride] - 2 * picture[at] + picture[at + stride]);
                row.largestBend = std::max(row.largestBend, bend);
                squares += bend * bend;
                ++count;
            }
    row.rmsBend = std::sqrt(squares / static_cast<double>(count));
    return row;
}

} // namespace

GreyPicture rotatedGradient() {
    constexpr double kTurn = 10 * 3.14159265358979323846 / 180; // "slightly": no block border lies along it
    GreyPicture picture;
    const double along = std::cos(kTurn), across = std::sin(kTurn);
    for (int y = 0; y < kGradientPixels; ++y)
        for (int x = 0; x < kGradientPixels; ++x)
            picture.push_back(((x + 0.5) * along + (y + 0.5) * across) /
                              (kGradientPixels * (along + across)));
    return picture;
}

std::vector<int> randomBlockLevels(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<int> levels;
    for (int block = 0; block < kBlocks * kBlocks; ++block)
        levels.push_back(static_cast<int>(random() % unsigned{kLevelCount}));
    return levels;
}

GreyPicture rebuilt(const GreyPicture& original, const std::vector<int>& blockLevels, EdgeFunction function) {
    Selection selection;
    selection.bricks = {kBlocks, kBlocks, 1};
    for (const int level : blockLevels) {
        selection.levels.push_back(static_cast<std::uint8_t>(level));
        ++selection.counts[static_cast<std::size_t>(level)];
    }
    MemoryBudget ram("RAM", "--ram", LevelMap::bytes(selection.bricks));
    Quality quality;
    quality.edgeFunction = function;
    const LevelMap map =
        makeLevelMap(selection, {kGradientPixels, kGradientPixels, kBrickExtent}, quality, ram);
    PictureSamples samples(original, map);
    GreyPicture picture;
    for (int y = 0; y < kGradientPixels; ++y)
        for (int x = 0; x < kGradientPixels; ++x)
            picture.push_back(interblockValue(samples, glm::dvec3(x + 0.5, y + 0.5, 0.5 * kBrickExtent)));
    return picture;
}

std::vector<double> greyDifferences(const GreyPicture& a, const GreyPicture& b) {
    const auto luv = [](double grey) { return luvFromLinear(glm::dvec3(linearFromSrgb(grey))); };
    std::vector<double> differences;
    for (std::size_t i = 0; i < a.size(); ++i)
        differences.push_back(glm::length(luv(a[i]) - luv(b[i])));
    return differences;
}

std::vector<EdgeFunctionRow> compareEdgeFunctions(unsigned seeds) {
    const GreyPicture original = rotatedGradient();
    std::vector<EdgeFunctionRow> rows;
    for (unsigned seed = 1; seed <= seeds; ++seed)
        for (const EdgeFunction function : kAllFunctions) {
            rows.push_back(measured(original, rebuilt(original, randomBlockLevels(seed), function)));
            rows.back().function = function;
            rows.back().seed = seed;
        }
    return rows;
}

Report edgeFunctionReport(unsigned seeds) {
    constexpr double kFullScale = 8; // L*u*v* that the colour map ends at
    Report report;
    report.name = "gradient";
    report.title = "Edge functions on a gradient (figure 2.24)";
    report.text = {"A grey gradient of 256 x 256 pixels, turned by 10 degrees, in 8 x 8 blocks of 32 x 32 "
                   "pixels. Every block has a random level from 32 x 32 samples down to one; the picture is "
                   "read from the product's own field. Errors are CIE L*u*v* distances to the gradient; the "
                   "bend is the second difference along rows and columns, in grey values of 255: 0 for a "
                   "gradient, large at a seam."};
    const std::vector<EdgeFunctionRow> rows = compareEdgeFunctions(seeds);
    Table all{"gradient-seeds",
              "Every seed:",
              {"edge function", "seed", "mean", "p99", "max", "largest bend", "rms bend"},
              {},
              false};
    Table table{"gradient",
                "Means over " + std::to_string(seeds) + " random mixes of levels:",
                {"edge function", "mean", "p99", "max", "largest bend", "rms bend",
                 "mixes where it bends least (rms)"},
                {},
                true};
    for (const EdgeFunction function : kAllFunctions) {
        EdgeFunctionRow sum;
        double count = 0, smoothest = 0;
        for (const EdgeFunctionRow& row : rows) {
            if (row.function != function)
                continue;
            ++count;
            sum.mean += row.mean, sum.p99 += row.p99, sum.largest += row.largest;
            sum.largestBend += row.largestBend, sum.rmsBend += row.rmsBend;
            smoothest += std::all_of(rows.begin(), rows.end(), [&](const EdgeFunctionRow& other) {
                return other.seed != row.seed || other.rmsBend >= row.rmsBend;
            });
            all.rows.push_back({edgeFunctionNames()[static_cast<std::size_t>(function)],
                                static_cast<double>(row.seed), row.mean, row.p99, row.largest,
                                row.largestBend, row.rmsBend});
        }
        table.rows.push_back({edgeFunctionNames()[static_cast<std::size_t>(function)], sum.mean / count,
                              sum.p99 / count, sum.largest / count, sum.largestBend / count,
                              sum.rmsBend / count,
                              std::to_string(static_cast<int>(smoothest)) + " of " + std::to_string(seeds)});
    }
    report.tables = {std::move(table), std::move(all)};

    const GreyPicture original = rotatedGradient();
    const std::vector<int> levels = randomBlockLevels(1);
    Figure figure;
    figure.caption = "Seed 1; errors from 0 (dark) to " + formatCell(kFullScale) +
                     " L*u*v* (bright), the same colours everywhere:";
    figure.columns = {"original"};
    figure.rows = {{"picture", {{"gradient-original", greyImage(original)}}}, {"error", {{}}}};
    for (const EdgeFunction function : kAllFunctions) {
        const std::string name = edgeFunctionNames()[static_cast<std::size_t>(function)];
        const GreyPicture picture = rebuilt(original, levels, function);
        figure.columns.push_back(name);
        figure.rows[0].second.push_back({"gradient-" + name, greyImage(picture)});
        figure.rows[1].second.push_back(
            {"gradient-" + name + "-error",
             colourMapped(greyDifferences(picture, original), glm::ivec2(kGradientPixels), kFullScale)});
    }
    report.figures = {std::move(figure)};
    return report;
}

} // namespace tessera::bench
