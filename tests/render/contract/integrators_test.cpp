// The tables behind integrators against exact integrals, which integrator a transfer function asks for, and
// what a picture says of its own errors. (Orders, stiff media and whole pictures have tests of their own.)
#include "core/base/brick.h"
#include "render/backends/reference/reference_integrator.h"
#include "render/contract/integrators.h"
#include "render/contract/preintegration.h"
#include "render/plan/choose_integrator.h"
#include "render/plan/frame_plan.h"
#include "render/plan/step_search.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

/// Wide flats, ramps and a spike, as editors make them; zero below 100 and from 700 to 800.
TransferTable mixedTable() {
    return makeTable(TransferFunction::fromOpacity(
        {{100, 0},
         {200, 0.3},
         {300, 0.3},
         {399, 0.05},
         {400, 0.9},
         {401, 0.05},
         {700, 0},
         {800, 0},
         {900, 0.6}},
        {{100, {0.9, 0.2, 0.1}}, {400, {0.2, 0.8, 0.3}}, {900, {0.9, 0.9, 1}}}, 1));
}

Optics opticsOf(const TransferTable& table, Integrator integrator) {
    Optics o;
    o.table = table.entries;
    o.scale = 1; // places stand for stored values
    setIntegrator(o, integrator);
    return o;
}

/// Integral over places, constant beyond the table.
glm::dvec4 upTo(const TransferTable& table, const TableIntegral& integral, double place) {
    const double last = static_cast<double>(table.entries.size() - 1);
    const double inside = std::clamp(place, 0.0, last);
    const glm::dvec4 e(place < 0 ? table.entries.front() : table.entries.back());
    return integral.upTo(inside) + (place - inside) * glm::dvec4(glm::dvec3(e) * e.a, e.a);
}

/// The bytes charged for an integrator's tables hold them, and no integrator is charged for another's.
TEST(TableBytes, HoldWhatAnIntegratorTakes) {
    const TransferTable table = mixedTable();
    std::size_t midpoint = 0;
    for (const Integrator integrator :
         {Integrator::midpoint, Integrator::linear, Integrator::preintegrated, Integrator::preintegrated2d}) {
        const Optics o = opticsOf(table, integrator);
        const std::size_t beside = (o.bins.size() + o.sums.size()) * sizeof(glm::vec4);
        const std::size_t charged = tableRamBytes(table.entries.size(), integrator);
        if (integrator == Integrator::midpoint)
            midpoint = charged;
        EXPECT_GE(charged, midpoint + beside) << static_cast<int>(integrator);
        EXPECT_GE(midpoint, o.table.size() * sizeof(glm::vec4));
        if (beside == 0) {
            EXPECT_EQ(charged, midpoint) << static_cast<int>(integrator);
        }
    }
}

// Differences from a ten-thousandth of a bin to hundreds of bins, over flats, ramps and a spike.
TEST(Preintegration, MeansAreThoseOfTheExactIntegral) {
    const TransferTable table = mixedTable();
    const Optics o = opticsOf(table, Integrator::preintegrated);
    const TableIntegral integral(table.entries);
    const double last = static_cast<double>(table.entries.size() - 1);
    double largest = 0;
    for (const glm::vec4& e : table.entries)
        largest = std::max(largest, static_cast<double>(e.a));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-0.2 * last, 1.2 * last), decade(-4, 2.5);
    double worstFloat = 0, worstDouble = 0, worstColour = 0;
    for (int n = 0; n < 20000; ++n) {
        const float a = static_cast<float>(place(random));
        const float b = a + static_cast<float>(std::pow(10, decade(random)) * (n % 2 ? 1 : -1));
        if (a == b)
            continue;
        const glm::dvec4 sum = (upTo(table, integral, b) - upTo(table, integral, a)) /
                               (static_cast<double>(b) - static_cast<double>(a));
        const auto f = endOf(o, a), g = endOf(o, b);
        const auto df = endOf(o, static_cast<double>(a)), dg = endOf(o, static_cast<double>(b));
        const double inFloat = static_cast<double>(segmentExtinction(o, f, g));
        if (std::abs(b - a) > 1e-2f) // the exact difference itself cancels below
            worstDouble = std::max(worstDouble, std::abs(segmentExtinction(o, df, dg) - sum.a));
        worstFloat = std::max(worstFloat, std::abs(inFloat - segmentExtinction(o, df, dg)));
        if (sum.a > 1e-3 * largest && std::abs(b - a) > 1e-2f)
            for (int c = 0; c < 3; ++c)
                worstColour = std::max(
                    worstColour, std::abs(static_cast<double>(meanColour(o, f, g)[c]) - sum[c] / sum.a));
        EXPECT_EQ(segmentExtinction(o, f, g), segmentExtinction(o, g, f));
    }
    EXPECT_LT(worstDouble, 1e-6 * largest); // the tables are floats: 2^-24 of the sums
    EXPECT_LT(worstFloat, 4e-5 * largest);
    // Inside a bin, its own colour and extinction are taken in the middle of what is used of it.
    EXPECT_LT(worstColour, 2e-3);
}

TEST(Preintegration, NothingShowsExactlyWhereNoEntryDoes) {
    const TransferTable table = mixedTable();
    const Optics o = opticsOf(table, Integrator::preintegrated);
    const auto placeOfValue = [&](double value) {
        return static_cast<float>((value - static_cast<double>(table.firstValue)) *
                                  static_cast<double>(table.entriesPerValue));
    };
    std::mt19937 random(5);
    std::uniform_real_distribution<double> below(-5000, 99.9), between(700.5, 799.5);
    for (int n = 0; n < 2000; ++n) {
        EXPECT_EQ(segmentExtinction(o, endOf(o, placeOfValue(below(random))),
                                    endOf(o, placeOfValue(below(random)))),
                  0);
        EXPECT_EQ(segmentExtinction(o, endOf(o, placeOfValue(between(random))),
                                    endOf(o, placeOfValue(between(random)))),
                  0);
        EXPECT_GT(segmentExtinction(o, endOf(o, placeOfValue(below(random))),
                                    endOf(o, placeOfValue(between(random)))),
                  0);
    }
}

// Values that are no numbers, or far outside of the table, come to a finite segment.
TEST(Preintegration, EveryValueHasAPlace) {
    for (const Integrator integrator :
         {Integrator::linear, Integrator::preintegrated, Integrator::preintegrated2d}) {
        Optics o = opticsOf(mixedTable(), integrator);
        preparePreintegration2d(o, 0.5, 0, 1);
        const float values[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 0, 1e-42f};
        for (const float a : values)
            for (const float b : values) {
                const auto f = endOf(o, a), g = endOf(o, b);
                const float extinction = segmentExtinction(o, f, g);
                ASSERT_TRUE(std::isfinite(extinction) && extinction >= 0) << a << " " << b;
                const float alpha = opacityOf(extinction);
                for (int c = 0; c < 3 && alpha > 0; ++c) {
                    ASSERT_TRUE(std::isfinite(segmentColour(o, f, g, extinction, alpha, 1)[c]))
                        << a << " " << b;
                }
            }
    }
}

// With attenuation inside the segment, against the integral itself: slices weigh a 32nd each.
TEST(Preintegration, ColourIsThatOfTheIntegral) {
    const TransferTable table = mixedTable();
    const TableIntegral integral(table.entries);
    const double last = static_cast<double>(table.entries.size() - 1);
    const auto at = [&](double place) {
        const auto bin = std::min(static_cast<std::size_t>(place), table.entries.size() - 2);
        const glm::dvec4 a(table.entries[bin]), b(table.entries[bin + 1]);
        return a + (place - static_cast<double>(bin)) * (b - a);
    };
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(0, last);
    for (const double length : {0.01, 1.0, 30.0, 1000.0})
        for (int n = 0; n < 12; ++n) {
            const double a = place(random), b = place(random);
            ReferenceIntegrator exact; // cut where the table has corners
            std::vector<double> cuts = {0, 1};
            for (double bin = std::ceil(std::min(a, b)); bin < std::max(a, b); ++bin)
                cuts.push_back((bin - a) / (b - a));
            std::sort(cuts.begin(), cuts.end());
            for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
                exact.add(length * cuts[i], length * cuts[i + 1], [&](double t) {
                    const glm::dvec4 e = at(std::clamp(a + (b - a) * t / length, 0.0, last));
                    return RadiantPoint{e.a, glm::dvec3(e)};
                });
            if (exact.alpha() < 1e-6)
                continue;
            const glm::dvec3 seen = preintegratedColour(integral, a, b, length);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(seen[c], exact.colour()[c] / exact.alpha(), 0.01)
                    << a << " to " << b << ", " << length;
        }
}

// Strides of 2^k segments take the layer of their own length.
TEST(Preintegration, SeenColoursAreThoseOfTheStridesLength) {
    Optics o;
    o.table =
        makeTable(TransferFunction::fromExtinction({{0, 0.2}, {100, 3}}, {{0, {1, 0, 0}}, {100, {0, 0, 1}}}))
            .entries;
    setIntegrator(o, Integrator::preintegrated2d);
    preparePreintegration2d(o, 0.7, 0, 3);
    const TableIntegral integral(o.table);
    const double last = static_cast<double>(o.table.size() - 1);
    for (const int n : {1, 2, 4}) {
        const glm::dvec3 exact = preintegratedColour(integral, 0.0, last, 0.7 * n),
                         taken = preintegratedColour(o, 0.0, last, n);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(taken[c], exact[c], 1e-5) << n;
    }
    EXPECT_GT(preintegratedColour(o, 0.0, last, 4).r, preintegratedColour(o, 0.0, last, 1).r + 0.05);
}

// 1 - exp(-x) as the shader has it, from the thinnest segment to the densest.
TEST(Opacity, IsRightAtEveryDepth) {
    for (double x = 1e-9; x < 60; x *= 1.07) {
        const double exact = -std::expm1(-static_cast<double>(static_cast<float>(x)));
        ASSERT_NEAR(static_cast<double>(opacityOf(static_cast<float>(x))), exact, 4e-7 * exact) << x;
    }
}

TEST(Preintegration, AnEditComputesOnlyWhatItChanges) {
    const TransferTable before = mixedTable();
    std::vector<glm::vec4> edited = before.entries;
    const std::size_t from = edited.size() / 2, to = from + edited.size() / 20;
    for (std::size_t i = from; i < to; ++i)
        edited[i].a *= 0.5f;
    Preintegration2d mended(before.entries, 0.7, 1, 2);
    const std::size_t all = static_cast<std::size_t>(2 * Preintegration2d::kEdge * Preintegration2d::kEdge);
    const std::size_t pairs = mended.update(edited);
    EXPECT_GT(pairs, 0u);
    EXPECT_LT(pairs, all * 6 / 10); // half of all pairs have both places on one side of the middle
    const Preintegration2d anew(edited, 0.7, 1, 2);
    for (std::size_t i = 0; i < anew.colours().size(); ++i)
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(mended.colours()[i][c], anew.colours()[i][c], 1e-5f) << i;
    EXPECT_EQ(mended.update(edited), 0u);
}

// A step function crossed by a rise of d a segment: the middle's error is evenly spread over (-d/2, d/2).
TEST(ChooseIntegrator, TheErrorOnARiseIsThatOfAStep) {
    const TransferTable table =
        makeTable(TransferFunction::fromExtinction({{0, 0}, {500, 0}, {500, 2}, {1000, 2}}, {}));
    const double d = 100, whole = 2 * 500;
    EXPECT_NEAR(midpointRampError(table, d, 0, 1000), 2 * d / std::sqrt(12) / whole, 0.01 * 2 * d / whole);
    const TransferTable spike =
        makeTable(TransferFunction::fromExtinction({{499.5, 0}, {500, 2}, {500.5, 0}}, {}));
    EXPECT_GE(midpointRampError(spike, d, 0, 1000), 1); // hit once in a hundred
    const TransferTable smooth = makeTable(TransferFunction::fromExtinction({{0, 0}, {1000, 2}}, {}));
    EXPECT_LT(midpointRampError(smooth, d, 0, 1000), 0.01);
    const TransferTable nothing = makeTable(TransferFunction::fromExtinction({{0, 0}, {1, 0}}, {}));
    EXPECT_EQ(midpointRampError(nothing, d, 0, 1000), 0);
}

// All cells count that can show something, also those of bricks that the volume ends in; in any order.
TEST(ChooseIntegrator, TheTypicalChangeIsThatOfAllCellsThatShow) {
    const TransferTable table =
        makeTable(TransferFunction::fromExtinction({{400, 0}, {450, 1}, {500, 0}}, {}));
    std::mt19937 random(7);
    for (const double slope : {2.0, -2.0}) {
        VolumeInfo info;
        info.rescaleSlope = slope;
        info.rescaleIntercept = slope > 0 ? -5 : 1005;
        Statistics s;
        s.cells = {10, 7, 9};
        s.bricks = {3, 2, 3};
        const std::size_t bricks = cellCount(s.bricks);
        s.brickMin.assign(bricks, 1e9f);
        s.brickMax.assign(bricks, -1e9f);
        std::vector<double> ranges;
        for (std::size_t n = 0; n < cellCount(s.cells); ++n) {
            const glm::ivec3 cell = gridPosition(n, s.cells);
            const std::size_t brick = linearIndex(cell / kCellsPerBrick, s.bricks);
            // Every third brick is far from what shows.
            const float low =
                std::uniform_real_distribution<float>(0, 240)(random) + (brick % 3 == 0 ? 300.0f : 0.0f);
            const float high =
                low + std::uniform_real_distribution<float>(0, 40)(random) * static_cast<float>(1 + cell.z);
            s.cellMin.push_back(low);
            s.cellMax.push_back(high);
            s.brickMin[brick] = std::min(s.brickMin[brick], low);
            s.brickMax[brick] = std::max(s.brickMax[brick], high);
            const double a = slope * double{low} + info.rescaleIntercept,
                         b = slope * double{high} + info.rescaleIntercept;
            if (!table.emptyOver(std::min(a, b), std::max(a, b)))
                ranges.push_back(std::abs(b - a));
        }
        std::sort(ranges.begin(), ranges.end());
        ASSERT_GT(ranges.size(), 100u);
        ASSERT_LT(ranges.size(), s.cellMin.size());
        const double rank = ranges[static_cast<std::size_t>(0.9 * static_cast<double>(ranges.size() - 1))];
        EXPECT_NEAR(typicalChangePerVoxel(s, table, info), rank / 3, 1e-4);
    }
}

TEST(PictureCheck, TheGridsRaysAreThePictures) {
    VolumeInfo info;
    info.extentVoxels = {64, 50, 40};
    info.patientFromVoxel = patientFromVoxelOf({-3, 5, 7}, {0.5, 0, 0}, {0, 0.9, 0}, {0, 0.6, 2});
    for (const Projection projection : {Projection::perspective, Projection::parallel})
        for (const glm::ivec2& size : {glm::ivec2(512, 300), glm::ivec2(97, 240), glm::ivec2(20, 7),
                                       glm::ivec2(190, 90), glm::ivec2(1, 1)}) {
            const Camera camera = fitCamera(info, View::left, projection, size);
            const RayFrame<double> frame = rayFrame(camera, info, size, 0.5);
            const PixelGrid grid(size);
            ASSERT_LE(std::max(grid.size().x, grid.size().y), PixelGrid::kMostPixels);
            const RayFrame<double> small = grid.frame(frame, 0.5);
            Image numbers(size); // each pixel knows where it is
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x)
                    numbers.at(x, y) = glm::vec4(x, y, 0, 1);
            const Image taken = grid.of(numbers);
            for (int y = 0; y < grid.size().y; ++y)
                for (int x = 0; x < grid.size().x; ++x) {
                    const glm::dvec2 pixel = glm::dvec2(taken.at(x, y).x, taken.at(x, y).y) + 0.5;
                    const auto mine = pixelLine(small, glm::dvec2(x + 0.5, y + 0.5)),
                               theirs = pixelLine(frame, pixel);
                    for (int axis = 0; axis < 3; ++axis) {
                        ASSERT_NEAR(mine.base[axis], theirs.base[axis], 1e-9);
                        ASSERT_NEAR(mine.direction[axis], theirs.direction[axis], 1e-12);
                    }
                    if (projection == Projection::perspective) {
                        ASSERT_NEAR(mine.nearest, theirs.nearest, 1e-9);
                    }
                }
        }
}

TEST(PictureCheck, AnErrorOfSecondOrderIsFound) {
    const auto picture = [](double error) {
        Image image(glm::ivec2(8, 8));
        for (std::size_t i = 0; i < image.pixels.size(); ++i)
            image.pixels[i] = glm::vec4(glm::vec3(0.5f + static_cast<float>(error * (i % 2 ? 1 : -1))), 1);
        return image;
    };
    const double e = 0.016;
    const StepError found = stepError(picture(e), picture(e / 4), picture(e / 16));
    EXPECT_NEAR(found.order, 2, 0.01);
    EXPECT_NEAR(found.error.largest, e, 1e-4);
    EXPECT_EQ(stepError(picture(0), picture(0), picture(0)).error.rms, 0);
}

} // namespace
} // namespace tessera
