// bricking/store/dct_chunk.h: a code of chunks by the discrete cosine transform (course notes on advanced
// volume ray casting, 2.9.1): blocks of 8^3 values; coefficient (i, j, k) in steps of step * (2 + i + j + k)
// / 2. In floats whose operations are neither fused nor reordered, so that every machine makes the same
// bytes, and the same values of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Of a chunk's numbers.
enum class DctNumber : std::uint8_t { u8, i16, u16 };

/// Number of the coefficients of a chunk.
std::size_t dctCoefficientCount();
/// All blocks' coefficients side by side, ordered by i + j + k; behind the first of them its upper half. Of a
/// block that is not wholly inside its numbers, unless it is wholly outside.
/// @param raw  kChunkExtent^3 numbers
/// @param step  from 2 on, even
/// @param inside  extent of the box at the chunk's origin that counts
std::vector<std::int16_t> dctCoefficients(std::span<const std::byte> raw, DctNumber number, int step,
                                          const glm::ivec3& inside);
/// The numbers that they stand for; rounded, and those of the type that are nearest. Outside: any.
void fromDctCoefficients(std::span<const std::int16_t> coefficients, DctNumber number, int step,
                         const glm::ivec3& inside, std::span<std::byte> out);

} // namespace tessera
