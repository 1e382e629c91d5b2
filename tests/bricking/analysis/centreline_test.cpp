// tests/bricking/analysis/centreline_test.cpp: centre-lines against curves that are known: the torso's colon,
// airways and aorta, and tubes of any shape; what is refused and how; memory and calling off.
#include "bricking/analysis/lumen/centreline.h"
#include "bricking/analysis/lumen/lumen_values.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/phantom_chunks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numeric>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kPlenty = std::size_t{512} << 20;

Centrelines find(const ChunkSource& source, const CentrelineRequest& request, std::size_t budget = kPlenty) {
    MemoryBudget ram("RAM", "--ram", budget);
    Progress silent;
    Centrelines found = findCentrelines(source, request, ram, silent, 2);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), budget);
    return found;
}

CentrelineRequest between(const glm::dvec3& from, const glm::dvec3& to) {
    CentrelineRequest request;
    request.seeds = {{from, "--from"}, {to, "--to"}};
    return request;
}

std::string refusal(const ChunkSource& source, const CentrelineRequest& request,
                    std::size_t budget = kPlenty) {
    try {
        find(source, request, budget);
    } catch (const InputError& error) {
        return error.what();
    }
    return "not refused";
}

/// Every point and the places between them, by the values themselves.
void expectInside(const ChunkSource& source, const CentreLine& line, const Lumen& lumen) {
    MemoryBudget ram("RAM", "--ram", kPlenty);
    BrickCache cache(source, ram, 64u << 20, 2);
    LumenValues values(cache, source.info());
    const glm::dmat4 toVoxel = glm::inverse(source.info().patientFromVoxel);
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
        for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const glm::dvec3 mm = line.points[i] + t * (line.points[i + 1] - line.points[i]);
            const double value = values.at(glm::dvec3(toVoxel * glm::dvec4(mm, 1)));
            if (lumen.side == Lumen::Side::below)
                ASSERT_LT(value, lumen.threshold) << "point " << i << " of " << line.points.size();
            else
                ASSERT_GT(value, lumen.threshold) << "point " << i << " of " << line.points.size();
        }
}

double voxelMm(const ChunkSource& source) {
    const glm::dvec3 mm = source.info().spacingMm();
    return std::cbrt(mm.x * mm.y * mm.z);
}

void expectNear(const ChunkSource& source, const CentreLine& line, const std::vector<glm::dvec3>& known,
                const std::string& what) {
    const Apart off = apart(line.points, known);
    EXPECT_LT(off.mean, std::min(1.0, voxelMm(source))) << what;
    EXPECT_LT(off.most, 3) << what;
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
        const double step = glm::length(line.points[i + 1] - line.points[i]);
        ASSERT_LE(step, line.spacingMm * (1 + 1e-9));
        ASSERT_GE(step, 0.6 * line.spacingMm);
    }
}

const glm::ivec3 kTorso(192, 144, 224);

TEST(Centreline, KeepsToTheTorsosColonAirwaysAndAorta) {
    const PhantomChunks torso("torso", kTorso);
    const auto colon = torsoColon().pointsMm;
    const Centrelines ofColon = find(torso, between(colon.front(), colon.back()));
    expectNear(torso, ofColon.lines[0], colon, "colon");
    expectInside(torso, ofColon.lines[0], ofColon.lumen);
    EXPECT_LT(apart(colon, ofColon.lines[0].points).most, 3) << "all of it: no false bridge";
    EXPECT_NEAR(ofColon.lines[0].lengthMm(), 700, 15);
    EXPECT_GT(ofColon.leastTurnMm, 5);

    const auto aorta = torsoAorta().pointsMm;
    const Centrelines ofAorta = find(torso, between(aorta[1], aorta[aorta.size() - 2]));
    expectNear(torso, ofAorta.lines[0], aorta, "aorta");
    expectInside(torso, ofAorta.lines[0], ofAorta.lumen);

    const auto airways = torsoAirways();
    const auto end =
        std::find_if(airways.begin(), airways.end(), [](const auto& a) { return a.generation == 4; });
    std::vector<glm::dvec3> way;
    for (const PhantomCurve* tube = &*end;;) {
        way.insert(way.end(), tube->pointsMm.rbegin(), tube->pointsMm.rend());
        if (tube->parent < 0)
            break;
        tube = &airways[static_cast<std::size_t>(tube->parent)];
    }
    const Centrelines ofAirways = find(torso, between({0, 8, 180}, end->pointsMm.back()));
    expectNear(torso, ofAirways.lines[0], way, "airways");
    expectInside(torso, ofAirways.lines[0], ofAirways.lumen);
}

TEST(Centreline, TheAirwaysTreeHasTheirBranchesAndNoOthers) {
    const PhantomChunks torso("torso", kTorso);
    CentrelineRequest request;
    request.seeds = {{{0, 8, 180}, "--from"}};
    request.tree = true;
    const Centrelines tree = find(torso, request);
    const auto airways = torsoAirways();
    std::vector<glm::dvec3> all;
    for (const CentreLine& line : tree.lines)
        all.insert(all.end(), line.points.begin(), line.points.end());
    for (const PhantomCurve& tube : airways)
        if (tube.generation <= 4) {
            const glm::dvec3 most = tube.pointsMm.size() > 2
                                        ? tube.pointsMm[tube.pointsMm.size() * 3 / 4]
                                        : 0.25 * tube.pointsMm[0] + 0.75 * tube.pointsMm[1];
            double nearest = 1e300;
            for (const glm::dvec3& p : all)
                nearest = std::min(nearest, glm::length(p - most));
            EXPECT_LT(nearest, 2) << "generation " << tube.generation;
        }
    double mean = 0, count = 0;
    for (std::size_t i = 0; i < tree.lines.size(); ++i) {
        const CentreLine& line = tree.lines[i];
        if (line.parent) {
            EXPECT_LT(*line.parent, i);
            EXPECT_EQ(tree.generations[i], tree.generations[*line.parent] + 1);
            EXPECT_LT(glm::length(line.points.front() - tree.lines[*line.parent].points.back()), 1e-6);
        } else
            EXPECT_EQ(tree.generations[i], 0);
        for (const glm::dvec3& p : line.points) {
            double off = 1e300;
            for (const PhantomCurve& tube : airways)
                if (tube.generation < 2 || glm::length(tube.pointsMm.front() - p) < 60)
                    off = std::min(off, lineDistance(p, tube.pointsMm));
            EXPECT_LT(off, 3.5) << "generation " << tree.generations[i];
            mean += off;
            ++count;
        }
    }
    EXPECT_LT(mean / count, 1);
    const auto ofGeneration = [&](int g) {
        return std::count(tree.generations.begin(), tree.generations.end(), g);
    };
    EXPECT_EQ(ofGeneration(1), 2);
    EXPECT_EQ(ofGeneration(2), 4);
    EXPECT_EQ(ofGeneration(3), 8);
    request.mostGenerations = 2;
    const Centrelines few = find(torso, request);
    EXPECT_EQ(*std::max_element(few.generations.begin(), few.generations.end()), 2);
}

TEST(Centreline, ACollapsedSegmentIsBridgedOnlyWhereASeedSaysSo) {
    const PhantomChunks torso("torso-collapsed", kTorso);
    const auto colon = torsoColon().pointsMm;
    CentrelineRequest request = between(colon.front(), colon.back());
    const std::string refused = refusal(torso, request);
    EXPECT_THAT(refused, HasSubstr("--to: expected a point that the lumen of --from"));
    EXPECT_THAT(refused, HasSubstr("found a gap: the two parts come nearest at ("));
    EXPECT_THAT(refused, HasSubstr("mm apart"));
    // a seed in the gap
    const glm::dvec3 inGap = colon[static_cast<std::size_t>(0.615 * static_cast<double>(colon.size() - 1))];
    request.seeds.insert(request.seeds.begin() + 1, {inGap, "--through", true});
    const Centrelines bridged = find(torso, request);
    ASSERT_EQ(bridged.bridges.size(), 2u);
    const Apart off = apart(bridged.lines[0].points, colon);
    EXPECT_LT(off.mean, 1);
    EXPECT_LT(off.most, 4);
    EXPECT_LT(apart(colon, bridged.lines[0].points).most, 4);
    const auto outside = std::count(bridged.lines[0].radiusMm.begin(), bridged.lines[0].radiusMm.end(), 0.0);
    EXPECT_NEAR(static_cast<double>(outside) * bridged.lines[0].spacingMm, 30, 12) << "the gap alone";
}

/// Behind a gap the line goes on from seed to seed, each of which it meets once and in order.
TEST(Centreline, SeedsBehindAGapAreMetInOrder) {
    const std::vector<glm::dvec3> before = {{0, 0, 0}, {0, 0, 30}}, after = {{0, 0, 50}, {0, 0, 110}};
    const Field first = tube(before, 5, 1), second = tube(after, 5, 1);
    const FieldChunks chunks(boxInfo({30, 30, 130}, glm::dvec3(1), {-15, -15, -10}),
                             [=](const glm::dvec3& p) { return std::min(first(p), second(p)); });
    CentrelineRequest request;
    request.seeds = {{{0, 0, 4}, "--from"},
                     {{0, 0, 60}, "--through", true},
                     {{0, 0, 80}, "--through"},
                     {{0, 0, 104}, "--to"}};
    const Centrelines found = find(chunks, request);
    ASSERT_EQ(found.bridges.size(), 1u);
    EXPECT_NEAR(static_cast<double>(found.lumenVoxels), M_PI * 25 * (30 + 60) + 2 * 4 / 3.0 * M_PI * 125, 500)
        << "of both parts";
    const std::vector<glm::dvec3>& points = found.lines[0].points;
    EXPECT_NEAR(points.front().z, 4, 2);
    EXPECT_NEAR(points.back().z, 104, 2);
    EXPECT_NEAR(found.lines[0].lengthMm(), 100, 6);
    for (std::size_t i = 1; i < points.size(); ++i)
        ASSERT_GT(points[i].z, points[i - 1].z - 0.1) << "it turns back at point " << i;
}

TEST(Centreline, CroppingMovesNoLine) {
    const glm::ivec3 low(13, 9, 21), size(150, 121, 189);
    const PhantomChunks whole("torso", kTorso), part("torso", kTorso, low, size);
    const auto aorta = torsoAorta().pointsMm;
    const auto colon = torsoColon().pointsMm;
    for (const auto& [from, to] :
         {std::pair(aorta[2], aorta[aorta.size() - 3]), std::pair(colon[40], colon[260])}) {
        const Centrelines a = find(whole, between(from, to)), b = find(part, between(from, to));
        const Apart off = apart(a.lines[0].points, b.lines[0].points);
        EXPECT_LT(off.mean, 0.1 * voxelMm(whole));
        EXPECT_LT(off.most, 0.5 * voxelMm(whole));
    }
}

std::vector<glm::dvec3> helix(double turns) {
    std::vector<glm::dvec3> line;
    for (double a = 0; a <= turns; a += 0.005)
        line.emplace_back(25 * std::cos(6.2831853 * a), 25 * std::sin(6.2831853 * a), 40 * a);
    return line;
}

TEST(Centreline, KeepsToAHelixInAnisotropicObliqueVoxels) {
    const auto line = helix(0.8);
    VolumeInfo info = boxInfo({110, 90, 32}, {0.7, 0.9, 2.4}, {-38, -38, -16});
    const double c = std::cos(0.3), s = std::sin(0.3); // turned about z
    info.patientFromVoxel =
        patientFromVoxelOf({-31, -50, -16}, {0.7 * c, 0.7 * s, 0}, {-0.9 * s, 0.9 * c, 0}, {0, 0, 2.4});
    const FieldChunks air(info, tube(line, 6, 1.2)), blood(info, tube(line, 6, 1.2, 350, 50));
    for (const FieldChunks* chunks : {&air, &blood}) {
        const Centrelines found = find(*chunks, between(line[6], line[line.size() - 7]));
        const Apart off = apart(found.lines[0].points, line);
        EXPECT_LT(off.mean, 0.25);
        EXPECT_LT(off.most, 1);
        expectInside(*chunks, found.lines[0], found.lumen);
        EXPECT_NEAR(found.lumen.threshold, chunks == &air ? -480 : 200, 40);
        for (std::size_t i = 15; i + 15 < found.lines[0].radiusMm.size(); ++i)
            EXPECT_NEAR(found.lines[0].radiusMm[i], 6, 0.7);
    }
}

// The same voxels, numbered along other axes: y, z, x with y backwards; and left for right.
TEST(Centreline, HoweverVoxelsAreNumbered) {
    const auto line = helix(0.8);
    const glm::dvec3 spacing{0.8, 1, 1.5}, low{-38, -38, -16};
    const glm::ivec3 extent(95, 76, 40);
    const VolumeInfo info = boxInfo(extent, spacing, low);
    const FieldChunks as(info, tube(line, 6, 1.2));
    const Centrelines known = find(as, between(line[6], line[line.size() - 7]));
    VolumeInfo turned = info, mirrored = info;
    turned.extentVoxels = {extent.y, extent.z, extent.x};
    const double top = low.y + (extent.y - 0.5) * spacing.y;
    turned.patientFromVoxel = patientFromVoxelOf({low.x + 0.5 * spacing.x, top, low.z + 0.5 * spacing.z},
                                                 {0, -spacing.y, 0}, {0, 0, spacing.z}, {spacing.x, 0, 0});
    mirrored.patientFromVoxel = patientFromVoxelOf(
        {low.x + (extent.x - 0.5) * spacing.x, low.y + 0.5 * spacing.y, low.z + 0.5 * spacing.z},
        {-spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z});
    for (const VolumeInfo& other : {turned, mirrored}) {
        const FieldChunks numbered(other, tube(line, 6, 1.2));
        const Centrelines found = find(numbered, between(line[6], line[line.size() - 7]));
        const Apart off = apart(found.lines[0].points, known.lines[0].points);
        EXPECT_LT(off.mean, 0.1 * voxelMm(as));
        EXPECT_LT(off.most, 0.5 * voxelMm(as));
        EXPECT_NEAR(found.lines[0].lengthMm(), known.lines[0].lengthMm(), 0.5);
        EXPECT_EQ(found.lumen.threshold, known.lumen.threshold);
    }
}

TEST(Centreline, AWallThinnerThanABlockIsNoWayThrough) {
    // two arms of a U with a wall of two voxels between them, in a volume whose path is searched in larger
    // blocks
    const std::vector<glm::dvec3> u = {{-11, 0, 0}, {-11, 0, 90}, {-9, 0, 98}, {0, 0, 103},
                                       {9, 0, 98},  {11, 0, 90},  {11, 0, 0}};
    const FieldChunks chunks(boxInfo({130, 60, 300}, glm::dvec3(0.4), {-26, -12, -4}), tube(u, 10.6, 0.3));
    const Centrelines found = find(chunks, between({-11, 0, 4}, {11, 0, 4}));
    EXPECT_GT(found.blockVoxels, 1);
    EXPECT_NEAR(found.lines[0].lengthMm(), 211, 15);
    expectInside(chunks, found.lines[0], found.lumen);
}

/// Steps as a reader of paths wants them.
void expectEvenSteps(const CentreLine& line, double mostMm) {
    EXPECT_LE(line.spacingMm, mostMm);
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
        const double step = glm::length(line.points[i + 1] - line.points[i]);
        ASSERT_LE(step, line.spacingMm * (1 + 1e-9)) << mostMm;
        ASSERT_GE(step, 0.6 * line.spacingMm) << mostMm;
    }
}

/// However far apart points are asked for, and the way between two of them lies in the lumen.
TEST(Centreline, StepsOfAnyLengthAreEvenAndInside) {
    const std::vector<glm::dvec3> hairpin = {{-4, 0, 0}, {-4, 0, 50}, {-3, 0, 52}, {0, 0, 54},
                                             {3, 0, 52}, {4, 0, 50},  {4, 0, 0}};
    const FieldChunks chunks(boxInfo({50, 40, 140}, glm::dvec3(0.5), {-12, -10, -8}), tube(hairpin, 2, 0.5));
    CentrelineRequest request = between({-4, 0, 2}, {4, 0, 2});
    for (const double spacing : {0.7, 3.0, 11.0, 23.0, 47.0}) {
        request.spacingMm = spacing;
        const Centrelines found = find(chunks, request);
        expectEvenSteps(found.lines[0], spacing);
        if (spacing < 20)
            expectInside(chunks, found.lines[0], found.lumen);
    }
}

/// A line that turns back at two thirds of its length: in two even steps, four, eight and sixteen, a step
/// holds the turn's both sides and is too short.
TEST(Centreline, StepsAcrossAKinkAreEven) {
    const std::vector<glm::dvec3> hairpin = {{-1, 0, 0}, {-1, 0, 60}, {1, 0, 60}, {1, 0, 30}};
    const FieldChunks chunks(boxInfo({32, 24, 272}, glm::dvec3(0.25), {-4, -3, -4}),
                             tube(hairpin, 0.6, 0.25));
    CentrelineRequest request = between({-1, 0, 1}, {1, 0, 31});
    request.spacingMm = 47;
    expectEvenSteps(find(chunks, request).lines[0], 47);
}

TEST(Centreline, AThresholdThatLeaksIsTightenedAndSaidSo) {
    // a windpipe whose wall has a hole to a lung that is nearly as dark
    const std::vector<glm::dvec3> line = {{0, 0, 0}, {0, 0, 80}};
    const Field pipe = tube(line, 6, 1);
    const FieldChunks leaky(boxInfo({90, 60, 90}, glm::dvec3(1), {-30, -30, -5}), [=](const glm::dvec3& p) {
        const bool hole = p.x > 0 && p.x < 12 && std::abs(p.y) < 2 && std::abs(p.z - 40) < 2;
        const bool lung = p.x > 10;
        return std::min(pipe(p), hole || lung ? -860.0 : 40.0);
    });
    CentrelineRequest request = between({0, 0, 6}, {0, 0, 74});
    const Centrelines found = find(leaky, request);
    ASSERT_TRUE(found.evidence.leaksAt);
    EXPECT_FALSE(found.evidence.leaks) << "what was taken does not";
    EXPECT_NEAR(*found.evidence.leaksAt, -480, 30);
    EXPECT_LT(found.lumen.threshold, -860);
    EXPECT_NEAR(static_cast<double>(found.lumenVoxels), 3.14159 * 36 * 80, 2500);
    EXPECT_LT(apart(found.lines[0].points, line).most, 0.5);
    request.threshold = -700; // one that is given, too
    const Centrelines given = find(leaky, request);
    EXPECT_EQ(given.evidence.leaksAt, -700);
    EXPECT_LT(given.lumen.threshold, -860);
    EXPECT_LT(given.lumenVoxels, 12000u);
    EXPECT_THAT(lumenText(given, "HU"), HasSubstr("tightened from -700 HU, at which it leaks"));
    request.mayLeak = true; // but where that is asked for
    EXPECT_GT(find(leaky, request).lumenVoxels, 100000u);
    EXPECT_EQ(find(leaky, request).lumen.threshold, -700);
    const FieldChunks tight(leaky.info(), pipe);
    EXPECT_FALSE(find(tight, between({0, 0, 6}, {0, 0, 74})).evidence.leaksAt);
}

TEST(Centreline, OneSeedGoesToTheFurthestPlace) {
    const auto line = helix(0.7);
    const FieldChunks chunks(boxInfo({90, 90, 50}, glm::dvec3(0.9), {-40, -40, -9}), tube(line, 5, 1));
    CentrelineRequest request;
    request.seeds = {{line[2], "--from"}};
    const Centrelines found = find(chunks, request);
    EXPECT_LT(apart(found.lines[0].points, line).most, 1);
    EXPECT_LT(glm::length(found.lines[0].points.back() - line.back()), 8);
}

TEST(Centreline, SeedsThatAreNowhereAreNamed) {
    const auto line = helix(0.7);
    const FieldChunks chunks(boxInfo({90, 90, 50}, glm::dvec3(0.9), {-40, -40, -9}), tube(line, 5, 1));
    EXPECT_THAT(refusal(chunks, between(line[9], {0, 0, 500})),
                HasSubstr("--to: expected a point in the volume, from (-40.0, -40.0, -9.0) mm"));
    EXPECT_THAT(refusal(chunks, between({std::nan(""), 0, 0}, line[9])),
                HasSubstr("--from: expected a point in the volume"));
    EXPECT_THAT(refusal(chunks, between(line[9], {0, 0, 8})),
                HasSubstr("--to: expected a point in the lumen of --from"));
    CentrelineRequest given = between(line[9], {0, 0, 8});
    given.threshold = -500;
    EXPECT_THAT(refusal(chunks, given), HasSubstr("found 40 at (0.0, 0.0, 8.0) mm"));
    const FieldChunks nothing(chunks.info(), [](const glm::dvec3&) { return -1000.0; });
    EXPECT_THAT(refusal(nothing, between({0, 0, 0}, {5, 5, 5})),
                HasSubstr("--from: expected a point in a lumen, with a wall"));
}

TEST(Centreline, AVolumeOfAnySizeStaysWithinItsBudget) {
    // 2048^3 voxels, 17 GB, of which those near a tube of 30 voxels' radius are read
    const std::vector<glm::dvec3> line = {{40, 60, 20}, {80, 90, 120}, {90, 90, 150}};
    const FieldChunks chunks(boxInfo(glm::ivec3(2048), glm::dvec3(0.125), glm::dvec3(0)),
                             tube(line, 3.75, 0.3));
    const Centrelines found = find(chunks, between(line.front(), line.back()), 32u << 20);
    EXPECT_LT(apart(found.lines[0].points, line).mean, 0.25);
    EXPECT_GT(found.lumenVoxels, 2000000u);
    EXPECT_LT(chunks.read(), 4000);
    EXPECT_THAT(refusal(chunks, between(line.front(), line.back()), 6u << 20), HasSubstr("raise --ram"));
}

TEST(Centreline, IsCalledOffWhileItReads) {
    const auto line = helix(0.7);
    FieldChunks chunks(boxInfo({180, 180, 100}, glm::dvec3(0.45), {-40, -40, -9}), tube(line, 5, 1));
    Cancellation::Flag flag = false;
    chunks.onRead = [&] { flag = chunks.read() > 3; };
    const Cancellation cancellation(&flag);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    Progress silent;
    EXPECT_THROW(findCentrelines(chunks, between(line[2], line.back()), ram, silent, 2), Cancelled);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LT(chunks.read(), 60) << "of 6 x 6 x 4";
}

/// What people are told of a lumen, word by word.
// Residue or a fold about a seed is brighter than the air around it, and still of the lumen.
TEST(Centreline, ASeedInWhatIsBrighterThanTheLumenIsOfIt) {
    const auto line = helix(0.7);
    const auto air = tube(line, 5, 1);
    const glm::dvec3 end = line[line.size() - 9];
    const auto chunks = [&](double value) {
        return FieldChunks(boxInfo({90, 90, 50}, glm::dvec3(0.9), {-40, -40, -9}), [=](const glm::dvec3& at) {
            return glm::length(at - end) < 2.2 ? value : air(at);
        });
    };
    const Centrelines found = find(chunks(-620), between(line[9], end));
    EXPECT_LT(glm::length(found.lines[0].points.back() - end), 1);
    EXPECT_NEAR(found.lumen.threshold, find(chunks(-1000), between(line[9], end)).lumen.threshold, 1);
    EXPECT_THAT(refusal(chunks(-300), between(line[9], end)),
                HasSubstr("--to: expected a point in the lumen of --from, below -48"));
}

TEST(Centreline, ALumenIsToldInOneLine) {
    Centrelines found;
    found.lumen.threshold = -480.25;
    found.evidence.lumen = -1000;
    found.evidence.wall = 40;
    const auto text = [&] { return lumenText(found, "HU"); };
    EXPECT_EQ(text(), "lumen: below -480.2 HU, half way from -1000 in it to 40 around it");
    EXPECT_EQ(lumenText(found, ""), "lumen: below -480.2, half way from -1000 in it to 40 around it");
    found.evidence.given = true;
    EXPECT_EQ(text(), "lumen: below -480.2 HU, as given");
    found.evidence.leaksAt = -350;
    EXPECT_EQ(text(), "lumen: below -480.2 HU, tightened from -350 HU, at which it leaks");
    found.lumen.branchesTo = -400;
    found.lumen.noise = 20;
    found.evidence.noise = 21;
    found.evidence.noiseLeft = 3.5;
    EXPECT_EQ(text(),
              "lumen: below -480.2 HU, tightened from -350 HU, at which it leaks; thin branches to -400 HU; "
              "noise of 21 HU, smoothed to 3.5 HU");
    found.evidence.leaks = true;
    found.lumen.branchesTo.reset();
    found.lumen.noise = 0;
    EXPECT_EQ(text(),
              "lumen: below -480.2 HU, as given; it leaks: lines may lie outside of it, and a tighter "
              "threshold separates the seeds");
    found.lumen.leavesAtMm = 24.4;
    EXPECT_THAT(text(), HasSubstr("outside of it from 24.4 mm on, and"));
    found.evidence = {};
    found.evidence.lumen = 300;
    found.lumen = {200, Lumen::Side::above};
    for (const double left : {24.9, 25.0, 25.1}) { // four deviations are clear
        found.evidence.noiseLeft = left;
        EXPECT_EQ(found.evidence.clear(200), left <= 25) << left;
        EXPECT_EQ(text(), std::string("lumen: above 200 HU, half way from 300 in it to 0 around it") +
                              (left > 25 ? "; unsure: it hardly differs from the noise in it" : ""));
    }
    Centrelines muscle;
    muscle.evidence.wall = 800;
    for (const auto& [value, isTold] : {std::pair{52.0, true}, {-100, true}, {-700, false}, {240, false}}) {
        muscle.evidence.lumen = value;
        EXPECT_EQ(lumenText(muscle, "HU").find("soft tissue") != std::string::npos, isTold) << value;
        EXPECT_EQ(lumenText(muscle, "").find("soft tissue"), std::string::npos);
    }
}

} // namespace
} // namespace tessera::test
