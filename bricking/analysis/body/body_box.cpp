// bricking/analysis/body/body_box.cpp: see body_box.h.
#include "bricking/analysis/body/body_box.h"

#include "bricking/analysis/body/body_voxels.h"
#include "bricking/analysis/body/marks.h"
#include "core/base/error.h"

#include <array>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

namespace tessera {

namespace {

constexpr std::size_t kMostSamples = std::size_t{1} << 21; // 128^3
constexpr double kOfVoxelAround = 0.7; // the skin extends less than this beyond a coarse voxel above kBodyHu

int levelOf(const VolumeInfo& info) {
    return bodyLevelOf(info, kMostSamples);
}

} // namespace

std::size_t bodyBoxBytes(const VolumeInfo& info) {
    return bodyBytes(levelExtent(info.extentVoxels, levelOf(info)), info.type);
}

BodyBox findBody(const ChunkSource& source, MemoryBudget& ram) {
    const VolumeInfo& info = source.info();
    const Charge charge = ram.charge(bodyBoxBytes(info), "finding the body");
    BodyBox box;
    box.level = levelOf(info);
    const double voxels = static_cast<double>(1 << box.level); // of level 0, along an axis of a sample
    const BodyGrid grid(info, box.level, 1);
    const Marks above = std::move(samplesAbove(std::array{kBodyHu}, source, box.level, grid).front());
    if (!above.any())
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
    for (int z = 0; z < grid.extent.z; ++z)
        for (int y = 0; y < grid.extent.y; ++y)
            forMarked(body.row(body.rowNumber(y, z)), [&](int x) {
                const glm::dvec3 middle = place((glm::dvec3(x, y, z) + 0.5) * voxels);
                box.low = glm::min(box.low, middle - half);
                box.high = glm::max(box.high, middle + half);
            });
    const std::size_t inside = body.count(), all = above.count();
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
