// bricking/import/plain_file_source.cpp: see plain_file_source.h.
#include "bricking/import/plain_file_source.h"

#include <utility>
#include <vector>

namespace tessera {
namespace {

class PlainFileSource final : public RandomSlabSource {
  public:
    PlainFileSource(InputFile file, const VolumeInfo& info, const VoxelLayout& layout,
                    std::string description)
        : file_(std::move(file)), info_(info), layout_(layout), description_(std::move(description)) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        const std::size_t fileBytes =
            sliceBytesOf(info_) / bytesPerValue(info_.type) * bytesPerFileValue(layout_.type);
        buffer_.resize(fileBytes);
        file_.readAt(layout_.offsetBytes + static_cast<std::uint64_t>(z) * fileBytes, buffer_);
        VoxelCounts counts;
        storeVoxels(layout_.type, layout_.bigEndian, buffer_, info_.fillStored, out, counts);
        info_.nonFiniteVoxels += counts.nonFinite;
        info_.clampedVoxels += counts.clamped;
    }

  private:
    InputFile file_;
    VolumeInfo info_;
    VoxelLayout layout_;
    std::string description_;
    std::vector<std::byte> buffer_; // one slice, as it lies in the file
};

} // namespace

std::uint64_t voxelBytesInFile(const VolumeInfo& info, FileType type) {
    return info.voxelCount() * bytesPerFileValue(type);
}

std::unique_ptr<SlabSource> makePlainFileSource(InputFile file, const VolumeInfo& info,
                                                const VoxelLayout& layout, std::string description) {
    TESSERA_CHECK(info.type == storedTypeOf(layout.type));
    return std::make_unique<PlainFileSource>(std::move(file), info, layout, std::move(description));
}

} // namespace tessera
