// bricking/analysis/lumen/quiet_values.cpp: see lumen_values.h. A chunk and two voxels around it are filtered
// twice, row by row, so that compilers vectorise it.
#include "bricking/analysis/lumen/lumen_values.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

namespace tessera {
namespace {

constexpr std::size_t kMostFieldBytes = std::size_t{256} << 20;
constexpr int kPasses = 2;
constexpr int kMostWide = kChunkExtent + 2 * kPasses;
constexpr std::size_t kScratchBytes = 2 * sizeof(float) * kMostWide * kMostWide * kMostWide;
// Differences of values that have full weight, and any weight, in deviations of the noise before each pass.
// The first leaves about two fifths of it.
constexpr std::array<std::array<float, 2>, kPasses> kAlike = {{{2.5F, 4.5F}, {1.2F, 2.4F}}};
constexpr double kReach = 1.2; // standard deviation of the spatial weights, in smallest spacings

struct Neighbour {
    glm::ivec3 step;
    float weight;
};

std::array<Neighbour, 27> neighbourhood(const glm::dvec3& spacingMm) {
    const double reach = kReach * std::min({spacingMm.x, spacingMm.y, spacingMm.z});
    std::array<Neighbour, 27> all;
    for (int i = 0; i < 27; ++i) {
        const glm::ivec3 step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        const glm::dvec3 mm = glm::dvec3(step) * spacingMm / reach;
        all[static_cast<std::size_t>(i)] = {
            step, static_cast<float>(std::exp(-0.5 * (mm.x * mm.x + mm.y * mm.y + mm.z * mm.z)))};
    }
    return all;
}

/// One pass: from a box of `wide` voxels along each edge to one that is a voxel smaller on every side.
void quietenOnce(const float* in, int wide, float* out, const std::array<Neighbour, 27>& neighbours,
                 float inFull, float atAll) {
    const int n = wide - 2;
    const float slope = 1 / (atAll - inFull);
    std::array<float, kMostWide> low, low2, high, high2, sum, weight, own;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y) {
            const auto rowAt = [&](const glm::ivec3& step) {
                return in + (1 + step.x) + wide * ((y + 1 + step.y) + wide * (z + 1 + step.z));
            };
            low.fill(std::numeric_limits<float>::max());
            low2 = low;
            high.fill(std::numeric_limits<float>::lowest());
            high2 = high;
            for (const Neighbour& neighbour : neighbours) {
                if (neighbour.step == glm::ivec3(0))
                    continue;
                const float* row = rowAt(neighbour.step);
                for (std::size_t x = 0; x < static_cast<std::size_t>(n); ++x) {
                    low2[x] = std::min(low2[x], std::max(low[x], row[x]));
                    low[x] = std::min(low[x], row[x]);
                    high2[x] = std::max(high2[x], std::min(high[x], row[x]));
                    high[x] = std::max(high[x], row[x]);
                }
            }
            const float* middle = rowAt(glm::ivec3(0));
            for (std::size_t x = 0; x < static_cast<std::size_t>(n); ++x)
                own[x] = std::min(std::max(middle[x], low2[x]), high2[x]);
            sum = own;
            weight.fill(1);
            for (const Neighbour& neighbour : neighbours) {
                if (neighbour.step == glm::ivec3(0))
                    continue;
                const float* row = rowAt(neighbour.step);
                for (std::size_t x = 0; x < static_cast<std::size_t>(n); ++x) {
                    const float alike =
                        std::min(1.0F, std::max(0.0F, (atAll - std::abs(row[x] - own[x])) * slope));
                    const float w = alike * neighbour.weight;
                    sum[x] += w * row[x];
                    weight[x] += w;
                }
            }
            float* to = out + n * (y + n * z);
            for (std::size_t x = 0; x < static_cast<std::size_t>(n); ++x)
                to[x] = sum[x] / weight[x];
        }
}

/// Voxels of a box, as floats; clamped at the volume's edge.
void copyBox(BrickCache& cache, const VolumeInfo& info, const glm::ivec3& corner, int wide, float* out) {
    const glm::ivec3 last = info.extentVoxels - 1;
    const auto clamped = [&](int at, int axis) { return std::clamp(corner[axis] + at, 0, last[axis]); };
    // by chunks, so that one is held at a time
    std::array<std::vector<std::array<int, 2>>, 3> runs; // along each axis, first and end with one chunk
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < wide; ++i) {
            auto& ofAxis = runs[static_cast<std::size_t>(axis)];
            if (!ofAxis.empty() && clamped(i, axis) >> 5 == clamped(i - 1, axis) >> 5)
                ofAxis.back()[1] = i + 1;
            else
                ofAxis.push_back({i, i + 1});
        }
    for (const auto& rz : runs[2])
        for (const auto& ry : runs[1])
            for (const auto& rx : runs[0]) {
                const ChunkPointer chunk =
                    cache.get({0, clamped(rx[0], 0) >> 5, clamped(ry[0], 1) >> 5, clamped(rz[0], 2) >> 5});
                withValueType(info.type, [&](auto typed) {
                    using Value = decltype(typed);
                    for (int z = rz[0]; z < rz[1]; ++z)
                        for (int y = ry[0]; y < ry[1]; ++y) {
                            const std::byte* row =
                                chunk->bytes.get() +
                                sizeof(Value) * static_cast<std::size_t>(
                                                    kChunkExtent * ((clamped(y, 1) & 31) +
                                                                    kChunkExtent * (clamped(z, 2) & 31)));
                            for (int x = rx[0]; x < rx[1]; ++x) {
                                std::memcpy(&typed,
                                            row +
                                                sizeof(Value) * static_cast<std::size_t>(clamped(x, 0) & 31),
                                            sizeof typed);
                                out[x + wide * (y + wide * z)] = static_cast<float>(typed);
                            }
                        }
                });
            }
}

} // namespace

QuietValues::QuietValues(BrickCache& loud, const VolumeInfo& info, double deviation, MemoryBudget& ram,
                         int readers)
    : loud_(loud), info_(info), deviation_(deviation / std::abs(info.rescaleSlope)),
      charge_(ram.charge(kScratchBytes * static_cast<std::size_t>(readers > 0 ? readers : defaultThreads()),
                         "denoising")) {
    TESSERA_CHECK(deviation > 0);
}

void QuietValues::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    TESSERA_CHECK(key.level == 0 && out.size() == chunkBytes());
    const std::array<Neighbour, 27> neighbours = neighbourhood(info_.spacingMm());
    const auto a = std::make_unique_for_overwrite<float[]>(kMostWide * kMostWide * kMostWide),
               b = std::make_unique_for_overwrite<float[]>(kMostWide * kMostWide * kMostWide);
    copyBox(loud_, info_, glm::ivec3(key.i, key.j, key.k) * kChunkExtent - kPasses, kMostWide, a.get());
    float *from = a.get(), *to = b.get();
    const auto deviation = static_cast<float>(deviation_);
    for (int pass = 0; pass < kPasses; ++pass) {
        const auto& [inFull, atAll] = kAlike[static_cast<std::size_t>(pass)];
        quietenOnce(from, kMostWide - 2 * pass, to, neighbours, inFull * deviation, atAll * deviation);
        std::swap(from, to);
    }
    withValueType(info_.type, [&](auto typed) {
        using Value = decltype(typed);
        for (std::size_t i = 0; i < out.size() / sizeof(Value); ++i) {
            if constexpr (std::is_integral_v<Value>)
                typed = static_cast<Value>(std::lround(from[i])); // a mean is within the range of its values
            else
                typed = from[i];
            std::memcpy(out.data() + sizeof(Value) * i, &typed, sizeof typed);
        }
    });
}

LumenField::LumenField(const ChunkSource& source, MemoryBudget& ram, int threads)
    : info_(source.info()), ram_(ram), threads_(threads), loud_(source, ram, cacheBytes(2), threads) {}

/// @param per thread: those that fill it, and readers that hold a chunk each
std::size_t LumenField::cacheBytes(int times) const {
    const auto readers = static_cast<std::size_t>(threads_ > 0 ? threads_ : defaultThreads());
    const std::size_t chunk = cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info_.type);
    return std::max(std::min(kMostFieldBytes, ram_.freeBytes() / 4),
                    BrickCache::floorBytes(info_, threads_) +
                        static_cast<std::size_t>(times - 1) * readers * chunk);
}

void LumenField::quieten(double deviation) {
    TESSERA_CHECK(!quiet_);
    quiet_.emplace(loud_, info_, deviation, ram_, threads_);
    quietCache_.emplace(*quiet_, ram_, cacheBytes(1), threads_);
}

void LumenField::unquieten() {
    quietCache_.reset();
    quiet_.reset();
}

} // namespace tessera
