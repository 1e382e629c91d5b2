// render/plan/shown_rays.h: tests whether a ray is visible, at the finest level without light. It needs no
// levels, maps or device, so the camera can be fitted before these exist.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/statistics/statistics.h"
#include "core/scene/camera.h" // ViewAxes
#include "core/scene/transfer_function.h"
#include "render/contract/lattice.h"
#include "render/contract/ray.h"
#include "render/labels/label_field.h"
#include "render/plan/drawn_part.h"

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Points and boxes along a view's axes: right, up and towards the viewer, mm.
struct ViewSpace {
    glm::dmat3 patientFromView;
    glm::dmat4 voxelFromPatient;
    glm::dvec3 origin{0}, i{0}, j{0}, k{0}; // origin and voxel steps of voxel space
    ViewSpace(const VolumeInfo& info, const ViewAxes& axes)
        : patientFromView(axes.right, axes.up, axes.towards),
          voxelFromPatient(glm::inverse(info.patientFromVoxel)) {
        const glm::dmat3 viewFromPatient = glm::transpose(patientFromView);
        const auto column = [&](int n) { return viewFromPatient * glm::dvec3(info.patientFromVoxel[n]); };
        i = column(0), j = column(1), k = column(2), origin = column(3);
    }
    glm::dvec3 at(const glm::dvec3& voxel) const { return origin + i * voxel.x + j * voxel.y + k * voxel.z; }
    /// Half the size of the box around a box of voxels.
    glm::dvec3 halfOf(const glm::dvec3& voxels) const {
        return 0.5 * (glm::abs(i) * voxels.x + glm::abs(j) * voxels.y + glm::abs(k) * voxels.z);
    }
};

class ShownRays {
  public:
    /// All must outlive this.
    /// @param leastOpacity  from which on a ray is visible
    /// @param part  the drawn part; null: all of the volume
    /// @param labels  null: there are none
    /// @param threads  0: all processors
    ShownRays(BrickCache& cache, const VolumeInfo& info, const Statistics& statistics,
              const TransferTable& table, const ViewSpace& space, const DrawnPart* part, LabelBricks* labels,
              double leastOpacity, int threads);

    /// For one thread.
    LatticeReader reader() const { return {cache_, info_, 0, nullptr}; }
    /// Tells the source of bricks that rays through a place will soon read: those that could be visible
    /// nearby, in the ray's direction (as in onRay()) and against it.
    void tell(std::span<const glm::dvec3> places, const glm::dvec3& direction) const;
    /// The cells of a brick that could be visible: bits, x + 4y + 16z.
    std::uint64_t shownCells(std::size_t brick) const { return shownCells_[brick]; }
    static glm::ivec3 cellOfBit(int bit) { return {bit & 3, bit >> 2 & 3, bit >> 4}; }
    static constexpr std::size_t kCellVoxels = std::size_t{kCellExtent} * kCellExtent * kCellExtent;
    /// Possible visibility of each voxel of a cell, x fastest: extinction, or the depth of an isosurface
    /// between it and a neighbour. 0 beyond the volume.
    /// @param first  the cell's first voxel
    void strengths(LatticeReader& samples, const glm::ivec3& first,
                   std::array<double, kCellVoxels>& out) const;
    /// True if a ray through a point is visible. Outlying voxels are narrow peaks, so the mean over the
    /// values between samples is used instead of a sample's extinction.
    /// @param place  voxels; one of the ray's samples is at this point
    /// @param direction  unit, of the view's axes
    bool onRay(LatticeReader& samples, const glm::dvec3& place, const glm::dvec3& direction) const;

    /// Memory of one, for a volume of this size.
    static std::size_t bytes(const VolumeInfo& info);

  private:
    struct Surface {
        double value, depth; // physical; optical
    };
    bool reaches(LatticeReader& samples, const glm::dvec3& place, const glm::dvec3& direction,
                 double mmPerVoxel, double& depth) const;
    /// @param value  of the voxel, physical
    /// Share of the function, and the medium's extinction.
    struct Labelled {
        double function = 1, medium = 0;
    };
    static double extinctionOf(const Labelled& shares, double extinction) {
        return extinction * shares.function + shares.medium;
    }
    struct NearLabels; // of the brick that was read last
    Labelled labelled(NearLabels& near, const glm::ivec3& voxel) const;
    double strength(LatticeReader& samples, NearLabels& near, const glm::ivec3& voxel, double value) const;
    double physical(double stored) const { return info_.rescaleSlope * stored + info_.rescaleIntercept; }
    bool emptyOver(float lowest, float highest) const;
    /// Of a point in voxels.
    bool drawn(const glm::dvec3& place) const { return !part_ || part_->meets(place, place); }
    double lookUp(double entry) const;
    double sumTo(double entry) const;
    /// A value in units of the table's entries.
    double entryOf(double value) const {
        return (value - static_cast<double>(table_.firstValue)) * static_cast<double>(table_.entriesPerValue);
    }
    double meanExtinction(double a, double b) const;

    BrickCache& cache_;
    const VolumeInfo& info_;
    glm::ivec3 bricks_;
    const TransferTable& table_;
    const ViewSpace& space_;
    const DrawnPart* part_;
    LabelBricks* labels_;
    double leastDepth_;                     // optical
    std::vector<std::uint64_t> shownCells_; // of every brick
    std::vector<Surface> surfaces_;
    std::vector<double> sums_; // trapezoids of the table from its first entry to every kSumEvery-th
};

} // namespace tessera
