// viewer/bench/brick_truth.cpp: see brick_truth.h.
#include "viewer/bench/brick_truth.h"

#include "core/colour.h"
#include "core/error.h"
#include "core/threads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <mutex>
#include <numeric>

namespace tessera::bench {
namespace {

glm::ivec3 placeOf(std::size_t n, const glm::ivec3& grid) {
    const auto nx = static_cast<std::size_t>(grid.x), ny = static_cast<std::size_t>(grid.y);
    return {static_cast<int>(n % nx), static_cast<int>(n / nx % ny), static_cast<int>(n / nx / ny)};
}

template <typename T> void copyRow(const std::byte* from, int count, float* to) {
    for (int i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, from + static_cast<std::size_t>(i) * sizeof(T), sizeof(T));
        to[i] = static_cast<float>(value);
    }
}
void copyRow(ValueType type, const std::byte* from, int count, float* to) {
    switch (type) {
    case ValueType::u8:
        return copyRow<std::uint8_t>(from, count, to);
    case ValueType::i16:
        return copyRow<std::int16_t>(from, count, to);
    case ValueType::u16:
        return copyRow<std::uint16_t>(from, count, to);
    case ValueType::f32:
        return copyRow<float>(from, count, to);
    }
}

/// The field of a level at the voxels' centres of a brick, [z][y][x].
void fieldAtVoxels(const BrickFields& fields, int level, std::vector<float>& out) {
    out.clear();
    glm::ivec3 v(0);
    for (v.z = 0; v.z < fields.size.z; ++v.z)
        for (v.y = 0; v.y < fields.size.y; ++v.y)
            for (v.x = 0; v.x < fields.size.x; ++v.x)
                out.push_back(fields.at(level, glm::dvec3(v) + 0.5));
}

/// L*u*v* of every row of voxels along an axis, composited front to back before black.
void rowColours(const std::vector<glm::vec4>& optical, const glm::ivec3& size, int axis, float voxelMm,
                std::vector<glm::dvec3>& out) {
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    glm::ivec3 step(0);
    step[axis] = 1;
    const std::size_t stride = linearIndex(step, size);
    glm::ivec3 start(0);
    for (start[w] = 0; start[w] < size[w]; ++start[w])
        for (start[u] = 0; start[u] < size[u]; ++start[u]) {
            std::size_t at = linearIndex(start, size);
            glm::vec3 colour(0);
            float through = 1;
            for (int i = 0; i < size[axis]; ++i, at += stride) {
                const glm::vec4& o = optical[at];
                if (!(o.a > 0))
                    continue;
                const float alpha = opacityOf(o.a * voxelMm);
                colour += through * alpha * glm::vec3(o);
                through -= through * alpha;
            }
            out.push_back(luvFromLinear(glm::clamp(glm::dvec3(colour), glm::dvec3(0.0), glm::dvec3(1.0))));
        }
}

/// Calls body(brick index, its fields) for every brick that shows something, on all processors.
template <typename Body>
void forShownBricks(const VolumeLevels& volume, const std::vector<std::uint8_t>& shows, const Body& body) {
    const glm::ivec3 bricks = brickGrid(volume.info().extentVoxels);
    TESSERA_CHECK(shows.size() == cellCount(bricks));
    parallelFor(shows.size(), 0, [&](std::size_t n) {
        if (!shows[n])
            return;
        thread_local std::vector<float> room;
        body(n, volume.brick(placeOf(n, bricks), room));
    });
}

LevelErrors noErrors(const VolumeLevels& volume, std::vector<std::uint8_t> shows) {
    LevelErrors errors;
    errors.bricks = brickGrid(volume.info().extentVoxels);
    errors.errors.assign(shows.size(), {});
    errors.shows = std::move(shows);
    return errors;
}

} // namespace

VolumeLevels::VolumeLevels(const StoreReader& store, Ledger& ram) : info_(store.info()) {
    std::size_t count = 0;
    for (int level = 0; level < kLevelCount; ++level)
        count += cellCount(levelExtent(info_.extentVoxels, level));
    charge_ = ram.charge(count * sizeof(float), "the whole volume, for the true errors of its bricks");
    for (int level = 0; level < kLevelCount; ++level) {
        std::vector<float>& values = values_[static_cast<std::size_t>(level)];
        const glm::ivec3 extent = levelExtent(info_.extentVoxels, level);
        const glm::ivec3 chunks = chunkGrid(info_.extentVoxels, level);
        values.resize(cellCount(extent));
        parallelFor(cellCount(chunks), 0, [&](std::size_t n) {
            const glm::ivec3 chunk = placeOf(n, chunks), origin = chunk * kChunkExtent;
            std::vector<std::byte> bytes(store.chunkBytes());
            store.readChunk({level, chunk.x, chunk.y, chunk.z}, bytes);
            const glm::ivec3 size = glm::min(extent - origin, glm::ivec3(kChunkExtent));
            for (int z = 0; z < size.z; ++z)
                for (int y = 0; y < size.y; ++y)
                    copyRow(info_.type,
                            bytes.data() +
                                linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * bytesPerValue(info_.type),
                            size.x, values.data() + linearIndex(origin + glm::ivec3(0, y, z), extent));
        });
    }
}

BrickFields VolumeLevels::brick(const glm::ivec3& at, std::vector<float>& room) const {
    struct Part {
        glm::ivec3 first, end;
        std::size_t offset;
    };
    std::array<Part, kLevelCount> parts{};
    room.clear();
    for (int level = 0; level < kLevelCount; ++level) {
        const int layer = level == 0 ? 0 : 1; // the finest level is read inside the brick only
        const glm::ivec3 extent = levelExtent(info_.extentVoxels, level);
        const glm::ivec3 own = at * (kBrickExtent >> level);
        Part& part = parts[static_cast<std::size_t>(level)];
        part = {glm::max(own - layer, glm::ivec3(0)), glm::min(own + (kBrickExtent >> level) + layer, extent),
                room.size()};
        const std::vector<float>& values = values_[static_cast<std::size_t>(level)];
        for (int z = part.first.z; z < part.end.z; ++z)
            for (int y = part.first.y; y < part.end.y; ++y) {
                const auto row =
                    values.begin() + static_cast<std::ptrdiff_t>(linearIndex({part.first.x, y, z}, extent));
                room.insert(room.end(), row, row + (part.end.x - part.first.x));
            }
    }
    BrickFields fields;
    fields.size = parts[0].end - parts[0].first;
    const std::span<const float> all(room);
    fields.voxels = all.first(cellCount(fields.size));
    for (int level = 1; level < kLevelCount; ++level) {
        const Part& part = parts[static_cast<std::size_t>(level)];
        BrickFields::Box& box = fields.levels[static_cast<std::size_t>(level)];
        box.first = part.first - at * (kBrickExtent >> level);
        box.extent = part.end - part.first;
        box.samples = all.subspan(part.offset, cellCount(box.extent));
    }
    return fields;
}

LevelErrors trueErrors(const VolumeLevels& volume, std::vector<std::uint8_t> shows, const Optics& optics) {
    LevelErrors errors = noErrors(volume, std::move(shows));
    const glm::dvec3 mm = volume.info().spacingMm();
    forShownBricks(volume, errors.shows, [&](std::size_t n, const BrickFields& fields) {
        thread_local std::vector<float> values;
        thread_local std::vector<glm::vec4> optical;
        thread_local std::vector<glm::dvec3> finest, colours;
        for (int level = 0; level < kLevelCount; ++level) {
            fieldAtVoxels(fields, level, values);
            optical.clear();
            for (const float value : values)
                optical.push_back(lookUp(optics, value));
            std::vector<glm::dvec3>& out = level == 0 ? finest : colours;
            out.clear();
            for (int axis = 0; axis < 3; ++axis)
                rowColours(optical, fields.size, axis, static_cast<float>(mm[axis]), out);
            if (level == 0)
                continue;
            // Every axis counts alike, however many rows it has.
            double sum = 0;
            std::size_t at = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const auto rows =
                    static_cast<std::size_t>(fields.size[(axis + 1) % 3] * fields.size[(axis + 2) % 3]);
                double mean = 0;
                for (std::size_t i = 0; i < rows; ++i, ++at)
                    mean += glm::length(colours[at] - finest[at]);
                sum += mean / static_cast<double>(rows) / 3;
            }
            errors.errors[n][static_cast<std::size_t>(level)] = static_cast<float>(sum);
        }
    });
    return errors;
}

LevelErrors dataErrors(const VolumeLevels& volume, std::vector<std::uint8_t> shows) {
    LevelErrors errors = noErrors(volume, std::move(shows));
    forShownBricks(volume, errors.shows, [&](std::size_t n, const BrickFields& fields) {
        thread_local std::vector<float> values;
        for (int level = 1; level < kLevelCount; ++level) {
            fieldAtVoxels(fields, level, values);
            double squares = 0;
            for (std::size_t i = 0; i < values.size(); ++i) {
                const double d = static_cast<double>(values[i]) - static_cast<double>(fields.voxels[i]);
                squares += d * d;
            }
            errors.errors[n][static_cast<std::size_t>(level)] =
                static_cast<float>(std::sqrt(squares / static_cast<double>(values.size())));
        }
    });
    return errors;
}

double rankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
    TESSERA_CHECK(a.size() == b.size());
    if (a.size() < 3)
        return 0;
    const auto ranks = [](const std::vector<double>& values) {
        std::vector<std::size_t> order(values.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::sort(order.begin(), order.end(),
                  [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
        std::vector<double> rank(values.size());
        for (std::size_t first = 0; first < order.size();) {
            std::size_t end = first + 1;
            while (end < order.size() && values[order[end]] == values[order[first]])
                ++end;
            for (std::size_t i = first; i < end; ++i)
                rank[order[i]] = 0.5 * static_cast<double>(first + end - 1);
            first = end;
        }
        return rank;
    };
    const std::vector<double> ra = ranks(a), rb = ranks(b);
    const double mean = 0.5 * static_cast<double>(a.size() - 1);
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (ra[i] - mean) * (rb[i] - mean);
        aa += (ra[i] - mean) * (ra[i] - mean);
        bb += (rb[i] - mean) * (rb[i] - mean);
    }
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

} // namespace tessera::bench
