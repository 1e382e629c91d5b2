// render/plan/framing.cpp: see framing.h.
#include "render/plan/framing.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/geometry/shape.h"
#include "render/plan/shown_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace tessera {
namespace {

/// Largest number of cells tested per side; the remaining candidates then count as shown. Some tenths of a
/// second.
constexpr std::size_t kMostCells = 1 << 13;
constexpr std::size_t kCellsAtOnce = 32; // independent of the number of threads
constexpr int kMostTurns = 4;
constexpr double kHardlyMoved = 0.1; // of its distance
constexpr std::size_t kMostCacheBytes = std::size_t{64} << 20;

/// Finds the points that decide the picture's edges. From each edge inwards, cells that could be outermost
/// are tested, until one is visible further out than all others could be.
class EdgeSearch {
  public:
    /// @param empty  a fit that holds nothing yet
    EdgeSearch(const VolumeInfo& info, const Statistics& statistics, const ShownRays& shown,
               const ViewSpace& space, const ViewFit& empty, int threads)
        : info_(info), statistics_(statistics), shown_(shown), space_(space), empty_(empty),
          threads_(threads), around_(space.halfOf(glm::dvec3(kAround))) {
        ViewFit all = empty;
        for (std::size_t b = 0; b < cellCount(statistics.bricks); ++b)
            if (shown_.shownCells(b) != 0) {
                bricks_.push_back(static_cast<std::uint32_t>(b));
                all.add(middleOf(b, true), halfOf(b, true));
            }
        if (bricks_.empty())
            return;
        lookFrom(all.camera());
    }

    /// The fit of all points that decide the edges of a picture from near `camera`, if anything is shown.
    ViewFit run() const {
        ViewFit fit = empty_;
        for (std::size_t side = 0; side < 4 && !bricks_.empty(); ++side)
            searchSide(side, fit);
        return fit;
    }
    const Camera& camera() const { return camera_; }
    void lookFrom(const Camera& camera) {
        camera_ = camera;
        const ViewAxes& axes = empty_.axes();
        eye_ = glm::transpose(glm::dmat3(axes.right, axes.up, axes.towards)) * camera_.position;
    }

  private:
    /// Edge of the box around an outermost point, voxels: the error of its search.
    static constexpr double kAround = 0.25;
    static constexpr std::size_t kVoxelsFollowed = 8; // of a cell, the outermost visible ones
    /// The picture size for visibility: the default size for every picture, so that pictures of all sizes
    /// show the same.
    static constexpr double kPicturePixels = 512;
    static constexpr double kOfPixel = 0.7;
    /// A brick or a cell that could be outermost.
    struct Candidate {
        float reach = 0;
        std::uint32_t place = 0;
        bool brick = false;
        bool operator<(const Candidate& other) const { // for a heap: the outermost on top
            if (reach != other.reach)
                return reach < other.reach;
            return brick != other.brick ? !brick : place > other.place;
        }
    };

    glm::ivec3 firstOf(std::size_t place, bool brick) const {
        return brick ? gridPosition(place, statistics_.bricks) * kBrickExtent
                     : gridPosition(place, statistics_.cells) * kCellExtent;
    }
    glm::ivec3 endOf(std::size_t place, bool brick) const {
        return glm::min(firstOf(place, brick) + (brick ? kBrickExtent : kCellExtent), info_.extentVoxels);
    }
    glm::dvec3 middleOf(std::size_t place, bool brick) const {
        return space_.at(0.5 * glm::dvec3(firstOf(place, brick) + endOf(place, brick)));
    }
    glm::dvec3 halfOf(std::size_t place, bool brick) const {
        return space_.halfOf(glm::dvec3(endOf(place, brick) - firstOf(place, brick)) + 1.0);
    }
    double reachOf(const glm::dvec3& middle, const glm::dvec3& half, std::size_t side) const {
        return empty_.reachOf(middle, half)[side];
    }

    void searchSide(std::size_t side, ViewFit& fit) const {
        std::vector<Candidate> heap;
        const auto push = [&](std::size_t place, bool brick) {
            heap.push_back({static_cast<float>(reachOf(middleOf(place, brick), halfOf(place, brick), side)),
                            static_cast<std::uint32_t>(place), brick});
        };
        for (const std::uint32_t b : bricks_)
            push(b, true);
        std::make_heap(heap.begin(), heap.end());
        double best = -std::numeric_limits<double>::infinity();
        std::size_t looked = 0;
        while (!heap.empty() && static_cast<double>(heap.front().reach) > best) {
            std::vector<std::size_t> cells;
            while (cells.size() < kCellsAtOnce && !heap.empty() &&
                   static_cast<double>(heap.front().reach) > best) {
                std::pop_heap(heap.begin(), heap.end());
                const Candidate top = heap.back();
                heap.pop_back();
                if (!top.brick) {
                    cells.push_back(top.place);
                    continue;
                }
                const glm::ivec3 first = gridPosition(top.place, statistics_.bricks) * kCellsPerBrick;
                for (int bit = 0; bit < 64; ++bit)
                    if (shown_.shownCells(top.place) >> bit & 1) {
                        push(linearIndex(first + ShownRays::cellOfBit(bit), statistics_.cells), false);
                        std::push_heap(heap.begin(), heap.end());
                    }
            }
            if (looked >= kMostCells) { // count the outermost remaining one as shown
                if (!cells.empty())
                    fit.add(middleOf(cells.front(), false), halfOf(cells.front(), false));
                return;
            }
            looked += cells.size();
            tell(cells);
            std::vector<std::optional<glm::dvec3>> outermost(cells.size());
            parallelFor(cells.size(), threads_,
                        [&](std::size_t n) { outermost[n] = outermostOf(cells[n], side); });
            for (const std::optional<glm::dvec3>& place : outermost)
                if (place) {
                    best = std::max(best, reachOf(*place, around_, side));
                    fit.add(*place, around_);
                }
        }
    }

    /// What the search will read of cells.
    void tell(const std::vector<std::size_t>& cells) const {
        if (cells.empty())
            return;
        std::vector<glm::dvec3> places;
        for (const std::size_t cell : cells)
            places.push_back(0.5 * glm::dvec3(firstOf(cell, false) + endOf(cell, false)));
        shown_.tell(places, directionAt(space_.at(places.front())));
    }
    /// Of the ray through a place of the view's axes.
    glm::dvec3 directionAt(const glm::dvec3& at) const {
        return camera_.projection == Projection::perspective ? glm::normalize(at - eye_)
                                                             : glm::dvec3(0, 0, -1);
    }

    /// The furthest visible point of a cell towards a side; nullopt if the ray through its strongest voxel is
    /// invisible.
    std::optional<glm::dvec3> outermostOf(std::size_t cell, std::size_t side) const {
        struct Voxel {
            glm::ivec3 at;
            double reach;
        };
        LatticeReader samples = shown_.reader();
        std::vector<Voxel> voxels;
        double most = 0;
        glm::ivec3 strongest(0);
        const glm::ivec3 first = firstOf(cell, false);
        std::array<double, ShownRays::kCellVoxels> strengths;
        shown_.strengths(samples, first, strengths);
        for (std::size_t n = 0; n < strengths.size(); ++n) {
            if (!(strengths[n] > 0))
                continue;
            const glm::ivec3 at = first + gridPosition(n, glm::ivec3(kCellExtent));
            voxels.push_back({at, reachOf(space_.at(centreOf(at)), around_, side)});
            if (strengths[n] > most) {
                most = strengths[n];
                strongest = at;
            }
        }
        if (voxels.empty() || !shows(samples, centreOf(strongest)))
            return std::nullopt;
        std::stable_sort(voxels.begin(), voxels.end(),
                         [](const Voxel& a, const Voxel& b) { return a.reach > b.reach; });
        // Visibility usually grows inwards: the outermost visible voxel, by bisection.
        std::size_t out = 0, in = 0;
        while (voxels[in].at != strongest)
            ++in;
        while (out < in) {
            const std::size_t middle = (out + in) / 2;
            if (shows(samples, centreOf(voxels[middle].at)))
                in = middle;
            else
                out = middle + 1;
        }
        // The visible extent of a voxel towards the next one, by bisection.
        const glm::dvec3 outwards = outwardsOf(side);
        glm::dvec3 best = centreOf(voxels[in].at);
        for (std::size_t n = in; n < std::min(in + kVoxelsFollowed, voxels.size()); ++n) {
            const glm::dvec3 centre = centreOf(voxels[n].at);
            if (n > in && !shows(samples, centre))
                continue;
            double shown = 0, hidden = 1;
            while (hidden - shown > kAround / 2) {
                const double middle = 0.5 * (shown + hidden);
                (shows(samples, centre + middle * outwards) ? shown : hidden) = middle;
            }
            const glm::dvec3 place = centre + shown * outwards;
            if (reachOf(space_.at(place), around_, side) > reachOf(space_.at(best), around_, side))
                best = place;
        }
        return space_.at(best);
    }
    /// The vector from a voxel's centre towards a side of the picture, up to its neighbours: voxels.
    glm::dvec3 outwardsOf(std::size_t side) const {
        const glm::dvec3 toSide = side < 2 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 voxels = glm::dmat3(space_.voxelFromPatient) * (space_.patientFromView * toSide) *
                                  (side % 2 == 0 ? 1.0 : -1.0);
        return voxels / std::max({std::abs(voxels.x), std::abs(voxels.y), std::abs(voxels.z)});
    }
    static glm::dvec3 centreOf(const glm::ivec3& voxel) { return glm::dvec3(voxel) + 0.5; }
    /// True if a pixel cannot miss the visible region around a point. The region must be visible on the ray
    /// through the point, and on two of four rays nearly half a pixel away.
    /// @param place  voxels
    bool shows(LatticeReader& samples, const glm::dvec3& place) const {
        const glm::dvec3 at = space_.at(place);
        const bool perspective = camera_.projection == Projection::perspective;
        const glm::dvec3 direction = directionAt(at);
        if (!shown_.onRay(samples, place, direction))
            return false;
        const double half = perspective
                                ? std::tan(glm::radians(camera_.viewAngle) / 2) * std::max(eye_.z - at.z, 0.0)
                                : camera_.parallelScale;
        const double offset = kOfPixel * 2 * half / kPicturePixels;
        int seen = 0;
        for (int n = 0; n < 4 && seen < 2 && n - seen <= 2; ++n) {
            glm::dvec3 side(0);
            side[n / 2] = n % 2 == 0 ? offset : -offset;
            const glm::dvec3 beside =
                place + glm::dmat3(space_.voxelFromPatient) * (space_.patientFromView * side);
            seen += shown_.onRay(samples, beside, direction);
        }
        return seen == 2;
    }

    const VolumeInfo& info_;
    const Statistics& statistics_;
    const ShownRays& shown_;
    const ViewSpace& space_;
    const ViewFit& empty_;
    int threads_;
    glm::dvec3 around_;
    std::vector<std::uint32_t> bricks_; // possibly visible
    Camera camera_;                     // that sees them all; its rays are near those of the picture
    glm::dvec3 eye_{0};                 // of the view's axes
};

/// Memory of the candidates of the search: cells of few bricks at a time.
std::size_t searchBytes(const VolumeInfo& info) {
    constexpr std::size_t kBytesPerBrick = 32, kBytesPerCell = 12, kMostBricksOpened = 512;
    const std::size_t bricks = cellCount(brickGrid(info.extentVoxels));
    return ShownRays::bytes(info) + bricks * kBytesPerBrick +
           64 * kBytesPerCell * std::min(bricks, kMostBricksOpened);
}

} // namespace

std::size_t framingBytes(const VolumeInfo& info, int threads) {
    return searchBytes(info) + latticeCacheFloorBytes(info, threads);
}

namespace {

/// The fit of all points that decide the edges of a picture from a side; empty if nothing is shown.
ViewFit fitOfShown(const ViewAxes& axes, Projection projection, BrickCache& cache, const VolumeInfo& info,
                   const Statistics& statistics, const TransferTable& table, const DrawnPart* part,
                   LabelBricks* labels, const glm::ivec2& imageSize, int threads) {
    const ViewFit empty(axes, projection, imageSize);
    const ViewSpace space(info, empty.axes());
    const ShownRays shown(cache, info, statistics, table, space, part, labels, kLeastOpacityFramed, threads);
    EdgeSearch search(info, statistics, shown, space, empty, threads);
    // Visibility depends on the eye, which is being searched: iterates until it hardly moves.
    for (int turn = 0;; ++turn) {
        ViewFit fit = search.run();
        if (fit.empty())
            return fit;
        const Camera before = search.camera(), camera = fit.camera();
        const double moved = glm::length(camera.position - before.position);
        if (turn + 1 == kMostTurns || projection == Projection::parallel ||
            moved < kHardlyMoved * glm::length(camera.position - camera.focalPoint))
            return fit;
        search.lookFrom(camera);
    }
}

/// The meshes' own reach; of what a kept part cuts, the points that are in it.
void addMeshes(std::span<const SceneMesh> meshes, const VolumeInfo& info, const DrawnPart* kept,
               ViewFit& fit) {
    constexpr double kOnCut = 1e-3; // voxels, as rays have it
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const ViewAxes& axes = fit.axes();
    for (const SceneMesh& mesh : meshes) {
        TESSERA_CHECK(mesh.shape);
        mesh.shape->forEachBall([&](const glm::dvec3& p, double radius) {
            if (kept && mesh.clipped && !kept->keeps(glm::dvec3(voxelFromPatient * glm::dvec4(p, 1)), kOnCut))
                return;
            fit.add({glm::dot(p, axes.right), glm::dot(p, axes.up), glm::dot(p, axes.towards)},
                    glm::dvec3(radius));
        });
    }
}

const DrawnPart* partOf(const FittedView& view, const DrawnPart& part) {
    return view.fit == Fit::kept && part.any() ? &part : nullptr;
}

std::size_t cacheBytes(const VolumeInfo& info, const MemoryBudget& ram, int threads) {
    const std::size_t floor = latticeCacheFloorBytes(info, threads);
    return std::clamp(ram.freeBytes() / 4, floor, std::max(floor, kMostCacheBytes));
}

} // namespace

ViewFit shownFit(const FittedView& view, const ChunkSource& volume, const Statistics& statistics,
                 const TransferTable& table, const DrawnPart& part, const glm::ivec2& imageSize,
                 MemoryBudget& ram, int threads, LabelBricks* labels, std::span<const SceneMesh> meshes) {
    const VolumeInfo& info = volume.info();
    const Charge charge = ram.charge(searchBytes(info), "fitting the camera");
    BrickCache cache(volume, ram, cacheBytes(info, ram, threads), threads > 0 ? threads : defaultThreads());
    ViewFit fit = fitOfShown(axesOf(view), view.projection, cache, info, statistics, table,
                             partOf(view, part), labels, imageSize, threads);
    addMeshes(meshes, info, partOf(view, part), fit);
    return fit;
}

Camera fittedCamera(const FittedView& view, const ChunkSource& volume, const Statistics& statistics,
                    const TransferTable& table, const DrawnPart& part, const glm::ivec2& imageSize,
                    MemoryBudget& ram, int threads, LabelBricks* labels, std::span<const SceneMesh> meshes) {
    if (view.fit != Fit::volume)
        if (const ViewFit fit =
                shownFit(view, volume, statistics, table, part, imageSize, ram, threads, labels, meshes);
            !fit.empty())
            return fit.camera();
    return fitCamera(volume.info(), axesOf(view), view.projection, imageSize);
}

/// Every direction's silhouette, in parallel: the narrowest cylinder about an axis from feet to head.
constexpr int kDirections = 12; // over half a turn: between two of them it is 1 % wider at most

std::vector<ViewFit> turningFits(const FittedView& view, const ChunkSource& volume,
                                 const Statistics& statistics, const TransferTable& table,
                                 const DrawnPart& part, const glm::ivec2& imageSize, MemoryBudget& ram,
                                 int threads, LabelBricks* labels, std::span<const SceneMesh> meshes) {
    const VolumeInfo& info = volume.info();
    const Charge charge = ram.charge(searchBytes(info), "fitting the camera");
    BrickCache cache(volume, ram, cacheBytes(info, ram, threads), threads > 0 ? threads : defaultThreads());
    std::vector<ViewFit> fits;
    for (int n = 0; n < kDirections; ++n) {
        const ViewAxes axes = viewAxes(ViewAngles{n * 180.0 / kDirections, 0});
        ViewFit fit(axes, Projection::parallel, imageSize);
        if (view.fit != Fit::volume) {
            fit = fitOfShown(axes, Projection::parallel, cache, info, statistics, table, partOf(view, part),
                             labels, imageSize, threads);
            addMeshes(meshes, info, partOf(view, part), fit);
        }
        fits.push_back(fit);
    }
    return fits;
}

Camera turningCamera(const FittedView& view, std::vector<ViewFit> fits,
                     std::span<const VolumeInfo* const> boxes, const glm::ivec2& imageSize) {
    TESSERA_CHECK(fits.size() == kDirections);
    for (ViewFit& fit : fits)
        if (fit.empty())
            for (const VolumeInfo* info : boxes) {
                const ViewSpace space(*info, fit.axes());
                const glm::dvec3 all(info->extentVoxels);
                fit.add(space.at(0.5 * all), space.halfOf(all));
            }
    const auto middle = [](const ViewFit& fit) { return 0.5 * (fit.reach()[0] - fit.reach()[1]); };
    const glm::dvec3 axis = middle(fits[0]) * fits[0].axes().right +
                            middle(fits[kDirections / 2]) * fits[kDirections / 2].axes().right;
    double radius = 0, up = fits[0].reach()[2], down = fits[0].reach()[3];
    for (const ViewFit& fit : fits) {
        const double at = glm::dot(axis, fit.axes().right);
        radius = std::max({radius, fit.reach()[0] - at, fit.reach()[1] + at});
        up = std::max(up, fit.reach()[2]), down = std::max(down, fit.reach()[3]);
    }
    const ViewAxes axes = axesOf(view);
    const glm::dvec3 centre = axis + glm::dvec3(0, 0, 0.5 * (up - down));
    const double half = 0.5 * (up + down);
    const auto reach = [&](const glm::dvec3& direction) { // of the cylinder
        return radius * glm::length(glm::dvec2(direction)) + half * std::abs(direction.z);
    };
    ViewFit fit(axes, view.projection, imageSize);
    fit.add({glm::dot(centre, axes.right), glm::dot(centre, axes.up), glm::dot(centre, axes.towards)},
            {reach(axes.right), reach(axes.up), reach(axes.towards)});
    return fit.camera();
}

} // namespace tessera
