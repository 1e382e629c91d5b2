// bricking/import/source/slice_converter.h: from the numbers of a file's slices to the stored values of a
// volume: their types and their conversion.
#pragma once

#include "bricking/import/source/voxel_tally.h"
#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

// Conversion of the number types that files use to the four that a store holds. It is lossless if possible
// (i8 widens to i16). 32- and 64-bit integers and doubles become float32, which keeps integers exactly up to
// 2^24 only. Sources report this in describe().

enum class FileType : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

std::size_t bytesPerFileValue(FileType type);
/// "int8" ... "float64".
const char* name(FileType type);
/// The inverse of name(); nullopt for any other word.
std::optional<FileType> fileTypeOf(const std::string& name);
/// The type that the store holds for it.
ValueType storedTypeOf(FileType type);
/// True where the stored type cannot hold every value of the file type exactly (i32, u32, i64, u64, f64).
bool losesPrecision(FileType type);

/// Counts of changed values.
struct VoxelCounts {
    std::uint64_t nonFinite = 0; // NaN and infinities, replaced
    std::uint64_t clamped = 0;   // finite doubles beyond float32, clamped to its largest value
    RoundingTally rounded;       // values that float32 cannot hold exactly, unscaled
};

/// Converts in.size() / bytesPerFileValue(type) values into little-endian stored values.
/// out.size() must be that count times bytesPerValue(storedTypeOf(type)). in and out may not overlap.
/// Values that are not finite become absentStored.
void storeVoxels(FileType type, bool bigEndian, std::span<const std::byte> in, double absentStored,
                 std::span<std::byte> out, VoxelCounts& counts);

/// Range of finite stored values.
struct ValueRange {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    bool isEmpty() const { return least > most; }
};
/// Widens the range by in.size() / bytesPerFileValue(type) values.
void widen(ValueRange& range, FileType type, bool bigEndian, std::span<const std::byte> in);

// Converts slices of a file's numbers to slices of stored values. A voxel without a number (NaN: a mask, a
// field of view) gets the lowest value of the data. A 0 would be water in a CT: an opaque slab around the
// masked region.

class SliceConverter {
  public:
    /// Calls its argument with all voxels of the file, in portions, from the first one.
    using VisitVoxels = std::function<void(const std::function<void(std::span<const std::byte>)>&)>;

    /// visitAll is called once, and only if there is a voxel without a number.
    SliceConverter(FileType type, bool bigEndian, VisitVoxels visitAll);
    /// Converts whole rows as storeVoxels() does and updates info: nonFiniteVoxels, absentStored,
    /// clampedVoxels. Throws what visitAll throws.
    void convert(std::span<const std::byte> in, std::span<std::byte> out, VolumeInfo& info);
    /// True if stored values are the file's own bytes, whatever they are: then count() does for convert().
    bool keepsBytes() const;
    void count(std::span<const std::byte> stored, const VolumeInfo& info);
    /// Of what was converted since the last call. Only numbers without a scale and a unit may be labels.
    VoxelTally takeTally();

  private:
    void findLowest(VolumeInfo& info) const;

    FileType type_;
    bool bigEndian_;
    VisitVoxels visitAll_;
    VoxelTally tally_;
};

} // namespace tessera
