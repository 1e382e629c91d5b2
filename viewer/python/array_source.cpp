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
constexpr std::size_t kAtOnceBytes = std::size_t{1}
                                     << 20; // of rows that are gathered before they are converted

std::size_t bytesInArray(const ArrayVoxels& array) {
    return array.isHalf ? sizeof(std::uint16_t) : bytesPerFileValue(array.type);
}

float floatAt(const std::byte* half, bool bigEndian) {
    const auto low = static_cast<unsigned>(half[bigEndian ? 1 : 0]),
               high = static_cast<unsigned>(half[bigEndian ? 0 : 1]);
    return floatOfHalf(static_cast<std::uint16_t>(high << 8 | low));
}

class ArraySource final : public RandomSlabSource {
  public:
    ArraySource(const ArrayVoxels& array, const VolumeInfo& info)
        : array_(array), info_(info),
          converter_(array.type, array.bigEndian && !array.isHalf, [this](const auto& visit) {
              std::vector<std::byte> piece;
              for (int z = 0; z < info_.extentVoxels.z; ++z) {
                  checkInterrupted();
                  eachPiece(info_.extentVoxels.y, [&](int first, int count) {
                      piece.resize(gatheredBytes(count));
                      gather(z, first, count, piece);
                      visit(piece);
                  });
              }
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return "an array"; }
    VoxelTally takeTally() override { return converter_.takeTally(); }

    void readSliceAt(int z, std::span<std::byte> out) override { readRows(z, 0, info_.extentVoxels.y, out); }
    RowAccess rowAccess() const override { return RowAccess::any; }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        const std::size_t rowBytes = rowBytesOf(info_);
        TESSERA_CHECK(out.size() == rowBytes * static_cast<std::size_t>(count));
        eachPiece(count, [&](int row, int rows) {
            const auto to = out.subspan(rowBytes * static_cast<std::size_t>(row),
                                        rowBytes * static_cast<std::size_t>(rows));
            if (converter_.keepsBytes()) {
                gather(z, first + row, rows, to);
                return converter_.count(to, info_);
            }
            buffer_.resize(gatheredBytes(rows));
            gather(z, first + row, rows, buffer_);
            converter_.convert(buffer_, to, info_);
        });
    }

  private:
    std::size_t gatheredBytes(int rows) const {
        return static_cast<std::size_t>(rows) * static_cast<std::size_t>(info_.extentVoxels.x) *
               bytesPerFileValue(array_.type);
    }
    template <typename Body> void eachPiece(int rows, const Body& body) const {
        const int most = static_cast<int>(std::clamp<std::size_t>(
            kAtOnceBytes / gatheredBytes(1), 1, static_cast<std::size_t>(std::max(rows, 1))));
        for (int first = 0; first < rows; first += most)
            body(first, std::min(most, rows - first));
    }
    /// Rows of a slice, their numbers one after another.
    void gather(int z, int first, int count, std::span<std::byte> out) const {
        const std::size_t bytes = bytesPerFileValue(array_.type);
        const auto width = static_cast<std::size_t>(info_.extentVoxels.x);
        std::byte* to = out.data();
        for (int y = first; y < first + count; ++y) {
            const std::byte* from = array_.first + z * array_.strides[2] + y * array_.strides[1];
            if (!array_.isHalf && array_.strides[0] == static_cast<std::ptrdiff_t>(bytes)) {
                std::memcpy(to, from, bytes * width);
                to += bytes * width;
                continue;
            }
            for (std::size_t x = 0; x < width; ++x, from += array_.strides[0], to += bytes) {
                if (array_.isHalf) {
                    const float value = floatAt(from, array_.bigEndian);
                    std::memcpy(to, &value, sizeof value);
                } else {
                    std::memcpy(to, from, bytes);
                }
            }
        }
    }

    ArrayVoxels array_; // its axes are those of the volume
    VolumeInfo info_;
    SliceConverter converter_;
    std::vector<std::byte> buffer_;
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
    requirePlausibleRescale(
        info.rescaleSlope, info.rescaleIntercept,
        isReal ? 0 : std::ldexp(1.0, std::min(kDigits, static_cast<int>(8 * bytesInArray(array)))), false,
        "slope", "intercept", kWhere);
    info.validate(kWhere);
    if (info.unit == "HU")
        info.fillStored = fillOf(info);
    info = orientedInfo(info);
    ArrayVoxels turned = array;
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
