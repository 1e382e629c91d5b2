// bricking/store/dct_codec.cpp: see dct_codec.h.
#include "bricking/store/dct_codec.h"

#include "bricking/store/dct_chunk.h"
#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace tessera {
namespace {

/// First byte of a chunk. As coefficients the box follows: its extent, and the value beyond it.
constexpr std::byte kAsValues{0}, kAsCoefficients{1}, kAsTheyAre{2}, kAsCoefficientsWithoutSign{3};
constexpr std::size_t kBoxBytes = 3 + 2;

/// What a chunk has inside of a box at its origin; beyond it one value.
struct Inside {
    glm::ivec3 size{1};
    std::array<std::byte, 2> beyond{};
};

/// Calls for each row of the chunk with its z and y.
template <typename Visit> void forEachRow(std::size_t valueBytes, const Visit& visit) {
    for (int z = 0; z < kChunkExtent; ++z)
        for (int y = 0; y < kChunkExtent; ++y)
            visit(z, y, linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes);
}

Inside insideOf(std::span<const std::byte> raw, std::size_t valueBytes) {
    Inside inside;
    std::memcpy(inside.beyond.data(), raw.data() + raw.size() - valueBytes, valueBytes);
    forEachRow(valueBytes, [&](int z, int y, std::size_t at) {
        int used = kChunkExtent; // values up to the last that is another
        while (used > 0 && std::memcmp(raw.data() + at + static_cast<std::size_t>(used - 1) * valueBytes,
                                       inside.beyond.data(), valueBytes) == 0)
            --used;
        if (used > 0)
            inside.size = glm::max(inside.size, glm::ivec3(used, y + 1, z + 1));
    });
    return inside;
}

void putBeyond(std::span<std::byte> raw, std::size_t valueBytes, const Inside& inside) {
    forEachRow(valueBytes, [&](int z, int y, std::size_t at) {
        const bool within = z < inside.size.z && y < inside.size.y;
        for (int x = within ? inside.size.x : 0; x < kChunkExtent; ++x)
            std::memcpy(raw.data() + at + static_cast<std::size_t>(x) * valueBytes, inside.beyond.data(),
                        valueBytes);
    });
}

DctNumber numberOf(std::size_t valueBytes, bool hasSign) {
    return valueBytes == 1 ? DctNumber::u8 : hasSign ? DctNumber::i16 : DctNumber::u16;
}

struct Coded {
    Inside inside;
    std::vector<std::int16_t> coefficients;
    std::vector<std::byte> decoded;
};
Coded codedOf(std::span<const std::byte> raw, DctNumber number, Codec codec) {
    const std::size_t valueBytes = number == DctNumber::u8 ? 1 : 2;
    Coded coded;
    coded.inside = insideOf(raw, valueBytes);
    coded.coefficients = dctCoefficients(raw, number, dctStep(codec), coded.inside.size);
    coded.decoded.resize(raw.size());
    fromDctCoefficients(coded.coefficients, number, dctStep(codec), coded.inside.size, coded.decoded);
    putBeyond(coded.decoded, valueBytes, coded.inside);
    return coded;
}

} // namespace

void withDctSteps(std::span<std::byte> raw, std::size_t valueBytes, bool hasSign, Codec codec) {
    const Coded coded = codedOf(raw, numberOf(valueBytes, hasSign), codec);
    std::copy(coded.decoded.begin(), coded.decoded.end(), raw.begin());
}

std::size_t encodeByDct(std::span<const std::byte> raw, std::size_t valueBytes, std::span<std::byte> out,
                        Codec codec) {
    const auto tryAs = [&](std::byte kind, std::span<const std::byte> numbers, std::size_t numberBytes,
                           std::size_t before) {
        std::vector<std::byte> room(encodedBound(numbers.size()));
        const std::size_t used = encodeBlosc(numbers, numberBytes, room, codec);
        if (before + used > raw.size())
            return std::size_t{0};
        out[0] = kind;
        std::memcpy(out.data() + before, room.data(), used);
        return before + used;
    };
    std::size_t used = 0;
    for (const bool hasSign : {true, false}) { // whichever keeps the numbers
        const Coded coded = codedOf(raw, numberOf(valueBytes, hasSign), codec);
        if (std::memcmp(coded.decoded.data(), raw.data(), raw.size()) != 0)
            continue;
        used = tryAs(hasSign ? kAsCoefficients : kAsCoefficientsWithoutSign,
                     std::as_bytes(std::span(coded.coefficients)), sizeof(std::int16_t), 1 + kBoxBytes);
        if (used == 0)
            break;
        for (int axis = 0; axis < 3; ++axis)
            out[static_cast<std::size_t>(1 + axis)] = static_cast<std::byte>(coded.inside.size[axis]);
        std::copy(coded.inside.beyond.begin(), coded.inside.beyond.end(), out.begin() + 4);
        return used;
    }
    if (used = tryAs(kAsValues, raw, valueBytes, 1); used > 0)
        return used;
    out[0] = kAsTheyAre; // noise
    std::memcpy(out.data() + 1, raw.data(), raw.size());
    return 1 + raw.size();
}

void decodeByDct(std::span<const std::byte> coded, std::span<std::byte> out, const std::string& where,
                 Codec codec) {
    const std::byte kind = coded.empty() ? std::byte{255} : coded[0];
    if (kind == kAsValues) {
        decodeBlosc(coded.subspan(1), out, where);
        return;
    }
    if (kind == kAsTheyAre && coded.size() == 1 + out.size()) {
        std::memcpy(out.data(), coded.data() + 1, out.size());
        return;
    }
    Inside inside;
    bool fits =
        (kind == kAsCoefficients || kind == kAsCoefficientsWithoutSign) && coded.size() > 1 + kBoxBytes;
    for (int axis = 0; axis < 3 && fits; ++axis) {
        inside.size[axis] = std::to_integer<int>(coded[static_cast<std::size_t>(1 + axis)]);
        fits = inside.size[axis] >= 1 && inside.size[axis] <= kChunkExtent;
    }
    if (!fits)
        throw badFile(where, "a chunk that begins with 0 to 3, its box and its numbers", "another");
    std::copy_n(coded.begin() + 4, 2, inside.beyond.begin());
    std::vector<std::int16_t> coefficients(dctCoefficientCount());
    decodeBlosc(coded.subspan(1 + kBoxBytes), std::as_writable_bytes(std::span(coefficients)), where);
    const std::size_t valueBytes = out.size() / cellCount(glm::ivec3(kChunkExtent));
    fromDctCoefficients(coefficients, numberOf(valueBytes, kind == kAsCoefficients), dctStep(codec),
                        inside.size, out);
    putBeyond(out, valueBytes, inside);
}

} // namespace tessera
