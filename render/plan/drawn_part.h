// render/plan/drawn_part.h: the part of a volume that a scene draws. A slice's plane or slab, and convex
// cuts, become slabs that every ray is clipped to. It also lists the bricks wholly outside, and gives a slice
// its camera where the scene names none.
#pragma once

#include "bricking/levels/selection.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h"
#include "render/contract/ray_cuts.h"

#include <memory>
#include <vector>

namespace tessera {

struct DrawnPart {
    std::vector<RaySlab<double>> slabs; // of a slice first; at most kMostSlabs
    bool slice = false;                 // the first is a slice's
    bool flat = false;                  // which is a plane
    /// What no slab can say; null: there is nothing.
    std::shared_ptr<const RayCuts> cuts;

    bool any() const { return !slabs.empty() || cuts; }
    /// Rays of the frame are clipped to it. A parallel camera's positions are then exact where the first
    /// slab lies: its rays start from there.
    void clip(RayFrame<double>& frame) const;
    /// Whether anything of a box is in it. Voxels; the box is closed.
    bool meets(const glm::dvec3& low, const glm::dvec3& high) const;
};
/// Throws InputError for cuts that are none, such as boxes without an inside.
DrawnPart drawnPart(const Scene& scene, const VolumeInfo& info);

/// The camera of a slice that is looked at along its normal: parallel, filled by the volume's cross-section,
/// or by its box where the plane misses it.
Camera sliceCamera(const SlicePlane& slice, const VolumeInfo& info, const glm::ivec2& imageSize);

/// Bricks that no sample of the part reads become empty. Returns how many. Pictures stay as they are, bit
/// for bit where the selection has one level.
/// @param lit  gradients are taken
std::size_t leaveOutUndrawn(Selection& selection, const DrawnPart& part, const VolumeInfo& info, bool lit);

} // namespace tessera
