// bricking/export/exported_values.h: the numbers that a file gets for a volume's stored values: as they are,
// where the file keeps slope and intercept or there are none to keep, else the physical values.
#pragma once

#include "bricking/export/box_source.h"
#include "bricking/import/source/slice_converter.h" // FileType
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Value of the file = slope * stored + intercept, as a number of that type.
struct ExportedValues {
    FileType type = FileType::i16;
    double slope = 1, intercept = 0; // 1, 0: stored values as they are
    bool isRounded = false;          // to float32: physical values that are no whole numbers
    bool isStored() const { return slope == 1 && intercept == 0; }
};

/// As they are stored, with slope and intercept for the file to keep.
ExportedValues storedValues(const VolumeInfo& info);
/// Physical values. Whole ones get the smallest of the types that holds all of the box's, without rounding:
/// first the stored type, then int16, uint16 and int32; else float32. Reads the box where types alone do not
/// decide, then rewinds it.
/// @param types  that the file can hold, float32 among them
ExportedValues physicalValues(BoxSource& box, std::span<const FileType> types, MemoryBudget& ram,
                              Progress& progress);

/// Of the box's stored values, from the next slice on; then rewinds it.
ValueRange storedRange(BoxSource& box, MemoryBudget& ram, Progress& progress);

/// Converts stored values: out.size() is their count times bytesPerFileValue(values.type).
void convertValues(ValueType stored, std::span<const std::byte> in, const ExportedValues& values,
                   std::span<std::byte> out);

/// Gets the next slices of the box as the file's numbers, little-endian: [slices][y][x]. Portions of a slice
/// come in order.
using TakeNumbers = std::function<void(std::span<const std::byte> numbers)>;

/// Passes on all slices of the box from the next one on, and checks for Ctrl-C. Memory: as many slices as
/// chunks have, or as fit into the free bytes of ram but for `kept`; at least one, else InputError.
/// @param kept  bytes of ram to leave to the taker
void streamNumbers(BoxSource& box, const ExportedValues& values, MemoryBudget& ram, Progress& progress,
                   const TakeNumbers& take, std::size_t kept = 0);
/// The same with whole slices.
using TakeSlices = std::function<void(int first, int count, std::span<const std::byte> stored)>;
void streamSlices(BoxSource& box, MemoryBudget& ram, Progress& progress, const TakeSlices& take,
                  std::size_t kept = 0);

/// "HU as int16", "uint16 as stored, with slope 1 ...": for the message.
std::string sayValues(const VolumeInfo& info, const ExportedValues& values, bool keepsRescale);

} // namespace tessera
