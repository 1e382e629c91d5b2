// tests/render/labels/label_parts_test.cpp: parts of pictures with labels, each beside a look at every voxel:
// texels of bricks at every level, what shows, sets of places, outlines, and places of a slice's pixels. On a
// lattice of three unlike extents and spacings.
#include "core/base/error.h"
#include "render/contract/leaves.h"
#include "render/contract/ray.h"
#include "render/labels/drawn_labels.h"
#include "render/labels/label_looks.h"
#include "render/labels/outline_band.h"
#include "render/labels/plane_places.h"
#include "render/labels/set_reader.h"
#include "tests/support/labelled.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

const glm::ivec3 kExtent(70, 45, 52);

VolumeInfo scanOf() {
    return gridOf(kExtent, patientFromVoxelOf({3, -8, 20}, {0.8, 0, 0}, {0, 0.9, 0.2}, {0, 0, 1.7}));
}

/// Balls of labels, of every look.
struct OfEveryLook {
    OfEveryLook() {
        labels.path = labels.store = balls.store;
        labels.opacity = 0.25;
        labels.hide = {"3"};
        LabelRule tint, plain, dense, overlap;
        tint.of = "2", tint.look = LabelLook::tint, tint.opacity = 0.6,
        tint.colour = glm::dvec3(0.2, 0.4, 0.9);
        plain.of = "40", plain.look = LabelLook::plain, plain.opacity = 0.3;
        dense.of = "1", dense.opacity = 0.7, dense.colour = glm::dvec3(0.9, 0.1, 0.3);
        overlap.of = "7", overlap.colour = glm::dvec3(0.1, 0.8, 0.5);
        labels.each = {tint, plain, dense, overlap};
    }
    std::unique_ptr<DrawnLabels> drawn(LabelMedium* looks = nullptr) {
        auto volume = std::make_unique<LabelVolume>(balls.store, ram);
        LabelTable table = namedLabels(volume->table(), labels);
        LabelMedium medium = labelLooks(table, labels, 1, "labels");
        if (looks)
            *looks = medium;
        return std::make_unique<DrawnLabels>(std::move(volume), std::move(table), medium.bySet,
                                             medium.density);
    }
    const VolumeInfo scan = scanOf();
    const BallsOfLabels balls{scan};
    Labels labels;
    MemoryBudget ram{"RAM", "--ram", std::size_t{512} << 20};
};

/// -ln(1 - opacity), per mm.
double extinctionOf(double opacity) {
    return -std::log(1 - opacity);
}

// docs/sampling.md, "Labels": overlapping labels have the mean of those that show; the densest solid one
// is 1.
TEST(LabelLooks, AreTheMeansOfWhatShows) {
    OfEveryLook of;
    LabelMedium medium;
    const auto drawn = of.drawn(&medium);
    const LabelTable& table = drawn->table();
    const double densest = extinctionOf(0.7);
    EXPECT_NEAR(medium.density, densest, 1e-6);
    ASSERT_EQ(medium.bySet.size(), table.sets.size());
    std::set<std::size_t> sizes;
    for (std::size_t s = 0; s < table.sets.size(); ++s) {
        double shown = 0, plain = 0, tinted = 0, solid = 0;
        glm::dvec3 colour(0);
        for (const std::uint16_t number : table.sets[s]) {
            const std::uint32_t value = table.labels[number].value;
            if (value == 3)
                continue;
            ++shown;
            plain += value == 40 ? 0.3 : 0;
            tinted += value == 2 ? 0.6 : 0;
            const double share = value == 2    ? 0.6
                                 : value == 40 ? 0
                                 : value == 1  ? 1
                                               : extinctionOf(0.25) / densest;
            solid += value == 2 ? 0 : share;
            colour += share * (value == 1   ? glm::dvec3(0.9, 0.1, 0.3)
                               : value == 2 ? glm::dvec3(0.2, 0.4, 0.9)
                               : value == 7 ? glm::dvec3(0.1, 0.8, 0.5)
                                            : glm::dvec3(table.labels[number].colour.value_or(glm::vec3(0))));
        }
        const LabelFactors& f = medium.bySet[s];
        const bool none = table.sets[s].empty();
        EXPECT_NEAR(f.plain, none ? 1 : shown > 0 ? plain / shown : 0, 1e-6);
        EXPECT_NEAR(f.tinted, shown > 0 ? tinted / shown : 0, 1e-6);
        EXPECT_NEAR(f.solid, shown > 0 ? solid / shown : 0, 1e-6);
        EXPECT_EQ(f.shows(), none || shown > 0);
        bool known = true;
        for (const std::uint16_t number : table.sets[s])
            known = known && (std::set<std::uint32_t>{1, 2, 7, 40, 3}.contains(table.labels[number].value));
        for (int c = 0; c < 3 && known && tinted + solid > 0; ++c)
            EXPECT_NEAR(f.colour[c], colour[c] / (tinted + solid), 1e-6);
        sizes.insert(table.sets[s].size());
    }
    EXPECT_TRUE(sizes.contains(0) && sizes.contains(1) && sizes.contains(2));
    // Without a named opacity: nearly opaque over a voxel.
    Labels opaque = of.labels;
    opaque.opacity.reset();
    opaque.each.clear();
    EXPECT_NEAR(labelLooks(table, opaque, 2.5, "labels").density, extinctionOf(0.999) / 2.5, 1e-5);
    opaque.show = {"2"};
    for (std::size_t s = 0; s < table.sets.size(); ++s) {
        bool has = false;
        for (const std::uint16_t number : table.sets[s])
            has = has || table.labels[number].value == 2;
        EXPECT_EQ(labelLooks(table, opaque, 1, "labels").bySet[s].shows(), has)
            << "tissue without a label is hidden, too";
    }
    opaque.unlabelled = true;
    EXPECT_EQ(labelLooks(table, opaque, 1, "labels").bySet[0].plain, 1);
    opaque.show = {"no such label"};
    EXPECT_THROW(labelLooks(table, opaque, 1, "labels"), InputError);
}

TEST(LabelTexels, AreThoseOfTheirVoxels) {
    OfEveryLook of;
    const auto drawn = of.drawn();
    const ReadBack back = readBack(of.balls.store);
    const leaf::LabelNumbers& numbers = drawn->numbers();
    ASSERT_EQ(numbers.count, 7) << "plain, tinted, solid, dense, and a colour";
    std::set<int> channels{numbers.plain,  numbers.tinted,     numbers.solid,     numbers.dense,
                           numbers.colour, numbers.colour + 1, numbers.colour + 2};
    EXPECT_EQ(channels, (std::set<int>{0, 1, 2, 3, 4, 5, 6}));
    const double border = 0.42, voxelMm = std::cbrt(0.8 * 0.9 * 1.7), density = drawn->numbers().density;
    const glm::ivec3 bricks = brickGrid(kExtent);
    std::vector<std::uint16_t> texels(7 * kBrickTexels);
    std::size_t mixed = 0;
    for (std::size_t b = 0; b < cellCount(bricks); ++b)
        for (int level = 0; level < kLevelCount; ++level) {
            if (level + 1 < kLevelCount)
                drawn->fill(b, level, texels);
            const glm::ivec3 brick = gridPosition(b, bricks), from = brick * kBrickExtent,
                             to = glm::min(from + kBrickExtent, kExtent);
            bool isOne = true;
            for (std::size_t n = 0; n < cellCount(to - from); ++n)
                isOne = isOne && back.levels[0][linearIndex(from + gridPosition(n, to - from), kExtent)] ==
                                     back.levels[0][linearIndex(from, kExtent)];
            const int along = 1 << level, edge = kBrickExtent >> level;
            for (std::size_t n = 0; n < cellCount(glm::ivec3(edge)); n += level == 0   ? 37
                                                                          : level == 1 ? 11
                                                                                       : 1) {
                const glm::ivec3 at = gridPosition(n, glm::ivec3(edge)),
                                 low = brick * kBrickExtent + at * along,
                                 high = glm::min(low + along, kExtent);
                if (glm::any(glm::greaterThanEqual(low, high)))
                    continue;
                const double count = static_cast<double>(cellCount(high - low));
                double plain = 0, tinted = 0, whole = 0, dense = 0;
                glm::dvec3 ofTinted(0), ofSolid(0);
                std::set<int> sets;
                for (int z = low.z; z < high.z; ++z)
                    for (int y = low.y; y < high.y; ++y)
                        for (int x = low.x; x < high.x; ++x) {
                            const auto set =
                                static_cast<std::size_t>(back.levels[0][linearIndex({x, y, z}, kExtent)]);
                            const LabelFactors& f = drawn->factors()[set];
                            sets.insert(static_cast<int>(set));
                            plain += f.plain / count, tinted += f.tinted / count;
                            whole += f.solid > 0 ? 1 / count : 0, dense += f.solid / count;
                            ofTinted += double{f.tinted} / count * glm::dvec3(f.colour);
                            ofSolid += double{f.solid} / count * glm::dvec3(f.colour);
                        }
                mixed += sets.size() > 1 ? 1 : 0;
                // docs/sampling.md, "Labels": s = b + (1 - b) m h.
                const double relative = whole > 0 ? dense / whole : 0;
                const double h = level == 0 ? 1
                                            : 1 - (1 - border / (1 - border)) *
                                                      (1 - std::exp(-density * relative * voxelMm * along));
                const double solid = whole > 0 ? border + (1 - border) * whole * h : 0;
                const auto found = [&](int channel) {
                    return level + 1 < kLevelCount ? texels[static_cast<std::size_t>(channel) * kBrickTexels +
                                                            linearIndex(at, glm::ivec3(kBrickExtent))]
                                                   : drawn->standing(b, channel);
                };
                const std::string what = "brick " + std::to_string(b) + ", level " + std::to_string(level);
                // A brick of one set has that set's texels at every level.
                const double own = isOne && level + 1 < kLevelCount && whole > 0 ? 1 : solid;
                ASSERT_NEAR(found(numbers.plain), 16384 * plain, 1) << what;
                ASSERT_NEAR(found(numbers.tinted), 16384 * tinted, 1) << what;
                ASSERT_NEAR(found(numbers.solid), 16384 * own, 1) << what;
                ASSERT_NEAR(found(numbers.dense), 16384 * own * relative, 1) << what;
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(found(numbers.colour + c),
                                16384 * (ofTinted[c] + (dense > 0 ? own * ofSolid[c] / dense : 0)), 1)
                        << what;
            }
        }
    EXPECT_GT(mixed, 300u);
    // What takes light: the function's share, and the medium's extinction inside its border.
    std::vector<float> function(kBrickTexels), medium(kBrickTexels);
    for (int level = 0; level < kLevelCount; ++level) {
        const glm::ivec3 chunks = chunkGrid(kExtent, level), extent = levelExtent(kExtent, level);
        double most = 0;
        for (std::size_t c = 0; c < cellCount(chunks); ++c) {
            const glm::ivec3 chunk = gridPosition(c, chunks);
            drawn->extinctions({level, chunk.x, chunk.y, chunk.z}, function, medium);
            for (std::size_t n = 0; n < kBrickTexels; n += 5) {
                const glm::ivec3 i = chunk * kChunkExtent + gridPosition(n, glm::ivec3(kChunkExtent));
                if (!glm::all(glm::lessThan(i, extent)))
                    continue;
                const int edge = kBrickExtent >> level;
                const std::size_t b = linearIndex(i / edge, bricks);
                if (level + 1 < kLevelCount)
                    drawn->fill(b, level, texels);
                const auto factor = [&](int channel) {
                    return (level + 1 < kLevelCount
                                ? texels[static_cast<std::size_t>(channel) * kBrickTexels +
                                         linearIndex(i % edge, glm::ivec3(kBrickExtent))]
                                : drawn->standing(b, channel)) /
                           16384.0;
                };
                ASSERT_NEAR(function[n], factor(numbers.plain) + factor(numbers.tinted), 1e-5);
                const double s = factor(numbers.solid), inside = std::max(0.0, (s - border) / (1 - border));
                ASSERT_NEAR(medium[n], inside > 0 ? density * inside * factor(numbers.dense) / s : 0, 1e-5);
                most = std::max(most, double{medium[n]});
                n += level == 0 ? 211 : 0;
            }
        }
        EXPECT_GT(most, 0.001) << level;
    }
}

// Of a cell shows what some voxel of it, or of a cell that touches it, has; of a brick what its cells do, and
// with two layers those around.
TEST(LabelShows, IsWhatVoxelsNearHave) {
    OfEveryLook of;
    of.labels.unlabelled = false;
    const auto drawn = of.drawn();
    const ReadBack back = readBack(of.balls.store);
    Statistics s;
    s.cells = cellGrid(kExtent), s.bricks = brickGrid(kExtent);
    drawn->showOnly(s, of.ram);
    EXPECT_TRUE(s.hasLabels());
    // Of the voxels of cells [low, high), held to the volume: what shows.
    const auto partsOf = [&](glm::ivec3 low, glm::ivec3 high) {
        low = glm::max(low * kCellExtent, glm::ivec3(0)), high = glm::min(high * kCellExtent, kExtent);
        std::uint8_t parts = 0;
        for (int z = low.z; z < high.z; ++z)
            for (int y = low.y; y < high.y; ++y)
                for (int x = low.x; x < high.x; ++x) {
                    const LabelFactors& f = drawn->factors()[static_cast<std::size_t>(
                        back.levels[0][linearIndex({x, y, z}, kExtent)])];
                    parts |=
                        (f.plain > 0 || f.tinted > 0 ? kShowsFunction : 0) | (f.solid > 0 ? kShowsMedium : 0);
                }
        return parts;
    };
    std::set<int> seen;
    for (std::size_t c = 0; c < s.cellShows.size(); ++c) {
        const glm::ivec3 cell = gridPosition(c, s.cells);
        ASSERT_EQ(s.cellShows[c], partsOf(cell - 1, cell + 2)) << cell.x << "," << cell.y << "," << cell.z;
        seen.insert(s.cellShows[c]);
    }
    EXPECT_EQ(seen.size(), 4u) << "nothing, function, medium, both";
    for (std::size_t b = 0; b < s.brickShows.size(); ++b) {
        const glm::ivec3 first = gridPosition(b, s.bricks) * kCellsPerBrick,
                         end = glm::min(first + kCellsPerBrick, s.cells);
        EXPECT_EQ(s.brickShows[b], partsOf(first - 1, end + 1));
        EXPECT_EQ(s.wideShows[b], partsOf(first - 2, end + 2));
        double function = 0, medium = 0, count = 0;
        const glm::ivec3 low = first * kCellExtent, high = glm::min(end * kCellExtent, kExtent);
        std::set<std::size_t> sets;
        for (int z = low.z; z < high.z; ++z)
            for (int y = low.y; y < high.y; ++y)
                for (int x = low.x; x < high.x; ++x, ++count) {
                    const auto set =
                        static_cast<std::size_t>(back.levels[0][linearIndex({x, y, z}, kExtent)]);
                    const LabelFactors& f = drawn->factors()[set];
                    function += f.plain + f.tinted, medium += f.solid > 0 ? 1 : 0;
                    sets.insert(set);
                }
        EXPECT_NEAR(s.labelledBricks[b].function, function / count, 1e-5);
        EXPECT_NEAR(s.labelledBricks[b].medium, medium / count, 1e-5);
        EXPECT_GE(s.labelledBricks[b].borders, 0);
        EXPECT_LE(s.labelledBricks[b].borders, 1);
        EXPECT_TRUE(sets.size() == 1 || s.labelledBricks[b].borders > 0);
    }
}

// The set of most weight among the eight samples around; of equal ones labels before none, then the first.
TEST(SetReaders, TakeTheSetOfMostWeight) {
    OfEveryLook of;
    LabelVolume volume(of.balls.store, of.ram);
    const ReadBack back = readBack(of.balls.store);
    BrickCache cache(volume.voxels(), of.ram, std::size_t{8} << 20, 1);
    std::vector<std::uint16_t> shown;
    for (std::size_t set = 0; set < back.table.sets.size(); ++set) // some are hidden, two are one
        shown.push_back(static_cast<std::uint16_t>(set == 2 ? 0 : set == 4 ? 1 : set));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-0.1, 1.1);
    for (const LabelBorders borders : {LabelBorders::smooth, LabelBorders::nearest})
        for (int level = 0; level < 4; ++level) {
            SetReader reader(cache, volume.voxels().info(), level, borders, shown);
            const glm::ivec3 samples = levelExtent(kExtent, level);
            const double pitch = std::ldexp(1.0, level);
            std::set<int> seen;
            int ties = 0;
            for (int n = 0; n < 3000; ++n) {
                glm::dvec3 place = glm::dvec3(kExtent) * glm::dvec3(unit(random), unit(random), unit(random));
                if (n % 2 == 0) // halfway between samples, and on them
                    place = glm::round(place / pitch * 2.0) * pitch / 2.0;
                place = glm::round(place * 4096.0) / 4096.0;
                const glm::dvec3 held = glm::clamp(place, glm::dvec3(-1), glm::dvec3(kExtent) + 1.0);
                const auto numberAt = [&](const glm::ivec3& i) {
                    const glm::ivec3 at = glm::clamp(i, glm::ivec3(0), samples - 1);
                    return int{shown[static_cast<std::size_t>(
                        back.levels[static_cast<std::size_t>(level)][linearIndex(at, samples)])]};
                };
                int expected = 0;
                if (borders == LabelBorders::nearest) {
                    expected = numberAt(glm::ivec3(glm::floor(held / pitch)));
                } else {
                    const glm::dvec3 in = held / pitch - 0.5, low = glm::floor(in), f = in - low;
                    std::map<int, double> weights;
                    for (int i = 0; i < 8; ++i) {
                        const glm::ivec3 corner(i & 1, i >> 1 & 1, i >> 2);
                        double weight = 1;
                        for (int axis = 0; axis < 3; ++axis)
                            weight *= corner[axis] != 0 ? f[axis] : 1 - f[axis];
                        weights[numberAt(glm::ivec3(low) + corner)] += weight;
                    }
                    double most = -1;
                    for (const auto& [set, weight] : weights)
                        most = std::max(most, weight);
                    std::vector<int> best;
                    for (const auto& [set, weight] : weights)
                        if (weight >= most)
                            best.push_back(set);
                    ties += best.size() > 1 ? 1 : 0;
                    expected = best.size() > 1 && best[0] == 0 ? best[1] : best[0];
                }
                ASSERT_EQ(int{reader.at(place)}, expected)
                    << "level " << level << " at " << place.x << "," << place.y << "," << place.z;
                seen.insert(expected);
            }
            EXPECT_GT(seen.size(), 3u);
            EXPECT_TRUE(borders == LabelBorders::nearest || ties > 10) << ties;
        }
    SetReader reader(cache, volume.voxels().info(), 0, LabelBorders::smooth, shown);
    EXPECT_EQ(reader.at(glm::dvec3(std::nan(""), 1e300, -1e300)), reader.at({-1, 46, -1}));
}

// Shares fall over a place's width about the distance that is asked for, 0.3 beyond half a place for the
// raster.
TEST(OutlineBands, AreByDistancesToWhatIsOutside) {
    std::mt19937 random(2);
    OutlineBand band;
    for (const double width : {1.0, 2.5, 0.4, 7.2}) {
        const int around = OutlineBand::reach(width);
        EXPECT_EQ(around, static_cast<int>(std::ceil(width + 0.8)));
        const glm::ivec2 count(23, 17), first(around + 2, around),
            size = count + 2 * around + glm::ivec2(3, 1);
        std::vector<std::uint8_t> inside(static_cast<std::size_t>(size.x * size.y), 1);
        for (std::size_t n = 0; n < 12; ++n)
            inside[random() % inside.size()] = 0;
        const std::vector<float>& found = band.of(inside, size, first, count, width);
        ASSERT_EQ(found.size(), static_cast<std::size_t>(count.x * count.y));
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const glm::ivec2 at = first + glm::ivec2(x, y);
                double nearest = 1e9;
                for (int v = 0; v < size.y; ++v)
                    for (int u = 0; u < size.x; ++u)
                        if (inside[static_cast<std::size_t>(v * size.x + u)] == 0)
                            nearest = std::min(nearest, std::hypot(u - at.x, v - at.y));
                const double expected = nearest == 0 ? 0 : std::clamp(width + 0.3 + 0.5 - nearest, 0.0, 1.0);
                ASSERT_NEAR(found[static_cast<std::size_t>(y * count.x + x)], expected, 1e-6)
                    << width << ": " << x << "," << y;
            }
    }
}

// A pixel's place is where its ray meets the plane.
TEST(PlanePlaces, AreWhereRaysMeetThePlane) {
    const VolumeInfo info = scanOf();
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(kExtent), 1));
    const glm::dmat4 toVoxels = glm::inverse(info.patientFromVoxel);
    const glm::ivec2 size(37, 24);
    SlicePlane oblique;
    oblique.orientation = Orientation::oblique;
    oblique.point = middle + glm::dvec3(2, -3, 4);
    oblique.normal = {0.3, -0.8, 0.6};
    SlicePlane axial;
    for (const SlicePlane& slice : {oblique, axial})
        for (const Projection projection : {Projection::parallel, Projection::perspective}) {
            const SlicePose plane = poseOf(slice, middle);
            Camera camera = fitCamera(info, View::anterior, projection, size);
            camera.position =
                middle + glm::length(camera.position - middle) * glm::normalize(glm::dvec3(0.4, -1, 0.8));
            camera.focalPoint = middle;
            const PlanePlaces places = planePlaces(camera, slice, info, size);
            ASSERT_TRUE(places.isMet);
            EXPECT_EQ(places.perspective, projection == Projection::perspective);
            const RayFrame<double> frame = rayFrame(camera, info, size, 1);
            int met = 0;
            for (const glm::dvec2& pixel :
                 {glm::dvec2(0, 0), glm::dvec2(37, 24), glm::dvec2(0.5, 20.25), glm::dvec2(30, 3)}) {
                const RayLine<double> line = pixelLine(frame, pixel);
                const auto patient = [&](const glm::dvec3& voxel) {
                    return glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
                };
                const glm::dvec3 base = patient(line.base), way = patient(line.base + line.direction) - base;
                const double t = glm::dot(plane.normal, plane.point - base) / glm::dot(plane.normal, way);
                const auto found = places.at(pixel);
                ASSERT_EQ(found.has_value(), projection == Projection::parallel || t > line.nearest);
                if (!found)
                    continue;
                ++met;
                EXPECT_LT(glm::distance(*found, line.base + t * line.direction), 1e-8);
            }
            EXPECT_GE(met, 2);
        }
    // Along its normal: a pixel is a step on the plane.
    const SlicePose plane = poseOf(axial, middle);
    const PlanePlaces places = planePlaces(plane, 0.6, info, size);
    for (const glm::dvec2& pixel : {glm::dvec2(0, 0), glm::dvec2(18.5, 12), glm::dvec2(30, 5)}) {
        const glm::dvec3 at =
            plane.point + 0.6 * (pixel.x - 18.5) * plane.right - 0.6 * (pixel.y - 12) * plane.up;
        EXPECT_LT(glm::distance(*places.at(pixel), glm::dvec3(toVoxels * glm::dvec4(at, 1))), 1e-9);
    }
    // 0.6 mm are 0.75 voxels along x, and along y, which is sheared, fewer.
    const glm::dvec3 down = glm::dmat3(toVoxels) * (0.6 * plane.up);
    EXPECT_NEAR(places.voxelsPerPixel(), std::min(0.75, glm::length(down)), 1e-9);
    // A camera in the plane meets it nowhere.
    Camera edge = fitCamera(info, View::anterior, Projection::parallel, size);
    EXPECT_FALSE(planePlaces(edge, axial, info, size).isMet);
}

} // namespace
} // namespace tessera::test
