// viewer/session/slice_views.cpp: see slice_views.h.
#include "viewer/session/slice_views.h"

#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr int kTile = 32; // pixels along a tile: few chunks at a time

} // namespace

int sliceLevel(const VolumeInfo& info, const SliceFrame& frame, std::size_t chunks) {
    const glm::dmat3 voxelFromPatient = glm::inverse(glm::dmat3(info.patientFromVoxel));
    const glm::dvec3 right = frame.mmPerPixel * (voxelFromPatient * frame.pose.right),
                     up = frame.mmPerPixel * (voxelFromPatient * frame.pose.up);
    const double voxels = std::min(glm::length(right), glm::length(up)); // per pixel
    int level =
        std::clamp(static_cast<int>(std::floor(std::log2(std::max(1.0, voxels)))), 0, kLevelCount - 1);
    const glm::dvec3 along = static_cast<double>(frame.size.x) * glm::abs(right),
                     across = static_cast<double>(frame.size.y) * glm::abs(up);
    for (; level < kLevelCount - 1; ++level) {
        const double edge = static_cast<double>(kChunkExtent << level);
        const glm::dvec3 box = glm::min(along + across, glm::dvec3(info.extentVoxels)) / edge + 2.0;
        // A plane crosses at most as many chunks as the two longest sides of its box span; an oblique plane
        // at most twice as many.
        const double least = std::min({box.x, box.y, box.z});
        if (2 * box.x * box.y * box.z / least <= static_cast<double>(chunks))
            break;
    }
    return level;
}

std::vector<float> sliceValues(BrickCache& cache, const VolumeInfo& info, const SliceFrame& frame, int level,
                               int threads) {
    const glm::ivec2 size = frame.size;
    std::vector<float> values(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const double perVoxel = std::exp2(-level);
    const glm::dvec3 extent(info.extentVoxels);
    const glm::ivec2 tiles = (size + (kTile - 1)) / kTile;
    parallelFor(
        static_cast<std::size_t>(tiles.x) * static_cast<std::size_t>(tiles.y), threads, [&](std::size_t n) {
            LatticeReader samples(cache, info, level, nullptr);
            const glm::ivec2 first =
                kTile * glm::ivec2(static_cast<int>(n) % tiles.x, static_cast<int>(n) / tiles.x);
            const glm::ivec2 end = glm::min(first + kTile, size);
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const glm::dvec3 mm = frame.patientFromPicture({x + 0.5, y + 0.5});
                    const glm::dvec3 voxel(voxelFromPatient * glm::dvec4(mm, 1));
                    const bool inside = glm::clamp(voxel, glm::dvec3(0), extent) == voxel;
                    values[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                           static_cast<std::size_t>(x)] =
                        inside ? static_cast<float>(info.rescaleSlope * fieldValue(samples, voxel, perVoxel) +
                                                    info.rescaleIntercept)
                               : std::numeric_limits<float>::quiet_NaN();
                }
        });
    return values;
}

std::vector<std::uint32_t> greyPixels(const std::vector<float>& values, const GreyWindow& window) {
    std::vector<std::uint32_t> pixels(values.size());
    std::transform(values.begin(), values.end(), pixels.begin(), [&](float value) {
        const double part = (static_cast<double>(value) - window.low()) / window.width;
        const double grey = part > 0 ? std::min(part, 1.0) : 0.0; // NaN is black
        const auto code = static_cast<std::uint32_t>(std::lround(255 * grey));
        return code | code << 8 | code << 16 | 0xFF000000u;
    });
    return pixels;
}

} // namespace tessera
