// bricking/import/source/cropped_source.cpp: see cropped_source.h.
#include "bricking/import/source/cropped_source.h"

#include "core/base/error.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

namespace tessera {
namespace {

/// @tparam Base  SlabSource, or RandomSlabSource of one
template <class Base> class CroppedSource : public Base {
  public:
    CroppedSource(std::unique_ptr<SlabSource> source, const FileBox& box, const FilePart& part,
                  std::vector<std::string> remarks)
        : source_(std::move(source)), box_(box), whole_(source_->info().extentVoxels),
          remarks_(std::move(remarks)), info_(source_->info()) {
        if (box_ != FileBox{glm::ivec3(0), whole_} && source_->crop(box_)) {
            whole_ = source_->info().extentVoxels;
            box_ = {glm::ivec3(0), whole_};
            info_ = source_->info();
        } else {
            info_ = croppedInfo(std::move(info_), box_);
        }
        info_.filePart = part;
        takeFindings();
    }

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return source_->describe(); }
    void setThreads(int threads) override { source_->setThreads(threads); }
    VoxelTally takeTally() override { return source_->takeTally(); }
    std::vector<std::string> notes() const override {
        std::vector<std::string> notes = source_->notes();
        notes.insert(notes.end(), remarks_.begin(), remarks_.end());
        return notes;
    }
    RowAccess rowAccess() const override { return isWhole() ? source_->rowAccess() : RowAccess::none; }
    int rowUnit() const override { return source_->rowUnit(); }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        TESSERA_CHECK(isWhole());
        source_->readRows(z, first, count, out);
        takeFindings();
    }
    std::size_t roomBytes() const override {
        return source_->roomBytes() +
               (isWhole() ? 0 : wholeRowBytes() * static_cast<std::size_t>(rowsRead()));
    }

  protected:
    bool isWhole() const { return box_ == FileBox{glm::ivec3(0), whole_}; }
    bool hasWholeSlices() const {
        return info_.extentVoxels.x == whole_.x && info_.extentVoxels.y == whole_.y;
    }
    bool readsRows() const {
        return !hasWholeSlices() && source_->rowAccess() == RowAccess::any && source_->rowUnit() == 1;
    }
    int rowsRead() const { return readsRows() ? info_.extentVoxels.y : whole_.y; }
    std::size_t wholeRowBytes() const {
        return static_cast<std::size_t>(whole_.x) * bytesPerValue(info_.type);
    }
    /// @param read  reads whole slices of the source into a buffer
    template <class Read> void readSlice(int z, std::span<std::byte> out, const Read& read) {
        buffer_.resize(wholeRowBytes() * static_cast<std::size_t>(rowsRead()));
        int firstRow = box_.low.y;
        if (readsRows())
            source_->readRows(z, std::exchange(firstRow, 0), info_.extentVoxels.y, buffer_);
        else
            read(std::span<std::byte>(buffer_));
        const std::size_t row = rowBytesOf(info_),
                          before = static_cast<std::size_t>(box_.low.x) * bytesPerValue(info_.type);
        for (int y = 0; y < info_.extentVoxels.y; ++y)
            std::memcpy(out.data() + static_cast<std::size_t>(y) * row,
                        buffer_.data() + static_cast<std::size_t>(firstRow + y) * wholeRowBytes() + before,
                        row);
    }
    void takeFindings() {
        const VolumeInfo& found = source_->info();
        info_.nonFiniteVoxels = found.nonFiniteVoxels;
        info_.absentStored = found.absentStored;
        info_.clampedVoxels = found.clampedVoxels;
        info_.lossy = found.lossy;
        info_.remarks = found.remarks;
        info_.remarks.insert(info_.remarks.end(), remarks_.begin(), remarks_.end());
    }

    std::unique_ptr<SlabSource> source_;
    FileBox box_;      // of the source's voxels
    glm::ivec3 whole_; // the source's extent
    std::vector<std::string> remarks_;
    VolumeInfo info_;
    std::vector<std::byte> buffer_;
};

class ForwardCrop final : public CroppedSource<SlabSource> {
  public:
    using CroppedSource::CroppedSource;

    bool seek(int z) override {
        TESSERA_CHECK(z >= 0 && z <= info_.extentVoxels.z);
        if (!source_->seek(box_.low.z + z))
            return false;
        at_ = box_.low.z + z;
        next_ = z;
        return true;
    }
    void readSlices(int count, std::span<std::byte> out) override {
        TESSERA_CHECK(count >= 0 && next_ + count <= info_.extentVoxels.z);
        const std::size_t slice = sliceBytesOf(info_);
        if (at_ < box_.low.z && !readsRows() && !seek(next_))
            passOver();
        if (hasWholeSlices()) {
            source_->readSlices(count, out);
            at_ += count;
        } else {
            for (int i = 0; i < count; ++i)
                this->readSlice(box_.low.z + next_ + i,
                                out.subspan(static_cast<std::size_t>(i) * slice, slice),
                                [&](std::span<std::byte> whole) {
                                    source_->readSlices(1, whole);
                                    ++at_;
                                });
        }
        next_ += count;
        takeFindings();
    }

  private:
    /// Slices before the box, which can only be read.
    void passOver() {
        std::vector<std::byte> slice(wholeRowBytes() * static_cast<std::size_t>(whole_.y));
        for (; at_ < box_.low.z; ++at_)
            source_->readSlices(1, slice);
    }

    int next_ = 0, at_ = 0; // slices of the box and of the source that are read next
};

class RandomCrop final : public CroppedSource<RandomSlabSource> {
  public:
    using CroppedSource::CroppedSource;

    void readSliceAt(int z, std::span<std::byte> out) override { readSlicesAt(z, 1, out); }

  protected:
    void readSlicesAt(int first, int count, std::span<std::byte> out) override {
        const std::size_t slice = sliceBytesOf(info_);
        if (hasWholeSlices()) {
            TESSERA_CHECK(source_->seek(box_.low.z + first));
            source_->readSlices(count, out);
        } else {
            for (int i = 0; i < count; ++i)
                this->readSlice(
                    box_.low.z + first + i, out.subspan(static_cast<std::size_t>(i) * slice, slice),
                    [&](std::span<std::byte> whole) {
                        static_cast<RandomSlabSource&>(*source_).readSliceAt(box_.low.z + first + i, whole);
                    });
        }
        takeFindings();
    }
};

} // namespace

std::unique_ptr<SlabSource> cropSource(std::unique_ptr<SlabSource> source, const FileBox& box,
                                       const FilePart& part, std::vector<std::string> remarks) {
    const glm::ivec3 extent = source->info().extentVoxels;
    for (int axis = 0; axis < 3; ++axis)
        TESSERA_CHECK(0 <= box.low[axis] && box.low[axis] < box.high[axis] && box.high[axis] <= extent[axis]);
    if (dynamic_cast<RandomSlabSource*>(source.get()))
        return std::make_unique<RandomCrop>(std::move(source), box, part, std::move(remarks));
    return std::make_unique<ForwardCrop>(std::move(source), box, part, std::move(remarks));
}

} // namespace tessera
