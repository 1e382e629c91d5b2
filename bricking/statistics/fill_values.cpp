// bricking/statistics/fill_values.cpp: see fill_values.h.
#include "bricking/statistics/fill_values.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <limits>
#include <mutex>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kLeastBins = 8; // of a measurement

struct Ends {
    bool low = false, high = false;
    bool any() const { return low || high; }
};

bool isNatural(float stored, bool isLow, const VolumeInfo& info) {
    constexpr double kLeastHu = -1100; // of air
    const double value = info.rescaleSlope * static_cast<double>(stored) + info.rescaleIntercept;
    const bool isUnsigned = info.type == ValueType::u8 || info.type == ValueType::u16;
    if (value == 0 || value == -1000 || value == -1024 || (isUnsigned && stored == 0))
        return true;
    return info.unit == "HU" && isLow == (info.rescaleSlope > 0) && value >= kLeastHu;
}

/// The ends that may stand alone, by empty bins beside them.
Ends loneBins(const WholeRange& of, const VolumeInfo& info) {
    constexpr int kLast = kHistogramBins - 1;
    const auto isFilled = [](std::uint64_t count) { return count > 0; };
    const auto first = std::find_if(of.histogram.begin() + 1, of.histogram.end(), isFilled);
    const auto last = std::find_if(of.histogram.rbegin() + 1, of.histogram.rend(), isFilled);
    if (first == of.histogram.end() || last == of.histogram.rend())
        return {}; // of one value
    // A bin may be filled at either of its ends.
    const int low = static_cast<int>(first - of.histogram.begin()),
              high = kLast - static_cast<int>(last - of.histogram.rbegin());
    Ends ends{low + 1 >= kLast - low, kLast - high + 1 >= high};
    if (low <= high && low + 1 >= high - low - 1 && kLast - high + 1 >= high - low - 1)
        ends = {true, true};
    ends.low = ends.low && !isNatural(of.lowest, true, info);
    ends.high = ends.high && !isNatural(of.highest, false, info);
    return ends;
}

/// Calls body(values, valid) with every chunk of the finest level, from several threads.
/// @param valid  voxels inside the volume; rows are kChunkExtent long all the same
template <typename Body>
void eachChunk(const StoreReader& store, BufferPool& pool, int threads, const Body& body) {
    const VolumeInfo& info = store.info();
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, 0);
    parallelFor(cellCount(grid), threads, [&](std::size_t n) {
        const glm::ivec3 chunk = gridPosition(n, grid);
        const BufferPool::Lease buffer(pool);
        store.readChunk({0, chunk.x, chunk.y, chunk.z}, buffer.bytes());
        const glm::ivec3 valid = glm::min(info.extentVoxels - chunk * kChunkExtent, glm::ivec3(kChunkExtent));
        withValueType(info.type, [&](auto typed) {
            const auto* const values = reinterpret_cast<const decltype(typed)*>(buffer.bytes().data());
            body(values, valid);
        });
    });
}

template <typename Value, typename Body>
void eachValue(const Value* chunk, const glm::ivec3& valid, const Body& body) {
    for (int z = 0; z < valid.z; ++z)
        for (int y = 0; y < valid.y; ++y) {
            const Value* const row = chunk + linearIndex({0, y, z}, glm::ivec3(kChunkExtent));
            for (int x = 0; x < valid.x; ++x)
                body(static_cast<float>(row[x]));
        }
}

/// What lies between the ends of a range.
struct Inner {
    std::uint64_t atLowest = 0, atHighest = 0;
    float least = std::numeric_limits<float>::infinity(), most = -least;
};

Inner gatherInner(const StoreReader& store, float lowest, float highest, BufferPool& pool, int threads) {
    Inner all;
    std::mutex mutex;
    eachChunk(store, pool, threads, [&](const auto* values, const glm::ivec3& valid) {
        Inner own;
        eachValue(values, valid, [&](float value) {
            own.atLowest += value == lowest;
            own.atHighest += value == highest;
            if (value > lowest && value < highest) {
                own.least = std::min(own.least, value);
                own.most = std::max(own.most, value);
            }
        });
        const std::lock_guard lock(mutex);
        all.atLowest += own.atLowest;
        all.atHighest += own.atHighest;
        all.least = std::min(all.least, own.least);
        all.most = std::max(all.most, own.most);
    });
    return all;
}

/// The histogram of the values within a range.
void gatherWithin(const StoreReader& store, WholeRange& range, BufferPool& pool, int threads) {
    range.histogram.assign(kHistogramBins, 0);
    std::mutex mutex;
    const double low = range.lowest, high = range.highest;
    eachChunk(store, pool, threads, [&](const auto* values, const glm::ivec3& valid) {
        std::array<std::uint64_t, kHistogramBins> own{};
        eachValue(values, valid, [&](float value) {
            if (value >= range.lowest && value <= range.highest)
                ++own[static_cast<std::size_t>(histogramBin(static_cast<double>(value), low, high))];
        });
        const std::lock_guard lock(mutex);
        for (std::size_t bin = 0; bin < own.size(); ++bin)
            range.histogram[bin] += own[bin];
    });
}

/// Those of the ends that stand alone indeed.
Ends loneEnds(const WholeRange& of, const Inner& inner, const Ends& may) {
    const double lowest = of.lowest, highest = of.highest, least = inner.least, most = inner.most;
    if (!(least <= most))
        return {}; // two values
    const double below = least - lowest, above = highest - most, between = most - least;
    if (may.low && may.high && between > 0 && below >= between && above >= between)
        return {true, true};
    if (may.low && below >= highest - least)
        return {true, false};
    return {false, may.high && above >= most - lowest};
}

} // namespace

bool mayHaveFills(const WholeRange& whole, const VolumeInfo& info) {
    return loneBins(whole, info).any();
}

FillValues findFills(const StoreReader& store, const WholeRange& whole, BufferPool& pool, int threads) {
    FillValues fills;
    WholeRange rest = whole;
    while (fills.values.size() + 1 < kMostFillValues) {
        const Ends may = loneBins(rest, store.info());
        if (!may.any())
            break;
        const Inner inner = gatherInner(store, rest.lowest, rest.highest, pool, threads);
        const Ends ends = loneEnds(rest, inner, may);
        if (!ends.any())
            break;
        if (ends.low) {
            fills.values.push_back({rest.lowest, inner.atLowest});
            rest.lowest = inner.least;
        }
        if (ends.high) {
            fills.values.push_back({rest.highest, inner.atHighest});
            rest.highest = inner.most;
        }
        gatherWithin(store, rest, pool, threads);
    }
    const auto filled = std::count_if(rest.histogram.begin(), rest.histogram.end(),
                                      [](std::uint64_t count) { return count > 0; });
    if (fills.values.empty() || static_cast<std::size_t>(filled) < kLeastBins)
        return {};
    fills.lowest = rest.lowest;
    fills.highest = rest.highest;
    fills.histogram = std::move(rest.histogram);
    return fills;
}

Json fillsJson(const FillValues& fills) {
    Json json = {{"values", Json::array()}, {"voxels", Json::array()}};
    for (const FillValues::Value& fill : fills.values) {
        json["values"].push_back(fill.value);
        json["voxels"].push_back(fill.voxels);
    }
    if (!fills.values.empty()) {
        json["lowest"] = fills.lowest;
        json["highest"] = fills.highest;
        json["histogram"] = fills.histogram;
    }
    return json;
}

FillValues readFills(const Json& document, const std::string& pointer, std::uint64_t voxels,
                     const std::string& where) {
    constexpr std::int64_t kMost = std::int64_t{1} << 62;
    FillValues fills;
    const std::size_t count = jsonAt(document, pointer + "/values", where).size();
    if (count > kMostFillValues)
        throw badFile(where, "at most " + std::to_string(kMostFillValues) + " fill values",
                      std::to_string(count));
    if (count == 0)
        return fills;
    std::uint64_t counted = 0;
    for (std::size_t n = 0; n < count; ++n) {
        const std::string at = "/" + std::to_string(n);
        fills.values.push_back(
            {static_cast<float>(numberAt(document, pointer + "/values" + at, where)),
             static_cast<std::uint64_t>(integerAt(document, pointer + "/voxels" + at, 1, kMost, where))});
        counted += fills.values.back().voxels;
    }
    fills.lowest = static_cast<float>(numberAt(document, pointer + "/lowest", where));
    fills.highest = static_cast<float>(numberAt(document, pointer + "/highest", where));
    for (int bin = 0; bin < kHistogramBins; ++bin) {
        fills.histogram.push_back(static_cast<std::uint64_t>(
            integerAt(document, pointer + "/histogram/" + std::to_string(bin), 0, kMost, where)));
        counted += fills.histogram.back();
    }
    if (counted != voxels || !(fills.lowest < fills.highest))
        throw badFile(where, "fill values and a histogram of all other voxels",
                      std::to_string(counted) + " counts");
    return fills;
}

} // namespace tessera
