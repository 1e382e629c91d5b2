// bricking/level_error.cpp: see level_error.h. What costs time is compositing 512 samples a brick: one
// look-up each, in tables made for the few lengths that segments have, and the conversion to L*u*v*, which
// the compiler turns into vector code because it is written over arrays.
#include "bricking/level_error.h"

#include "core/error.h"
#include "core/threads.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tessera {
namespace {

constexpr std::size_t kBricksPerTask = 256;
constexpr int kRays = kBrickRayParts * kRaysPerPart;
constexpr std::size_t kColours = std::size_t{kRays * kLevelCount};

/// What a segment of one length adds for a value: colour times opacity, and opacity. A vector of the
/// compilers (GCC and Clang), because neither makes one of four floats by itself here, and this loop is half
/// of the time.
using Added = float __attribute__((vector_size(16)));

/// The function, resampled for nearest look-ups. 4096 entries are an eighth of the finest table step or less
/// for the usual tables of 256 and 512 entries; larger tables keep their size up to what stays in a cache.
class SegmentTables {
  public:
    static constexpr std::size_t kMostEntries = 16384;
    static constexpr std::size_t kMostBytes = 18 * kMostEntries * sizeof(Added); // 3 axes, 2 rests, 3 lengths
    SegmentTables(const TransferTable& table, const VolumeInfo& info)
        : size_(std::clamp<std::size_t>(std::bit_ceil(table.entries.size()), 4096, kMostEntries)) {
        const double entries = static_cast<double>(table.entries.size() - 1);
        const double first = table.firstValue, span = entries / static_cast<double>(table.entriesPerValue);
        // index = round((slope * stored + intercept - first) / span * (size - 1))
        const double scale = static_cast<double>(size_ - 1) / span;
        perStored_ = info.rescaleSlope * scale;
        atZero_ = (info.rescaleIntercept - first) * scale;
        const glm::dvec3 spacing = info.spacingMm();
        for (int axis = 0; axis < 3; ++axis)
            for (const bool border : {false, true}) {
                const int rest = info.extentVoxels[axis] % kBrickExtent;
                const int voxels = border && rest > 0 ? rest : kBrickExtent;
                for (int level = 0; level < kLevelCount; ++level)
                    tables_[slot(axis, border, level)] = tableFor(
                        table, spacing[axis] * voxels / kRaySamples[static_cast<std::size_t>(level)]);
            }
    }
    /// Index of a value in any of the tables, before rounding and clamping: a * stored + b.
    double perStored() const { return perStored_; }
    double atZero() const { return atZero_; }
    std::size_t size() const { return size_; }
    const Added* at(int axis, bool border, int level) const {
        return made_[tables_[slot(axis, border, level)]].data();
    }

  private:
    static std::size_t slot(int axis, bool border, int level) {
        return static_cast<std::size_t>((axis * 2 + (border ? 1 : 0)) * kLevelCount + level);
    }
    /// Place of the table of a length; equal lengths share one.
    std::size_t tableFor(const TransferTable& table, double lengthMm) {
        for (std::size_t i = 0; i < lengths_.size(); ++i)
            if (std::abs(lengths_[i] - lengthMm) <= 1e-9 * lengthMm)
                return i;
        std::vector<Added> made(size_);
        for (std::size_t i = 0; i < size_; ++i) {
            const double at = static_cast<double>(i) * static_cast<double>(table.entries.size() - 1) /
                              static_cast<double>(size_ - 1);
            const std::size_t left = std::min(static_cast<std::size_t>(at), table.entries.size() - 2);
            const glm::vec4 a = table.entries[left], b = table.entries[left + 1];
            const glm::vec4 e = a + static_cast<float>(at - static_cast<double>(left)) * (b - a);
            const float alpha = static_cast<float>(-std::expm1(-static_cast<double>(e.a) * lengthMm));
            made[i] = Added{e.r * alpha, e.g * alpha, e.b * alpha, alpha};
        }
        lengths_.push_back(lengthMm);
        made_.push_back(std::move(made));
        return made_.size() - 1;
    }

    std::size_t size_;
    double perStored_ = 0, atZero_ = 0;
    std::array<std::size_t, std::size_t{6 * kLevelCount}> tables_{};
    std::vector<double> lengths_;
    std::vector<std::vector<Added>> made_;
};

/// Colours of all rays at all levels, as arrays: [level][ray].
struct Colours {
    alignas(16) std::array<float, kColours> r{}, g{}, b{};
    std::array<float, kRays> alpha{}; // at level 0
};

/// Cube root of a number in [0, 2]: a guess from the bits and two Newton steps; below 2e-6 relative.
inline float cubeRoot(float x) {
    const float safe = std::max(x, 1e-12f);
    const auto bits = static_cast<float>(std::bit_cast<std::int32_t>(safe));
    float y = std::bit_cast<float>(static_cast<std::int32_t>(bits * (1.0f / 3)) + 0x2a514067);
    y = (2 * y + safe / (y * y)) * (1.0f / 3);
    y = (2 * y + safe / (y * y)) * (1.0f / 3);
    return y;
}

/// luvFromLinear of core/colour.h in float, over all colours at once; in place.
void toLuv(Colours& c) {
    constexpr float xn = 0.9504700f, yn = 1.0000001f, zn = 1.0888300f, sn = xn + 15 * yn + 3 * zn;
    constexpr float un = 4 * xn / sn, vn = 9 * yn / sn, kappa = 24389.0f / 27, epsilon = 216.0f / 24389;
    for (std::size_t i = 0; i < kColours; ++i) {
        const float r = std::min(c.r[i], 1.0f), g = std::min(c.g[i], 1.0f), b = std::min(c.b[i], 1.0f);
        const float x = 0.4124564f * r + 0.3575761f * g + 0.1804375f * b;
        const float y = 0.2126729f * r + 0.7151522f * g + 0.0721750f * b;
        const float z = 0.0193339f * r + 0.1191920f * g + 0.9503041f * b;
        const float inverse = 1 / std::max(x + 15 * y + 3 * z, 1e-20f);
        const float curved = 116 * cubeRoot(y) - 16, straight = kappa * y;
        const float lightness = y > epsilon ? curved : straight;
        c.r[i] = lightness;
        c.g[i] = 13 * lightness * (4 * x * inverse - un);
        c.b[i] = 13 * lightness * (9 * y * inverse - vn);
    }
}

/// Composites the rays of one part at all levels, front to back, before black.
void compositePart(const BrickRayPart& part, const SegmentTables& tables, const glm::bvec3& border,
                   int firstRay, Colours& out) {
    // Nearest entries of all 256 codes: less work than one conversion per sample.
    alignas(16) std::array<std::int32_t, 256> entry;
    const double range = (static_cast<double>(part.hi) - static_cast<double>(part.lo)) / 255;
    const auto per = static_cast<float>(tables.perStored() * range);
    const auto zero = static_cast<float>(tables.perStored() * static_cast<double>(part.lo) + tables.atZero());
    const auto last = static_cast<float>(tables.size() - 1);
    for (int i = 0; i < 256; ++i) {
        const auto code = static_cast<std::size_t>(i);
        const float at = std::min(std::max(zero + per * static_cast<float>(i), 0.0f), last) + 0.5f;
        entry[code] = static_cast<std::int32_t>(at);
    }
    for (int ray = 0; ray < kRaysPerPart; ++ray) {
        const int axis = part.axis(ray);
        const std::uint8_t* codes =
            part.codes.data() + std::size_t{kSamplesPerRay} * static_cast<std::size_t>(ray);
        for (int level = 0; level < kLevelCount; ++level) {
            const Added* table = tables.at(axis, border[axis], level);
            Added sum = {0, 0, 0, 0};
            const int samples = kRaySamples[static_cast<std::size_t>(level)];
            for (int j = 0; j < samples; ++j)
                sum += (1 - sum[3]) * table[static_cast<std::size_t>(entry[*codes++])];
            const auto at = static_cast<std::size_t>(level * kRays + firstRay + ray);
            out.r[at] = sum[0];
            out.g[at] = sum[1];
            out.b[at] = sum[2];
            if (level == 0)
                out.alpha[at] = sum[3];
        }
    }
}

} // namespace

std::span<const std::uint8_t, kBrickRayBytes> BrickRays::part(std::uint32_t row, int part) const {
    const std::size_t at = row % kRowsPerPage * rowBytes() + static_cast<std::size_t>(part) * kBrickRayBytes;
    return std::span<const std::uint8_t, kBrickRayBytes>(pages[row / kRowsPerPage].data() + at,
                                                         kBrickRayBytes);
}

std::span<std::uint8_t> BrickRays::row(std::uint32_t row) {
    return std::span(pages[row / kRowsPerPage]).subspan(row % kRowsPerPage * rowBytes(), rowBytes());
}

std::size_t predictErrorsBytes(std::size_t bricks) {
    // The errors and, while they are smoothed, the errors as they were; flags; the tables of all lengths.
    return bricks * (3 * sizeof(LevelErrors::errors[0]) + sizeof(float) + 1) + SegmentTables::kMostBytes;
}

LevelErrors rayErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                      const VolumeInfo& info, int threads) {
    LevelErrors out;
    out.bricks = brickGrid(info.extentVoxels);
    TESSERA_CHECK(rays.bricks == out.bricks && shows.size() == cellCount(out.bricks));
    out.shows = std::move(shows);
    out.errors.assign(out.shows.size(), {});
    out.biases.assign(out.shows.size(), {});
    out.transmittances.assign(out.shows.size(), 1.0f);
    const SegmentTables tables(table, info);
    const std::size_t count = out.shows.size();
    const int used = rays.parts * kRaysPerPart;
    std::array<float, kRays> weights{};
    for (int i = 0; i < used; ++i)
        weights[static_cast<std::size_t>(i)] =
            (i % kRaysPerPart == kRayGroups ? kExtremeWeight : (1 - kExtremeWeight) / kRayGroups) /
            static_cast<float>(rays.parts);
    const glm::bvec3 cut = glm::notEqual(info.extentVoxels % kBrickExtent, glm::ivec3(0));
    parallelFor((count + kBricksPerTask - 1) / kBricksPerTask, threads, [&](std::size_t task) {
        Colours colours;
        const std::size_t end = std::min(count, (task + 1) * kBricksPerTask);
        for (std::size_t brick = task * kBricksPerTask; brick < end; ++brick) {
            if (!out.shows[brick])
                continue;
            const std::uint32_t row = rays.rowOf[brick];
            TESSERA_CHECK(row != BrickRays::kNoRow);
            const glm::ivec3 at = gridPosition(brick, out.bricks);
            glm::bvec3 border = glm::equal(at, out.bricks - 1);
            for (int axis = 0; axis < 3; ++axis)
                border[axis] = border[axis] && cut[axis];
            for (int part = 0; part < rays.parts; ++part)
                compositePart(decodeRays(rays.part(row, part)), tables, border, part * kRaysPerPart, colours);
            toLuv(colours);
            float through = 0;
            for (std::size_t i = 0; i < static_cast<std::size_t>(used); ++i)
                through += weights[i] * (1 - colours.alpha[i]);
            out.transmittances[brick] = std::clamp(through, 0.0f, 1.0f);
            const auto isBlack = [&](std::size_t i) { return colours.r[i] == 0; }; // lightness
            std::size_t black = 0;
            while (black < static_cast<std::size_t>(used) && isBlack(black))
                ++black;
            if (black == static_cast<std::size_t>(used)) { // what it shows, all its rays missed
                for (int level = 1; level < kLevelCount; ++level)
                    out.errors[brick][static_cast<std::size_t>(level)] =
                        out.biases[brick][static_cast<std::size_t>(level)] =
                            100.0f / static_cast<float>(used) * static_cast<float>(level) / (kLevelCount - 1);
                continue;
            }
            for (std::size_t level = 1; level < kLevelCount; ++level) {
                float sum = 0, sumL = 0, sumU = 0, sumV = 0;
                for (int i = 0; i < used; ++i) {
                    const std::size_t a = static_cast<std::size_t>(i), b = level * kRays + a;
                    const float l = colours.r[b] - colours.r[a], u = colours.g[b] - colours.g[a],
                                v = colours.b[b] - colours.b[a];
                    sum += weights[a] * std::sqrt(l * l + u * u + v * v);
                    sumL += weights[a] * l;
                    sumU += weights[a] * u;
                    sumV += weights[a] * v;
                }
                out.errors[brick][level] = sum;
                out.biases[brick][level] = std::sqrt(sumL * sumL + sumU * sumU + sumV * sumV);
            }
        }
    });
    return out;
}

void smoothErrors(LevelErrors& errors, int threads) {
    const std::size_t count = errors.errors.size(), tasks = (count + kBricksPerTask - 1) / kBricksPerTask;
    const std::vector<std::array<float, kLevelCount>> own = errors.errors;
    const glm::ivec3 bricks = errors.bricks;
    using Sums = std::array<double, kLevelCount>;
    std::vector<Sums> sums(tasks, Sums{}); // added up in order afterwards: the same for any number of threads
    parallelFor(tasks, threads, [&](std::size_t task) {
        const std::size_t end = std::min(count, (task + 1) * kBricksPerTask);
        for (std::size_t brick = task * kBricksPerTask; brick < end; ++brick) {
            if (!errors.shows[brick])
                continue;
            const glm::ivec3 at = gridPosition(brick, bricks);
            std::array<float, kLevelCount> around{};
            float neighbours = 0;
            for (int axis = 0; axis < 3; ++axis)
                for (const int step : {-1, 1}) {
                    glm::ivec3 beside = at;
                    beside[axis] += step;
                    if (beside[axis] < 0 || beside[axis] >= bricks[axis])
                        continue;
                    const std::size_t other = linearIndex(beside, bricks);
                    if (!errors.shows[other])
                        continue;
                    ++neighbours;
                    for (std::size_t level = 1; level < kLevelCount; ++level)
                        around[level] += own[other][level];
                }
            std::array<float, kLevelCount>& mine = errors.errors[brick];
            for (std::size_t level = 1; level < kLevelCount; ++level) {
                if (neighbours > 0)
                    mine[level] =
                        kOwnShare * own[brick][level] + (1 - kOwnShare) * around[level] / neighbours;
                sums[task][level] += static_cast<double>(mine[level]);
            }
        }
    });
    Sums all{};
    double total = 0;
    for (const Sums& part : sums)
        for (std::size_t level = 1; level < kLevelCount; ++level) {
            all[level] += part[level];
            total += part[level];
        }
    if (!(total > 0))
        return;
    parallelFor(tasks, threads, [&](std::size_t task) {
        const std::size_t end = std::min(count, (task + 1) * kBricksPerTask);
        for (std::size_t brick = task * kBricksPerTask; brick < end; ++brick) {
            std::array<float, kLevelCount>& mine = errors.errors[brick];
            float sum = 0;
            for (std::size_t level = 1; level < kLevelCount; ++level)
                sum += mine[level];
            for (std::size_t level = 1; level < kLevelCount; ++level)
                mine[level] = (1 - kProfileShare) * mine[level] +
                              kProfileShare * sum * static_cast<float>(all[level] / total);
        }
    });
}

LevelErrors predictErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                          const VolumeInfo& info, int threads) {
    LevelErrors errors = rayErrors(rays, std::move(shows), table, info, threads);
    smoothErrors(errors, threads);
    return errors;
}

} // namespace tessera
