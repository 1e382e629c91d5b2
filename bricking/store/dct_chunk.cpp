// bricking/store/dct_chunk.cpp: see dct_chunk.h.
#include "bricking/store/dct_chunk.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/vector_relational.hpp>
#include <limits>
#include <utility>

// Wide registers where the processor has some: the same operations in the same order.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&     \
    !defined(__SANITIZE_THREAD__)
#define TESSERA_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define TESSERA_WIDE
#endif

namespace tessera {
namespace {

constexpr int kEdge = 8, kBlock = kEdge * kEdge * kEdge;
constexpr int kBlocks = kChunkExtent / kEdge; // along an axis
constexpr int kAll = kBlocks * kBlocks * kBlocks;

using Block = std::array<float, kBlock>;
using Matrix = std::array<std::array<float, kEdge>, kEdge>;

/// Orthonormal, [out][in]. There: entry [k][x] is cos(pi (x + 1/2) k / 8) / 2, of k = 0 sqrt(1/8). By
/// literals, so that it is the same everywhere.
template <bool Back> constexpr Matrix matrix() {
    constexpr std::array<float, 9> kHalfCosines = {0.5f,          0.4903926402f, 0.4619397663f,
                                                   0.4157348061f, 0.3535533906f, 0.2777851165f,
                                                   0.1913417162f, 0.0975451610f, 0.0f};
    Matrix m{};
    for (std::size_t k = 0; k < kEdge; ++k)
        for (std::size_t x = 0; x < kEdge; ++x) {
            const std::size_t at = (2 * x + 1) * k % 32; // sixteenths of pi
            const std::size_t from = at <= 16 ? at : 32 - at;
            const float cosine = from <= 8 ? kHalfCosines[from] : -kHalfCosines[16 - from];
            (Back ? m[x][k] : m[k][x]) = k == 0 ? kHalfCosines[4] : cosine;
        }
    return m;
}

/// Along the slowest axis; the block's axes turn by one.
TESSERA_WIDE void transformAndTurn(const Matrix& m, const float* in, float* out) {
    constexpr int kRest = kEdge * kEdge;
    float sums[kEdge][kRest] = {};
    for (std::size_t a = 0; a < kEdge; ++a)
        for (std::size_t b = 0; b < kEdge; ++b)
            for (std::size_t r = 0; r < kRest; ++r)
                sums[a][r] += m[a][b] * in[b * kRest + r];
    for (std::size_t r = 0; r < kRest; ++r)
        for (std::size_t a = 0; a < kEdge; ++a)
            out[r * kEdge + a] = sums[a][r];
}
/// Along all three axes, which then stand as they did.
template <bool Back> void transform(Block& block) {
    static constexpr Matrix kMatrix = matrix<Back>();
    Block other;
    transformAndTurn(kMatrix, block.data(), other.data());
    transformAndTurn(kMatrix, other.data(), block.data());
    transformAndTurn(kMatrix, block.data(), other.data());
    block = other;
}

struct Place {
    std::size_t index = 0; // in a block
    int frequency = 0;     // i + j + k
};
/// By frequency.
const std::array<Place, kBlock>& order() {
    static const std::array<Place, kBlock> places = [] {
        std::array<Place, kBlock> all{};
        for (int n = 0; n < kBlock; ++n)
            all[static_cast<std::size_t>(n)] = {static_cast<std::size_t>(n),
                                                n % kEdge + n / kEdge % kEdge + n / (kEdge * kEdge)};
        std::stable_sort(all.begin(), all.end(),
                         [](const Place& a, const Place& b) { return a.frequency < b.frequency; });
        return all;
    }();
    return places;
}
float stepOf(const Place& place, int step) {
    return static_cast<float>(step * (2 + place.frequency) / 2);
}
/// Of the n-th coefficient of block b; the first ones are followed by their upper halves.
std::size_t slotOf(int n, int b) {
    return static_cast<std::size_t>((n == 0 ? 0 : n + 1) * kAll + b);
}

/// Visits the rows of a block: where each begins in the chunk and in the block.
template <typename Visit> void forEachBlockRow(int b, const Visit& visit) {
    const glm::ivec3 first = glm::ivec3(b % kBlocks, b / kBlocks % kBlocks, b / (kBlocks * kBlocks)) * kEdge;
    for (int z = 0; z < kEdge; ++z)
        for (int y = 0; y < kEdge; ++y)
            visit(linearIndex(first + glm::ivec3(0, y, z), glm::ivec3(kChunkExtent)),
                  static_cast<std::size_t>((z * kEdge + y) * kEdge));
}

template <typename T> Block blockOf(std::span<const std::byte> raw, int b) {
    Block block;
    forEachBlockRow(b, [&](std::size_t from, std::size_t to) {
        T row[kEdge];
        std::memcpy(row, raw.data() + from * sizeof(T), sizeof row);
        for (std::size_t x = 0; x < kEdge; ++x)
            block[to + x] = static_cast<float>(row[x]);
    });
    return block;
}
template <typename T> void putBlock(std::span<std::byte> out, int b, const Block& block) {
    constexpr float kLow = std::numeric_limits<T>::min(), kHigh = std::numeric_limits<T>::max();
    forEachBlockRow(b, [&](std::size_t to, std::size_t from) {
        T row[kEdge];
        for (std::size_t x = 0; x < kEdge; ++x)
            row[x] = static_cast<T>(std::floor(std::clamp(block[from + x], kLow, kHigh) + 0.5f));
        std::memcpy(out.data() + to * sizeof(T), row, sizeof row);
    });
}

/// Blocks within the inside are transformed, those that it cuts are kept as they are.
bool isWithin(int b, const glm::ivec3& inside) {
    const glm::ivec3 block(b % kBlocks, b / kBlocks % kBlocks, b / (kBlocks * kBlocks));
    return glm::all(glm::lessThanEqual((block + 1) * kEdge, inside));
}

/// Calls with a number of the type.
template <typename Call> void withNumber(DctNumber number, const Call& call) {
    if (number == DctNumber::u8)
        call(std::uint8_t{});
    else if (number == DctNumber::i16)
        call(std::int16_t{});
    else
        call(std::uint16_t{});
}

} // namespace

std::size_t dctCoefficientCount() {
    return slotOf(kBlock, 0);
}

std::vector<std::int16_t> dctCoefficients(std::span<const std::byte> raw, DctNumber number, int step,
                                          const glm::ivec3& inside) {
    std::vector<std::int16_t> coefficients(dctCoefficientCount());
    withNumber(number, [&](auto zero) {
        for (int b = 0; b < kAll; ++b) {
            Block block = blockOf<decltype(zero)>(raw, b);
            if (!isWithin(b, inside)) {
                for (int n = 0; n < kBlock; ++n)
                    coefficients[slotOf(n, b)] =
                        static_cast<std::int16_t>(block[static_cast<std::size_t>(n)]);
                continue;
            }
            transform<false>(block);
            for (int n = 0; n < kBlock; ++n) {
                const Place& place = order()[static_cast<std::size_t>(n)];
                const auto steps =
                    static_cast<std::int32_t>(std::floor(block[place.index] / stepOf(place, step) + 0.5f));
                if (n > 0) {
                    coefficients[slotOf(n, b)] = static_cast<std::int16_t>(std::clamp(steps, -32768, 32767));
                } else { // of any size
                    coefficients[slotOf(0, b)] =
                        static_cast<std::int16_t>(static_cast<std::uint32_t>(steps) & 0xFFFF);
                    coefficients[slotOf(0, b) + kAll] = static_cast<std::int16_t>(steps >> 16);
                }
            }
        }
    });
    return coefficients;
}

void fromDctCoefficients(std::span<const std::int16_t> coefficients, DctNumber number, int step,
                         const glm::ivec3& inside, std::span<std::byte> out) {
    TESSERA_CHECK(coefficients.size() == dctCoefficientCount());
    withNumber(number, [&](auto zero) {
        for (int b = 0; b < kAll; ++b) {
            Block block;
            const bool transformed = isWithin(b, inside);
            for (int n = 0; n < kBlock; ++n) {
                if (!transformed) {
                    block[static_cast<std::size_t>(n)] =
                        static_cast<float>(static_cast<decltype(zero)>(coefficients[slotOf(n, b)]));
                    continue;
                }
                const Place& place = order()[static_cast<std::size_t>(n)];
                std::int32_t steps = coefficients[slotOf(n, b)];
                if (n == 0)
                    steps = (steps & 0xFFFF) + coefficients[slotOf(0, b) + kAll] * 65536;
                block[place.index] = static_cast<float>(steps) * stepOf(place, step);
            }
            if (transformed)
                transform<true>(block);
            putBlock<decltype(zero)>(out, b, block);
        }
    });
}

} // namespace tessera
