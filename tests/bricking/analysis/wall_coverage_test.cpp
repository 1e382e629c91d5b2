// tests/bricking/analysis/wall_coverage_test.cpp: the visible share of a wall, against shapes whose area and
// unseen side are known, and against the formula of the torso's colon.
#include "bricking/analysis/lumen/wall_coverage.h"
#include "bricking/analysis/lumen/wall_patches.h"
#include "core/animation/flight.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "datasets/colon_shape.h"
#include "datasets/phantom.h"
#include "tests/support/lumen_tubes.h"

#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <span>

namespace tessera::test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

constexpr std::size_t kWallBytes = std::size_t{256} << 20;
constexpr double kRadius = 10;

CentreLine lineOf(std::vector<glm::dvec3> points, double radius) {
    CentreLine line;
    line.radiusMm.assign(points.size(), radius);
    line.spacingMm = glm::length(points[1] - points[0]);
    line.points = std::move(points);
    return line;
}

std::vector<glm::dvec3> straight(const glm::dvec3& from, const glm::dvec3& to, int steps) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= steps; ++i)
        points.push_back(from + (to - from) * (static_cast<double>(i) / steps));
    return points;
}

Path pathAlong(std::vector<glm::dvec3> points) {
    Path path;
    path.lines = {lineOf(std::move(points), kRadius)};
    path.lumen = Lumen{-480, Lumen::Side::below};
    path.flight = Flight{};
    return path;
}

CoverageRequest requestOf(const Path& path, bool bothWays = false) {
    CoverageRequest request;
    request.lines = path.lines;
    request.flight = *path.flight;
    request.lumen = *path.lumen;
    request.cameras = flightCameras(path, 2, bothWays);
    return request;
}

WallCoverage measure(const ChunkSource& source, const CoverageRequest& request, int threads = 2,
                     std::size_t budget = kWallBytes) {
    MemoryBudget ram("RAM", "--ram", budget);
    Progress silent;
    WallCoverage found = measureWallCoverage(source, request, ram, silent, threads);
    EXPECT_EQ(ram.usedBytes(), 0u);
    return found;
}

std::string refusal(const ChunkSource& source, const CoverageRequest& request,
                    std::size_t budget = kWallBytes) {
    try {
        measure(source, request, 2, budget);
    } catch (const InputError& error) {
        return error.what();
    }
    return "not refused";
}

/// Tissue with a tube of air along z, longer than its line at both ends.
FieldChunks tubeAlongZ(const glm::dvec3& spacing) {
    return {boxInfo(glm::ivec3(glm::ceil(glm::dvec3(28, 28, 160) / spacing)), spacing, {-14, -14, -20}),
            tube({{0, 0, -14}, {0, 0, 134}}, kRadius, 1)};
}

TEST(WallCoverage, ATubesWallHasItsAreaHoweverItLies) {
    Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
    for (const glm::dvec3& spacing : {glm::dvec3(1), glm::dvec3(0.6, 0.8, 2)}) {
        const WallCoverage found = measure(tubeAlongZ(spacing), requestOf(path));
        EXPECT_NEAR(found.wallMm2, 2 * pi * kRadius * 120, 0.025 * 2 * pi * kRadius * 120);
    }
    const glm::dvec3 from(-30, -25, -20), to(30, 25, 20); // faces alone would be 1.4 times as much
    const FieldChunks slanting(boxInfo({100, 90, 80}, glm::dvec3(1), {-50, -45, -40}),
                               tube({1.2 * from, 1.2 * to}, kRadius, 1));
    const double area = 2 * pi * kRadius * glm::length(to - from);
    const WallCoverage found = measure(slanting, requestOf(pathAlong(straight(from, to, 44))));
    EXPECT_NEAR(found.wallMm2, area, 0.025 * area);
    EXPECT_GT(static_cast<double>(found.faces), 1.3 * area) << "of 1 mm2";
    EXPECT_GT(found.share(), 0.85);
}

TEST(WallCoverage, OneSeesAStraightTubeButForWhatTheFirstPictureLeavesOut) {
    Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
    path.flight->viewAngle = 90;
    CoverageRequest request = requestOf(path);
    request.aspect = 1; // the picture's edges come to the wall 10 mm ahead, its corners nearer than that
    const FieldChunks chunks = tubeAlongZ(glm::dvec3(1));
    const WallCoverage ahead = measure(chunks, request);
    // of the first 10 mm what is within a square of half edge z: 1 - (mean over the round of max(|c|, |s|))
    const double meanMost = 4 / pi * std::sin(pi / 4); // of max(|cos|, |sin|)
    const double unseen = meanMost * 10 / 120;
    EXPECT_NEAR(ahead.share(), 1 - unseen, 0.015);
    ASSERT_EQ(ahead.patches.size(), 1u);
    EXPECT_NEAR(ahead.patches[0].areaMm2, unseen * ahead.wallMm2, 90);
    EXPECT_NEAR(ahead.patches[0].fromMm, 0, 1);
    EXPECT_NEAR(ahead.patches[0].toMm, 10, 1.5);
    EXPECT_NEAR(glm::length(glm::dvec2(ahead.patches[0].middleMm)), kRadius, 1) << "on the wall";
    request.cameras = flightCameras(path, 2, true);
    EXPECT_GT(measure(chunks, request).share(), 0.9999);
    request.cameras = flightCameras(path, 2, false);
    request.farthestMm = 8; // the wall is 10 mm away
    EXPECT_LT(measure(chunks, request).share(), 0.01);
}

/// However wide pictures are: the wall at an angle is seen from where its picture's edge is wide enough.
TEST(WallCoverage, WiderPicturesSeeMore) {
    Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
    path.flight->viewAngle = 90;
    const FieldChunks chunks = tubeAlongZ(glm::dvec3(1));
    double before = 0;
    for (const double aspect : {0.25, 1.0, 4.0}) {
        CoverageRequest request = requestOf(path);
        request.aspect = aspect;
        double unseenMm = 0; // of the tube's beginning, in the mean around it
        constexpr int kAngles = 3600;
        for (int i = 0; i < kAngles; ++i) {
            const double angle = 2 * pi * i / kAngles;
            unseenMm +=
                kRadius * std::max(std::abs(std::cos(angle)) / aspect, std::abs(std::sin(angle))) / kAngles;
        }
        const double share = measure(chunks, request).share();
        EXPECT_NEAR(share, 1 - unseenMm / 120, 0.02) << aspect;
        if (aspect <= 1) { // beyond, the wall beside the eye is a voxel or two away
            EXPECT_GT(share, before + 0.02) << aspect;
        }
        before = share;
    }
}

/// From one end of what is flown to the other, both of them looked from, and no further apart than was asked.
TEST(WallCoverage, CamerasAreAtBothEndsAndBetween) {
    for (const bool backwards : {false, true})
        for (const double every : {1.0, 7.0, 33.0, 500.0}) {
            Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
            path.flight->fromMm = 10, path.flight->toMm = 100;
            path.flight->backwards = backwards;
            const std::vector<Camera> cameras = flightCameras(path, every, false);
            ASSERT_EQ(cameras.size(), static_cast<std::size_t>(std::ceil(90 / every)) + 1);
            EXPECT_NEAR(cameras.front().position.z, backwards ? 100 : 10, 1e-6);
            EXPECT_NEAR(cameras.back().position.z, backwards ? 10 : 100, 1e-6);
            for (std::size_t i = 1; i < cameras.size(); ++i)
                EXPECT_LE(glm::length(cameras[i].position - cameras[i - 1].position), every + 1e-6);
            const std::vector<Camera> both = flightCameras(path, every, true);
            ASSERT_EQ(both.size(), 2 * cameras.size());
            for (std::size_t i = 0; i < cameras.size(); ++i)
                EXPECT_LT(glm::length(both[both.size() - 1 - i].position - cameras[i].position), 1e-6);
        }
}

/// Keyframes at places keep them, whichever way they are flown over.
TEST(WallCoverage, KeyframesAtPlacesAreFlownOverBothWays) {
    Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
    for (const double mm : {20.0, 60.0, 90.0}) {
        Keyframe& key = path.keyframes.emplace_back();
        key.placeMm = mm;
        key.look = LookAround{.yawDegrees = mm, .pitchDegrees = 0, .offsetMm = {}};
    }
    const std::vector<Camera> both = flightCameras(path, 2, true);
    const Path back = flownTheOtherWay(path);
    EXPECT_TRUE(back.flight->backwards);
    EXPECT_NO_THROW(checkPath(back, "back"));
    const std::vector<Camera> alone = flightCameras(back, 2, false);
    ASSERT_EQ(both.size(), 2 * alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i)
        EXPECT_EQ(both[alone.size() + i], alone[i]);
    EXPECT_EQ(flownTheOtherWay(back).keyframes.front().placeMm, 20.0);
    Path timed = path; // times are times
    for (std::size_t n = 0; n < 3; ++n) {
        timed.keyframes[n].placeMm.reset();
        timed.keyframes[n].timeS = static_cast<double>(n);
    }
    EXPECT_EQ(flownTheOtherWay(timed).keyframes.front().timeS, 0.0);
}

/// The volume's border is no wall: of a tube that a border cuts lengthwise the remaining wall counts.
TEST(WallCoverage, TheVolumesBorderIsNoWall) {
    constexpr double kInside = 4.5; // mm from the axis to the border
    const double left = 2 * pi - 2 * std::acos(kInside / kRadius), area = left * kRadius * 120;
    for (const int axis : {0, 1})
        for (const bool upper : {false, true}) {
            glm::dvec3 corner(-14, -14, -20);
            glm::ivec3 extent(28, 28, 160);
            extent[axis] = 19;
            corner[axis] = upper ? kInside - 19 : -kInside;
            const FieldChunks chunks(boxInfo(extent, glm::dvec3(1), corner),
                                     tube({{0, 0, -14}, {0, 0, 134}}, kRadius, 1));
            const WallCoverage found =
                measure(chunks, requestOf(pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60))));
            EXPECT_NEAR(found.wallMm2, area, 0.05 * area) << axis << (upper ? ", upper" : ", lower");
        }
}

/// What the header says, face by face, with the wall's normals and lines of sight of wall_patches.h.
struct PlainCoverage {
    double wall = 0, seen = 0;
    std::uint64_t faces = 0, blind = 0;
};
PlainCoverage plainly(const FieldChunks& chunks, const CoverageRequest& request) {
    const VolumeInfo& info = chunks.info();
    MemoryBudget ram("RAM", "--ram", kWallBytes);
    VoxelSet lumen(info.extentVoxels, ram);
    const glm::dmat4 toMm = info.patientFromVoxel, toVoxel = glm::inverse(toMm);
    const auto mmOf = [&](const glm::dvec3& place) { return glm::dvec3(toMm * glm::dvec4(place, 1)); };
    std::vector<std::int16_t> chunk(cellCount(glm::ivec3(kChunkExtent)));
    for (std::size_t c = 0; c < cellCount(lumen.chunks()); ++c) {
        const glm::ivec3 at = gridPosition(c, lumen.chunks());
        chunks.readChunk({0, at.x, at.y, at.z}, std::as_writable_bytes(std::span(chunk)));
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const glm::ivec3 local = gridPosition(i, glm::ivec3(kChunkExtent)), v = 32 * at + local;
            if (v == glm::min(v, info.extentVoxels - 1) && chunk[i] < request.lumen.threshold)
                lumen.edit(c)[static_cast<std::size_t>(local.y + 32 * local.z)] |= 1u << local.x;
        }
    }
    const std::vector<RoutePoint> route = routeOf(request.lines, request.flight.route);
    const double from = request.flight.fromMm, to = request.flight.toMm.value_or(route.back().alongMm);
    double reach = 0;
    for (const RoutePoint& point : route)
        if (point.alongMm >= from && point.alongMm <= to)
            reach = std::max(reach, 1.5 * point.radiusMm);
    reach += glm::length(info.spacingMm());
    std::vector<glm::dvec3> way, others; // points of lines that are not flown
    for (const RoutePoint& point : route)
        way.push_back(point.at);
    for (const CentreLine& line : request.lines)
        for (const glm::dvec3& p : line.points)
            if (lineDistance(p, way) > 0.5 * line.spacingMm)
                others.push_back(p);
    const auto counts = [&](const glm::dvec3& mm) {
        std::size_t nearest = 0;
        double best = 1e300;
        for (std::size_t i = 0; i + 1 < way.size(); ++i)
            if (const double away = segmentDistance(mm, way[i], way[i + 1]); away < best) {
                best = away;
                nearest = i;
            }
        const glm::dvec3 a = way[nearest], ab = way[nearest + 1] - a;
        const double t = glm::dot(mm - a, ab) / glm::dot(ab, ab);
        const double along = route[nearest].alongMm +
                             std::clamp(t, 0.0, 1.0) * (route[nearest + 1].alongMm - route[nearest].alongMm);
        const bool beyond = (nearest == 0 && t < 0) || (nearest + 2 == way.size() && t > 1);
        return best <= reach && !beyond && along >= from && along <= to &&
               std::none_of(others.begin(), others.end(),
                            [&](const glm::dvec3& p) { return glm::length(p - mm) < best; });
    };
    PlainCoverage found;
    std::vector<Camera> eyes;
    for (const Camera& camera : request.cameras)
        if (lumen.containsPlace(glm::dvec3(toVoxel * glm::dvec4(camera.position, 1))))
            eyes.push_back(camera);
    found.blind = request.cameras.size() - eyes.size();
    const WallFaces wall(lumen, toMm);
    for (std::size_t i = 0; i < cellCount(info.extentVoxels); ++i)
        for (int side = 0; side < kSides; ++side) {
            const glm::ivec3 v = gridPosition(i, info.extentVoxels), beside = v + sideStep(side);
            if (!lumen.contains(v) || lumen.contains(beside) ||
                beside != glm::clamp(beside, glm::ivec3(0), info.extentVoxels - 1))
                continue;
            const WallFaces::Face face = wall.at(v, side);
            const glm::dvec3 mm = mmOf(face.middle);
            if (!counts(mm))
                continue;
            ++found.faces;
            found.wall += face.areaMm2;
            for (const Camera& eye : eyes) {
                const glm::dmat3 axes = patientFromCamera(eye);
                const glm::dvec3 ray = mm - eye.position,
                                 local(glm::dot(ray, axes[0]), glm::dot(ray, axes[1]),
                                       -glm::dot(ray, axes[2]));
                const double edge = std::tan(0.5 * eye.viewAngle * pi / 180) * local.z;
                if (local.z > 0 && glm::dot(ray, face.outward) > 0 &&
                    std::abs(local.x) <= edge * request.aspect && std::abs(local.y) <= edge &&
                    glm::length(ray) <= request.farthestMm &&
                    seesThrough(lumen, face.above, glm::dvec3(toVoxel * glm::dvec4(eye.position, 1)))) {
                    found.seen += face.areaMm2;
                    break;
                }
            }
        }
    return found;
}

/// Three lines of different widths that fork, of which two are flown; the wall of the third is not theirs.
TEST(WallCoverage, IsWhatEveryFaceAndEveryCameraSay) {
    const std::vector<glm::dvec3> trunk = straight({0, 0, 0}, {3, 2, 30}, 20),
                                  left = straight({3, 2, 30}, {-14, 8, 52}, 25),
                                  right = straight({3, 2, 30}, {17, -3, 49}, 17);
    VolumeInfo info = boxInfo({61, 47, 41}, glm::dvec3(1), glm::dvec3(0));
    const double c = std::cos(0.25), s = std::sin(0.25);
    info.patientFromVoxel =
        patientFromVoxelOf({-26, -18, -3.5}, {0.9 * c, 0.9 * s, 0}, {-s, c, 0}, {0, 0.05, 1.4});
    const Field wide = tube(trunk, 5.6, 1), a = tube(left, 4.1, 1), b = tube(right, 3.3, 1);
    const FieldChunks chunks(info, [=](const glm::dvec3& p) { return std::min({wide(p), a(p), b(p)}); });
    Path path;
    path.lines = {lineOf(trunk, 5.6), lineOf(left, 4.1), lineOf(right, 3.3)};
    path.lines[1].parent = path.lines[2].parent = 0;
    path.lines[1].leavesAtMm = path.lines[2].leavesAtMm = path.lines[0].lengthMm();
    path.lumen = Lumen{-480, Lumen::Side::below};
    for (const std::size_t branch : {1u, 2u})
        for (const bool part : {false, true}) {
            path.flight = Flight{};
            path.flight->route = {0, branch};
            path.flight->viewAngle = part ? 75 : 110;
            if (part) {
                path.flight->fromMm = 8.5;
                path.flight->toMm = 41.2;
            }
            CoverageRequest request;
            request.lines = path.lines;
            request.flight = *path.flight;
            request.lumen = *path.lumen;
            request.cameras = flightCameras(path, 7, part);
            request.cameras.push_back(request.cameras.back());
            request.cameras.back().position += glm::dvec3(0, 20, 0); // in the wall
            request.aspect = part ? 0.7 : 1.6;
            request.farthestMm = part ? 24 : 1e9;
            const WallCoverage found = measure(chunks, request);
            const PlainCoverage expected = plainly(chunks, request);
            EXPECT_EQ(found.faces, expected.faces);
            EXPECT_EQ(found.blind, expected.blind);
            EXPECT_EQ(expected.blind, 1u);
            EXPECT_NEAR(found.wallMm2, expected.wall, 1e-4 * expected.wall);
            EXPECT_NEAR(found.seenMm2, expected.seen, 1e-4 * expected.wall);
            EXPECT_GT(expected.seen, 0.3 * expected.wall);
            EXPECT_LT(expected.seen, 0.99 * expected.wall);
        }
}

TEST(WallCoverage, TheBackOfAFoldIsSeenOnTheWayBackAlone) {
    // a ring that stands 5 mm into the tube, 3 mm thick, in the middle
    const Field pipe = tube({{0, 0, -14}, {0, 0, 134}}, kRadius, 1);
    const FieldChunks chunks(
        boxInfo({47, 47, 267}, glm::dvec3(0.6), {-14, -14, -20}), [=](const glm::dvec3& p) {
            const double inRing = std::min(1.5 - std::abs(p.z - 60), glm::length(glm::dvec2(p)) - 5);
            const double share = std::clamp(inRing / 0.6 + 0.5, 0.0, 1.0);
            return std::max(pipe(p), -1000 + share * 1040);
        });
    Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
    path.flight->viewAngle = 90;
    CoverageRequest request = requestOf(path);
    const WallCoverage there = measure(chunks, request);
    path.flight->backwards = true;
    const WallCoverage back = measure(chunks, requestOf(path));
    path.flight->backwards = false;
    const WallCoverage both = measure(chunks, requestOf(path, true));
    const double side = pi * (kRadius * kRadius - 5 * 5),
                 all = 2 * pi * kRadius * 117 + 2 * side + 2 * pi * 5 * 3;
    EXPECT_NEAR(there.wallMm2, all, 0.03 * all);
    // there: the ring's back, from z = 61.5, and nothing else but the beginning
    const auto ofRing = [](const WallCoverage& found, double from, double to) {
        double area = 0;
        for (const UnseenPatch& patch : found.patches)
            area += patch.alongMm > from && patch.alongMm < to ? patch.areaMm2 : 0;
        return area;
    };
    EXPECT_GT(ofRing(there, 61, 72), 0.9 * side) << "its back, and wall beside it";
    EXPECT_EQ(ofRing(there, 45, 60.5), 0);
    EXPECT_GT(ofRing(back, 48, 59), 0.9 * side);
    EXPECT_EQ(ofRing(back, 59.5, 75), 0);
    EXPECT_NEAR(ofRing(there, 61, 72), ofRing(back, 48, 59), 0.1 * side) << "the same by its mirror image";
    EXPECT_GT(both.share(), 0.995);
    EXPECT_LT(there.share() + 0.02, both.share());
    EXPECT_EQ(measure(chunks, request, 1).seenMm2, measure(chunks, request, 5).seenMm2);
}

class TorsoChunks final : public ChunkSource { // in memory
  public:
    TorsoChunks() : source_(makePhantom("torso", kSize)), values_(cellCount(kSize)) {
        source_->readSlices(kSize.z, std::as_writable_bytes(std::span(values_)));
    }
    const VolumeInfo& info() const override { return source_->info(); }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        std::size_t n = 0;
        for (int z = 0; z < kChunkExtent; ++z)
            for (int y = 0; y < kChunkExtent; ++y)
                for (int x = 0; x < kChunkExtent; ++x) {
                    const glm::ivec3 v = glm::ivec3(key.i, key.j, key.k) * kChunkExtent + glm::ivec3(x, y, z);
                    const bool in = glm::all(glm::lessThan(v, info().extentVoxels));
                    const std::int16_t value =
                        in ? values_[linearIndex(v, info().extentVoxels)] : std::int16_t{-1024};
                    std::memcpy(out.data() + 2 * n++, &value, 2);
                }
    }

  private:
    // Of 0.95 mm: folds are 3.4 mm thick at half their height. Voxels hide less of what is behind thin ones:
    // of twice the size 82 %, of two thirds of it 77 %.
    static constexpr glm::ivec3 kSize{384, 288, 448};
    decltype(makePhantom("", {})) source_;
    std::vector<std::int16_t> values_;
};

TEST(WallCoverage, FoldsOfTheColonHideWhatTheirFormulaHides) {
    const auto course = std::make_shared<const ColonCourse>();
    const Colon lumen(std::make_shared<const ColonGrid>(course), true);
    const auto toWall = [&](const glm::dvec3& p) {
        return -static_cast<double>(lumen.distance(glm::vec3(p)));
    };
    Path path;
    CentreLine line;
    line.spacingMm = static_cast<double>(course->stationMm());
    for (const auto& station : course->stations()) {
        line.points.emplace_back(station.at);
        line.radiusMm.push_back(std::max(0.0, toWall(line.points.back())));
    }
    path.lines = {line};
    path.lumen = Lumen{-500, Lumen::Side::below};
    path.flight = Flight{};
    path.flight->fromMm = 20;
    path.flight->toMm = 640;
    path.flight->viewAngle = 100;
    CoverageRequest request = requestOf(path);
    request.cameras = flightCameras(path, 4, false);
    const WallCoverage found = measure(TorsoChunks(), request);
    // the same by the formula: places of the wall, half a millimetre above it
    double all = 0, seen = 0;
    for (float arc = 21.5F; arc < 640; arc += 3)
        for (int column = 0; column < 24; ++column) {
            const float angle = (static_cast<float>(column) + 0.5F) * 6.2831853F / 24;
            const float c = std::cos(angle), s = std::sin(angle);
            const ColonCourse::Station at = course->atArc(arc);
            const ColonCourse::Lumen wall = course->lumen(arc, c, s, true);
            const auto area = static_cast<double>(wall.radiusMm * std::sqrt(1 + wall.slope * wall.slope));
            const glm::dvec3 out(c * at.normal + s * at.binormal),
                along(glm::normalize(course->atArc(arc + 1).at - course->atArc(arc - 1).at));
            const glm::dvec3 outward = glm::normalize(out - static_cast<double>(wall.slope) * along);
            const glm::dvec3 p = glm::dvec3(at.at) + static_cast<double>(wall.radiusMm) * out - 0.5 * outward;
            const auto sees = [&](const Camera& camera) {
                const glm::dvec3 way = p - camera.position;
                const glm::dmat3 axes = patientFromCamera(camera);
                const double depth = -glm::dot(way, axes[2]), half = std::tan(pi / 180 * 50);
                if (!(depth > 0) || glm::dot(way, outward) <= 0 ||
                    std::abs(glm::dot(way, axes[0])) > depth * half * request.aspect ||
                    std::abs(glm::dot(way, axes[1])) > depth * half)
                    return false;
                const double far = glm::length(way);
                for (double t = 0; t < far;) {
                    const double free = toWall(camera.position + way * (t / far));
                    if (free < 0)
                        return false;
                    t += std::max(0.3, 0.5 * free);
                }
                return true;
            };
            all += area;
            seen += std::any_of(request.cameras.rbegin(), request.cameras.rend(), sees) ? area : 0;
        }
    EXPECT_NEAR(found.share(), seen / all, 0.03) << "by the formula " << seen / all;
    EXPECT_LT(found.share(), 0.97) << "backs of folds";
    RecordProperty("share", std::to_string(found.share()) + " by the formula " + std::to_string(seen / all));
}

TEST(WallCoverage, LinesOfAnotherVolumeAreRefused) {
    const FieldChunks chunks = tubeAlongZ(glm::dvec3(1));
    Path path = pathAlong(straight({0, 0, 0}, {0, 0, 120}, 60));
    CoverageRequest request = requestOf(path);
    request.where = "colon.json";
    CoverageRequest far = request, beside = request, other = request;
    for (glm::dvec3& p : far.lines[0].points)
        p.z += 500;
    EXPECT_THAT(refusal(chunks, far), HasSubstr("colon.json: expected a line in this volume"));
    for (glm::dvec3& p : beside.lines[0].points)
        p.x += 12;
    EXPECT_THAT(refusal(chunks, beside),
                HasSubstr("colon.json: expected a line in the lumen of this volume"));
    other.lumen.side = Lumen::Side::above;
    EXPECT_THAT(refusal(chunks, other), HasSubstr("found one of which 0 of 61 points are in it"));
    EXPECT_THAT(refusal(chunks, request, 300u << 10), HasSubstr("--ram"));
    Cancellation::Flag flag = true;
    const Cancellation cancellation(&flag);
    EXPECT_THROW(measure(chunks, request), Cancelled);
}

} // namespace
} // namespace tessera::test
