// bricking/import/source/slice_converter.cpp: see slice_converter.h.
#include "bricking/import/source/slice_converter.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "stored values are copied as they lie in memory");

struct TypeRow {
    FileType type;
    const char* name;
    std::size_t bytes;
    ValueType stored;
};
constexpr std::array<TypeRow, 10> kTypes = {{
    {FileType::i8, "int8", 1, ValueType::i16},
    {FileType::u8, "uint8", 1, ValueType::u8},
    {FileType::i16, "int16", 2, ValueType::i16},
    {FileType::u16, "uint16", 2, ValueType::u16},
    {FileType::i32, "int32", 4, ValueType::f32},
    {FileType::u32, "uint32", 4, ValueType::f32},
    {FileType::i64, "int64", 8, ValueType::f32},
    {FileType::u64, "uint64", 8, ValueType::f32},
    {FileType::f32, "float32", 4, ValueType::f32},
    {FileType::f64, "float64", 8, ValueType::f32},
}};

const TypeRow& row(FileType type) {
    return kTypes[static_cast<std::size_t>(type)];
}

template <class T> T load(const std::byte* from, bool bigEndian) {
    std::array<std::byte, sizeof(T)> bytes;
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes[i] = from[bigEndian ? sizeof(T) - 1 - i : i];
    return std::bit_cast<T>(bytes);
}

/// Counts a value that its stored one does not equal.
void countRounded(long double value, long double stored, std::uint64_t& count, RoundingTally& rounded) {
    const auto change = static_cast<double>(std::abs(stored - value));
    ++count;
    rounded.most = std::max(rounded.most, change);
    rounded.mostPart = std::max(rounded.mostPart, static_cast<double>(std::abs((stored - value) / value)));
}

template <class Out> Out toStored(auto value, double absentStored, VoxelCounts& counts) {
    if constexpr (std::is_floating_point_v<decltype(value)>) {
        if (!std::isfinite(value)) {
            ++counts.nonFinite;
            return static_cast<Out>(absentStored);
        }
        constexpr double kLargest = std::numeric_limits<float>::max();
        if (std::abs(static_cast<double>(value)) > kLargest) {
            ++counts.clamped;
            return static_cast<Out>(std::copysign(kLargest, static_cast<double>(value)));
        }
        if constexpr (sizeof(value) > sizeof(Out))
            if (const auto stored = static_cast<Out>(value); static_cast<double>(stored) != value)
                countRounded(value, stored, counts.rounded.real, counts.rounded);
    }
    if constexpr (std::is_integral_v<decltype(value)> && std::is_floating_point_v<Out> && sizeof(value) >= 4)
        if (const long double stored = static_cast<Out>(value), exact = value; stored != exact)
            countRounded(exact, stored, counts.rounded.whole, counts.rounded);
    return static_cast<Out>(value);
}

template <class In, class Out>
void convert(bool bigEndian, std::span<const std::byte> in, double absentStored, std::span<std::byte> out,
             VoxelCounts& counts) {
    if (std::is_same_v<In, Out> && std::is_integral_v<In> && (!bigEndian || sizeof(In) == 1)) {
        std::memcpy(out.data(), in.data(), in.size());
        return;
    }
    const std::size_t count = in.size() / sizeof(In);
    for (std::size_t i = 0; i < count; ++i) {
        const Out value =
            toStored<Out>(load<In>(in.data() + i * sizeof(In), bigEndian), absentStored, counts);
        std::memcpy(out.data() + i * sizeof(Out), &value, sizeof(Out));
    }
}

} // namespace

std::size_t bytesPerFileValue(FileType type) {
    return row(type).bytes;
}
const char* name(FileType type) {
    return row(type).name;
}
ValueType storedTypeOf(FileType type) {
    return row(type).stored;
}

std::optional<FileType> fileTypeOf(const std::string& name) {
    for (const TypeRow& candidate : kTypes)
        if (name == candidate.name)
            return candidate.type;
    return std::nullopt;
}

bool losesPrecision(FileType type) {
    return storedTypeOf(type) == ValueType::f32 && type != FileType::f32;
}

namespace {

/// Calls body with a value, 0, of the C++ type that a FileType names.
template <class Body> void withFileType(FileType type, const Body& body) {
    switch (type) {
    case FileType::i8:
        return body(std::int8_t{});
    case FileType::u8:
        return body(std::uint8_t{});
    case FileType::i16:
        return body(std::int16_t{});
    case FileType::u16:
        return body(std::uint16_t{});
    case FileType::i32:
        return body(std::int32_t{});
    case FileType::u32:
        return body(std::uint32_t{});
    case FileType::i64:
        return body(std::int64_t{});
    case FileType::u64:
        return body(std::uint64_t{});
    case FileType::f32:
        return body(float{});
    case FileType::f64:
        return body(double{});
    }
}

} // namespace

void storeVoxels(FileType type, bool bigEndian, std::span<const std::byte> in, double absentStored,
                 std::span<std::byte> out, VoxelCounts& counts) {
    TESSERA_CHECK(in.size() / bytesPerFileValue(type) * bytesPerValue(storedTypeOf(type)) == out.size());
    withFileType(type, [&](auto typed) {
        using In = decltype(typed);
        withValueType(storedTypeOf(type), [&](auto stored) {
            convert<In, decltype(stored)>(bigEndian, in, absentStored, out, counts);
        });
    });
}

void widen(ValueRange& range, FileType type, bool bigEndian, std::span<const std::byte> in) {
    withFileType(type, [&](auto typed) {
        using In = decltype(typed);
        for (std::size_t at = 0; at + sizeof(In) <= in.size(); at += sizeof(In)) {
            const In value = load<In>(in.data() + at, bigEndian);
            VoxelCounts counts;
            const auto stored = static_cast<double>(toStored<float>(value, 0, counts));
            if (counts.nonFinite == 0) {
                range.least = std::min(range.least, stored);
                range.most = std::max(range.most, stored);
            }
        }
    });
}

SliceConverter::SliceConverter(FileType type, bool bigEndian, VisitVoxels visitAll)
    : type_(type), bigEndian_(bigEndian), visitAll_(std::move(visitAll)) {}

void SliceConverter::convert(std::span<const std::byte> in, std::span<std::byte> out, VolumeInfo& info) {
    VoxelCounts counts;
    storeVoxels(type_, bigEndian_, in, info.absentStored, out, counts);
    if (counts.nonFinite > 0 && info.nonFiniteVoxels == 0) {
        findLowest(info);
        counts = {};
        storeVoxels(type_, bigEndian_, in, info.absentStored, out, counts);
    }
    info.nonFiniteVoxels += counts.nonFinite;
    info.clampedVoxels += counts.clamped;
    counts.rounded.most *= std::abs(info.rescaleSlope);
    tally_.rounded.add(counts.rounded);
    count(out, info);
}

bool SliceConverter::keepsBytes() const {
    switch (type_) {
    case FileType::u8:
        return true;
    case FileType::i16:
    case FileType::u16:
        return !bigEndian_;
    default:
        return false;
    }
}

void SliceConverter::count(std::span<const std::byte> stored, const VolumeInfo& info) {
    const bool isBare = info.rescaleSlope == 1 && info.rescaleIntercept == 0 && info.unit.empty();
    if (isBare)
        tally_.labels.add(stored, info.type, static_cast<std::size_t>(info.extentVoxels.x));
}

VoxelTally SliceConverter::takeTally() {
    return std::exchange(tally_, {});
}

void SliceConverter::findLowest(VolumeInfo& info) const {
    ValueRange range;
    visitAll_([&](std::span<const std::byte> voxels) { widen(range, type_, bigEndian_, voxels); });
    // A negative slope turns the data over: its lowest physical value is the highest stored one.
    info.absentStored = range.isEmpty() ? info.fillStored : info.rescaleSlope < 0 ? range.most : range.least;
}

} // namespace tessera
