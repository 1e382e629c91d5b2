// bricking/labels/label_majority.cpp: see label_majority.h.
#include "bricking/labels/label_majority.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <vector>

namespace tessera {
namespace {

using Ranks = std::vector<std::uint32_t>; // of a value: its place by voxels, then by value

template <typename Value> Value majorityOf(const std::array<Value, 8>& of, const Ranks& ranks) {
    Value best = of[0];
    int most = 0;
    for (std::size_t i = 0; i < 8; ++i) {
        const auto votes = static_cast<int>(std::count(of.begin(), of.end(), of[i]));
        if (votes > most || (votes == most && ranks[of[i]] < ranks[best])) {
            best = of[i];
            most = votes;
        }
    }
    return best;
}

template <typename Value>
void reduceSliceByMajority(const glm::ivec3& extent, const Value* in, Value* out, int z, const Ranks& ranks) {
    const glm::ivec3 half = ceilDiv(extent, 2);
    const auto row = [&](int y, int slice) {
        return in + linearIndex({0, std::min(y, extent.y - 1), std::min(slice, extent.z - 1)}, extent);
    };
    for (int y = 0; y < half.y; ++y) {
        const std::array<const Value*, 4> rows = {row(2 * y, 2 * z), row(2 * y + 1, 2 * z),
                                                  row(2 * y, 2 * z + 1), row(2 * y + 1, 2 * z + 1)};
        Value* const to = out + linearIndex({0, y, z}, half);
        for (int x = 0; x < half.x; ++x) {
            const int a = 2 * x, b = std::min(2 * x + 1, extent.x - 1);
            const std::array<Value, 8> of = {rows[0][a], rows[0][b], rows[1][a], rows[1][b],
                                             rows[2][a], rows[2][b], rows[3][a], rows[3][b]};
            const bool isOne = std::all_of(of.begin(), of.end(), [&](Value v) { return v == of[0]; });
            to[x] = isOne ? of[0] : majorityOf(of, ranks);
        }
    }
}

template <typename Value>
void reduceByMajority(const glm::ivec3& extent, std::span<const std::byte> in, std::span<std::byte> out,
                      int threads, const Ranks& ranks) {
    const glm::ivec3 half = ceilDiv(extent, 2);
    TESSERA_CHECK(in.size() == cellCount(extent) * sizeof(Value));
    TESSERA_CHECK(out.size() == cellCount(half) * sizeof(Value));
    const auto* from = reinterpret_cast<const Value*>(in.data());
    auto* to = reinterpret_cast<Value*>(out.data());
    parallelFor(static_cast<std::size_t>(half.z), threads,
                [&](std::size_t z) { reduceSliceByMajority(extent, from, to, static_cast<int>(z), ranks); });
}

} // namespace

PyramidRule majorityRule(std::span<const std::uint64_t> voxelsOf) {
    std::vector<std::uint32_t> values(voxelsOf.size());
    std::iota(values.begin(), values.end(), 0u);
    std::stable_sort(values.begin(), values.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return voxelsOf[a] < voxelsOf[b]; });
    const auto ranks = std::make_shared<Ranks>(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        (*ranks)[values[i]] = static_cast<std::uint32_t>(i);
    return {kMajorityRule, [ranks](ValueType type, const glm::ivec3& extent, std::span<const std::byte> in,
                                   std::span<std::byte> out, int threads) {
                TESSERA_CHECK(type == ValueType::u8 || type == ValueType::u16);
                if (type == ValueType::u8)
                    reduceByMajority<std::uint8_t>(extent, in, out, threads, *ranks);
                else
                    reduceByMajority<std::uint16_t>(extent, in, out, threads, *ranks);
            }};
}

} // namespace tessera
