// bricking/export/exported_values.cpp: see exported_values.h.
#include "bricking/export/exported_values.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

namespace tessera {
namespace {

FileType sameTypeAs(ValueType type) {
    switch (type) {
    case ValueType::u8:
        return FileType::u8;
    case ValueType::i16:
        return FileType::i16;
    case ValueType::u16:
        return FileType::u16;
    case ValueType::f32:
        break;
    }
    return FileType::f32;
}

/// Whole numbers that a type holds exactly.
ValueRange rangeOf(FileType type) {
    switch (type) {
    case FileType::u8:
        return {0, 255};
    case FileType::i16:
        return {-32768, 32767};
    case FileType::u16:
        return {0, 65535};
    default:
        return {-2147483648.0, 2147483647.0}; // int32
    }
}

bool isWhole(double value) {
    constexpr double kMost = 1e9;
    return std::abs(value) <= kMost && value == std::floor(value);
}

/// The first type of those that holds all whole numbers of a range; nullopt: none does.
std::optional<FileType> typeFor(const ValueRange& range, FileType stored, std::span<const FileType> types) {
    for (const FileType type : {stored, FileType::i16, FileType::u16, FileType::i32}) {
        const ValueRange held = rangeOf(type);
        if (std::find(types.begin(), types.end(), type) != types.end() && held.least <= range.least &&
            range.most <= held.most)
            return type;
    }
    return std::nullopt;
}

ValueRange physicalRange(const ValueRange& stored, const VolumeInfo& info) {
    const double a = info.rescaleSlope * stored.least + info.rescaleIntercept,
                 b = info.rescaleSlope * stored.most + info.rescaleIntercept;
    return {std::min(a, b), std::max(a, b)};
}

template <class To> void putNumber(double value, std::byte* out) {
    const auto number = static_cast<To>(value);
    std::memcpy(out, &number, sizeof number);
}

} // namespace

ExportedValues storedValues(const VolumeInfo& info) {
    return {.type = sameTypeAs(info.type)};
}

ExportedValues physicalValues(BoxSource& box, std::span<const FileType> types, MemoryBudget& ram,
                              Progress& progress) {
    const VolumeInfo& info = box.info();
    const FileType stored = sameTypeAs(info.type);
    const bool holdsStored = std::find(types.begin(), types.end(), stored) != types.end();
    const bool isRescaled = info.rescaleSlope != 1 || info.rescaleIntercept != 0;
    if (!isRescaled && holdsStored)
        return {.type = stored};
    ExportedValues values{FileType::f32, info.rescaleSlope, info.rescaleIntercept, isRescaled};
    if (info.type == ValueType::f32 || !isWhole(info.rescaleSlope) || !isWhole(info.rescaleIntercept))
        return values;
    values.isRounded = false;
    std::optional<FileType> type = typeFor(physicalRange(rangeOf(stored), info), stored, types);
    if (!type || bytesPerFileValue(*type) > bytesPerValue(info.type)) { // not all values may be in the box
        const ValueRange range = physicalRange(storedRange(box, ram, progress), info);
        type = typeFor(range, stored, types);
        constexpr double kExactInFloat = 16777216; // 2^24
        values.isRounded = !type && std::max(-range.least, range.most) > kExactInFloat;
    }
    values.type = type.value_or(FileType::f32);
    return values;
}

ValueRange storedRange(BoxSource& box, MemoryBudget& ram, Progress& progress) {
    progress.stage("looking for the range of values");
    const FileType type = sameTypeAs(box.info().type);
    ValueRange found;
    streamSlices(box, ram, progress, [&](int, int count, std::span<const std::byte> slices) {
        const std::size_t slice = slices.size() / static_cast<std::size_t>(count);
        for (std::size_t at = 0; at < slices.size(); at += slice) {
            checkInterrupted();
            widen(found, type, false, slices.subspan(at, slice));
        }
    });
    box.rewind();
    return found;
}

void convertValues(ValueType stored, std::span<const std::byte> in, const ExportedValues& values,
                   std::span<std::byte> out) {
    const std::size_t from = bytesPerValue(stored), to = bytesPerFileValue(values.type),
                      count = in.size() / from;
    TESSERA_CHECK(out.size() == count * to);
    if (values.isStored() && values.type == sameTypeAs(stored)) {
        std::copy(in.begin(), in.end(), out.begin());
        return;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const double value = values.slope * storedValue(stored, in.data() + i * from) + values.intercept;
        std::byte* const at = out.data() + i * to;
        switch (values.type) {
        case FileType::u8:
            putNumber<std::uint8_t>(value, at);
            break;
        case FileType::i16:
            putNumber<std::int16_t>(value, at);
            break;
        case FileType::u16:
            putNumber<std::uint16_t>(value, at);
            break;
        case FileType::i32:
            putNumber<std::int32_t>(value, at);
            break;
        default:
            putNumber<float>(value, at);
        }
    }
}

void streamSlices(BoxSource& box, MemoryBudget& ram, Progress& progress, const TakeSlices& take,
                  std::size_t kept) {
    const VolumeInfo& info = box.info();
    const std::size_t sliceBytes = sliceBytesOf(info);
    int most = std::min(kChunkExtent, info.extentVoxels.z);
    std::optional<Charge> charge;
    for (;; most = (most + 1) / 2) {
        const std::size_t bytes = static_cast<std::size_t>(most) * sliceBytes;
        if (most == 1)
            charge = ram.charge(bytes + kept, "a slice of " + box.describe());
        else
            charge = ram.tryCharge(bytes + kept);
        if (charge)
            break;
    }
    charge.reset(); // the taker has its part
    charge = ram.charge(static_cast<std::size_t>(most) * sliceBytes, "slices of " + box.describe());
    std::vector<std::byte> slab(static_cast<std::size_t>(most) * sliceBytes);
    while (const int left = box.slicesOfChunks()) {
        checkInterrupted();
        const int first = box.nextSlice(), count = std::min(left, most);
        const auto slices = std::span(slab).first(static_cast<std::size_t>(count) * sliceBytes);
        box.readSlices(count, slices);
        take(first, count, slices);
        progress.update(static_cast<double>(first + count) / info.extentVoxels.z);
    }
}

void streamNumbers(BoxSource& box, const ExportedValues& values, MemoryBudget& ram, Progress& progress,
                   const TakeNumbers& take, std::size_t kept) {
    constexpr std::size_t kPortion = 64 * 1024; // values that are converted and passed on at a time
    const ValueType stored = box.info().type;
    const std::size_t from = bytesPerValue(stored), to = bytesPerFileValue(values.type);
    const bool isSame = values.isStored() && values.type == sameTypeAs(stored);
    std::vector<std::byte> converted(isSame ? 0 : kPortion * to);
    streamSlices(
        box, ram, progress,
        [&](int, int, std::span<const std::byte> slices) {
            for (std::size_t at = 0; at < slices.size(); at += kPortion * from) {
                checkInterrupted(); // the taker may deflate for a while
                const auto part = slices.subspan(at, std::min(kPortion * from, slices.size() - at));
                if (isSame) {
                    take(part);
                    continue;
                }
                const auto numbers = std::span(converted).first(part.size() / from * to);
                convertValues(stored, part, values, numbers);
                take(numbers);
            }
        },
        kept);
}

std::string sayValues(const VolumeInfo& info, const ExportedValues& values, bool keepsRescale) {
    const std::string unit = info.unit.empty() ? std::string("values") : info.unit;
    const std::string type = name(values.type);
    const bool isRescaled = info.rescaleSlope != 1 || info.rescaleIntercept != 0;
    if (!isRescaled)
        return unit + " as " + type;
    const std::string rescale =
        "slope " + numberText(info.rescaleSlope, 9) + ", intercept " + numberText(info.rescaleIntercept, 9);
    if (keepsRescale)
        return type + " as stored, with " + rescale + " beside them";
    return unit + " as " + type + ", " + rescale + " applied" +
           (values.isRounded ? " and rounded to float32" : "");
}

} // namespace tessera
