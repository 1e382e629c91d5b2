// bricking/levels/view_weight.cpp: see view_weight.h. Corners become homogeneous pixel coordinates, which are
// linear in voxels. Faces towards the eye are clipped to the picture there, so no corner is divided by a
// depth that is not positive.
#include "bricking/levels/view_weight.h"

#include "core/base/threads.h"

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
/// Its corners in homogeneous pixel coordinates; bit 0, 1, 2 of the index: high along x, y, z.
using Corners = std::array<glm::dvec3, 8>;

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

    Corners corners(const Box& box) const {
        const glm::dvec3 size = box.hi - box.lo;
        const std::array<glm::dvec3, 3> edge = {size.x * axes_[0], size.y * axes_[1], size.z * axes_[2]};
        Corners c;
        c[0] = at(box.lo);
        c[1] = c[0] + edge[0];
        c[2] = c[0] + edge[1];
        c[3] = c[1] + edge[1];
        for (std::size_t n = 0; n < 4; ++n)
            c[n + 4] = c[n] + edge[2];
        return c;
    }

    /// False only if no point of the box can be in the picture: all corners are beyond one side of it.
    bool mayTouch(const Corners& corners) const {
        std::array<int, 5> beyond{};
        for (const glm::dvec3& c : corners) {
            const double x = half_.x * c.z, y = half_.y * c.z;
            beyond[0] += c.x < -x;
            beyond[1] += c.x > x;
            beyond[2] += c.y < -y;
            beyond[3] += c.y > y;
            beyond[4] += c.z <= 0;
        }
        return *std::max_element(beyond.begin(), beyond.end()) < 8;
    }

    /// Pixels that the box covers.
    double area(const Box& box, const Corners& corners) const {
        if (perspective_ && glm::all(glm::greaterThanEqual(eye_, box.lo)) &&
            glm::all(glm::lessThanEqual(eye_, box.hi)))
            return pixels();
        bool inside = true;
        for (const glm::dvec3& c : corners)
            inside = inside && std::abs(c.x) <= half_.x * c.z && std::abs(c.y) <= half_.y * c.z && c.z > 0;
        std::array<glm::dvec2, 8> pixel;
        if (inside)
            for (std::size_t n = 0; n < pixel.size(); ++n)
                pixel[n] = glm::dvec2(corners[n]) / corners[n].z;
        double sum = 0; // faces towards the eye do not cover one another: the box is convex
        for (int axis = 0; axis < 3; ++axis)
            for (const bool high : {false, true}) {
                if (!looksAtEye(box, axis, high))
                    continue;
                const std::size_t u = std::size_t{1} << (axis + 1) % 3, w = std::size_t{1} << (axis + 2) % 3;
                const std::size_t first = high ? std::size_t{1} << axis : 0;
                if (!inside) {
                    sum += clippedArea(
                        {corners[first], corners[first + u], corners[first + u + w], corners[first + w]});
                    continue;
                }
                const glm::dvec2 a = pixel[first + u + w] - pixel[first],
                                 b = pixel[first + w] - pixel[first + u];
                sum += 0.5 * std::abs(a.x * b.y - a.y * b.x);
            }
        return sum;
    }

    /// The level of view_weight.h.
    int finestLevel(const Corners& corners) const {
        double depth = 1, away = half_.x * half_.x + half_.y * half_.y; // squared pixels from the middle
        if (perspective_) {
            depth = corners[0].z;
            for (const glm::dvec3& c : corners)
                depth = std::min(depth, c.z);
            if (!(depth > 0))
                return 0;
            double furthest = 0;
            for (const glm::dvec3& c : corners)
                furthest = std::max(furthest, (c.x * c.x + c.y * c.y) / (c.z * c.z));
            away = std::min(away, furthest);
        }
        // Away from the centre a pixel is narrower across the ray, by the cosine of the angle.
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
                        int threads, std::span<const std::uint8_t> shows) {
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
            const std::size_t at = linearIndex({i, j, k}, out.bricks);
            if (!shows.empty() && !shows[at])
                continue;
            const glm::ivec3 first = glm::ivec3(i, j, k) * kBrickExtent;
            const Box box{glm::dvec3(first), glm::dvec3(glm::min(first + kBrickExtent, info.extentVoxels))};
            const Corners corners = view.corners(box);
            double area = view.mayTouch(corners) ? view.area(box, corners) : 0;
            if (!(area > 0)) {
                const Box reach = grown(box, kBrickExtent / 2);
                const Corners reached = view.corners(reach);
                if (view.mayTouch(reached))
                    area = 0.25 * view.area(reach, reached);
            }
            if (!(area > 0))
                continue;
            out.area[at] = static_cast<float>(area);
            out.finest[at] = static_cast<std::uint8_t>(view.finestLevel(corners));
        }
    });
    return out;
}

} // namespace tessera
