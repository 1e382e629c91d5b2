// tests/bench/lod/brick_truth.cpp: see brick_truth.h.
#include "tests/bench/lod/brick_truth.h"

#include "core/base/threads.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numeric>

namespace tessera::bench {
namespace {

/// One brick's fields of all levels at its voxels' centres.
struct Resampled {
    glm::ivec3 size{0};
    std::array<std::vector<float>, kLevelCount> values; // [z][y][x]
};

Resampled resample(const WholeLevels& levels, const glm::ivec3& brick) {
    const glm::ivec3 first = brick * kBrickExtent;
    Resampled out;
    out.size = glm::min(levels.info.extentVoxels - first, glm::ivec3(kBrickExtent));
    for (int level = 0; level < kLevelCount; ++level) {
        const auto at = static_cast<std::size_t>(level);
        const glm::ivec3 extent = levels.extents[at];
        const std::vector<float>& in = levels.values[at];
        std::array<std::array<int, kBrickExtent>, 3> low{}, high{};
        std::array<std::array<float, kBrickExtent>, 3> f{};
        for (int axis = 0; axis < 3; ++axis)
            for (int x = 0; x < out.size[axis]; ++x) {
                const double p = (first[axis] + x + 0.5) / (1 << level) - 0.5, below = std::floor(p);
                const auto a = static_cast<std::size_t>(axis), i = static_cast<std::size_t>(x);
                f[a][i] = static_cast<float>(p - below);
                low[a][i] = std::clamp(static_cast<int>(below), 0, extent[axis] - 1);
                high[a][i] = std::clamp(static_cast<int>(below) + 1, 0, extent[axis] - 1);
            }
        out.values[at].reserve(cellCount(out.size));
        for (int z = 0; z < out.size.z; ++z)
            for (int y = 0; y < out.size.y; ++y)
                for (int x = 0; x < out.size.x; ++x) {
                    const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y),
                               k = static_cast<std::size_t>(z);
                    const auto row = [&](int yy, int zz) {
                        const float a = in[linearIndex({low[0][i], yy, zz}, extent)];
                        return a + f[0][i] * (in[linearIndex({high[0][i], yy, zz}, extent)] - a);
                    };
                    const auto plane = [&](int zz) {
                        const float a = row(low[1][j], zz);
                        return a + f[1][j] * (row(high[1][j], zz) - a);
                    };
                    const float a = plane(low[2][k]);
                    out.values[at].push_back(a + f[2][k] * (plane(high[2][k]) - a));
                }
    }
    return out;
}

glm::vec4 entryAt(const TransferTable& table, const VolumeInfo& info, float stored) {
    const double value = info.rescaleSlope * static_cast<double>(stored) + info.rescaleIntercept;
    const double x = std::clamp((value - static_cast<double>(table.firstValue)) *
                                    static_cast<double>(table.entriesPerValue),
                                0.0, static_cast<double>(table.entries.size() - 1));
    const std::size_t left = std::min(static_cast<std::size_t>(x), table.entries.size() - 2);
    return glm::mix(table.entries[left], table.entries[left + 1],
                    static_cast<float>(x - static_cast<double>(left)));
}

/// A row of voxels composited before black, seen from its first voxel or from its last. Colours are times
/// their opacity.
glm::dvec3 seenAlong(const std::vector<glm::dvec4>& voxels, std::size_t first, std::size_t stride, int count,
                     bool fromItsEnd) {
    glm::dvec3 colour(0);
    double through = 1;
    for (int n = 0; n < count; ++n) {
        const auto i = static_cast<std::size_t>(fromItsEnd ? count - 1 - n : n);
        const glm::dvec4& added = voxels[first + i * stride];
        colour += through * glm::dvec3(added);
        through *= 1 - added.a;
    }
    return luvFromLinear(glm::min(colour, glm::dvec3(1)));
}

std::array<float, kLevelCount> errorsOf(const Resampled& brick, const TransferTable& table,
                                        const VolumeInfo& info) {
    const glm::ivec3 size = brick.size, stride(1, size.x, size.x * size.y);
    std::array<float, kLevelCount> errors{};
    std::vector<glm::dvec4> added(cellCount(size));
    std::vector<glm::dvec3> finest;
    for (std::size_t level = 0; level < kLevelCount; ++level) {
        double sum = 0;
        std::size_t rays = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, w = (axis + 2) % 3;
            const double mm = info.spacingMm()[axis];
            for (std::size_t i = 0; i < added.size(); ++i) {
                const glm::vec4 e = entryAt(table, info, brick.values[level][i]);
                const double alpha = -std::expm1(-static_cast<double>(e.a) * mm);
                added[i] = glm::dvec4(alpha * glm::dvec3(e), alpha);
            }
            for (int q = 0; q < size[w]; ++q)
                for (int p = 0; p < size[u]; ++p)
                    for (const bool fromItsEnd : {false, true}) {
                        const glm::dvec3 luv =
                            seenAlong(added, static_cast<std::size_t>(p * stride[u] + q * stride[w]),
                                      static_cast<std::size_t>(stride[axis]), size[axis], fromItsEnd);
                        if (level == 0)
                            finest.push_back(luv);
                        else
                            sum += glm::length(luv - finest[rays]);
                        ++rays;
                    }
        }
        errors[level] = static_cast<float>(sum / static_cast<double>(rays));
    }
    return errors;
}

template <typename Body>
LevelErrors forBricks(const WholeLevels& levels, const std::vector<std::uint8_t>& shows, int threads,
                      const Body& body) {
    LevelErrors out;
    out.bricks = brickGrid(levels.info.extentVoxels);
    out.shows = shows;
    out.errors.resize(shows.size());
    parallelFor(shows.size(), threads, [&](std::size_t n) {
        const int i = static_cast<int>(n);
        if (shows[n])
            out.errors[n] = body(resample(levels, {i % out.bricks.x, i / out.bricks.x % out.bricks.y,
                                                   i / out.bricks.x / out.bricks.y}));
    });
    return out;
}

std::vector<double> ranks(const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    std::vector<double> out(values.size());
    for (std::size_t i = 0; i < order.size();) {
        std::size_t end = i;
        while (end < order.size() && values[order[end]] == values[order[i]])
            ++end;
        for (std::size_t k = i; k < end; ++k)
            out[order[k]] = 0.5 * static_cast<double>(i + end - 1);
        i = end;
    }
    return out;
}

} // namespace

WholeLevels loadLevels(const StoreReader& store) {
    WholeLevels out;
    out.info = store.info();
    std::vector<std::byte> chunk(store.chunkBytes());
    const std::size_t bytes = bytesPerValue(out.info.type);
    const auto valueAt = [&](std::size_t i) {
        return static_cast<float>(storedValue(out.info.type, chunk.data() + i * bytes));
    };
    for (int level = 0; level < kLevelCount; ++level) {
        const glm::ivec3 extent = levelExtent(out.info.extentVoxels, level),
                         grid = ceilDiv(extent, kChunkExtent);
        std::vector<float>& values = out.values[static_cast<std::size_t>(level)];
        out.extents[static_cast<std::size_t>(level)] = extent;
        values.resize(cellCount(extent));
        for (std::size_t n = 0; n < cellCount(grid); ++n) {
            const int i = static_cast<int>(n);
            const glm::ivec3 at(i % grid.x, i / grid.x % grid.y, i / grid.x / grid.y),
                first = at * kChunkExtent;
            store.readChunk({level, at.x, at.y, at.z}, chunk);
            const glm::ivec3 size = glm::min(extent - first, glm::ivec3(kChunkExtent));
            for (int z = 0; z < size.z; ++z)
                for (int y = 0; y < size.y; ++y)
                    for (int x = 0; x < size.x; ++x)
                        values[linearIndex(first + glm::ivec3(x, y, z), extent)] =
                            valueAt(linearIndex({x, y, z}, glm::ivec3(kChunkExtent)));
        }
    }
    return out;
}

LevelErrors trueErrors(const WholeLevels& levels, const std::vector<std::uint8_t>& shows,
                       const TransferTable& table, int threads) {
    return forBricks(levels, shows, threads,
                     [&](const Resampled& brick) { return errorsOf(brick, table, levels.info); });
}

LevelErrors dataErrors(const WholeLevels& levels, const std::vector<std::uint8_t>& shows, int threads) {
    return forBricks(levels, shows, threads, [](const Resampled& brick) {
        std::array<float, kLevelCount> errors{};
        for (std::size_t level = 1; level < kLevelCount; ++level) {
            double sum = 0;
            for (std::size_t i = 0; i < brick.values[0].size(); ++i) {
                const double d =
                    static_cast<double>(brick.values[level][i]) - static_cast<double>(brick.values[0][i]);
                sum += d * d;
            }
            errors[level] = static_cast<float>(std::sqrt(sum / static_cast<double>(brick.values[0].size())));
        }
        return errors;
    });
}

LevelErrors sizeErrors(const glm::ivec3& bricks, const std::vector<std::uint8_t>& shows) {
    LevelErrors out;
    out.bricks = bricks;
    out.shows = shows;
    for (const std::uint8_t shown : shows) {
        std::array<float, kLevelCount> errors{};
        for (int level = 1; level < kLevelCount && shown; ++level)
            errors[static_cast<std::size_t>(level)] = static_cast<float>((1 << level) - 1);
        out.errors.push_back(errors);
    }
    return out;
}

ViewWeights distanceWeights(ViewWeights weights) {
    for (float& area : weights.area)
        area = std::sqrt(area);
    return weights;
}

double rankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
    const std::vector<double> x = ranks(a), y = ranks(b);
    const double middle = (static_cast<double>(a.size()) - 1) / 2;
    double xy = 0, xx = 0, yy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        xy += (x[i] - middle) * (y[i] - middle);
        xx += (x[i] - middle) * (x[i] - middle);
        yy += (y[i] - middle) * (y[i] - middle);
    }
    return xy / std::sqrt(xx * yy);
}

} // namespace tessera::bench
