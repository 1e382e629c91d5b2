// bricking/export/box_source.cpp: see box_source.h.
#include "bricking/export/box_source.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace tessera {
namespace {

std::string boxText(const glm::dvec3& low, const glm::dvec3& high) {
    std::string text;
    for (const double number : {low.x, high.x, low.y, high.y, low.z, high.z})
        text += (text.empty() ? "" : ",") + numberText(number, 6);
    return text;
}

void requireLevel(int level) {
    if (level < 0 || level >= kLevelCount)
        throw badFile("--level", "a level from 0 (finest) to " + std::to_string(kLevelCount - 1),
                      std::to_string(level));
}

std::size_t workers(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}

} // namespace

LevelBox wholeLevel(const VolumeInfo& info, int level) {
    requireLevel(level);
    return {level, glm::ivec3(0), levelExtent(info.extentVoxels, level)};
}

LevelBox levelBoxOf(const VolumeInfo& info, int level, const glm::dvec3& low, const glm::dvec3& high,
                    const std::string& option) {
    const LevelBox whole = wholeLevel(info, level);
    const glm::dvec3 extent(info.extentVoxels);
    const glm::dvec3 from = glm::max(low, glm::dvec3(0)), to = glm::min(high, extent);
    for (int axis = 0; axis < 3; ++axis)
        if (!(low[axis] < high[axis]))
            throw badFile(option, "a box whose second corner is above the first one", boxText(low, high));
    for (int axis = 0; axis < 3; ++axis)
        if (!(from[axis] < to[axis]))
            throw badFile(option, "a box within " + boxText(glm::dvec3(0), extent) + " (voxels)",
                          boxText(low, high));
    // A bound that a rounded affine puts beside a voxel's face is that face.
    constexpr double kRounding = 1e-6;
    const double step = std::ldexp(1.0, level);
    LevelBox box = whole;
    box.low = glm::clamp(glm::ivec3(glm::floor((from + kRounding) / step)), glm::ivec3(0), whole.high - 1);
    box.high = glm::min(glm::ivec3(glm::ceil((to - kRounding) / step)), whole.high);
    box.high = glm::max(box.high, box.low + 1); // of a box thinner than the rounding
    return box;
}

PatientBox voxelBoxAround(const VolumeInfo& info, const PatientBox& mm) {
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    PatientBox box{glm::dvec3(1e300), glm::dvec3(-1e300)};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 at((corner & 1) != 0 ? mm.high.x : mm.low.x,
                            (corner & 2) != 0 ? mm.high.y : mm.low.y,
                            (corner & 4) != 0 ? mm.high.z : mm.low.z, 1);
        const glm::dvec3 voxel(voxelFromPatient * at);
        box.low = glm::min(box.low, voxel), box.high = glm::max(box.high, voxel);
    }
    return box;
}

VolumeInfo infoOfBox(const VolumeInfo& whole, const LevelBox& box) {
    VolumeInfo info = whole;
    info.extentVoxels = box.extent();
    const double step = std::ldexp(1.0, box.level);
    if (box.level != 0 || box.low != glm::ivec3(0)) {
        const glm::dmat4 voxelFromSample =
            glm::scale(glm::translate(glm::dmat4(1), step * glm::dvec3(box.low)), glm::dvec3(step));
        info.patientFromVoxel = whole.patientFromVoxel * voxelFromSample;
    }
    if (box.level != 0 || box.extent() != whole.extentVoxels)
        info.nonFiniteVoxels = info.clampedVoxels = 0, info.filePart.reset();
    return info;
}

BoxSource::BoxSource(const ChunkSource& source, const LevelBox& box, MemoryBudget& ram, int threads)
    : source_(source), box_(box), info_(infoOfBox(source.info(), box)), threads_(threads),
      buffers_(ram, workers(threads), source.chunkBytes(), "decoding chunks") {}

std::string BoxSource::describe() const {
    const glm::ivec3 n = info_.extentVoxels;
    return std::to_string(n.x) + " x " + std::to_string(n.y) + " x " + std::to_string(n.z) +
           " voxels of level " + std::to_string(box_.level);
}

int BoxSource::slicesOfChunks() const {
    const int z = box_.low.z + next_;
    return std::min(box_.high.z, (z / kChunkExtent + 1) * kChunkExtent) - z;
}

void BoxSource::readSlices(int count, std::span<std::byte> out) {
    TESSERA_CHECK(count >= 0 && next_ + count <= info_.extentVoxels.z);
    TESSERA_CHECK(out.size() == static_cast<std::size_t>(count) * sliceBytesOf(info_));
    if (count == 0)
        return;
    const glm::ivec3 low(box_.low.x, box_.low.y, box_.low.z + next_),
        high(box_.high.x, box_.high.y, box_.low.z + next_ + count);
    const glm::ivec3 first = low / kChunkExtent, chunks = ceilDiv(high, kChunkExtent) - first;
    const std::size_t bytes = bytesPerValue(info_.type);
    const glm::ivec3 extent = high - low;
    parallelFor(cellCount(chunks), threads_, [&](std::size_t n) {
        const BufferPool::Lease lease(buffers_);
        const glm::ivec3 chunk = first + gridPosition(n, chunks);
        source_.readChunk({box_.level, chunk.x, chunk.y, chunk.z}, lease.bytes());
        const glm::ivec3 corner = chunk * kChunkExtent, from = glm::max(low, corner),
                         to = glm::min(high, corner + kChunkExtent);
        const std::size_t rowBytes = static_cast<std::size_t>(to.x - from.x) * bytes;
        for (int z = from.z; z < to.z; ++z)
            for (int y = from.y; y < to.y; ++y)
                std::memcpy(out.data() + bytes * linearIndex(glm::ivec3(from.x, y, z) - low, extent),
                            lease.bytes().data() + bytes * linearIndex(glm::ivec3(from.x, y, z) - corner,
                                                                       glm::ivec3(kChunkExtent)),
                            rowBytes);
    });
    next_ += count;
}

} // namespace tessera
