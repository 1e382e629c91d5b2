// render/plan/drawn_part.h: the part of a volume that a scene draws. A slice's plane or slab, and convex
// cuts, become slabs to which every ray is clipped. It also finds the bricks entirely outside, and the
// default camera of a slice.
#pragma once

#include "bricking/levels/selection.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h"
#include "render/contract/ray_cuts.h"
#include "render/contract/scene_numbers.h"

#include <memory>
#include <vector>

namespace tessera {

struct DrawnPart {
    std::vector<RaySlab<double>> slabs; // of a slice first; at most kMostSlabs
    bool slice = false;                 // the first is a slice's
    bool flat = false;                  // that is a plane
    /// Cuts that are no slabs; null: none, and no meshes or hulls, which end rays as cuts do.
    std::shared_ptr<const RayCuts> cuts;

    bool any() const { return !slabs.empty() || cuts; }
    /// Clips the rays of the frame to it. Positions of a parallel camera are then exact at the first slab,
    /// where its rays start.
    void clip(RayFrame<double>& frame) const;
    /// True if a point is in it, or no further than the tolerance outside; voxels.
    bool keeps(const glm::dvec3& point, double tolerance) const;
    /// True if any of a box is in it. Voxels; the box is closed.
    bool meets(const glm::dvec3& low, const glm::dvec3& high) const;
};
/// The cuts of one of several volumes, besides those of all: as its samples meet them, and exactly.
struct OwnCuts {
    std::vector<leaf::CutSlab> slabs;
    RayCuts exact;
};
/// Throws InputError for invalid cuts, and for scissors.
OwnCuts ownCuts(const Cuts& cuts, const VolumeInfo& info);

/// Of a scene's cuts; in that of one volume also of the volume's own.
/// Throws InputError for invalid cuts, such as boxes without an inside.
DrawnPart drawnPart(const Scene& scene, const VolumeInfo& info);

/// The camera of a slice seen along its normal: parallel, fitted to the volume's cross-section, or to its box
/// if the plane misses it.
Camera sliceCamera(const SlicePlane& slice, const VolumeInfo& info, const glm::ivec2& imageSize);

/// Bricks that no sample of the part reads become empty. Returns their number. Pictures are unchanged, bit
/// for bit if the selection has one level.
/// @param pitches  that gradients reach to a side, where any are taken
std::size_t leaveOutUndrawn(Selection& selection, const DrawnPart& part, const VolumeInfo& info, int pitches);
/// Of gradients that a scene takes, if it does.
inline int pitchesOfGradients(bool takesGradients, const Shading& shading) {
    return takesGradients ? reachOf(shading.gradient) : 0;
}

} // namespace tessera
