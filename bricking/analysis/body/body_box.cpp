// bricking/analysis/body/body_box.cpp: see body_box.h.
#include "bricking/analysis/body/body_box.h"

#include "core/base/brick.h" // linearIndex
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/lower_envelope.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

namespace tessera {

void squaredDistances(std::vector<float>& grid, const glm::ivec3& extent, const glm::dvec3& spacingMm) {
    LowerEnvelope envelope;
    std::vector<double> line;
    const glm::ivec3 strides(1, extent.x, extent.x * extent.y);
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 lines = extent; // one line for each place of the other two axes
        lines[axis] = 1;
        line.resize(static_cast<std::size_t>(extent[axis]));
        for (std::size_t n = 0; n < cellCount(lines); ++n) {
            float* const at = grid.data() + linearIndex(gridPosition(n, lines), extent);
            for (std::size_t i = 0; i < line.size(); ++i) {
                const float value = at[static_cast<std::ptrdiff_t>(i) * strides[axis]];
                line[i] =
                    value < kFarAway ? static_cast<double>(value) : std::numeric_limits<double>::infinity();
            }
            envelope.transform(line, spacingMm[axis]);
            for (std::size_t i = 0; i < line.size(); ++i)
                at[static_cast<std::ptrdiff_t>(i) * strides[axis]] =
                    line[i] < static_cast<double>(kFarAway) ? static_cast<float>(line[i]) : kFarAway;
        }
    }
}

namespace {

constexpr std::size_t kMostSamples = std::size_t{1} << 21; // 128^3
constexpr double kOfVoxelAround = 0.7; // the skin extends less than this beyond a coarse voxel above kBodyHu
/// Bytes per sample: two distance fields, the voxels of a part, which grow by doubling, and seven sets of
/// marks.
constexpr std::size_t kBytesPerSample = 2 * sizeof(float) + 2 * sizeof(std::int32_t) + 8;

int levelOf(const VolumeInfo& info) {
    int level = 0;
    while (level + 1 < kLevelCount && cellCount(levelExtent(info.extentVoxels, level)) > kMostSamples)
        ++level;
    return level;
}

/// A level's grid, and sets of its voxels as bytes.
struct Grid {
    glm::ivec3 extent;
    glm::dvec3 spacingMm;
    std::size_t size() const { return cellCount(extent); }
    /// Calls what(index) for the up to six voxels that share a face.
    template <typename What> void beside(std::size_t index, const What& what) const {
        const glm::ivec3 at = gridPosition(index, extent);
        for (int face = 0; face < 6; ++face) {
            glm::ivec3 next = at;
            next[face / 2] += face % 2 == 0 ? -1 : 1;
            if (next[face / 2] >= 0 && next[face / 2] < extent[face / 2])
                what(linearIndex(next, extent));
        }
    }
};
using Marks = std::vector<std::uint8_t>;

/// The samples of a level above kBodyHu.
Marks marksOf(const ChunkSource& source, int level, const Grid& grid) {
    const VolumeInfo& info = source.info();
    Marks marks(grid.size());
    std::vector<std::byte> chunk(source.chunkBytes());
    const glm::ivec3 chunks = chunkGrid(info.extentVoxels, level);
    for (std::size_t n = 0; n < cellCount(chunks); ++n) {
        checkInterrupted();
        const glm::ivec3 at = gridPosition(n, chunks), first = at * kChunkExtent;
        source.readChunk({level, at.x, at.y, at.z}, chunk);
        const glm::ivec3 count = glm::min(grid.extent - first, glm::ivec3(kChunkExtent));
        for (std::size_t v = 0; v < cellCount(count); ++v) {
            const glm::ivec3 in = gridPosition(v, count);
            const std::size_t place = linearIndex(in, glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
            const double value =
                info.rescaleSlope * storedValue(info.type, chunk.data() + place) + info.rescaleIntercept;
            marks[linearIndex(first + in, grid.extent)] = value > kBodyHu;
        }
    }
    return marks;
}

/// Squared distance to the nearest voxel with mark `of`, mm2.
std::vector<float> distancesTo(const Marks& marks, std::uint8_t of, const Grid& grid) {
    std::vector<float> field(marks.size());
    std::transform(marks.begin(), marks.end(), field.begin(),
                   [of](std::uint8_t mark) { return mark == of ? 0.f : kFarAway; });
    squaredDistances(field, grid.extent, grid.spacingMm);
    return field;
}

/// Calls part(voxels) for every connected part of the marked voxels; by faces, in the order of their first
/// voxels. `part` may change marks of its voxels only.
template <typename Part> void forParts(const Marks& marks, const Grid& grid, const Part& part) {
    Marks seen(marks.size());
    std::vector<std::int32_t> voxels;
    for (std::size_t start = 0; start < marks.size(); ++start) {
        if (!marks[start] || seen[start])
            continue;
        voxels.assign(1, static_cast<std::int32_t>(start));
        seen[start] = 1;
        for (std::size_t next = 0; next < voxels.size(); ++next)
            grid.beside(static_cast<std::size_t>(voxels[next]), [&](std::size_t beside) {
                if (marks[beside] && !seen[beside]) {
                    seen[beside] = 1;
                    voxels.push_back(static_cast<std::int32_t>(beside));
                }
            });
        part(voxels);
    }
}

/// The marks of the body among those of all voxels above kBodyHu.
Marks bodyOf(const Marks& above, const Grid& grid) {
    std::vector<float> depths = distancesTo(above, 0, grid);
    const double thickest = std::sqrt(static_cast<double>(*std::max_element(depths.begin(), depths.end())));
    if (thickest >= std::sqrt(static_cast<double>(kFarAway)))
        return above; // no air at all
    const double least = std::min({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z});
    const double ball = std::max(thickest / kBodyOfThickness, 1.01 * least);
    Marks core(above.size());
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = static_cast<double>(depths[i]) > ball * ball;
    Marks kept(above.size());
    const double thick = thickest / kBodyOfThinnestPart;
    forParts(core, grid, [&](const std::vector<std::int32_t>& voxels) {
        const auto deepest = std::max_element(voxels.begin(), voxels.end(), [&](auto a, auto b) {
            return depths[static_cast<std::size_t>(a)] < depths[static_cast<std::size_t>(b)];
        });
        if (static_cast<double>(depths[static_cast<std::size_t>(*deepest)]) >= thick * thick)
            for (const std::int32_t voxel : voxels)
                kept[static_cast<std::size_t>(voxel)] = 1;
    });
    depths = distancesTo(kept, 1, grid);
    Marks body(above.size()), rest(above.size());
    for (std::size_t i = 0; i < body.size(); ++i) {
        body[i] = above[i] && static_cast<double>(depths[i]) <= ball * ball;
        rest[i] = above[i] && !body[i];
    }
    // Small attached pieces return.
    const Marks opened = body;
    forParts(rest, grid, [&](const std::vector<std::int32_t>& voxels) {
        glm::ivec3 low(std::numeric_limits<int>::max()), high(-1);
        bool touches = false;
        for (const std::int32_t voxel : voxels) {
            const glm::ivec3 at = gridPosition(static_cast<std::size_t>(voxel), grid.extent);
            low = glm::min(low, at), high = glm::max(high, at);
            grid.beside(static_cast<std::size_t>(voxel), [&](std::size_t i) { touches |= opened[i] != 0; });
        }
        if (touches && glm::length(glm::dvec3(high + 1 - low) * grid.spacingMm) < thickest)
            for (const std::int32_t voxel : voxels)
                body[static_cast<std::size_t>(voxel)] = 1;
    });
    return body;
}

} // namespace

std::size_t bodyBoxBytes(const VolumeInfo& info) {
    return kBytesPerSample * cellCount(levelExtent(info.extentVoxels, levelOf(info))) +
           cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
}

BodyBox findBody(const ChunkSource& source, MemoryBudget& ram) {
    const VolumeInfo& info = source.info();
    const Charge charge = ram.charge(bodyBoxBytes(info), "finding the body");
    BodyBox box;
    box.level = levelOf(info);
    const double voxels = static_cast<double>(1 << box.level); // of level 0, along an axis of a sample
    const Grid grid{levelExtent(info.extentVoxels, box.level), voxels * info.spacingMm()};
    const Marks above = marksOf(source, box.level, grid);
    if (std::find(above.begin(), above.end(), 1) == above.end())
        throw badFile("--crop body", "a body: something above -300 HU", "none");
    const Marks body = bodyOf(above, grid);

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
