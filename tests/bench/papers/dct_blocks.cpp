// tests/bench/papers/dct_blocks.cpp: see dct_blocks.h.
#include "tests/bench/papers/dct_blocks.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <zstd.h>

namespace tessera::bench {
namespace {

constexpr int kEdge = 8, kBlock = kEdge * kEdge * kEdge;
constexpr int kBlocks = kChunkExtent / kEdge; // along an axis
constexpr int kAll = kBlocks * kBlocks * kBlocks;
constexpr int kZstdLevel = 3;

using Matrix = std::array<std::array<float, kEdge>, kEdge>;

/// Orthonormal: [frequency][place].
const Matrix& cosines() {
    static const Matrix matrix = [] {
        Matrix m{};
        for (int k = 0; k < kEdge; ++k)
            for (int x = 0; x < kEdge; ++x)
                m[static_cast<std::size_t>(k)][static_cast<std::size_t>(x)] =
                    static_cast<float>(std::sqrt((k == 0 ? 1.0 : 2.0) / kEdge) *
                                       std::cos(std::numbers::pi * (x + 0.5) * k / kEdge));
        return m;
    }();
    return matrix;
}

struct Place {
    int index = 0;     // in a block
    int frequency = 0; // i + j + k
};
/// By frequency.
const std::array<Place, kBlock>& order() {
    static const std::array<Place, kBlock> places = [] {
        std::array<Place, kBlock> all{};
        for (int n = 0; n < kBlock; ++n)
            all[static_cast<std::size_t>(n)] = {n, n % kEdge + n / kEdge % kEdge + n / (kEdge * kEdge)};
        std::stable_sort(all.begin(), all.end(),
                         [](const Place& a, const Place& b) { return a.frequency < b.frequency; });
        return all;
    }();
    return places;
}
double stepOf(const Place& place, double step) {
    return step * (1 + 0.5 * place.frequency);
}

/// Along one axis of a block, in place; there or back.
template <bool Back> void transformAxis(std::array<float, kBlock>& block, int stride) {
    const Matrix& m = cosines();
    for (int line = 0; line < kEdge * kEdge; ++line) {
        const int start = stride == 1
                              ? line * kEdge
                              : (stride == kEdge ? line / kEdge * kEdge * kEdge + line % kEdge : line);
        std::array<float, kEdge> in{}, out{};
        for (int n = 0; n < kEdge; ++n)
            in[static_cast<std::size_t>(n)] = block[static_cast<std::size_t>(start + n * stride)];
        for (std::size_t k = 0; k < kEdge; ++k)
            for (std::size_t x = 0; x < kEdge; ++x)
                out[Back ? x : k] += m[k][x] * in[Back ? k : x];
        for (int n = 0; n < kEdge; ++n)
            block[static_cast<std::size_t>(start + n * stride)] = out[static_cast<std::size_t>(n)];
    }
}
template <bool Back> void transform(std::array<float, kBlock>& block) {
    for (const int stride : {1, kEdge, kEdge * kEdge})
        transformAxis<Back>(block, stride);
}

/// Value n of block b in the cube.
std::size_t placeInCube(int b, int n) {
    const glm::ivec3 block(b % kBlocks, b / kBlocks % kBlocks, b / (kBlocks * kBlocks));
    const glm::ivec3 in(n % kEdge, n / kEdge % kEdge, n / (kEdge * kEdge));
    return linearIndex(block * kEdge + in, glm::ivec3(kChunkExtent));
}

} // namespace

std::vector<std::byte> encodeDct(std::span<const float> values, double step) {
    std::vector<std::int16_t> coefficients(kBlock * kAll);
    for (int b = 0; b < kAll; ++b) {
        std::array<float, kBlock> block;
        for (int n = 0; n < kBlock; ++n)
            block[static_cast<std::size_t>(n)] = values[placeInCube(b, n)];
        transform<false>(block);
        for (int n = 0; n < kBlock; ++n) {
            const Place& place = order()[static_cast<std::size_t>(n)];
            const double steps = std::round(
                static_cast<double>(block[static_cast<std::size_t>(place.index)]) / stepOf(place, step));
            coefficients[static_cast<std::size_t>(n * kAll + b)] =
                static_cast<std::int16_t>(std::clamp(steps, -32768.0, 32767.0));
        }
    }
    const std::size_t bytes = coefficients.size() * sizeof(std::int16_t);
    std::vector<std::byte> coded(ZSTD_compressBound(bytes));
    const std::size_t size =
        ZSTD_compress(coded.data(), coded.size(), coefficients.data(), bytes, kZstdLevel);
    TESSERA_CHECK(!ZSTD_isError(size));
    coded.resize(size);
    return coded;
}

void decodeDct(std::span<const std::byte> coded, double step, std::span<float> values) {
    std::vector<std::int16_t> coefficients(kBlock * kAll);
    const std::size_t bytes = coefficients.size() * sizeof(std::int16_t);
    TESSERA_CHECK(ZSTD_decompress(coefficients.data(), bytes, coded.data(), coded.size()) == bytes);
    for (int b = 0; b < kAll; ++b) {
        std::array<float, kBlock> block;
        for (int n = 0; n < kBlock; ++n) {
            const Place& place = order()[static_cast<std::size_t>(n)];
            block[static_cast<std::size_t>(place.index)] = static_cast<float>(
                coefficients[static_cast<std::size_t>(n * kAll + b)] * stepOf(place, step));
        }
        transform<true>(block);
        for (int n = 0; n < kBlock; ++n)
            values[placeInCube(b, n)] = block[static_cast<std::size_t>(n)];
    }
}

} // namespace tessera::bench
