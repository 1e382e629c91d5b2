// bricking/import/source/blended_slices.cpp: see blended_slices.h.
#include "bricking/import/source/blended_slices.h"

#include "core/base/error.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tessera {
namespace {

template <class T>
void blend(std::span<const std::byte> lower, std::span<const std::byte> upper, float weight,
           std::span<std::byte> out) {
    for (std::size_t at = 0; at < out.size(); at += sizeof(T)) {
        T a, b;
        std::memcpy(&a, lower.data() + at, sizeof(T));
        std::memcpy(&b, upper.data() + at, sizeof(T));
        const double mixed =
            static_cast<double>(a) + weight * (static_cast<double>(b) - static_cast<double>(a));
        const T value = static_cast<T>(std::is_integral_v<T> ? std::nearbyint(mixed) : mixed);
        std::memcpy(out.data() + at, &value, sizeof(T));
    }
}

} // namespace

void blendSlices(ValueType type, std::span<const std::byte> lower, std::span<const std::byte> upper,
                 float weight, std::span<std::byte> out) {
    TESSERA_CHECK(lower.size() == out.size() && upper.size() == out.size());
    switch (type) {
    case ValueType::u8:
        return blend<std::uint8_t>(lower, upper, weight, out);
    case ValueType::i16:
        return blend<std::int16_t>(lower, upper, weight, out);
    case ValueType::u16:
        return blend<std::uint16_t>(lower, upper, weight, out);
    case ValueType::f32:
        return blend<float>(lower, upper, weight, out);
    }
}

} // namespace tessera
