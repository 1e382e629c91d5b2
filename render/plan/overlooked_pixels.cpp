// render/plan/overlooked_pixels.cpp: see overlooked_pixels.h.
#include "render/plan/overlooked_pixels.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/scene/camera.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace tessera {
namespace {

/// Pixels across a cell, 8 voxels, from which on some centre meets the smallest possible structure: a single
/// sample, which trilinear interpolation makes two voxels wide.
constexpr double kLargeCell = 8;

/// Columns and rows of pixels: from low up to, not with, high.
struct PixelBox {
    glm::ivec2 low{0}, high{0};
    bool empty() const { return high.x <= low.x || high.y <= low.y; }
};

/// Projects boxes of voxels onto the picture.
class Projector {
  public:
    Projector(const RayPlane& plane, const VolumeInfo& info, const glm::ivec2& size)
        : plane_(plane), size_(size), patientFromVoxel_(info.patientFromVoxel),
          right_(plane.right / glm::dot(plane.right, plane.right)),
          up_(plane.up / glm::dot(plane.up, plane.up)), eye_(plane.centre - plane.toCentre),
          distance_(plane.perspective ? glm::dot(plane.toCentre, plane.forward) : 1) {
        const glm::dmat3 linear(info.patientFromVoxel);
        for (int axis = 0; axis < 3; ++axis)
            halfOfVoxel_[axis] = 0.5 * glm::abs(inView(linear[axis]));
    }
    /// Of voxels from low up to, not with, high. Empty if it is outside the picture, or around or behind the
    /// eye.
    PixelBox of(const glm::ivec3& lowVoxel, const glm::ivec3& highVoxel, bool& large) const {
        const glm::dvec3 middle = 0.5 * glm::dvec3(lowVoxel + highVoxel), voxels(highVoxel - lowVoxel);
        const glm::dvec3 place(patientFromVoxel_ * glm::dvec4(middle, 1));
        const glm::dvec3 at = inView(place - (plane_.perspective ? eye_ : plane_.centre));
        const glm::dvec3 half = halfOfVoxel_ * voxels;
        glm::dvec2 low(at - half), high(at + half);
        if (plane_.perspective) {
            const double nearest = at.z - half.z, farthest = at.z + half.z;
            if (!(nearest > 0))
                return {};
            for (int axis = 0; axis < 2; ++axis) {
                low[axis] *= distance_ / (low[axis] < 0 ? nearest : farthest);
                high[axis] *= distance_ / (high[axis] > 0 ? nearest : farthest);
            }
        }
        const glm::dvec2 size(size_), from((low.x + 1) / 2 * size.x, (1 - high.y) / 2 * size.y),
            to((high.x + 1) / 2 * size.x, (1 - low.y) / 2 * size.y);
        large = std::max(to.x - from.x, to.y - from.y) > kLargeCell;
        return {glm::ivec2(glm::clamp(glm::floor(from), glm::dvec2(0), size)),
                glm::ivec2(glm::clamp(glm::ceil(to), glm::dvec2(0), size))};
    }

  private:
    /// Along the picture's right and up, in halves of it where the plane is, and along the view, mm.
    glm::dvec3 inView(const glm::dvec3& v) const {
        return {glm::dot(v, right_), glm::dot(v, up_), glm::dot(v, plane_.forward)};
    }
    RayPlane plane_;
    glm::ivec2 size_;
    glm::dmat4 patientFromVoxel_;
    glm::dvec3 right_, up_, eye_;
    double distance_;
    glm::dmat3 halfOfVoxel_{0}; // along the view, a column an axis of voxels
};

/// The number of visible pixels in a box, from sums over all pixels above and to the left.
class ShownPixels {
  public:
    explicit ShownPixels(const Image& image)
        : row_(static_cast<std::size_t>(image.size.x) + 1),
          sums_(row_ * (static_cast<std::size_t>(image.size.y) + 1)) {
        for (int y = 0; y < image.size.y; ++y) {
            std::uint32_t inRow = 0;
            for (int x = 0; x < image.size.x; ++x) {
                inRow += image.at(x, y).a > 0 ? 1 : 0;
                sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + inRow;
            }
        }
    }
    bool any(const PixelBox& b) const {
        return sums_[index(b.high.x, b.high.y)] + sums_[index(b.low.x, b.low.y)] !=
               sums_[index(b.low.x, b.high.y)] + sums_[index(b.high.x, b.low.y)];
    }

  private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * row_ + static_cast<std::size_t>(x);
    }
    std::size_t row_;
    std::vector<std::uint32_t> sums_;
};

} // namespace

std::vector<std::uint32_t> overlookedPixels(const FramePlan& plan, const Image& middles) {
    const Occupancy& cells = plan.layer().occupancy;
    if (!cells.exists())
        return {};
    const VolumeInfo& info = plan.info();
    const glm::ivec2& size = middles.size;
    const Projector projector(rayPlane(plan.view.camera, info, size), info, size);
    const ShownPixels shown(middles);
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    std::vector<bool> isOverlooked(middles.pixels.size(), false);
    std::size_t count = 0;
    for (std::size_t b = 0; b < cells.masks().size(); ++b) {
        if (cells.masks()[b] == 0)
            continue;
        const glm::ivec3 first = gridPosition(b, bricks) * kBrickExtent;
        bool large = false;
        for (std::uint64_t mask = cells.masks()[b]; mask != 0; mask &= mask - 1) {
            const int bit = std::countr_zero(mask);
            const glm::ivec3 low = first + glm::ivec3(bit & 3, bit >> 2 & 3, bit >> 4) * kCellExtent;
            const PixelBox box = projector.of(low, glm::min(low + kCellExtent, info.extentVoxels), large);
            if (box.empty() || shown.any(box))
                continue;
            const bool clipped = glm::any(glm::lessThanEqual(box.high - box.low, glm::ivec2(1)));
            if (large && !clipped)
                continue;
            for (int y = box.low.y; y < box.high.y; ++y)
                for (int x = box.low.x; x < box.high.x; ++x) {
                    const std::size_t pixel = linearIndex({x, y, 0}, {size, 1});
                    count += isOverlooked[pixel] ? 0 : 1;
                    isOverlooked[pixel] = true;
                }
        }
    }
    std::vector<std::uint32_t> pixels;
    pixels.reserve(count);
    for (std::uint32_t i = 0; count > 0 && i < isOverlooked.size(); ++i)
        if (isOverlooked[i])
            pixels.push_back(i);
    return pixels;
}

} // namespace tessera
