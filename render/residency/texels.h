// render/residency/texels.h: conversion of stored values to texels, and back.
#pragma once

#include "core/base/volume.h"

#include <cstddef>

namespace tessera {

/// Bytes of one texel. 8-bit volumes take 16 bits too: llvmpipe filters R8 to 256 levels only.
std::size_t texelBytes(ValueType type);

/// stored = 65535 * texel + bias for 16-bit texels; floats are unchanged.
struct TexelFormat {
    bool normalised; // 16-bit texels
    float bias;
};
TexelFormat texelFormat(ValueType type);

/// Converts `count` stored values to texels of texelFormat(type).
void toTexels(ValueType type, const std::byte* stored, std::size_t count, std::byte* texels);

} // namespace tessera
