// bricking/view_weight.cpp: see view_weight.h. Corners are taken to homogeneous pixel coordinates, which are
// linear in voxels; faces that look at the eye are clipped to the picture there, so no corner is ever divided
// by a depth that is not positive.
#include "bricking/view_weight.h"

#include "core/threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace tessera {
namespace {

/// A box of voxels, as its two extreme corners.
struct Box {
    glm::dvec3 lo, hi;
};

class Projector {
  public:
    Projector(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize) {
        const RayPlane plane = rayPlane(camera, info, imageSize);
        perspective_ = plane.perspective;
        half_ = glm::dvec2(imageSize) * 0.5;
        const double distance = glm::length(plane.toCentre);
        const glm::dvec3 right = plane.right / glm::dot(plane.right, plane.right) * half_.x;
        const glm::dvec3 down = -plane.up / glm::dot(plane.up, plane.up) * half_.y;
        // pixel - half = (x, y) / w; perspective: x = distance * dot(p - eye, right), w = depth.
        const glm::dvec3 origin = perspective_ ? plane.centre - plane.toCentre : plane.centre;
        const double scale = perspective_ ? distance : 1;
        const glm::dmat3 linear(info.patientFromVoxel);
        const glm::dvec3 offset = glm::dvec3(info.patientFromVoxel[3]) - origin;
        const auto project = [&](const glm::dvec3& mm) {
            return glm::dvec3(scale * glm::dot(mm, right), scale * glm::dot(mm, down),
                              perspective_ ? glm::dot(mm, plane.forward) : 0.0);
        };
        for (int axis = 0; axis < 3; ++axis)
            axes_[axis] = project(linear[axis]);
        origin_ = project(offset);
        if (!perspective_)
            origin_.z = 1;
        const glm::dmat3 voxelFromPatient = glm::inverse(linear);
        eye_ = voxelFromPatient * -offset; // perspective only
        along_ = voxelFromPatient * plane.forward;
        pixelMm_ = glm::length(plane.right) / half_.x / scale; // at depth 1 in perspective
        const glm::dvec3 spacing = info.spacingMm();
        largestEdgeMm_ = std::max({spacing.x, spacing.y, spacing.z});
    }

    /// Homogeneous pixel coordinates relative to the picture's middle.
    glm::dvec3 at(const glm::dvec3& voxel) const {
        return origin_ + voxel.x * axes_[0] + voxel.y * axes_[1] + voxel.z * axes_[2];
    }

    /// False only where no point of the box can be in the picture.
    bool mayTouch(const Box& box) const {
        const glm::dvec3 middle = at((box.lo + box.hi) * 0.5), reach = (box.hi - box.lo) * 0.5;
        const auto furthest = [&](const glm::dvec3& plane) { // largest dot(plane, point)
            double d = glm::dot(plane, middle);
            for (int axis = 0; axis < 3; ++axis)
                d += reach[axis] * std::abs(glm::dot(plane, axes_[axis]));
            return d;
        };
        return furthest({1, 0, half_.x}) >= 0 && furthest({-1, 0, half_.x}) >= 0 &&
               furthest({0, 1, half_.y}) >= 0 && furthest({0, -1, half_.y}) >= 0 && furthest({0, 0, 1}) > 0;
    }

    /// Pixels that the box covers.
    double area(const Box& box) const {
        if (perspective_ && glm::all(glm::greaterThanEqual(eye_, box.lo)) &&
            glm::all(glm::lessThanEqual(eye_, box.hi)))
            return 4 * half_.x * half_.y;
        double sum = 0; // faces that look at the eye do not cover one another: the box is convex
        for (int axis = 0; axis < 3; ++axis)
            for (const bool high : {false, true})
                if (looksAtEye(box, axis, high))
                    sum += faceArea(box, axis, high);
        return sum;
    }

    /// The level of view_weight.h.
    int finestLevel(const Box& box) const {
        double depth = 1, away = half_.x * half_.x + half_.y * half_.y; // squared pixels from the middle
        if (perspective_) {
            depth = 1e300;
            double furthest = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 h = at({corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                                         corner & 4 ? box.hi.z : box.lo.z});
                depth = std::min(depth, h.z);
                if (h.z > 0)
                    furthest = std::max(furthest, (h.x * h.x + h.y * h.y) / (h.z * h.z));
            }
            if (!(depth > 0))
                return 0;
            away = std::min(away, furthest);
        }
        // Away from the middle a pixel is narrower across the ray, by the cosine of the angle.
        const double cosine = perspective_ ? 1 / std::sqrt(1 + away * pixelMm_ * pixelMm_) : 1;
        double size = largestEdgeMm_, pixel = depth * pixelMm_ * cosine;
        int level = 0;
        while (level < kLevelCount - 1 && 2 * size <= pixel) {
            size *= 2;
            ++level;
        }
        return level;
    }

    double pixels() const { return 4 * half_.x * half_.y; }

  private:
    bool looksAtEye(const Box& box, int axis, bool high) const {
        if (!perspective_)
            return high ? along_[axis] < 0 : along_[axis] > 0;
        return high ? eye_[axis] > box.hi[axis] : eye_[axis] < box.lo[axis];
    }

    double faceArea(const Box& box, int axis, bool high) const {
        const int u = (axis + 1) % 3, w = (axis + 2) % 3;
        std::array<glm::dvec3, 4> corner;
        bool inside = true;
        for (int n = 0; n < 4; ++n) {
            glm::dvec3 p;
            p[axis] = high ? box.hi[axis] : box.lo[axis];
            p[u] = n == 1 || n == 2 ? box.hi[u] : box.lo[u];
            p[w] = n >= 2 ? box.hi[w] : box.lo[w];
            const glm::dvec3 h = corner[static_cast<std::size_t>(n)] = at(p);
            inside = inside && h.z > 0 && std::abs(h.x) <= half_.x * h.z && std::abs(h.y) <= half_.y * h.z;
        }
        if (!inside)
            return clippedArea(corner);
        const auto pixel = [&](std::size_t n) { return glm::dvec2(corner[n]) / corner[n].z; };
        const glm::dvec2 a = pixel(2) - pixel(0), b = pixel(3) - pixel(1);
        return 0.5 * std::abs(a.x * b.y - a.y * b.x);
    }

    /// Sutherland and Hodgman's clipping against the four sides of the picture.
    double clippedArea(const std::array<glm::dvec3, 4>& quad) const {
        std::array<glm::dvec3, 8> polygon, next; // each side adds at most one corner
        std::size_t count = 4;
        std::copy(quad.begin(), quad.end(), polygon.begin());
        const std::array<glm::dvec3, 4> sides = {glm::dvec3(1, 0, half_.x), glm::dvec3(-1, 0, half_.x),
                                                 glm::dvec3(0, 1, half_.y), glm::dvec3(0, -1, half_.y)};
        for (const glm::dvec3& side : sides) {
            std::size_t made = 0;
            for (std::size_t n = 0; n < count; ++n) {
                const glm::dvec3 a = polygon[n], b = polygon[(n + 1) % count];
                const double da = glm::dot(side, a), db = glm::dot(side, b);
                if (da >= 0)
                    next[made++] = a;
                if ((da >= 0) != (db >= 0) && made < next.size())
                    next[made++] = a + da / (da - db) * (b - a);
            }
            polygon = next;
            count = made;
        }
        double twice = 0;
        for (std::size_t n = 0; n < count; ++n) {
            const glm::dvec3 a = polygon[n], b = polygon[(n + 1) % count];
            if (a.z > 0 && b.z > 0) // zero only at the eye itself
                twice += (a.x * b.y - a.y * b.x) / (a.z * b.z);
        }
        return std::min(0.5 * std::abs(twice), pixels());
    }

    bool perspective_ = true;
    glm::dvec2 half_{0};
    std::array<glm::dvec3, 3> axes_{};
    glm::dvec3 origin_{0};
    glm::dvec3 eye_{0}, along_{0}; // voxels
    double pixelMm_ = 0, largestEdgeMm_ = 0;
};

Box grown(const Box& box, double voxels) {
    return {box.lo - voxels, box.hi + voxels};
}

} // namespace

ViewWeights viewWeights(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize,
                        int threads) {
    const Projector view(camera, info, imageSize);
    ViewWeights out;
    out.bricks = brickGrid(info.extentVoxels);
    out.pixels = view.pixels();
    const std::size_t count = cellCount(out.bricks);
    out.area.assign(count, 0);
    out.finest.assign(count, kLevelCount - 1);
    const auto rows = static_cast<std::size_t>(out.bricks.y) * static_cast<std::size_t>(out.bricks.z);
    parallelFor(rows, threads, [&](std::size_t row) {
        const int j = static_cast<int>(row % static_cast<std::size_t>(out.bricks.y));
        const int k = static_cast<int>(row / static_cast<std::size_t>(out.bricks.y));
        for (int i = 0; i < out.bricks.x; ++i) {
            const glm::ivec3 first = glm::ivec3(i, j, k) * kBrickExtent;
            const Box box{glm::dvec3(first), glm::dvec3(glm::min(first + kBrickExtent, info.extentVoxels))};
            const Box reach = grown(box, kBrickExtent / 2);
            if (!view.mayTouch(reach))
                continue;
            double area = view.area(box);
            if (!(area > 0))
                area = 0.25 * view.area(reach);
            if (!(area > 0))
                continue;
            const std::size_t at = linearIndex({i, j, k}, out.bricks);
            out.area[at] = static_cast<float>(area);
            out.finest[at] = static_cast<std::uint8_t>(view.finestLevel(box));
        }
    });
    return out;
}

} // namespace tessera
