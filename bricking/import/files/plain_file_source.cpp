// bricking/import/files/plain_file_source.cpp: see plain_file_source.h.
#include "bricking/import/files/plain_file_source.h"

#include "bricking/import/source/slice_converter.h"
#include "core/base/interrupt.h"

#include <utility>
#include <vector>

namespace tessera {
namespace {

class PlainFileSource final : public RandomSlabSource {
  public:
    PlainFileSource(InputFile file, const VolumeInfo& info, const VoxelLayout& layout,
                    std::string description)
        : file_(std::move(file)), info_(info), layout_(layout), description_(std::move(description)),
          converter_(layout.type, layout.bigEndian, [this](const auto& visit) {
              for (int z = 0; z < info_.extentVoxels.z; ++z) {
                  checkInterrupted();
                  std::vector<std::byte> slice(fileSliceBytes());
                  readFileSlice(z, slice);
                  visit(slice);
              }
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }
    std::vector<std::string> notes() const override {
        std::vector<std::string> lines = info_.remarks;
        for (std::string& line : converter_.notes())
            lines.push_back(std::move(line));
        return lines;
    }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        buffer_.resize(fileSliceBytes());
        readFileSlice(z, buffer_);
        converter_.convert(buffer_, out, info_);
    }

  private:
    std::size_t fileSliceBytes() const {
        return sliceBytesOf(info_) / bytesPerValue(info_.type) * bytesPerFileValue(layout_.type);
    }
    void readFileSlice(int z, std::span<std::byte> out) const {
        file_.readAt(layout_.offsetBytes + static_cast<std::uint64_t>(z) * out.size(), out);
    }

    InputFile file_;
    VolumeInfo info_;
    VoxelLayout layout_;
    std::string description_;
    SliceConverter converter_;
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
