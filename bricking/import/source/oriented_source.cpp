// bricking/import/source/oriented_source.cpp: see oriented_source.h.
#include "bricking/import/source/oriented_source.h"

#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// A plane of values seen through two strides; negative strides walk backwards.
struct PlaneView {
    std::ptrdiff_t origin = 0, strideX = 0, strideY = 0; // in values
};

template <class T>
void copyPlane(const std::byte* from, const PlaneView& view, std::byte* to, int width, int height) {
    const auto* source = reinterpret_cast<const T*>(from) + view.origin;
    auto* target = reinterpret_cast<T*>(to);
    for (int y = 0; y < height; ++y) {
        const T* row = source + y * view.strideY;
        for (int x = 0; x < width; ++x)
            *target++ = row[x * view.strideX];
    }
}

/// Values are moved as unsigned words of their size: no conversion, no canonical NaNs.
void copyPlane(std::size_t valueBytes, const std::byte* from, const PlaneView& view, std::byte* to, int width,
               int height) {
    switch (valueBytes) {
    case 1:
        return copyPlane<std::uint8_t>(from, view, to, width, height);
    case 2:
        return copyPlane<std::uint16_t>(from, view, to, width, height);
    default:
        return copyPlane<std::uint32_t>(from, view, to, width, height);
    }
}

template <class T> void reverseRow(std::span<std::byte> row) {
    auto* const values = reinterpret_cast<T*>(row.data());
    std::reverse(values, values + row.size() / sizeof(T));
}

void reverseRow(std::span<std::byte> row, std::size_t valueBytes) {
    switch (valueBytes) {
    case 1:
        return reverseRow<std::uint8_t>(row);
    case 2:
        return reverseRow<std::uint16_t>(row);
    default:
        return reverseRow<std::uint32_t>(row);
    }
}

class OrientedSource final : public SlabSource {
  public:
    OrientedSource(std::unique_ptr<SlabSource> source, std::filesystem::path scratchFolder)
        : source_(std::move(source)), random_(dynamic_cast<RandomSlabSource*>(source_.get())),
          scratchFolder_(std::move(scratchFolder)), order_(nearestLpsOrder(source_->info().patientFromVoxel)),
          sourceExtent_(source_->info().extentVoxels), info_(orientedInfo(source_->info())),
          valueBytes_(bytesPerValue(info_.type)) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return source_->describe(); }
    std::vector<std::string> notes() const override { return source_->notes(); }
    VoxelTally takeTally() override { return source_->takeTally(); }
    bool seek(int z) override {
        TESSERA_CHECK(z >= 0 && z <= info_.extentVoxels.z);
        const bool readsOn = order_.sourceAxis[2] == 2 && !order_.flipped[2];
        if (readsOn && !source_->seek(z))
            return false;
        next_ = z;
        return true;
    }

    void setThreads(int threads) override { source_->setThreads(threads); }
    RowAccess rowAccess() const override {
        if (order_.sourceAxis != AxisOrder{}.sourceAxis)
            return RowAccess::none;
        const RowAccess access = source_->rowAccess();
        if (access == RowAccess::any)
            return order_.flipped[1] && source_->rowUnit() > 1 ? RowAccess::none : RowAccess::any;
        return order_.flipped[1] || order_.flipped[2] ? RowAccess::none : access;
    }
    int rowUnit() const override { return source_->rowUnit(); }
    std::size_t roomBytes() const override {
        return source_->roomBytes() + (rowAccess() == RowAccess::none ? 2 * sourceSliceBytes() : 0);
    }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        TESSERA_CHECK(rowAccess() != RowAccess::none);
        const std::size_t rowBytes = rowBytesOf(info_);
        source_->readRows(order_.flipped[2] ? sourceExtent_.z - 1 - z : z,
                          order_.flipped[1] ? sourceExtent_.y - first - count : first, count, out);
        const auto row = [&](int n) { return out.subspan(static_cast<std::size_t>(n) * rowBytes, rowBytes); };
        for (int y = 0; order_.flipped[1] && y < count / 2; ++y)
            std::ranges::swap_ranges(row(y), row(count - 1 - y));
        for (int y = 0; order_.flipped[0] && y < count; ++y)
            reverseRow(row(y), valueBytes_);
        takeFindings();
    }

    void readSlices(int count, std::span<std::byte> out) override {
        const std::size_t sliceBytes = sliceBytesOf(info_);
        TESSERA_CHECK(count >= 0 && next_ + count <= info_.extentVoxels.z);
        TESSERA_CHECK(out.size() == static_cast<std::size_t>(count) * sliceBytes);
        if (order_.sourceAxis[2] != 2) {
            if (!spool_)
                spoolWithNewSlicesAsRows();
            gatherRows(count, out);
        } else {
            for (int i = 0; i < count; ++i)
                readOwnSlice(next_ + i, out.subspan(static_cast<std::size_t>(i) * sliceBytes, sliceBytes));
        }
        next_ += count;
        takeFindings();
    }

  private:
    void takeFindings() {
        info_.nonFiniteVoxels = source_->info().nonFiniteVoxels;
        info_.absentStored = source_->info().absentStored;
        info_.clampedVoxels = source_->info().clampedVoxels;
        info_.lossy = source_->info().lossy;
        info_.remarks = source_->info().remarks;
    }

    std::size_t sourceSliceBytes() const {
        return static_cast<std::size_t>(sourceExtent_.x) * static_cast<std::size_t>(sourceExtent_.y) *
               valueBytes_;
    }

    /// z stays: fetch the source's slice, then exchange and reverse x and y within it.
    void readOwnSlice(int z, std::span<std::byte> out) {
        slice_.resize(sourceSliceBytes());
        const int sourceZ = order_.flipped[2] ? sourceExtent_.z - 1 - z : z;
        if (!order_.flipped[2]) {
            source_->readSlices(1, slice_);
        } else if (random_) {
            random_->readSliceAt(sourceZ, slice_);
        } else {
            if (!spool_)
                spoolAsIs();
            spool_->readAt(static_cast<std::uint64_t>(sourceZ) * slice_.size(), slice_);
        }
        const std::array<std::ptrdiff_t, 2> stride = {1, sourceExtent_.x};
        PlaneView view;
        std::array<std::ptrdiff_t, 2> newStride{};
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const auto from = static_cast<std::size_t>(order_.sourceAxis[axis]);
            newStride[axis] = order_.flipped[axis] ? -stride[from] : stride[from];
            if (order_.flipped[axis])
                view.origin += (sourceExtent_[order_.sourceAxis[axis]] - 1) * stride[from];
        }
        view.strideX = newStride[0];
        view.strideY = newStride[1];
        copyPlane(valueBytes_, slice_.data(), view, out.data(), info_.extentVoxels.x, info_.extentVoxels.y);
    }

    void spoolAsIs() {
        spool_.emplace(scratchFolder_);
        std::vector<std::byte> slice(sourceSliceBytes());
        for (int z = 0; z < sourceExtent_.z; ++z) {
            source_->readSlices(1, slice);
            spool_->append(slice);
        }
    }

    /// Another axis becomes z. Each source slice is spooled with that axis as its rows (transposed if it was
    /// x), so that a new slice is one contiguous row of every spooled slice.
    void spoolWithNewSlicesAsRows() {
        spool_.emplace(scratchFolder_);
        std::vector<std::byte> slice(sourceSliceBytes()), turned(slice.size());
        for (int z = 0; z < sourceExtent_.z; ++z) {
            source_->readSlices(1, slice);
            if (order_.sourceAxis[2] == 0) {
                const PlaneView transposed{0, sourceExtent_.x, 1};
                copyPlane(valueBytes_, slice.data(), transposed, turned.data(), sourceExtent_.y,
                          sourceExtent_.x);
                slice.swap(turned);
            }
            spool_->append(slice);
        }
    }

    /// Reads `count` new slices: from each spooled slice one contiguous run of rows, scattered into out.
    void gatherRows(int count, std::span<std::byte> out) {
        const int newZFrom = order_.sourceAxis[2];
        const int rowAxis = 1 - newZFrom; // the source axis along a spooled row (0 or 1)
        const auto rowValues = static_cast<std::size_t>(sourceExtent_[rowAxis]);
        const std::size_t rowBytes = rowValues * valueBytes_;
        const int rows = sourceExtent_[newZFrom];
        const int firstRow = order_.flipped[2] ? rows - next_ - count : next_;
        slice_.resize(static_cast<std::size_t>(count) * rowBytes);

        // The position of the spooled row and of the source's z in the new x and y.
        const std::size_t rowTo = order_.sourceAxis[0] == rowAxis ? 0 : 1, zTo = 1 - rowTo;
        const std::array<std::ptrdiff_t, 2> outStride = {1, info_.extentVoxels.x};
        const std::size_t sliceBytes = sliceBytesOf(info_);
        for (int sourceZ = 0; sourceZ < sourceExtent_.z; ++sourceZ) {
            spool_->readAt(static_cast<std::uint64_t>(sourceZ) * sourceSliceBytes() +
                               static_cast<std::uint64_t>(firstRow) * rowBytes,
                           slice_);
            const std::ptrdiff_t zAt = order_.flipped[zTo] ? sourceExtent_.z - 1 - sourceZ : sourceZ;
            for (int i = 0; i < count; ++i) {
                const int row = order_.flipped[2] ? count - 1 - i : i;
                const std::byte* from = slice_.data() + static_cast<std::size_t>(row) * rowBytes;
                std::byte* to = out.data() + static_cast<std::size_t>(i) * sliceBytes +
                                static_cast<std::size_t>(zAt * outStride[zTo]) * valueBytes_;
                scatterRow(from, rowValues, order_.flipped[rowTo], to,
                           static_cast<std::size_t>(outStride[rowTo]) * valueBytes_);
            }
        }
    }

    void scatterRow(const std::byte* from, std::size_t values, bool reversed, std::byte* to,
                    std::size_t toStrideBytes) const {
        for (std::size_t i = 0; i < values; ++i) {
            const std::size_t at = reversed ? values - 1 - i : i;
            std::memcpy(to + at * toStrideBytes, from + i * valueBytes_, valueBytes_);
        }
    }

    std::unique_ptr<SlabSource> source_;
    RandomSlabSource* random_; // source_, if it can read in any order
    std::filesystem::path scratchFolder_;
    AxisOrder order_;
    glm::ivec3 sourceExtent_;
    VolumeInfo info_;
    std::size_t valueBytes_;
    int next_ = 0;
    std::vector<std::byte> slice_;
    std::optional<SpoolFile> spool_;
};

} // namespace

AxisOrder nearestLpsOrder(const glm::dmat4& patientFromVoxel) {
    std::array<glm::dvec3, 3> direction;
    for (int axis = 0; axis < 3; ++axis)
        direction[static_cast<std::size_t>(axis)] = glm::normalize(glm::dvec3(patientFromVoxel[axis]));
    std::array<int, 3> candidate = {0, 1, 2}, best = candidate;
    double bestSum = -1;
    do {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
            sum += std::abs(
                direction[static_cast<std::size_t>(candidate[static_cast<std::size_t>(axis)])][axis]);
        if (sum > bestSum + 1e-9) { // at a tie (45 degrees) the source's own order wins: it comes first
            bestSum = sum;
            best = candidate;
        }
    } while (std::next_permutation(candidate.begin(), candidate.end()));
    AxisOrder order;
    order.sourceAxis = best;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        order.flipped[at] = direction[static_cast<std::size_t>(best[at])][axis] < 0;
    }
    return order;
}

VolumeInfo orientedInfo(const VolumeInfo& source) {
    const AxisOrder order = nearestLpsOrder(source.patientFromVoxel);
    VolumeInfo info = source;
    glm::dvec4 corner = source.patientFromVoxel[3];
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        const int from = order.sourceAxis[at];
        const glm::dvec4 step = source.patientFromVoxel[from];
        info.extentVoxels[axis] = source.extentVoxels[from];
        info.patientFromVoxel[axis] = order.flipped[at] ? -step : step;
        if (order.flipped[at])
            corner += step * static_cast<double>(source.extentVoxels[from]);
    }
    info.patientFromVoxel[3] = corner;
    info.originalOrder = order;
    return info;
}

FileBox alongSourceAxes(const VolumeInfo& oriented, const FileBox& box) {
    FileBox turned = box;
    for (int axis = 0; axis < 3; ++axis)
        if (oriented.originalOrder.flipped[static_cast<std::size_t>(axis)]) {
            turned.low[axis] = oriented.extentVoxels[axis] - box.high[axis];
            turned.high[axis] = oriented.extentVoxels[axis] - box.low[axis];
        }
    return {alongSourceAxes(oriented, turned.low), alongSourceAxes(oriented, turned.high)};
}

std::unique_ptr<SlabSource> orientToLps(std::unique_ptr<SlabSource> source,
                                        const std::filesystem::path& scratchFolder) {
    if (nearestLpsOrder(source->info().patientFromVoxel) == AxisOrder{})
        return source;
    return std::make_unique<OrientedSource>(std::move(source), scratchFolder);
}

} // namespace tessera
