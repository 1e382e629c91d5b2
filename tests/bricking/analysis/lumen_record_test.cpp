// tests/bricking/analysis/lumen_record_test.cpp: centre-lines and coverage of lumens without any symmetry, as
// they are recorded: every number of the result. A change of a rule shows here; what a result should be,
// other tests say.
#include "bricking/analysis/lumen/centreline.h"
#include "bricking/analysis/lumen/wall_coverage.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/phantom_chunks.h"
#include "tests/support/recorded_numbers.h"

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

constexpr std::size_t kRoomBytes = std::size_t{256} << 20;

Centrelines linesIn(const ChunkSource& source, const CentrelineRequest& request) {
    MemoryBudget ram("RAM", "--ram", kRoomBytes);
    Progress silent;
    return findCentrelines(source, request, ram, silent, 2);
}

double numberOf(const std::optional<double>& value) {
    return value.value_or(-1e9); // no value that occurs
}

/// Every second point of each line, and the others by their number.
void expectRecorded(RecordedNumbers& record, const Centrelines& found) {
    const LumenEvidence& evidence = found.evidence;
    record.expect("rule", {found.lumen.threshold, found.lumen.side == Lumen::Side::below ? 1.0 : 0.0,
                           found.lumen.noise, numberOf(found.lumen.surface), numberOf(found.lumen.branchesTo),
                           numberOf(found.lumen.branchWall), numberOf(found.lumen.leavesAtMm),
                           found.lumen.unsure ? 1.0 : 0.0, found.lumen.leaks ? 1.0 : 0.0});
    record.expect("evidence", {evidence.lumen, evidence.wall, evidence.noise, evidence.noiseLeft,
                               numberOf(evidence.leaksAt), evidence.given ? 1.0 : 0.0});
    record.expect("lumen", {static_cast<double>(found.lumenVoxels), static_cast<double>(found.blockVoxels)});
    record.expect("turn", {found.leastTurnMm}, 1e-3);
    for (const CentrelineBridge& bridge : found.bridges)
        record.expect("bridge", {bridge.fromMm.x, bridge.fromMm.y, bridge.fromMm.z, bridge.toMm.x,
                                 bridge.toMm.y, bridge.toMm.z});
    for (std::size_t i = 0; i < found.lines.size(); ++i) {
        const CentreLine& line = found.lines[i];
        record.expect("line",
                      {static_cast<double>(found.generations[i]),
                       line.parent ? static_cast<double>(*line.parent) : -1, line.leavesAtMm, line.spacingMm,
                       static_cast<double>(line.points.size())},
                      1e-4, 1e-3);
        std::vector<double> points;
        for (std::size_t p = 0; p < line.points.size(); p += 2)
            points.insert(points.end(),
                          {line.points[p].x, line.points[p].y, line.points[p].z, line.radiusMm[p]});
        record.expect("points", points, 1e-4, 5e-3);
    }
}

void expectRecorded(RecordedNumbers& record, const WallCoverage& found) {
    record.expect("wall", {found.wallMm2, found.seenMm2, static_cast<double>(found.faces),
                           static_cast<double>(found.lines), static_cast<double>(found.flown),
                           static_cast<double>(found.blind)});
    for (const UnseenPatch& patch : found.patches)
        record.expect("patch", {patch.middleMm.x, patch.middleMm.y, patch.middleMm.z, patch.areaMm2,
                                patch.alongMm, patch.fromMm, patch.toMm});
}

double smoothStep(double away, double soft, double inside, double outside) {
    return inside + std::clamp(away / soft + 0.5, 0.0, 1.0) * (outside - inside);
}

/// A windpipe with three branches in a lung. Its wall has a hole to the lung, one branch is narrow where it
/// begins, one forks again.
FieldChunks airways() {
    const std::vector<glm::dvec3> trunk = {{1, 0.5, -40}, {0, 1.2, 100}}, narrow = {{0, 1, 20}, {-30, 3, 41}},
                                  wide = {{0.4, 0, 33}, {9, 20, 58}},
                                  forks = {{7.5, 16.5, 53.6}, {22, 14, 66}};
    return {boxInfo({78, 53, 83}, {0.95, 1.05, 0.9}, {-42, -21, -7}), [=](const glm::dvec3& p) {
                const double pipe = lineDistance(p, trunk) - 5.2, thin = lineDistance(p, narrow) - 2.1;
                const double away =
                    std::min({pipe, thin, lineDistance(p, wide) - 3.3, lineDistance(p, forks) - 2.4});
                const bool hole = p.x > 0 && std::abs(p.y - 1) < 2 && std::abs(p.z - 46) < 2;
                const bool wall = away < 1.7 && !(hole && pipe > 0 && pipe < 3);
                const double around = wall ? 45 : hole && pipe < 3 ? -775.0 : -858.0;
                const double air =
                    thin < 0 && pipe > 0 && p.x < -11 && p.x > -13 ? -700 - 20 * p.x - 260 : -1000.0;
                return smoothStep(away, 1, air, around);
            }};
}

TEST(LumenRecord, ATreeInNoise) {
    RecordedNumbers record("tests/bricking/analysis/recorded/airways.txt");
    const FieldChunks clean = airways();
    const NoisyChunks noisy(clean, 31, -1000);
    for (const ChunkSource* source :
         {static_cast<const ChunkSource*>(&noisy), static_cast<const ChunkSource*>(&clean)}) {
        CentrelineRequest request;
        request.seeds = {{{0.3, 0.2, 2.1}, "--from"}};
        request.tree = true;
        const Centrelines tree = linesIn(*source, request);
        expectRecorded(record, tree);
        Path path;
        path.lines = tree.lines;
        path.lumen = tree.lumen;
        path.flight = Flight{};
        std::size_t last = tree.lines.size() - 1;
        path.flight->route = {*tree.lines[last].parent, last};
        path.flight->fromMm = 3;
        CoverageRequest coverage;
        coverage.lines = path.lines;
        coverage.flight = *path.flight;
        coverage.lumen = tree.lumen;
        coverage.cameras = flightCameras(path, 2.5, false);
        coverage.smallestPatchMm2 = 4;
        MemoryBudget ram("RAM", "--ram", kRoomBytes);
        Progress silent;
        expectRecorded(record, measureWallCoverage(*source, coverage, ram, silent, 2));
    }
}

/// A bowel with folds, in voxels whose axes are oblique and no equal length.
FieldChunks bowel(std::vector<glm::dvec3>& course) {
    std::vector<double> arcs = {0};
    for (double a = 0; a <= 0.62; a += 0.0125)
        course.emplace_back(24 * std::cos(6.2831853 * a), 19 * std::sin(6.2831853 * a) + 5 * a,
                            47 * a * a + 11 * a);
    for (std::size_t i = 1; i < course.size(); ++i)
        arcs.push_back(arcs.back() + glm::length(course[i] - course[i - 1]));
    VolumeInfo info = boxInfo({100, 80, 25}, glm::dvec3(1), glm::dvec3(0));
    const double c = std::cos(0.3), s = std::sin(0.3);
    info.patientFromVoxel = patientFromVoxelOf({-23.5, -42.7, -8}, {0.7 * c, 0.7 * s, 0},
                                               {-0.9 * s, 0.9 * c, 0.02}, {0.05, 0, 1.7});
    return {info, [=](const glm::dvec3& p) {
                double best = 1e300, along = 0;
                for (std::size_t i = 0; i + 1 < course.size(); ++i)
                    if (const double away = segmentDistance(p, course[i], course[i + 1]); away < best) {
                        best = away;
                        along = arcs[i] +
                                glm::dot(p - course[i], course[i + 1] - course[i]) / (arcs[i + 1] - arcs[i]);
                    }
                const double fold = std::max(0.0, std::cos(along * 6.2831853 / 13) - 0.5);
                return smoothStep(best - 6.1 + 4.5 * fold, 1.2, -995, 38);
            }};
}

TEST(LumenRecord, ABowelThroughThreeSeedsAndItsCoverage) {
    RecordedNumbers record("tests/bricking/analysis/recorded/bowel.txt");
    std::vector<glm::dvec3> course;
    const FieldChunks chunks = bowel(course);
    CentrelineRequest request;
    request.seeds = {{course[2], "--from"},
                     {course[24] + glm::dvec3(1, -2, 0.5), "--through"},
                     {course[course.size() - 3], "--to"}};
    request.spacingMm = 1.7;
    const Centrelines found = linesIn(chunks, request);
    expectRecorded(record, found);
    Path path;
    path.lines = found.lines;
    path.lumen = found.lumen;
    path.flight = Flight{};
    path.flight->fromMm = 6.5;
    path.flight->toMm = 71;
    path.flight->viewAngle = 94;
    CoverageRequest coverage;
    coverage.lines = path.lines;
    coverage.flight = *path.flight;
    coverage.lumen = found.lumen;
    for (const bool bothWays : {false, true}) {
        coverage.cameras = flightCameras(path, 6.3, bothWays);
        for (const double farthest : {9.7, 1e9}) {
            coverage.farthestMm = farthest;
            MemoryBudget ram("RAM", "--ram", kRoomBytes);
            Progress silent;
            expectRecorded(record, measureWallCoverage(chunks, coverage, ram, silent, 2));
        }
    }
}

/// A tapering vessel in contrast, with bone beside it and a plaque at its wall.
TEST(LumenRecord, AVesselFromOneSeed) {
    RecordedNumbers record("tests/bricking/analysis/recorded/vessel.txt");
    const std::vector<glm::dvec3> course = {
        {-16, -9, 0}, {-11, 2, 17}, {-2, 7, 29}, {11, 4, 38}, {17, -8, 51}};
    const FieldChunks chunks(
        boxInfo({49, 41, 62}, {0.9, 0.8, 1.1}, {-23, -16, -6}), [=](const glm::dvec3& p) {
            const double vessel = lineDistance(p, course) - 5.4 + 0.05 * p.z;
            const double bone = glm::length(p - glm::dvec3(8, 14, 25)) - 7.3,
                         plaque = glm::length(p - glm::dvec3(-14, -1, 12)) - 2.4;
            return std::max({smoothStep(vessel, 1.1, 342, 47), smoothStep(bone, 0.9, 1180, 47),
                             smoothStep(plaque, 0.8, 905, 47)});
        });
    CentrelineRequest request;
    request.seeds = {{{-14, -5.5, 7}, "--from"}};
    request.spacingMm = 0.8;
    expectRecorded(record, linesIn(chunks, request));
    request.threshold = 171;
    expectRecorded(record, linesIn(chunks, request));
}

/// Three pieces of a lumen, with seeds at the gaps and in one of them.
TEST(LumenRecord, GapsThatAreBridged) {
    RecordedNumbers record("tests/bricking/analysis/recorded/gaps.txt");
    const Field first = tube({{0, 0, -3}, {2, 1, 24}}, 4.4, 1),
                second = tube({{4, 3, 41}, {1, 6, 63}}, 3.7, 1),
                third = tube({{-1, 7, 76}, {-6, 3, 95}}, 5.2, 1);
    const FieldChunks chunks(boxInfo({29, 27, 93}, {0.9, 1, 1.15}, {-14, -9, -9}), [=](const glm::dvec3& p) {
        return std::min({first(p), second(p), third(p)});
    });
    CentrelineRequest request;
    request.seeds = {{{0.4, -0.2, 1}, "--from"},
                     {{3, 2, 33}, "--through", true},
                     {{3.2, 3.9, 47}, "--through"},
                     {{-2, 6.2, 79}, "--through", true},
                     {{-5, 3.8, 91}, "--to"}};
    expectRecorded(record, linesIn(chunks, request));
}

/// A leak between two seeds that no threshold closes: the lung is as bright as the piece between them.
TEST(LumenRecord, ALeakThatStays) {
    RecordedNumbers record("tests/bricking/analysis/recorded/leak.txt");
    const Field pipe = tube({{0, 0, -2}, {3, 2, 82}}, 6.2, 1);
    const FieldChunks open(boxInfo({79, 48, 83}, {1, 1.1, 1.05}, {-25, -24, -5}), [=](const glm::dvec3& p) {
        const bool lung = p.x > 11 || (p.x > 0 && std::abs(p.z - 41) < 5 && std::abs(p.y - 1) < 3);
        return p.z > 31 && p.z < 52 && pipe(p) < -800 ? -841.0 : std::min(pipe(p), lung ? -852.0 : 43.0);
    });
    CentrelineRequest request;
    request.seeds = {{{0.4, 0.3, 7}, "--from"}, {{2.3, 2.2, 75}, "--to"}};
    expectRecorded(record, linesIn(open, request));
}

} // namespace
} // namespace tessera::test
