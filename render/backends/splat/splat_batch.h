// render/backends/splat/splat_batch.h: shown samples in the order of slices, projected together and then
// laid onto tiles together. The picture does not depend on where a batch ends.
#pragma once

#include "core/base/budget.h"
#include "render/backends/splat/sheet_tiles.h"
#include "render/backends/splat/splat_filter.h"
#include "render/backends/splat/splat_points.h"
#include "render/backends/splat/splat_samples.h"

#include <array>
#include <cstddef>
#include <vector>

namespace tessera {

/// Of a picture.
struct SplatCounts {
    std::size_t drawn = 0;                 // each once a slice that it lies in
    std::array<std::size_t, 3> byFilter{}; // of these, by SplatFilter's first three
    double pixels = 0;                     // of the boxes of these footprints
    std::size_t tooNear = 0; // left out: nearer to the eye than three deviations of their kernel
    std::size_t tooThin = 0; // left out: their footprint has no area

    SplatCounts& operator+=(const SplatCounts& o);
};

class SplatBatch {
  public:
    static constexpr std::size_t kLeast = 4096; // splats

    /// All of it outlives this.
    /// @param brightest  of the colours of samples
    /// @param bytes  that it may take
    SplatBatch(const SplatView& view, const SplatSettings& settings, const SliceOrder& order, float brightest,
               SheetTiles& tiles, std::size_t bytes, MemoryBudget& budget);

    /// The tiles that splats of a box of voxels can touch.
    TileBox tilesOf(const glm::dvec3& low, const glm::dvec3& high, int level) const;
    /// A slice of a brick. Its list stays until the batch is drawn.
    /// @param slice  of the list's level
    /// @param sheet  in the order of sheets
    /// @param share  of optical depths in this sheet
    void add(const BrickList& list, int slice, int sheet, float share, int threads);
    /// Points of one sheet. They stay until the batch is drawn.
    void add(std::span<const ShownPoint> points, std::span<const PointLook> looks, int threads);
    /// Draws what was added.
    void draw(int threads);
    const SplatCounts& counts() const { return counts_; }

  private:
    struct Unit {
        const BrickList* list;
        int slice, sheet;
        float share;
        std::size_t first; // of the splats
        std::size_t count;
        TileBox tiles;
        SplatCounts counts;
        std::span<const ShownPoint> points; // in place of a list
        std::span<const PointLook> looks;
    };
    /// The splats of a unit as they are projected.
    struct Projected {
        DrawnSplat* next;
        glm::vec2 low, high;
        SplatCounts& counts;
    };
    void project(Unit& unit);
    void projectSamples(const Unit& unit, Projected& out) const;
    void projectPoints(const Unit& unit, Projected& out) const;
    void put(const glm::vec3& at, const glm::mat3& kernel, float mass, SplatFilter filter,
             const glm::vec3& colour, Projected& out) const;
    std::array<SplatFilter, 16> filtersOf(const BrickList& list, int slice) const;
    glm::dvec3 middleOf(const BrickList& list, int slice, int place) const;

    const SplatView& view_;
    SplatSettings settings_;
    SliceOrder order_;
    float brightest_;
    SheetTiles& tiles_;
    FilterNumbers numbers_;
    std::array<FilterDepths, kLevelCount> depths_;
    Charge charge_;
    std::vector<DrawnSplat> splats_;
    std::size_t used_ = 0;
    std::vector<Unit> units_;
    SplatCounts counts_;
};

} // namespace tessera
