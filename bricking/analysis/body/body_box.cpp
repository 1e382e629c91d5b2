// bricking/analysis/body/body_box.cpp: see body_box.h.
#include "bricking/analysis/body/body_box.h"

#include "bricking/analysis/body/body_voxels.h"
#include "core/base/error.h"
#include "core/base/lower_envelope.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

namespace tessera {

void squaredDistances(std::vector<float>& grid, const glm::ivec3& extent, const glm::dvec3& spacingMm,
                      int threads) {
    constexpr std::size_t kLinesAtOnce = 512;
    const glm::ivec3 strides(1, extent.x, extent.x * extent.y);
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 lines = extent; // one line for each place of the other two axes
        lines[axis] = 1;
        const std::size_t count = cellCount(lines);
        parallelFor((count + kLinesAtOnce - 1) / kLinesAtOnce, threads, [&](std::size_t batch) {
            LowerEnvelope envelope;
            std::vector<double> line(static_cast<std::size_t>(extent[axis]));
            for (std::size_t n = batch * kLinesAtOnce; n < std::min(count, (batch + 1) * kLinesAtOnce); ++n) {
                float* const at = grid.data() + linearIndex(gridPosition(n, lines), extent);
                for (std::size_t i = 0; i < line.size(); ++i) {
                    const float value = at[static_cast<std::ptrdiff_t>(i) * strides[axis]];
                    line[i] = value < kFarAway ? static_cast<double>(value)
                                               : std::numeric_limits<double>::infinity();
                }
                if (std::adjacent_find(line.begin(), line.end(), std::not_equal_to<>()) == line.end())
                    continue; // each is its own nearest
                envelope.transform(line, spacingMm[axis]);
                for (std::size_t i = 0; i < line.size(); ++i)
                    at[static_cast<std::ptrdiff_t>(i) * strides[axis]] =
                        line[i] < static_cast<double>(kFarAway) ? static_cast<float>(line[i]) : kFarAway;
            }
        });
    }
}

namespace {

constexpr std::size_t kMostSamples = std::size_t{1} << 21; // 128^3
constexpr double kOfVoxelAround = 0.7; // the skin extends less than this beyond a coarse voxel above kBodyHu

int levelOf(const VolumeInfo& info) {
    return bodyLevelOf(info, kMostSamples);
}

} // namespace

std::size_t bodyBoxBytes(const VolumeInfo& info) {
    return kBodyBytesPerSample * cellCount(levelExtent(info.extentVoxels, levelOf(info))) +
           cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
}

BodyBox findBody(const ChunkSource& source, MemoryBudget& ram) {
    const VolumeInfo& info = source.info();
    const Charge charge = ram.charge(bodyBoxBytes(info), "finding the body");
    BodyBox box;
    box.level = levelOf(info);
    const double voxels = static_cast<double>(1 << box.level); // of level 0, along an axis of a sample
    const BodyGrid grid(info, box.level, 1);
    const Marks above = samplesAbove(std::array{kBodyHu}, source, box.level, grid);
    if (std::find(above.begin(), above.end(), 1) == above.end())
        throw badFile("--crop body", "a body: something above -300 HU", "none");
    const Marks body = bodyAmong(above, grid).marks;

    // A sample as a box of patient space, slightly enlarged: the affine of its centre, and half of its extent
    // along each axis.
    const glm::dmat3 edges(info.patientFromVoxel);
    glm::dvec3 half(0);
    for (int axis = 0; axis < 3; ++axis)
        half += glm::abs(edges[axis]) * (voxels * (0.5 + kOfVoxelAround));
    const auto place = [&](const glm::dvec3& voxel) {
        return glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
    };
    box.low = glm::dvec3(std::numeric_limits<double>::max());
    box.high = -box.low;
    std::size_t inside = 0, all = 0;
    for (std::size_t i = 0; i < body.size(); ++i) {
        all += above[i];
        inside += body[i];
        if (!body[i])
            continue;
        const glm::dvec3 middle = place((glm::dvec3(gridPosition(i, grid.extent)) + 0.5) * voxels);
        box.low = glm::min(box.low, middle - half);
        box.high = glm::max(box.high, middle + half);
    }
    glm::dvec3 first(std::numeric_limits<double>::max()), last = -first;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at =
            place(glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2));
        first = glm::min(first, at), last = glm::max(last, at);
    }
    constexpr double kTenth = 10; // rounded to tenths of a millimetre
    box.low = glm::floor(kTenth * glm::max(box.low, first)) / kTenth;
    box.high = glm::ceil(kTenth * glm::min(box.high, last)) / kTenth;
    const double litre = grid.spacingMm.x * grid.spacingMm.y * grid.spacingMm.z / 1e6;
    box.litres = static_cast<double>(inside) * litre;
    box.litresLeftOut = static_cast<double>(all - inside) * litre;
    return box;
}

} // namespace tessera
