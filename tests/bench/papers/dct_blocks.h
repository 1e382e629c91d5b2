// tests/bench/papers/dct_blocks.h: a lossy code of chunks by the discrete cosine transform (course notes on
// advanced volume ray casting, 2.9.1), for comparison with others.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tessera::bench {

/// Codes a cube of 32^3 values: blocks of 8^3, transformed along each axis; coefficient (i, j, k) in steps of
/// step * (1 + (i + j + k) / 2); all blocks' coefficients side by side, ordered by i + j + k; Zstandard.
std::vector<std::byte> encodeDct(std::span<const float> values, double step);
/// Decodes it into 32^3 values.
void decodeDct(std::span<const std::byte> coded, double step, std::span<float> values);

} // namespace tessera::bench
