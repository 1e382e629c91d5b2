// bricking/import/voxel_types.cpp: see voxel_types.h.
#include "bricking/import/voxel_types.h"

#include "core/error.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

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

template <class Out> Out toStored(auto value, double fillStored, VoxelCounts& counts) {
    if constexpr (std::is_floating_point_v<decltype(value)>) {
        if (!std::isfinite(value)) {
            ++counts.nonFinite;
            return static_cast<Out>(fillStored);
        }
        constexpr double kLargest = std::numeric_limits<float>::max();
        if (std::abs(static_cast<double>(value)) > kLargest) {
            ++counts.clamped;
            return static_cast<Out>(std::copysign(kLargest, static_cast<double>(value)));
        }
    }
    return static_cast<Out>(value);
}

template <class In, class Out>
void convert(bool bigEndian, std::span<const std::byte> in, double fillStored, std::span<std::byte> out,
             VoxelCounts& counts) {
    if (std::is_same_v<In, Out> && std::is_integral_v<In> && (!bigEndian || sizeof(In) == 1)) {
        std::memcpy(out.data(), in.data(), in.size());
        return;
    }
    const std::size_t count = in.size() / sizeof(In);
    for (std::size_t i = 0; i < count; ++i) {
        const Out value = toStored<Out>(load<In>(in.data() + i * sizeof(In), bigEndian), fillStored, counts);
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

void storeVoxels(FileType type, bool bigEndian, std::span<const std::byte> in, double fillStored,
                 std::span<std::byte> out, VoxelCounts& counts) {
    TESSERA_CHECK(in.size() / bytesPerFileValue(type) * bytesPerValue(storedTypeOf(type)) == out.size());
    switch (type) {
    case FileType::i8:
        return convert<std::int8_t, std::int16_t>(bigEndian, in, fillStored, out, counts);
    case FileType::u8:
        return convert<std::uint8_t, std::uint8_t>(bigEndian, in, fillStored, out, counts);
    case FileType::i16:
        return convert<std::int16_t, std::int16_t>(bigEndian, in, fillStored, out, counts);
    case FileType::u16:
        return convert<std::uint16_t, std::uint16_t>(bigEndian, in, fillStored, out, counts);
    case FileType::i32:
        return convert<std::int32_t, float>(bigEndian, in, fillStored, out, counts);
    case FileType::u32:
        return convert<std::uint32_t, float>(bigEndian, in, fillStored, out, counts);
    case FileType::i64:
        return convert<std::int64_t, float>(bigEndian, in, fillStored, out, counts);
    case FileType::u64:
        return convert<std::uint64_t, float>(bigEndian, in, fillStored, out, counts);
    case FileType::f32:
        return convert<float, float>(bigEndian, in, fillStored, out, counts);
    case FileType::f64:
        return convert<double, float>(bigEndian, in, fillStored, out, counts);
    }
}

} // namespace tessera
