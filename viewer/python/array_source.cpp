// viewer/python/array_source.cpp: see array_source.h.
#include "viewer/python/array_source.h"

#include "bricking/import/source/half_floats.h"
#include "bricking/import/source/oriented_source.h"
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace tessera::python {
namespace {

constexpr const char* kWhere = "array";
constexpr std::size_t kAtOnceBytes = std::size_t{1} << 20; // gathered before they are converted

/// Halves as floats.
void widenHalves(std::span<const std::byte> halves, bool bigEndian, std::vector<std::byte>& floats) {
    floats.resize(2 * halves.size());
    for (std::size_t at = 0; at < halves.size(); at += 2) {
        const auto low = static_cast<unsigned>(halves[at + (bigEndian ? 1 : 0)]),
                   high = static_cast<unsigned>(halves[at + (bigEndian ? 0 : 1)]);
        const float value = floatOfHalf(static_cast<std::uint16_t>(high << 8 | low));
        std::memcpy(floats.data() + 2 * at, &value, sizeof value);
    }
}

class ArraySource final : public RandomSlabSource {
  public:
    ArraySource(const ArrayVoxels& array, const VolumeInfo& info)
        : array_(array), info_(info),
          converter_(array.type, array.bigEndian && !array.isHalf, [this](const auto& visit) {
              Room room;
              for (const ArrayBlock& piece : piecesOf(array_, whole(), kAtOnceBytes)) {
                  checkInterrupted();
                  visit(numbersOf(piece, room));
              }
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return "an array"; }
    VoxelTally takeTally() override { return converter_.takeTally(); }

    void readSliceAt(int z, std::span<std::byte> out) override { readSlicesAt(z, 1, out); }
    void readSlicesAt(int first, int count, std::span<std::byte> out) override {
        TESSERA_CHECK(out.size() == sliceBytesOf(info_) * static_cast<std::size_t>(count));
        read({first, count, 0, info_.extentVoxels.y}, out);
    }
    RowAccess rowAccess() const override { return RowAccess::any; }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        TESSERA_CHECK(out.size() == rowBytesOf(info_) * static_cast<std::size_t>(count));
        read({z, 1, first, count}, out);
    }

  private:
    struct Room {
        std::vector<std::byte> numbers, floats;
    };

    ArrayBlock whole() const { return {0, info_.extentVoxels.z, 0, info_.extentVoxels.y}; }
    std::size_t bytesOf(const ArrayBlock& block) const { // of a slice of it, in the array's numbers
        return static_cast<std::size_t>(block.rows) * static_cast<std::size_t>(info_.extentVoxels.x) *
               array_.bytes();
    }
    /// As the converter takes them.
    std::span<const std::byte> numbersOf(const ArrayBlock& piece, Room& room) const {
        const std::size_t sliceBytes = bytesOf(piece);
        room.numbers.resize(sliceBytes * static_cast<std::size_t>(piece.slices));
        gatherBlock(array_, piece, room.numbers.data(), sliceBytes);
        if (!array_.isHalf)
            return room.numbers;
        widenHalves(room.numbers, array_.bigEndian, room.floats);
        return room.floats;
    }
    /// @param out  [z][y][x] of the block
    void read(const ArrayBlock& block, std::span<std::byte> out) {
        const std::size_t rowBytes = rowBytesOf(info_),
                          sliceBytes = rowBytes * static_cast<std::size_t>(block.rows);
        for (const ArrayBlock& piece : piecesOf(array_, block, kAtOnceBytes)) {
            checkInterrupted();
            const auto rowsOut = [&](int slice) {
                return out.subspan(static_cast<std::size_t>(piece.slice - block.slice + slice) * sliceBytes +
                                       static_cast<std::size_t>(piece.row - block.row) * rowBytes,
                                   static_cast<std::size_t>(piece.rows) * rowBytes);
            };
            if (converter_.keepsBytes()) {
                gatherBlock(array_, piece, rowsOut(0).data(), sliceBytes);
                for (int slice = 0; slice < piece.slices; ++slice)
                    converter_.count(rowsOut(slice), info_);
                continue;
            }
            const std::span<const std::byte> numbers = numbersOf(piece, room_);
            const std::size_t bytes = numbers.size() / static_cast<std::size_t>(piece.slices);
            for (int slice = 0; slice < piece.slices; ++slice)
                converter_.convert(numbers.subspan(static_cast<std::size_t>(slice) * bytes, bytes),
                                   rowsOut(slice), info_);
        }
    }

    ArrayVoxels array_; // its axes are those of the volume
    VolumeInfo info_;
    SliceConverter converter_;
    Room room_;
};

/// Air of a CT is its natural padding, where the stored type has it.
double fillOf(const VolumeInfo& info) {
    constexpr double kAirHu = -1024;
    const double stored = (kAirHu - info.rescaleIntercept) / info.rescaleSlope;
    return withValueType(info.type, [&](auto typed) {
        using Stored = decltype(typed);
        if constexpr (std::is_floating_point_v<Stored>)
            return static_cast<double>(static_cast<float>(stored));
        else
            return stored == std::floor(stored) && stored >= std::numeric_limits<Stored>::min() &&
                           stored <= std::numeric_limits<Stored>::max()
                       ? stored
                       : 0.0;
    });
}

} // namespace

std::unique_ptr<SlabSource> makeArraySource(const ArrayVoxels& array) {
    VolumeInfo info;
    info.extentVoxels = array.extent;
    info.type = storedTypeOf(array.type);
    info.patientFromVoxel = array.patientFromVoxel;
    info.orientationKnown = array.orientationKnown;
    info.rescaleSlope = array.slope;
    info.rescaleIntercept = array.intercept;
    info.unit = array.unit;
    requirePlausibleGeometry(info, {"spacing", "direction", "origin"}, kWhere);
    const bool isReal = array.type == FileType::f32 || array.type == FileType::f64;
    constexpr int kDigits = 24; // of a float
    requirePlausibleRescale(info.rescaleSlope, info.rescaleIntercept,
                            isReal ? 0
                                   : std::ldexp(1.0, std::min(kDigits, static_cast<int>(8 * array.bytes()))),
                            false, "slope", "intercept", kWhere);
    info.validate(kWhere);
    if (info.unit == "HU")
        info.fillStored = fillOf(info);
    info = orientedInfo(info);
    ArrayVoxels turned = array;
    turned.extent = info.extentVoxels;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto source = static_cast<std::size_t>(info.originalOrder.sourceAxis[axis]);
        turned.strides[axis] = array.strides[source];
        if (!info.originalOrder.flipped[axis])
            continue;
        turned.first += (array.extent[static_cast<int>(source)] - 1) * array.strides[source];
        turned.strides[axis] = -array.strides[source];
    }
    return std::make_unique<ArraySource>(turned, info);
}

} // namespace tessera::python
