// bricking/import/labels/label_values.cpp: see label_values.h.
#include "bricking/import/labels/label_values.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace tessera {
namespace {

constexpr double kRounding = 1e-5; // of a scaled value

template <class T> T numberAt(const std::byte* from, bool bigEndian) {
    std::array<std::byte, sizeof(T)> bytes;
    std::memcpy(bytes.data(), from, sizeof(T));
    if (bigEndian)
        for (std::size_t i = 0; i < sizeof(T) / 2; ++i)
            std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    return std::bit_cast<T>(bytes);
}

template <class T> bool isLabel(T number, std::uint32_t& label) {
    if constexpr (std::is_integral_v<T>) {
        if (!std::in_range<std::uint32_t>(number))
            return false;
        label = static_cast<std::uint32_t>(static_cast<std::make_unsigned_t<T>>(number));
        return true;
    } else {
        if (!(number >= 0 && number < static_cast<T>(4294967296.0)))
            return false;
        label = static_cast<std::uint32_t>(number);
        return static_cast<T>(label) == number;
    }
}

bool isScaledLabel(double value, std::uint32_t& label) {
    const double whole = std::round(value);
    return std::abs(value - whole) <= kRounding * std::max(1.0, std::abs(whole)) && isLabel(whole, label);
}

/// The first voxel that is no label, by its place in `in`; nullopt: all are.
template <class T>
std::optional<std::size_t> convertAll(std::span<const std::byte> in, bool bigEndian, double slope,
                                      double intercept, std::span<std::uint32_t> out, double& found) {
    const bool isScaled = slope != 1 || intercept != 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const T number = numberAt<T>(in.data() + i * sizeof(T), bigEndian);
        const double scaled = isScaled ? slope * static_cast<double>(number) + intercept : 0;
        if (isScaled ? !isScaledLabel(scaled, out[i]) : !isLabel(number, out[i])) {
            found = isScaled ? scaled : static_cast<double>(number);
            return i;
        }
    }
    return std::nullopt;
}

} // namespace

void LabelValues::convert(std::span<const std::byte> in, std::span<std::uint32_t> out) {
    TESSERA_CHECK(in.size() == out.size() * bytesPerFileValue(type_));
    double found = 0;
    const auto converted = [&](auto typed) {
        return convertAll<decltype(typed)>(in, bigEndian_, slope_, intercept_, out, found);
    };
    const auto byType = [&]() -> std::optional<std::size_t> {
        switch (type_) {
        case FileType::i8:
            return converted(std::int8_t{});
        case FileType::u8:
            return converted(std::uint8_t{});
        case FileType::i16:
            return converted(std::int16_t{});
        case FileType::u16:
            return converted(std::uint16_t{});
        case FileType::i32:
            return converted(std::int32_t{});
        case FileType::u32:
            return converted(std::uint32_t{});
        case FileType::i64:
            return converted(std::int64_t{});
        case FileType::u64:
            return converted(std::uint64_t{});
        case FileType::f32:
            return converted(float{});
        case FileType::f64:
            return converted(double{});
        }
        return std::nullopt;
    };
    if (const auto wrong = byType()) {
        const std::uint64_t at = done_ + *wrong;
        const auto nx = static_cast<std::uint64_t>(extent_.x), ny = static_cast<std::uint64_t>(extent_.y);
        throw badFile(file_, "labels: whole numbers from 0 to 4294967295",
                      numberText(found, 10) + " in voxel (" + std::to_string(at % nx) + ", " +
                          std::to_string(at / nx % ny) + ", " + std::to_string(at / nx / ny) + ")");
    }
    done_ += out.size();
}

} // namespace tessera
