// bricking/analysis/body/body_voxels.cpp: see body_voxels.h.
#include "bricking/analysis/body/body_voxels.h"

#include "bricking/analysis/body/body_box.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

namespace tessera {
std::vector<float> distancesTo(const Marks& marks, std::uint8_t of, const BodyGrid& grid) {
    std::vector<float> field(marks.size());
    std::transform(marks.begin(), marks.end(), field.begin(),
                   [of](std::uint8_t mark) { return mark == of ? 0.f : kFarAway; });
    squaredDistances(field, grid.extent, grid.spacingMm, grid.threads);
    return field;
}

int bodyLevelOf(const VolumeInfo& info, std::size_t mostSamples) {
    int level = 0;
    while (level + 1 < kLevelCount && cellCount(levelExtent(info.extentVoxels, level)) > mostSamples)
        ++level;
    return level;
}

Marks samplesAbove(std::span<const double> hu, const ChunkSource& source, int level, const BodyGrid& grid) {
    const VolumeInfo& info = source.info();
    Marks marks(grid.size());
    const glm::ivec3 chunks = chunkGrid(info.extentVoxels, level);
    parallelFor(cellCount(chunks), grid.threads, [&](std::size_t n) {
        std::vector<std::byte> chunk(source.chunkBytes());
        const glm::ivec3 at = gridPosition(n, chunks), first = at * kChunkExtent;
        source.readChunk({level, at.x, at.y, at.z}, chunk);
        const glm::ivec3 count = glm::min(grid.extent - first, glm::ivec3(kChunkExtent));
        withValueType(info.type, [&](auto example) {
            using Value = decltype(example);
            const auto* const values = reinterpret_cast<const Value*>(chunk.data());
            for (std::size_t v = 0; v < cellCount(count); ++v) {
                const glm::ivec3 in = gridPosition(v, count);
                const auto stored = static_cast<double>(values[linearIndex(in, glm::ivec3(kChunkExtent))]);
                const double value = info.rescaleSlope * stored + info.rescaleIntercept;
                marks[linearIndex(first + in, grid.extent)] = static_cast<std::uint8_t>(
                    std::count_if(hu.begin(), hu.end(), [value](double each) { return value > each; }));
            }
        });
    });
    return marks;
}

void forParts(const Marks& marks, const BodyGrid& grid,
              const std::function<void(std::span<const std::int32_t>)>& part) {
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

BodyMarks bodyAmong(const Marks& dense, const BodyGrid& grid) {
    std::vector<float> depths = distancesTo(dense, 0, grid);
    const double thickest = std::sqrt(static_cast<double>(*std::max_element(depths.begin(), depths.end())));
    if (thickest >= std::sqrt(static_cast<double>(kFarAway)))
        return {dense}; // no air at all
    const double least = std::min({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z});
    const double ball = std::max(thickest / kBodyOfThickness, 1.01 * least);
    Marks core(dense.size());
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = static_cast<double>(depths[i]) > ball * ball;
    Marks kept(dense.size());
    const double thick = thickest / kBodyOfThinnestPart;
    forParts(core, grid, [&](std::span<const std::int32_t> voxels) {
        const auto deepest = std::max_element(voxels.begin(), voxels.end(), [&](auto a, auto b) {
            return depths[static_cast<std::size_t>(a)] < depths[static_cast<std::size_t>(b)];
        });
        if (static_cast<double>(depths[static_cast<std::size_t>(*deepest)]) >= thick * thick)
            for (const std::int32_t voxel : voxels)
                kept[static_cast<std::size_t>(voxel)] = 1;
    });
    depths = distancesTo(kept, 1, grid);
    Marks body(dense.size()), rest(dense.size());
    for (std::size_t i = 0; i < body.size(); ++i) {
        body[i] = dense[i] && static_cast<double>(depths[i]) <= ball * ball;
        rest[i] = dense[i] && !body[i];
    }
    // Small attached pieces return.
    const Marks opened = body;
    forParts(rest, grid, [&](std::span<const std::int32_t> voxels) {
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
    return {std::move(body), ball};
}

} // namespace tessera
