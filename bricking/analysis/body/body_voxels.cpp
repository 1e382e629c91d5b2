// bricking/analysis/body/body_voxels.cpp: see body_voxels.h.
#include "bricking/analysis/body/body_voxels.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/analysis/body/body_marks.h"
#include "bricking/analysis/body/mark_distance.h"
#include "bricking/analysis/body/mark_parts.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

namespace tessera {
namespace {

/// Flags of neighbours, one a byte, as bits.
std::uint32_t bitsOf(std::span<const std::uint8_t, kChunkExtent> flags) {
    static_assert(std::endian::native == std::endian::little, "the first byte is the lowest");
    constexpr std::uint64_t kGather = 0x0102040810204080; // bit 0 of byte n to bit 56 + n
    std::uint32_t bits = 0;
    for (std::size_t n = 0; n < kChunkExtent; n += 8) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, &flags[n], sizeof eight);
        bits |= static_cast<std::uint32_t>(eight * kGather >> 56) << n;
    }
    return bits;
}

/// How many of the values each sample of a chunk's row is above.
template <typename Value>
void countAbove(const Value* row, const VolumeInfo& info, std::span<const double> hu,
                std::array<std::uint8_t, kChunkExtent>& counts) {
    std::array<double, kChunkExtent> values;
    for (std::size_t x = 0; x < kChunkExtent; ++x)
        values[x] = info.rescaleSlope * static_cast<double>(row[x]) + info.rescaleIntercept;
    counts.fill(0);
    for (const double each : hu)
        for (std::size_t x = 0; x < kChunkExtent; ++x)
            counts[x] = static_cast<std::uint8_t>(counts[x] + (values[x] > each));
}

} // namespace

int bodyLevelOf(const VolumeInfo& info, std::size_t mostSamples) {
    int level = 0;
    while (level + 1 < kLevelCount && cellCount(levelExtent(info.extentVoxels, level)) > mostSamples)
        ++level;
    return level;
}

std::size_t bodyBytes(const glm::ivec3& levelExtent, ValueType type) {
    constexpr std::size_t kSets = 20;
    return kSets * Marks::bytes(levelExtent) +
           std::max({partsBytes(levelExtent), growthBytes(levelExtent), depthBytes(levelExtent)}) +
           cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(type);
}

std::vector<Marks> samplesAbove(std::span<const double> hu, const ChunkSource& source, int level,
                                const BodyGrid& grid) {
    const VolumeInfo& info = source.info();
    std::vector<Marks> marks(hu.size(), Marks(grid.extent));
    constexpr int kChunksPerWord = Marks::kWordBits / kChunkExtent;
    const glm::ivec3 chunks = chunkGrid(info.extentVoxels, level);
    const glm::ivec3 groups((chunks.x + kChunksPerWord - 1) / kChunksPerWord, chunks.y, chunks.z);
    parallelFor(cellCount(groups), grid.threads, [&](std::size_t n) { // threads share no word
        std::vector<std::byte> chunk(source.chunkBytes());
        std::array<std::uint8_t, kChunkExtent> counts{}, flags{};
        const glm::ivec3 group = gridPosition(n, groups);
        for (int inWord = 0; inWord < std::min(kChunksPerWord, chunks.x - group.x * kChunksPerWord);
             ++inWord) {
            const glm::ivec3 at(group.x * kChunksPerWord + inWord, group.y, group.z);
            const glm::ivec3 first = at * kChunkExtent;
            const glm::ivec3 count = glm::min(grid.extent - first, glm::ivec3(kChunkExtent));
            source.readChunk({level, at.x, at.y, at.z}, chunk);
            const std::uint32_t inside = ~std::uint32_t{0} >> (kChunkExtent - count.x);
            withValueType(info.type, [&](auto example) {
                const auto* const values = reinterpret_cast<const decltype(example)*>(chunk.data());
                for (int z = 0; z < count.z; ++z)
                    for (int y = 0; y < count.y; ++y) {
                        countAbove(values + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)), info, hu,
                                   counts);
                        for (std::size_t set = 0; set < hu.size(); ++set) {
                            for (std::size_t x = 0; x < kChunkExtent; ++x)
                                flags[x] = counts[x] > set;
                            const Marks::Word bits = bitsOf(flags) & inside;
                            marks[set].row(marks[set].rowNumber(
                                first.y + y, first.z + z))[static_cast<std::size_t>(group.x)] |=
                                bits << (inWord * kChunkExtent);
                        }
                    }
            });
        }
    });
    return marks;
}

BodyMarks bodyAmong(const Marks& dense, const BodyGrid& grid) {
    const float deepest = largestDepth(dense, grid.spacingMm);
    if (deepest >= kFarAway)
        return {dense}; // no air at all
    const double thickest = std::sqrt(static_cast<double>(deepest));
    const double least = std::min({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z});
    const double ball = std::max(thickest / kBodyOfThickness, 1.01 * least);
    const double thick = thickest / kBodyOfThinnestPart;
    const auto nearAir = [&](double mostMm2) {
        return within(without(Marks::all(grid.extent), dense), grid.spacingMm, mostMm2, grid.threads);
    };
    const Marks core = without(dense, nearAir(ball * ball));
    const Marks deep = without(dense, nearAir(std::nextafter(thick * thick, -1))); // at least so deep
    const Marks kept = chosenParts(core, Connected::throughSlices, deep,
                                   [](const MarkPart& part) { return part.isMeeting; });
    const Marks opened = both(dense, within(kept, grid.spacingMm, ball * ball, grid.threads));
    // Small attached pieces return.
    const Marks pieces = chosenParts(
        without(dense, opened), Connected::throughSlices, besideFaces(opened), [&](const MarkPart& part) {
            return part.isMeeting &&
                   glm::length(glm::dvec3(part.high - part.low) * grid.spacingMm) < thickest;
        });
    return {combined([](Marks::Word a, Marks::Word b) { return a | b; }, opened, pieces), ball};
}

} // namespace tessera
