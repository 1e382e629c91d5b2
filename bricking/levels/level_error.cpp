// bricking/levels/level_error.cpp: see level_error.h. Time goes into compositing 1728 samples per brick, with
// one lookup each (except for narrow functions), in tables for the few lengths of segments. Vectors are
// compiler extensions (GCC and Clang), because neither vectorises these loops well by itself.
#include "bricking/levels/level_error.h"

#include "bricking/levels/ray_compositing.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "core/base/volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

namespace tessera {
namespace {

constexpr std::size_t kBricksPerTask = 256;
constexpr int kRays = kBrickRayParts * kRaysPerPart;
constexpr std::size_t kColours = std::size_t{kRays * kLevelCount};
constexpr std::size_t kSegmentsPerRay = 72;

/// Colours of all rays at all levels, as arrays: [level][ray].
struct Colours {
    alignas(16) std::array<float, kColours> r{}, g{}, b{};
    std::array<float, kRays> light{}; // transmittance at level 0
};

using Bits = std::int32_t __attribute__((vector_size(16)));

/// Cube roots of numbers in [0, 2]: a guess from the bits and a step of Halley's method; below 2e-5 relative.
inline Added cubeRoot(Added x) {
    const Added safe = x > 1e-12f ? x : Added{} + 1e-12f;
    const Added bits = __builtin_convertvector(std::bit_cast<Bits>(safe), Added);
    const Added y = std::bit_cast<Added>(__builtin_convertvector(bits * (1.0f / 3), Bits) + 0x2a514067);
    const Added cube = y * y * y;
    return y * (cube + 2 * safe) / (2 * cube + safe);
}

/// luvFromLinear of core/image/colour.h in float, over all colours at once; in place.
void toLuv(Colours& c) {
    constexpr float xn = 0.9504700f, yn = 1.0000001f, zn = 1.0888300f, sn = xn + 15 * yn + 3 * zn;
    constexpr float un = 4 * xn / sn, vn = 9 * yn / sn, kappa = 24389.0f / 27, epsilon = 216.0f / 24389;
    constexpr std::size_t kLanes = sizeof(Added) / sizeof(float);
    static_assert(kColours % kLanes == 0);
    const auto atMostOne = [](Added v) { return v < 1.0f ? v : Added{} + 1.0f; };
    for (std::size_t i = 0; i < kColours; i += kLanes) {
        Added r, g, b;
        std::memcpy(&r, &c.r[i], sizeof r);
        std::memcpy(&g, &c.g[i], sizeof g);
        std::memcpy(&b, &c.b[i], sizeof b);
        r = atMostOne(r);
        g = atMostOne(g);
        b = atMostOne(b);
        const Added x = 0.4124564f * r + 0.3575761f * g + 0.1804375f * b;
        const Added y = 0.2126729f * r + 0.7151522f * g + 0.0721750f * b;
        const Added z = 0.0193339f * r + 0.1191920f * g + 0.9503041f * b;
        const Added sum = x + 15 * y + 3 * z;
        const Added inverse = 1.0f / (sum > 1e-20f ? sum : Added{} + 1e-20f);
        const Added curved = 116 * cubeRoot(y) - 16, straight = kappa * y;
        const Added lightness = y > epsilon ? curved : straight;
        const Added u = 13 * lightness * (4 * x * inverse - un);
        const Added v = 13 * lightness * (9 * y * inverse - vn);
        std::memcpy(&c.r[i], &lightness, sizeof lightness);
        std::memcpy(&c.g[i], &u, sizeof u);
        std::memcpy(&c.b[i], &v, sizeof v);
    }
}

/// Twice as many samples, each a quarter of the way from one to its neighbour; at the ends as they are.
template <std::size_t n> void doubled(const std::uint8_t* in, std::uint8_t* out) {
    for (std::size_t j = 0; j < n; ++j) {
        const int here = 3 * in[j] + 2, before = in[j > 0 ? j - 1 : j], after = in[j + 1 < n ? j + 1 : j];
        out[2 * j] = static_cast<std::uint8_t>((here + before) / 4);
        out[2 * j + 1] = static_cast<std::uint8_t>((here + after) / 4);
    }
}

/// Codes of a ray's segments, [level][segment], from those of its samples.
void segmentCodes(const std::uint8_t* in, std::uint8_t* out) {
    static_assert(kRaySamples == std::array<int, kLevelCount>{16, 16, 8, 4, 2, 2});
    static_assert(kSegments == std::array<int, kLevelCount>{16, 16, 16, 8, 8, 8});
    std::copy(in, in + 32, out);
    doubled<8>(in + 32, out + 32);
    doubled<4>(in + 40, out + 48);
    for (int level = 4; level < kLevelCount; ++level) {
        std::array<std::uint8_t, 4> half;
        doubled<2>(in + 44 + 2 * (level - 4), half.data());
        doubled<4>(half.data(), out + 56 + 8 * (level - 4));
    }
}

/// Place of a ray's colour in Colours.
std::size_t placeOf(int level, int partIndex, int ray) {
    return static_cast<std::size_t>((level * kBrickRayParts + partIndex) * kRaysPerPart + ray);
}

/// compositePart() for narrow functions, and for those with gradient opacity.
/// @param grades  per mm
void compositeNarrowPart(const BrickRayPart& part, int partIndex, NarrowCompositor& compositor,
                         const GradientOpacity& grades, const VolumeInfo& info, const glm::bvec3& border,
                         Colours& out) {
    compositor.setPart(part);
    const double perCode =
        (static_cast<double>(part.hi) - static_cast<double>(part.lo)) / 255 * std::abs(info.rescaleSlope);
    std::array<double, 16> factors{};
    for (int ray = 0; ray < kRaysPerPart; ++ray) {
        const int axis = part.axis(ray);
        std::array<std::uint8_t, kSegmentsPerRay> codes;
        segmentCodes(part.codes.data() + static_cast<std::size_t>(ray * kSamplesPerRay), codes.data());
        std::size_t first = 0;
        for (int level = 0; level < kLevelCount; ++level) {
            const auto segments = static_cast<std::size_t>(kSegments[static_cast<std::size_t>(level)]);
            const auto begin = codes.begin() + static_cast<std::ptrdiff_t>(first);
            first += segments;
            if (seenFromItsEnd(partIndex, ray))
                std::reverse(begin, codes.begin() + static_cast<std::ptrdiff_t>(first));
            const auto along = std::span(codes).subspan(first - segments, segments);
            const double mm = segmentMm(info, axis, border[axis], level);
            std::span<double> byGradient;
            if (!grades.isOne()) {
                byGradient = std::span(factors).first(segments);
                gradedFactors(grades, along, level, perCode, mm, byGradient);
            }
            const glm::dvec4 colour = compositor.composite(along, mm, byGradient);
            const std::size_t to = placeOf(level, partIndex, ray);
            out.r[to] = static_cast<float>(colour.r);
            out.g[to] = static_cast<float>(colour.g);
            out.b[to] = static_cast<float>(colour.b);
            if (level == 0)
                out.light[to] = static_cast<float>(colour.a);
        }
    }
}

/// Composites the rays of one part at all levels, front to back, on black.
void compositePart(const BrickRayPart& part, int partIndex, const SegmentTables& tables,
                   const glm::bvec3& border, Colours& out) {
    // Nearest entries of all 256 codes: less work than one conversion per sample.
    alignas(16) std::array<std::int32_t, 256> entry;
    const double range = (static_cast<double>(part.hi) - static_cast<double>(part.lo)) / 255;
    const auto per = static_cast<float>(tables.perStored() * range);
    const auto zero = static_cast<float>(tables.perStored() * static_cast<double>(part.lo) + tables.atZero());
    const auto last = static_cast<float>(tables.size() - 1);
    for (int i = 0; i < 256; ++i) {
        const auto code = static_cast<std::size_t>(i);
        float place = zero + per * static_cast<float>(i);
        if (!std::isfinite(place)) // beside fill values near the largest float
            place = static_cast<float>(
                std::clamp(tables.perStored() * std::lerp(static_cast<double>(part.lo),
                                                          static_cast<double>(part.hi), i / 255.0) +
                               tables.atZero(),
                           0.0, static_cast<double>(last)));
        const float at = std::min(std::max(place, 0.0f), last) + 0.5f;
        entry[code] = static_cast<std::int32_t>(at);
    }
    for (int ray = 0; ray < kRaysPerPart; ++ray) {
        const int axis = part.axis(ray);
        std::array<std::uint8_t, kSegmentsPerRay> codes;
        segmentCodes(part.codes.data() + static_cast<std::size_t>(ray * kSamplesPerRay), codes.data());
        const bool fromItsEnd = seenFromItsEnd(partIndex, ray);
        // Three levels at a time, because each step of a ray depends on the transmittance of the last one.
        for (int level = 0; level < kLevelCount; level += 3) {
            const int segments = kSegments[static_cast<std::size_t>(level)];
            const std::uint8_t* code = codes.data() + level * kSegments[0] + (fromItsEnd ? segments - 1 : 0);
            const int step = fromItsEnd ? -1 : 1;
            const std::array<const Added*, 3> table = {tables.at(axis, border[axis], level),
                                                       tables.at(axis, border[axis], level + 1),
                                                       tables.at(axis, border[axis], level + 2)};
            std::array<Added, 3> sum{}, light = {Added{} + 1, Added{} + 1, Added{} + 1};
            for (int j = 0; j < segments; ++j, code += step)
                for (std::size_t n = 0; n < 3; ++n) {
                    const Added added = table[n][entry[code[n * static_cast<std::size_t>(segments)]]];
                    sum[n] += light[n] * added;
                    light[n] *= added[3];
                }
            for (std::size_t n = 0; n < 3; ++n) {
                const std::size_t to = placeOf(level + static_cast<int>(n), partIndex, ray);
                out.r[to] = sum[n][0];
                out.g[to] = sum[n][1];
                out.b[to] = sum[n][2];
            }
            if (level == 0)
                out.light[placeOf(0, partIndex, ray)] = light[0][3];
        }
    }
}

/// hi - lo of the parts of all visible bricks.
std::vector<float> rangesOf(const BrickRays& rays, const std::vector<std::uint8_t>& shows) {
    std::vector<float> ranges;
    for (std::size_t brick = 0; brick < shows.size(); ++brick) {
        if (!shows[brick])
            continue;
        TESSERA_CHECK(rays.rowOf[brick] != BrickRays::kNoRow);
        ranges.push_back(rangeOfRays(rays.part(rays.rowOf[brick], 0)));
    }
    return ranges;
}

} // namespace

std::size_t predictErrorsBytes(std::size_t bricks) {
    // The errors and, during smoothing, a copy of them; flags; the tables of all lengths, or for narrow
    // functions their sums, which are smaller.
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
    const std::size_t count = out.shows.size();
    // One of the two is there.
    std::optional<FunctionSums> sums(table);
    std::optional<SegmentTables> tables;
    const GradientOpacity grades = table.gradientOpacity.perMm(meanSpacingMm(info));
    if (grades.isOne() && !isNarrow(*sums, table, info, rangesOf(rays, out.shows))) {
        sums.reset();
        tables.emplace(table, info);
    }
    const int used = rays.parts * kRaysPerPart;
    std::array<float, kRays> weights{};
    for (int i = 0; i < used; ++i)
        weights[static_cast<std::size_t>(i)] =
            (i % kRaysPerPart == kRayGroups ? kExtremeWeight : (1 - kExtremeWeight) / kRayGroups) /
            static_cast<float>(rays.parts);
    const glm::bvec3 cut = glm::notEqual(info.extentVoxels % kBrickExtent, glm::ivec3(0));
    parallelFor((count + kBricksPerTask - 1) / kBricksPerTask, threads, [&](std::size_t task) {
        Colours colours;
        std::unique_ptr<NarrowCompositor> compositor;
        if (sums)
            compositor = std::make_unique<NarrowCompositor>(*sums, table, info);
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
            for (int part = 0; part < rays.parts; ++part) {
                const BrickRayPart decoded = decodeRays(rays.part(row, part));
                if (compositor)
                    compositeNarrowPart(decoded, part, *compositor, grades, info, border, colours);
                else
                    compositePart(decoded, part, *tables, border, colours);
            }
            toLuv(colours);
            float through = 0;
            for (std::size_t i = 0; i < static_cast<std::size_t>(used); ++i)
                through += weights[i] * colours.light[i];
            out.transmittances[brick] = std::clamp(through, 0.0f, 1.0f);
            const auto isBlack = [&](std::size_t i) { return colours.r[i] == 0; }; // lightness
            std::size_t black = 0;
            while (black < static_cast<std::size_t>(used) && isBlack(black))
                ++black;
            if (black == static_cast<std::size_t>(used)) { // it is visible, but all its rays missed that
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
