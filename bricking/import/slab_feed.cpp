// bricking/import/slab_feed.cpp: see slab_feed.h.
#include "bricking/import/slab_feed.h"

#include "bricking/store/level_writer.h"
#include "bricking/store/store_writer.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostBand = std::size_t{512} << 20; // wider ones are no quicker
constexpr std::size_t kBuffer = std::size_t{8} << 20;     // of rows on their way to a file

/// Rows of the narrowest band.
SlabPlan narrowest(int unit) {
    SlabPlan plan;
    plan.firstHeld = kLevelCount;
    plan.bandRows = static_cast<int>(
        std::min<std::int64_t>(std::lcm(std::int64_t{kChunkExtent}, std::int64_t{unit}), INT32_MAX));
    return plan;
}

/// The widest bands, in steps of the narrowest, and the most slabs in memory that have room.
SlabPlan widened(SlabPlan plan, const glm::ivec3& extent, ValueType type, std::size_t freeBytes) {
    const int step = plan.bandRows;
    const auto bandOf = [&](int rows) { // a second one may be read ahead
        return cellCount({extent.x, std::min(rows, extent.y), std::min(extent.z, kChunkExtent)}) *
               bytesPerValue(type);
    };
    const std::size_t room = std::min(freeBytes / 4, kMostBand);
    while (plan.bandRows < extent.y && bandOf(plan.bandRows + step) <= room)
        plan.bandRows += step;
    while (plan.firstHeld > 1) {
        SlabPlan more = plan;
        --more.firstHeld;
        if (SlabPyramid::bytesNeeded(extent, type, more) + bandOf(plan.bandRows) > freeBytes / 4 * 3)
            break;
        plan = more;
    }
    return plan;
}

/// Rows of a slice that are read at once into a file.
int bufferRowsOf(const SlabSource& source, const VolumeInfo& info) {
    if (source.rowAccess() == RowAccess::none)
        return info.extentVoxels.y;
    const auto unit = static_cast<std::size_t>(source.rowUnit());
    const std::size_t units = std::max<std::size_t>(kBuffer / (rowBytesOf(info) * unit), 1);
    return static_cast<int>(std::min(units * unit, static_cast<std::size_t>(info.extentVoxels.y)));
}

/// Both ways of bands at their least. Of the source's own bands nothing where it has none.
struct LeastBands {
    std::size_t common; // chunks, and what the source takes
    std::optional<std::size_t> direct;
    std::size_t spooled;
};
LeastBands leastBandsOf(const SlabSource& source, const VolumeInfo& info, int threads) {
    LeastBands least;
    least.common = LevelWriter::bytesNeeded(info, threads) + source.roomBytes();
    if (source.rowAccess() == RowAccess::any)
        least.direct = least.common +
                       SlabPyramid::bytesNeeded(info.extentVoxels, info.type, narrowest(source.rowUnit()));
    least.spooled = least.common + SlabPyramid::bytesNeeded(info.extentVoxels, info.type, narrowest(1)) +
                    rowBytesOf(info) * static_cast<std::size_t>(bufferRowsOf(source, info));
    return least;
}

} // namespace

std::size_t leastImportBytes(const SlabSource& source, const VolumeInfo& info, int threads) {
    const LeastBands bands = leastBandsOf(source, info, threads);
    return std::min(
        {StoreWriter::floorBytes(info, threads), bands.direct.value_or(bands.spooled), bands.spooled});
}

ImportPlan planImport(const SlabSource& source, const VolumeInfo& info, std::size_t freeBytes, int threads,
                      const std::filesystem::path& folder) {
    ImportPlan plan;
    const LeastBands least = leastBandsOf(source, info, threads);
    const std::size_t bands = std::min(least.direct.value_or(least.spooled), least.spooled);
    if (const std::size_t whole = StoreWriter::floorBytes(info, threads);
        whole <= freeBytes || whole <= bands)
        return plan;
    plan.roomBytes = source.roomBytes();
    const bool isDirect = least.direct && (*least.direct <= freeBytes || *least.direct <= least.spooled);
    std::size_t taken = least.common;
    if (!isDirect) {
        plan.bufferRows = bufferRowsOf(source, info);
        taken += rowBytesOf(info) * static_cast<std::size_t>(plan.bufferRows);
    }
    plan.slabs = widened(narrowest(isDirect ? source.rowUnit() : 1), info.extentVoxels, info.type,
                         freeBytes - std::min(freeBytes, taken));
    plan.slabs.folder = folder;
    return plan;
}

SlabPlan planSlabs(const glm::ivec3& extentVoxels, ValueType type, std::size_t freeBytes,
                   const std::filesystem::path& folder) {
    if (SlabPyramid::bytesNeeded(extentVoxels, type) <= freeBytes)
        return {};
    SlabPlan plan = widened(narrowest(1), extentVoxels, type, freeBytes);
    plan.folder = folder;
    return plan;
}

SlabFeed::SlabFeed(ImportPlan plan, const VolumeInfo& info, MemoryBudget& ram)
    : plan_(std::move(plan)), extent_(info.extentVoxels), rowBytes_(rowBytesOf(info)),
      charge_(ram.charge(plan_.roomBytes + rowBytes_ * static_cast<std::size_t>(plan_.bufferRows),
                         "reading slices")) {
    if (plan_.bufferRows == 0)
        return;
    const std::uint64_t slab = std::uint64_t{rowBytes_} * static_cast<std::uint64_t>(extent_.y) *
                               static_cast<std::uint64_t>(std::min(extent_.z, kChunkExtent));
    requireDiskRoom(plan_.slabs.folder, slab + SlabPyramid::fileBytes(extent_, info.type, plan_.slabs),
                    "slabs of slices that cannot be read by rows");
    file_.emplace(plan_.slabs.folder);
    buffer_.resize(rowBytes_ * static_cast<std::size_t>(plan_.bufferRows));
}

/// Rows of slice z, which comes next: each(rows, number of the first).
template <typename Each> void SlabFeed::eachPiece(SlabSource& source, int z, const Each& each) {
    checkInterrupted();
    if (source.rowAccess() == RowAccess::none) {
        source.readSlices(1, buffer_);
        return each(std::span<const std::byte>(buffer_), 0);
    }
    for (int first = 0; first < extent_.y; first += plan_.bufferRows) {
        const int rows = std::min(plan_.bufferRows, extent_.y - first);
        const auto piece = std::span(buffer_).first(rowBytes_ * static_cast<std::size_t>(rows));
        source.readRows(z, first, rows, piece);
        each(std::span<const std::byte>(piece), first);
    }
}

void SlabFeed::pass(SlabSource& source, int z, std::span<std::byte> scratch) {
    if (plan_.slabs.isWhole())
        source.readSlices(1, scratch);
    else
        eachPiece(source, z, [](std::span<const std::byte>, int) {});
}

void SlabFeed::read(SlabSource& source, const Band& band, std::span<std::byte> out) {
    const std::size_t bytes = rowBytes_ * static_cast<std::size_t>(band.rows); // of a slice
    TESSERA_CHECK(out.size() == bytes * static_cast<std::size_t>(band.slices));
    if (plan_.slabs.isWhole())
        return source.readSlices(band.slices, out);
    const std::uint64_t sliceBytes = std::uint64_t{rowBytes_} * static_cast<std::uint64_t>(extent_.y);
    const auto placeOf = [&](int slice, int row) {
        return sliceBytes * static_cast<std::uint64_t>(slice) +
               std::uint64_t{rowBytes_} * static_cast<std::uint64_t>(row);
    };
    for (int slice = 0; file_ && band.firstRow == 0 && slice < band.slices; ++slice)
        eachPiece(source, band.firstSlice + slice, [&](std::span<const std::byte> rows, int first) {
            file_->write(placeOf(slice, first), rows);
        });
    for (int slice = 0; slice < band.slices; ++slice) {
        checkInterrupted();
        const auto to = out.subspan(static_cast<std::size_t>(slice) * bytes, bytes);
        if (file_)
            file_->read(placeOf(slice, band.firstRow), to);
        else
            source.readRows(band.firstSlice + slice, band.firstRow, band.rows, to);
    }
}

} // namespace tessera
