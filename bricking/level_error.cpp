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

/// What a segment of one length adds for a value: colour times opacity, and opacity.
struct alignas(16) Added {
    float v[4];
};

/// The function, resampled for nearest look-ups. 4096 entries are an eighth of the finest table step or less
/// for the usual tables of 256 and 512 entries; larger tables keep their size up to what stays in a cache.
class SegmentTables {
  public:
    SegmentTables(const TransferTable& table, const VolumeInfo& info)
        : size_(std::clamp<std::size_t>(std::bit_ceil(table.entries.size()), 4096, 16384)) {
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
            made[i] = {{e.r * alpha, e.g * alpha, e.b * alpha, alpha}};
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
    alignas(16) std::array<std::uint32_t, 256> entry;
    const double range = (static_cast<double>(part.hi) - static_cast<double>(part.lo)) / 255;
    const auto per = static_cast<float>(tables.perStored() * range);
    const auto zero = static_cast<float>(tables.perStored() * static_cast<double>(part.lo) + tables.atZero());
    const auto last = static_cast<float>(tables.size() - 1);
    for (std::size_t code = 0; code < entry.size(); ++code) {
        const float at = zero + per * static_cast<float>(code) + 0.5f;
        entry[code] = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(at, 0.0f, last)));
    }
    for (int ray = 0; ray < kRaysPerPart; ++ray) {
        const int axis = part.axis(ray);
        const std::uint8_t* codes =
            part.codes.data() + std::size_t{kSamplesPerRay} * static_cast<std::size_t>(ray);
        for (int level = 0; level < kLevelCount; ++level) {
            const Added* table = tables.at(axis, border[axis], level);
            alignas(16) float sum[4] = {0, 0, 0, 0};
            const int samples = kRaySamples[static_cast<std::size_t>(level)];
            for (int j = 0; j < samples; ++j) {
                const Added& add = table[entry[*codes++]];
                const float through = 1 - sum[3];
                for (int c = 0; c < 4; ++c)
                    sum[c] += through * add.v[c];
            }
            const auto at = static_cast<std::size_t>(level * kRays + firstRay + ray);
            out.r[at] = sum[0];
            out.g[at] = sum[1];
            out.b[at] = sum[2];
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

LevelErrors predictErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                          const VolumeInfo& info, int threads) {
    LevelErrors out;
    out.bricks = brickGrid(info.extentVoxels);
    TESSERA_CHECK(rays.bricks == out.bricks && shows.size() == cellCount(out.bricks));
    out.shows = std::move(shows);
    out.errors.assign(out.shows.size(), {});
    out.biases.assign(out.shows.size(), {});
    const SegmentTables tables(table, info);
    const std::size_t count = out.shows.size();
    const glm::bvec3 cut = glm::notEqual(info.extentVoxels % kBrickExtent, glm::ivec3(0));
    parallelFor((count + kBricksPerTask - 1) / kBricksPerTask, threads, [&](std::size_t task) {
        Colours colours;
        const std::size_t end = std::min(count, (task + 1) * kBricksPerTask);
        for (std::size_t brick = task * kBricksPerTask; brick < end; ++brick) {
            if (!out.shows[brick])
                continue;
            const std::uint32_t row = rays.rowOf[brick];
            TESSERA_CHECK(row != BrickRays::kNoRow);
            const auto nx = static_cast<std::size_t>(out.bricks.x),
                       ny = static_cast<std::size_t>(out.bricks.y);
            const glm::ivec3 at(static_cast<int>(brick % nx), static_cast<int>(brick / nx % ny),
                                static_cast<int>(brick / nx / ny));
            glm::bvec3 border = glm::equal(at, out.bricks - 1);
            for (int axis = 0; axis < 3; ++axis)
                border[axis] = border[axis] && cut[axis];
            const int used = rays.parts * kRaysPerPart;
            for (int part = 0; part < rays.parts; ++part)
                compositePart(decodeRays(rays.part(row, part)), tables, border, part * kRaysPerPart, colours);
            toLuv(colours);
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
                for (std::size_t i = 0; i < static_cast<std::size_t>(used); ++i) {
                    const std::size_t other = level * kRays + i;
                    const float l = colours.r[other] - colours.r[i], u = colours.g[other] - colours.g[i],
                                v = colours.b[other] - colours.b[i];
                    sum += std::sqrt(l * l + u * u + v * v);
                    sumL += l;
                    sumU += u;
                    sumV += v;
                }
                out.errors[brick][level] = sum / static_cast<float>(used);
                out.biases[brick][level] =
                    std::sqrt(sumL * sumL + sumU * sumU + sumV * sumV) / static_cast<float>(used);
            }
        }
    });
    return out;
}

} // namespace tessera
