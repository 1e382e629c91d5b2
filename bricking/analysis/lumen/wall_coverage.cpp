// bricking/analysis/lumen/wall_coverage.cpp: see wall_coverage.h. Several threads process chunks, face by
// face. Cameras are tested until one sees the face, first those that saw the face before it.
#include "bricking/analysis/lumen/wall_coverage.h"

#include "bricking/analysis/lumen/lumen_paths.h"
#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/seed_threshold.h"
#include "bricking/analysis/lumen/thin_branches.h"
#include "bricking/analysis/lumen/wall_patches.h"
#include "core/animation/film.h"
#include "core/animation/flight.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>
#include <utility>

namespace tessera {
namespace {

constexpr double kReachRadii = 1.5;

/// Nearest positions on the lines: the route's segments, and the points of the other lines.
class Beside {
  public:
    Beside(const CoverageRequest& request)
        : route_(routeOf(request.lines, request.flight.route)), from_(request.flight.fromMm),
          to_(std::min(request.flight.toMm.value_or(route_.back().alongMm), route_.back().alongMm)) {
        for (const CentreLine& line : request.lines)
            for (const glm::dvec3& point : line.points)
                if (!onRoute(point, 0.5 * line.spacingMm))
                    others_.push_back(point);
        for (const RoutePoint& point : route_)
            if (point.alongMm >= from_ && point.alongMm <= to_)
                widest_ = std::max(widest_, point.radiusMm);
    }
    const std::vector<RoutePoint>& route() const { return route_; }
    double widestMm() const { return widest_; }

    /// Candidates for the nearest to points within `half` of a centre.
    struct Near {
        std::vector<std::size_t> segments, points;
    };
    Near near(const glm::dvec3& middle, double half, double reach) const {
        Near near;
        std::vector<double> away(route_.size() - 1);
        double least = reach + half;
        for (std::size_t i = 0; i < away.size(); ++i)
            least = std::min(least, away[i] = std::sqrt(toSegment(i, middle).squared));
        for (std::size_t i = 0; i < away.size(); ++i)
            if (away[i] <= least + 2 * half && away[i] <= reach + half)
                near.segments.push_back(i);
        for (std::size_t i = 0; i < others_.size() && !near.segments.empty(); ++i)
            if (glm::length(others_[i] - middle) <= least + 2 * half)
                near.points.push_back(i);
        return near;
    }
    /// Position along the route; none if the point is not beside the flown part.
    std::optional<double> along(const Near& near, const glm::dvec3& place, double reach) const {
        Foot best;
        std::size_t at = 0;
        for (const std::size_t i : near.segments)
            if (const Foot foot = toSegment(i, place); foot.squared < best.squared) {
                best = foot;
                at = i;
            }
        if (best.squared > reach * reach || (at == 0 && best.t < 0) ||
            (at + 2 == route_.size() && best.t > 1))
            return std::nullopt;
        const double t = std::clamp(best.t, 0.0, 1.0);
        const double mm = route_[at].alongMm + t * (route_[at + 1].alongMm - route_[at].alongMm);
        if (mm < from_ || mm > to_)
            return std::nullopt;
        for (const std::size_t i : near.points)
            if (const glm::dvec3 d = others_[i] - place; glm::dot(d, d) < best.squared)
                return std::nullopt;
        return mm;
    }

  private:
    struct Foot {
        double squared = 1e300, t = 0;
    };
    Foot toSegment(std::size_t i, const glm::dvec3& place) const {
        const glm::dvec3 a = route_[i].at, ab = route_[i + 1].at - a;
        const double t = glm::dot(place - a, ab) / std::max(glm::dot(ab, ab), 1e-300);
        const glm::dvec3 d = place - a - std::clamp(t, 0.0, 1.0) * ab;
        return {glm::dot(d, d), t};
    }
    bool onRoute(const glm::dvec3& place, double within) const {
        for (std::size_t i = 0; i + 1 < route_.size(); ++i)
            if (toSegment(i, place).squared <= within * within)
                return true;
        return false;
    }
    std::vector<RoutePoint> route_;
    std::vector<glm::dvec3> others_;
    double from_, to_, widest_ = 0;
};

/// A camera prepared for visibility tests.
struct Eye {
    glm::dvec3 mm, place, right, up, forward; // right and up: 1 at the picture's edge at depth 1
};

class Measuring {
  public:
    Measuring(const ChunkSource& source, const CoverageRequest& request, MemoryBudget& ram,
              Progress& progress, int threads)
        : source_(source), info_(source.info()), request_(request), ram_(ram), progress_(progress),
          threads_(threads), beside_(request), toMm_(info_.patientFromVoxel),
          toVoxel_(glm::inverse(info_.patientFromVoxel)),
          reach_(kReachRadii * beside_.widestMm() + voxelDiagonalMm()) {}

    WallCoverage run() {
        const std::unique_ptr<LumenParts> parts = grow();
        const VoxelSet& voxels = parts->whole().grown.voxels;
        const WallFaces wall(voxels, toMm_);
        WallCoverage found;
        found.lines = request_.lines.size();
        found.flown = request_.flight.route.size();
        addEyes(voxels, found);
        progress_.stage("finding unseen wall");
        ChunkFaces faces = placesOf(voxels, wall);
        std::vector<std::size_t> kept(faces.chunks.size());
        parallelFor(
            kept.size(), threads_, [&](std::size_t i) { kept[i] = look(voxels, wall, faces, i); },
            progress_.shares());
        std::size_t end = 0;
        for (std::size_t i = 0; i < kept.size(); ++i) {
            const std::size_t first = faces.first[i];
            faces.first[i] = end;
            std::copy_n(faces.all.begin() + static_cast<std::ptrdiff_t>(first), kept[i],
                        faces.all.begin() + static_cast<std::ptrdiff_t>(end));
            end += kept[i];
        }
        faces.first.back() = end;
        faces.all.resize(end);
        found.faces = end;
        for (const CoverageFace& face : faces.all) {
            found.wallMm2 += static_cast<double>(face.areaMm2);
            found.seenMm2 += face.seen() ? static_cast<double>(face.areaMm2) : 0;
        }
        found.patches = unseenPatches(faces, voxels, toMm_, request_.smallestPatchMm2, ram_);
        progress_.end();
        return found;
    }

  private:
    double voxelDiagonalMm() const { return glm::length(info_.spacingMm()); }
    glm::dvec3 mmOf(const glm::dvec3& place) const { return glm::dvec3(toMm_ * glm::dvec4(place, 1)); }
    glm::dvec3 placeOf(const glm::dvec3& mm) const { return glm::dvec3(toVoxel_ * glm::dvec4(mm, 1)); }
    bool inVolume(const glm::dvec3& place) const {
        return glm::all(glm::greaterThanEqual(place, glm::dvec3(0))) &&
               glm::all(glm::lessThan(place, glm::dvec3(info_.extentVoxels)));
    }

    /// The parts connected to the route's points: one on either side of a bridge.
    std::unique_ptr<LumenParts> grow() {
        progress_.stage("growing the lumen");
        field_.emplace(source_, ram_, threads_);
        if (request_.lumen.noise > 0)
            field_->quieten(request_.lumen.noise);
        LumenValues values(field_->cache(), info_);
        std::vector<glm::dvec3> seeds;
        for (const RoutePoint& point : beside_.route())
            if (point.radiusMm > 0) {
                seeds.push_back(placeOf(point.at));
                if (!inVolume(seeds.back()))
                    throw badFile(request_.where, "a line in this volume", "one that leaves it");
            }
        if (seeds.empty())
            throw badFile(request_.where, "a line with points in a lumen", "bridges alone");
        const SeedNeighbourhood here = neighbourhoodOf(values, seeds.front(), request_.lumen.threshold);
        rule_ = here.rule;
        rule_.brightest = std::max(
            rule_.brightest, neighbourhoodOf(values, seeds.back(), request_.lumen.threshold).rule.brightest);
        auto parts = std::make_unique<LumenParts>(field_->cache(), info_, rule_, ram_, progress_);
        std::size_t inside = 0;
        const LumenPart* first = nullptr; // the parts to which thin branches are attached
        for (const glm::dvec3& seed : seeds)
            if (const glm::ivec3 voxel(glm::floor(seed)); rule_.takes(values.voxel(voxel))) {
                LumenPart& part = parts->partOf(voxel);
                if (!first && request_.lumen.branchesTo) {
                    const double wall = request_.lumen.branchWall.value_or(branchWall(here, rule_));
                    addThinBranches(values, part.grown, rule_, wall, *request_.lumen.branchesTo, ram_);
                }
                first = first ? first : &part;
                ++inside;
            } else if (first && first->grown.voxels.contains(voxel))
                ++inside;
        if (rule_.below != (request_.lumen.side == Lumen::Side::below) || 2 * inside < seeds.size())
            throw badFile(
                request_.where, "a line in the lumen of this volume",
                "one of which " +
                    std::to_string(rule_.below == (request_.lumen.side == Lumen::Side::below) ? inside : 0) +
                    " of " + std::to_string(seeds.size()) + " points are in it");
        return parts;
    }

    void addEyes(const VoxelSet& voxels, WallCoverage& found) {
        for (const Camera& camera : request_.cameras) {
            const glm::dvec3 place = placeOf(camera.position);
            if (!voxels.containsPlace(place)) {
                ++found.blind;
                continue;
            }
            const glm::dmat3 axes = patientFromCamera(camera);
            const double half = std::tan(glm::radians(0.5 * camera.viewAngle));
            eyes_.push_back(
                {camera.position, place, axes[0] / (half * request_.aspect), axes[1] / half, -axes[2]});
        }
    }

    /// Chunks near the route, with memory for all of their faces.
    ChunkFaces placesOf(const VoxelSet& voxels, const WallFaces& wall) {
        ChunkFaces faces;
        for (const std::size_t chunk : voxels.filledChunks())
            if (!beside_.near(middleOf(chunk, voxels), halfChunkMm(), reach_).segments.empty())
                faces.chunks.push_back(chunk);
        std::vector<std::size_t> counts(faces.chunks.size());
        parallelFor(counts.size(), threads_, [&](std::size_t i) {
            const glm::ivec3 at = gridPosition(faces.chunks[i], voxels.chunks());
            for (int row = 0; row < kRowsPerChunk; ++row)
                for (int side = 0; side < kSides; ++side)
                    counts[i] += static_cast<std::size_t>(std::popcount(wall.bits(at, row, side)));
        });
        faces.first.assign(1, 0);
        for (const std::size_t count : counts)
            faces.first.push_back(faces.first.back() + count);
        faces.charge = ram_.charge(faces.first.back() * sizeof(CoverageFace), "the lumen's wall");
        faces.all.resize(faces.first.back());
        return faces;
    }
    glm::dvec3 middleOf(std::size_t chunk, const VoxelSet& voxels) const {
        return mmOf((glm::dvec3(gridPosition(chunk, voxels.chunks())) + 0.5) * double(kChunkExtent));
    }
    double halfChunkMm() const { // of a chunk of any shape
        const glm::dvec3 mm = info_.spacingMm();
        return 0.5 * kChunkExtent * (mm.x + mm.y + mm.z);
    }

    /// Fills in a chunk's faces that count.
    /// @return how many
    std::size_t look(const VoxelSet& voxels, const WallFaces& wall, ChunkFaces& faces, std::size_t i) const {
        const std::size_t chunk = faces.chunks[i];
        const glm::ivec3 at = gridPosition(chunk, voxels.chunks());
        const Beside::Near near = beside_.near(middleOf(chunk, voxels), halfChunkMm(), reach_);
        std::size_t count = 0, last = 0; // last: the eye that saw the face before
        for (int row = 0; row < kRowsPerChunk; ++row) {
            std::array<std::uint32_t, kSides> bits{};
            std::uint32_t any = 0;
            for (int side = 0; side < kSides; ++side)
                any |= bits[static_cast<std::size_t>(side)] = wall.bits(at, row, side);
            if (any)
                checkInterrupted();
            for (; any; any &= any - 1) {
                const int x = std::countr_zero(any);
                const glm::ivec3 voxel = kChunkExtent * at + glm::ivec3(x, row & 31, row >> 5);
                for (int side = 0; side < kSides; ++side) {
                    if (!(bits[static_cast<std::size_t>(side)] >> x & 1u))
                        continue;
                    const WallFaces::Face face = wall.at(voxel, side);
                    const glm::dvec3 mm = mmOf(face.middle);
                    const std::optional<double> along = beside_.along(near, mm, reach_);
                    if (!along)
                        continue;
                    CoverageFace& out = faces.all[faces.first[i] + count++];
                    out.place = CoverageFace::placeOf(voxel, side);
                    out.areaMm2 = static_cast<float>(face.areaMm2);
                    out.alongMm = static_cast<float>(*along);
                    if (seen(voxels, face, mm, last))
                        out.place |= CoverageFace::kSeen;
                }
            }
        }
        return count;
    }

    bool seen(const VoxelSet& voxels, const WallFaces::Face& face, const glm::dvec3& mm,
              std::size_t& last) const {
        const std::size_t n = eyes_.size();
        for (std::size_t turn = 0; turn < 2 * n; ++turn) { // outwards from the last
            const std::size_t away = (turn + 1) / 2;
            if (turn % 2 ? away > last : last + away >= n)
                continue;
            const std::size_t k = turn % 2 ? last - away : last + away;
            if (sees(voxels, eyes_[k], face, mm)) {
                last = k;
                return true;
            }
        }
        return false;
    }
    bool sees(const VoxelSet& voxels, const Eye& eye, const WallFaces::Face& face,
              const glm::dvec3& mm) const {
        const glm::dvec3 way = mm - eye.mm;
        const double depth = glm::dot(way, eye.forward);
        return depth > 0 && glm::dot(way, face.outward) > 0 && std::abs(glm::dot(way, eye.right)) <= depth &&
               std::abs(glm::dot(way, eye.up)) <= depth && glm::length(way) <= request_.farthestMm &&
               seesThrough(voxels, face.above, eye.place);
    }

    const ChunkSource& source_;
    const VolumeInfo& info_;
    const CoverageRequest& request_;
    MemoryBudget& ram_;
    Progress& progress_;
    const int threads_;
    const Beside beside_;
    const glm::dmat4 toMm_, toVoxel_;
    const double reach_;
    std::optional<LumenField> field_;
    LumenRule rule_;
    std::vector<Eye> eyes_;
};

} // namespace

std::vector<Camera> flightCameras(const Path& path, double everyMm, bool bothWays) {
    Path way = path;
    if (!way.flight)
        way.flight = Flight{};
    std::erase_if(way.keyframes, [](const Keyframe& key) { return !key.look; });
    for (Keyframe& key : way.keyframes) {
        key.transferFunction.reset();
        key.lighting.reset();
        key.cuts.reset();
    }
    std::vector<Camera> cameras;
    for (int pass = 0; pass < (bothWays ? 2 : 1); ++pass) {
        const Film film(way, Scene{}, {}, "the path");
        const double length = film.curve()->lengthMm();
        const int steps = std::max(1, static_cast<int>(std::ceil(length / everyMm)));
        for (int i = 0; i <= steps; ++i)
            cameras.push_back(film.cameraAt(length * i / steps / way.flight->speedMmPerS));
        way = flownTheOtherWay(std::move(way));
    }
    return cameras;
}

WallCoverage measureWallCoverage(const ChunkSource& source, const CoverageRequest& request, MemoryBudget& ram,
                                 Progress& progress, int threads) {
    TESSERA_CHECK(!request.lines.empty());
    return Measuring(source, request, ram, progress, threads).run();
}

} // namespace tessera
