// bricking/import/files/hdf5/h5_types.cpp: see h5_types.h.
#include "bricking/import/files/hdf5/h5_types.h"

#include <array>

namespace tessera {
namespace {

FileType wholeOf(std::size_t bytes, bool isSigned) {
    constexpr std::array kTypes = {FileType::u8,  FileType::i8,  FileType::u16, FileType::i16,
                                   FileType::u32, FileType::i32, FileType::u64, FileType::i64};
    return kTypes[2 * static_cast<std::size_t>(log2Of(bytes)) + (isSigned ? 1 : 0)];
}

} // namespace

std::uint64_t H5Space::count() const {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 62;
    std::uint64_t all = 1;
    for (const std::uint64_t extent : extents) {
        if (extent == 0)
            return 0;
        all = extent > kMost / all ? kMost : all * extent;
    }
    return all;
}

H5Space readH5Space(H5Bytes& bytes) {
    const int version = bytes.byte();
    bytes.requireVersion(version, 1, 2);
    const auto axes = static_cast<std::size_t>(bytes.byte());
    const bool hasMost = (bytes.byte() & 1) != 0;
    if (axes > kMostH5Axes)
        bytes.refuse("32 axes at most", std::to_string(axes));
    const bool isNull = version == 2 && bytes.byte() == 2;
    bytes.skip(version == 1 ? 5 : 0);
    H5Space space;
    for (std::size_t axis = 0; axis < axes; ++axis)
        space.extents.push_back(bytes.length());
    const std::uint64_t unlimited = kH5Unlimited >> (64 - 8 * bytes.file().lengthBytes());
    for (std::size_t axis = 0; axis < axes; ++axis) {
        const std::uint64_t most = hasMost ? bytes.length() : space.extents[axis];
        space.most.push_back(hasMost && most == unlimited ? kH5Unlimited : most);
        if (space.most[axis] < space.extents[axis])
            bytes.refuse("extents up to the largest that they may have", "one above it");
    }
    if (isNull)
        space.extents = space.most = {0};
    return space;
}

H5Type readH5Type(H5Bytes& bytes) {
    H5Type type;
    const int first = bytes.byte(), kind = first & 15;
    bytes.requireVersion(first >> 4, 1, 5);
    const std::uint64_t bits = bytes.number(3);
    type.bytes = bytes.number(4);
    constexpr int kWhole = 0, kFloat = 1, kText = 3;
    constexpr std::array kNames = {"whole numbers", "floats",
                                   "times",         "strings",
                                   "bit fields",    "bytes without a meaning",
                                   "structures",    "references",
                                   "enumerations",  "sequences of varying length",
                                   "arrays",        "complex numbers"};
    type.what = static_cast<std::size_t>(kind) < kNames.size() ? kNames[static_cast<std::size_t>(kind)]
                                                               : "a type of another kind";
    type.isText = kind == kText;
    type.isBig = (bits & 1) != 0;
    if ((kind != kWhole && kind != kFloat) || type.bytes > 8 || type.bytes < 1)
        return type;
    const std::uint64_t offset = bytes.number(2), precision = bytes.number(2);
    type.what += " of " + std::to_string(precision) + " bits in " + std::to_string(type.bytes) + " bytes";
    const bool isWhole = offset == 0 && precision == 8 * type.bytes && (type.bytes & (type.bytes - 1)) == 0;
    constexpr std::uint64_t kSigned = 8, kVax = 64;
    if (kind == kWhole && isWhole)
        type.number = wholeOf(type.bytes, (bits & kSigned) != 0);
    if (kind != kFloat || !isWhole || (bits & kVax) != 0)
        return type;
    struct Ieee {
        std::uint64_t bytes, exponentBits, bias;
        FileType type;
    };
    constexpr std::array kFloats = {Ieee{2, 5, 15, FileType::f32}, Ieee{4, 8, 127, FileType::f32},
                                    Ieee{8, 11, 1023, FileType::f64}};
    constexpr std::uint64_t kImplied = 2; // the mantissa's first bit
    const std::uint64_t exponentAt = bytes.number(1), exponentBits = bytes.number(1),
                        mantissaAt = bytes.number(1), mantissaBits = bytes.number(1), bias = bytes.number(4);
    for (const Ieee& ieee : kFloats)
        if (ieee.bytes == type.bytes && ieee.exponentBits == exponentBits && ieee.bias == bias &&
            mantissaAt == 0 && mantissaBits == exponentAt && exponentAt == precision - 1 - exponentBits &&
            (bits >> 8 & 255) == precision - 1 && (bits >> 4 & 3) == kImplied)
            type.number = ieee.type;
    type.isHalf = type.number && type.bytes == 2;
    return type;
}

std::optional<H5Shape> shapeOf(const H5Object& object) {
    auto space = object.find(H5Kind::space), type = object.find(H5Kind::type);
    if (!space || !type || !object.has(H5Kind::layout))
        return std::nullopt;
    return H5Shape{readH5Space(*space), readH5Type(*type)};
}

} // namespace tessera
