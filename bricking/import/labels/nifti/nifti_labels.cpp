// bricking/import/labels/nifti/nifti_labels.cpp: labels in NIfTI files: one layer of whole numbers of any
// type.
#include "bricking/import/files/nifti/nifti.h"
#include "bricking/import/labels/label_format.h"
#include "bricking/import/labels/label_values.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace tessera {
namespace {

/// Reads in pieces, and has its file open from its first slice to its last one only: masks are many.
class NiftiLabels final : public LabelLayer {
  public:
    explicit NiftiLabels(NiftiFile nifti)
        : path_(nifti.file.path()), header_(nifti.header), isGzip_(nifti.isGzip),
          values_(header_.type, header_.bigEndian, path_.string(), header_.info.extentVoxels),
          at_(header_.dataOffsetBytes) {
        values_.scale(header_.info.rescaleSlope, header_.info.rescaleIntercept);
    }

    const VolumeInfo& info() const override { return header_.info; }

    bool isAlone() const override { return true; }

    bool hasWholeType() const override {
        return header_.type != FileType::f32 && header_.type != FileType::f64 &&
               header_.info.rescaleSlope == 1 && header_.info.rescaleIntercept == 0;
    }

    void readSlices(int count, std::span<std::uint32_t> out) override {
        const glm::ivec3 extent = header_.info.extentVoxels;
        TESSERA_CHECK(count >= 0 && next_ + count <= extent.z);
        TESSERA_CHECK(out.size() == cellCount({extent.x, extent.y, count}));
        if (isGzip_ && !stream_)
            stream_.emplace(niftiVoxels(path_, header_));
        if (!isGzip_ && !file_)
            file_.emplace(path_);
        const std::size_t valueBytes = bytesPerFileValue(header_.type);
        std::vector<std::byte> piece(kPieceVoxels * valueBytes);
        for (std::size_t done = 0; done < out.size(); done += kPieceVoxels) {
            checkInterrupted();
            const auto to = out.subspan(done, std::min(kPieceVoxels, out.size() - done));
            const auto from = std::span(piece).first(to.size() * valueBytes);
            if (isGzip_)
                stream_->read(from);
            else
                file_->readAt(at_, from);
            at_ += from.size();
            values_.convert(from, to);
        }
        next_ += count;
        if (next_ < extent.z)
            return;
        if (isGzip_)
            checkNiftiSurplus(path_.string(), header_, stream_->finish());
        stream_.reset();
        file_.reset();
    }

  private:
    static constexpr std::size_t kPieceVoxels = 4096;

    std::filesystem::path path_;
    NiftiHeader header_;
    bool isGzip_;
    LabelValues values_;
    std::uint64_t at_;
    std::optional<GzipStream> stream_;
    std::optional<InputFile> file_;
    int next_ = 0;
};

LabelFile openNiftiLabels(const std::filesystem::path& path, const SourceOptions&) {
    LabelFile file;
    NiftiFile nifti = openNiftiFile(path);
    if (nifti.header.times > 1)
        throw badFile(path.string(), "labels of one time", "dim[4] = " + std::to_string(nifti.header.times));
    file.notes = nifti.header.info.remarks;
    file.layers.push_back(std::make_unique<NiftiLabels>(std::move(nifti)));
    return file;
}

} // namespace

LabelFormat niftiLabels() {
    return {"NIfTI files (.nii, .nii.gz)", openNiftiLabels, nullptr, true};
}

} // namespace tessera
