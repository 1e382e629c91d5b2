// bricking/export/preview.cpp: see preview.h.
#include "bricking/export/preview.h"

#include "bricking/export/box_source.h"
#include "bricking/import/importer.h"
#include "bricking/store/dct_codec.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_reader.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace tessera {
namespace {

/// A level of a store, its chunks rounded.
class RoundedSource : public SlabSource {
  public:
    RoundedSource(const StoreReader& store, int level, Codec codec, MemoryBudget& ram, int threads)
        : box_(store, wholeLevel(store.info(), level), ram, threads), info_(box_.info()), codec_(codec),
          threads_(threads) {
        info_.lossy = true;
        fill_.resize(cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info_.type));
        fillWith(info_, fill_);
    }
    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return "a preview of " + box_.describe(); }

    std::size_t roomBytes() const override { return static_cast<std::size_t>(kChunkExtent) * sliceBytes(); }
    /// Any number of them: chunks are rounded whole.
    void readSlices(int count, std::span<std::byte> out) override {
        for (int done = 0; done < count;) {
            if (left_ == 0)
                readSlab();
            const int some = std::min(count - done, left_);
            const auto from = std::span(slab_).last(static_cast<std::size_t>(left_) * sliceBytes());
            std::copy_n(from.begin(), static_cast<std::size_t>(some) * sliceBytes(),
                        out.begin() +
                            static_cast<std::ptrdiff_t>(static_cast<std::size_t>(done) * sliceBytes()));
            done += some, left_ -= some;
        }
    }

  private:
    std::size_t sliceBytes() const {
        return cellCount({info_.extentVoxels.x, info_.extentVoxels.y, 1}) * bytesPerValue(info_.type);
    }

    void readSlab() {
        left_ = std::min(kChunkExtent, info_.extentVoxels.z - box_.nextSlice());
        slab_.resize(static_cast<std::size_t>(left_) * sliceBytes());
        box_.readSlices(left_, slab_);
        const glm::ivec3 extent(info_.extentVoxels.x, info_.extentVoxels.y, left_);
        const glm::ivec3 grid = ceilDiv(extent, kChunkExtent);
        parallelFor(cellCount(grid), threads_, [&](std::size_t n) {
            const auto x = static_cast<std::size_t>(grid.x), y = static_cast<std::size_t>(grid.y);
            const glm::ivec3 first = glm::ivec3(n % x, n / x % y, n / x / y) * kChunkExtent;
            roundChunk(first, extent, slab_);
        });
    }

    void roundChunk(const glm::ivec3& first, const glm::ivec3& extent, std::span<std::byte> slab) const {
        const std::size_t valueBytes = bytesPerValue(info_.type);
        const glm::ivec3 size = glm::min(extent - first, glm::ivec3(kChunkExtent));
        std::vector<std::byte> chunk = fill_;
        const auto forEachRow = [&](const auto& copy) {
            for (int z = 0; z < size.z; ++z)
                for (int y = 0; y < size.y; ++y)
                    copy(slab.data() + linearIndex(first + glm::ivec3(0, y, z), extent) * valueBytes,
                         chunk.data() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes,
                         static_cast<std::size_t>(size.x) * valueBytes);
        };
        forEachRow(
            [](const std::byte* from, std::byte* to, std::size_t bytes) { std::memcpy(to, from, bytes); });
        withDctSteps(chunk, valueBytes, info_.type != ValueType::u16, codec_);
        forEachRow(
            [](std::byte* to, const std::byte* from, std::size_t bytes) { std::memcpy(to, from, bytes); });
    }

    BoxSource box_;
    VolumeInfo info_;
    Codec codec_;
    int threads_;
    std::vector<std::byte> fill_, slab_;
    int left_ = 0; // slices of the slab that are not yet handed out
};

} // namespace

std::string whyNoPreview(const VolumeInfo& info) {
    return bytesPerValue(info.type) <= 2
               ? ""
               : std::string("its values are ") + name(info.type) + ", not whole numbers of one or two bytes";
}

int previewLevel(const VolumeInfo& info) {
    int level = 0;
    while (level < kLevelCount - 1 && cellCount(levelExtent(info.extentVoxels, level)) > kPreviewVoxels)
        ++level;
    return level;
}

std::uint64_t writePreview(const std::filesystem::path& store, Codec codec, MemoryBudget& ram, int threads,
                           Progress* progress) {
    const StoreReader reader(store, ram);
    if (const std::string why = whyNoPreview(reader.info()); !why.empty())
        throw badFile(store.string(), "a volume that can have a preview", why);
    RoundedSource source(reader, previewLevel(reader.info()), codec, ram, threads);
    ImportOptions options;
    options.force = true;
    options.codec = codec;
    options.threads = threads;
    options.progress = progress;
    // Beside the store until it is whole: what a kill leaves is no part of it.
    const std::filesystem::path made =
        store.parent_path() / ("." + store.filename().string() + "." + kPreviewFolder);
    const std::uint64_t bytes = importToStore(source, made, ram, options).bytesOut;
    std::filesystem::remove_all(store / kPreviewFolder);
    std::filesystem::rename(made, store / kPreviewFolder);
    return bytes;
}

} // namespace tessera
