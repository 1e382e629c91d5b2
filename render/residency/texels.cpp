// render/residency/texels.cpp: see texels.h.
#include "render/residency/texels.h"

#include <cstdint>
#include <cstring>

namespace tessera {
namespace {

template <typename Stored, typename Texel, typename Convert>
void convert(const std::byte* stored, std::size_t count, std::byte* texels, Convert convertOne) {
    for (std::size_t i = 0; i < count; ++i) {
        Stored value;
        std::memcpy(&value, stored + i * sizeof(Stored), sizeof(Stored));
        const Texel texel = convertOne(value);
        std::memcpy(texels + i * sizeof(Texel), &texel, sizeof(Texel));
    }
}

} // namespace

std::size_t texelBytes(ValueType type) {
    return type == ValueType::f32 ? 4 : 2;
}

TexelFormat texelFormat(ValueType type) {
    switch (type) {
    case ValueType::i16:
        return {true, -32768.0f};
    case ValueType::u8:
    case ValueType::u16:
        return {true, 0.0f};
    case ValueType::f32:
        break;
    }
    return {false, 0.0f};
}

void toTexels(ValueType type, const std::byte* stored, std::size_t count, std::byte* texels) {
    switch (type) {
    case ValueType::u8:
        return convert<std::uint8_t, std::uint16_t>(
            stored, count, texels, [](std::uint8_t v) { return static_cast<std::uint16_t>(v); });
    case ValueType::i16: // two's complement plus 32768 is a flip of the sign bit
        return convert<std::uint16_t, std::uint16_t>(
            stored, count, texels, [](std::uint16_t v) { return static_cast<std::uint16_t>(v ^ 0x8000u); });
    case ValueType::u16:
        std::memcpy(texels, stored, count * 2);
        return;
    case ValueType::f32:
        std::memcpy(texels, stored, count * 4);
        return;
    }
}

} // namespace tessera
