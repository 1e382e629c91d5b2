// bricking/import/vtk/vtk_image.cpp: see vtk_image.h.
#include "bricking/import/vtk/vtk_image.h"

#include "bricking/import/source/plausible.h"
#include "bricking/import/source/slice_converter.h"
#include "bricking/import/source/source_files.h"
#include "bricking/import/vtk/packed_arrays.h"
#include "bricking/import/vtk/vtk_complaints.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLImageDataReader.h>

namespace tessera {
namespace {

constexpr std::size_t kGroupBytes = std::size_t{16} << 20; // of slices that VTK holds at once, at least one
constexpr std::uint64_t kMostOfVoxel = 1024;               // bytes of an array, of many components
constexpr std::uint64_t kMostPacked = 8192;                // values' bytes a byte of the file: LZMA's zeros

std::optional<FileType> fileTypeOfVtk(int type) {
    switch (type) {
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
        return FileType::i8;
    case VTK_UNSIGNED_CHAR:
        return FileType::u8;
    case VTK_SHORT:
        return FileType::i16;
    case VTK_UNSIGNED_SHORT:
        return FileType::u16;
    case VTK_INT:
        return FileType::i32;
    case VTK_UNSIGNED_INT:
        return FileType::u32;
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE:
        return FileType::i64;
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG:
        return FileType::u64;
    case VTK_FLOAT:
        return FileType::f32;
    case VTK_DOUBLE:
        return FileType::f64;
    default:
        return std::nullopt;
    }
}

/// VTK asks nobody whether pieces hold all of the image: what none holds would be any memory's values.
class PieceReader : public vtkXMLImageDataReader {
  public:
    static PieceReader* New() {
        auto* const reader = new PieceReader;
        reader->InitializeObjectBase();
        return reader;
    }
    /// Voxels of all pieces, as their extents say; they may not overlap. -1: two do, or one lies outside.
    std::int64_t voxelsOfPieces(const std::array<int, 6>& whole) const {
        std::int64_t sum = 0;
        for (int n = 0; n < this->NumberOfPieces; ++n) {
            const int* const e = this->PieceExtents + 6 * n;
            std::int64_t voxels = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const int low = e[2 * axis], high = e[2 * axis + 1];
                const auto at = static_cast<std::size_t>(2 * axis);
                if (low < whole[at] || high > whole[at + 1])
                    return -1;
                voxels *= std::max<std::int64_t>(0, std::int64_t{high} - low + 1);
            }
            for (int other = 0; other < n; ++other) {
                const int* const f = this->PieceExtents + 6 * other;
                if (e[0] <= f[1] && f[0] <= e[1] && e[2] <= f[3] && f[2] <= e[3] && e[4] <= f[5] &&
                    f[4] <= e[5])
                    return -1;
            }
            sum += voxels;
        }
        return sum;
    }
};

class VtkImageSource final : public RandomSlabSource {
  public:
    explicit VtkImageSource(const std::filesystem::path& path)
        : where_(path.string()), complaints_(*reader_), converter_(FileType::u8, false, {}) {
        const InputFile file(path); // its refusals name what is wrong with it
        reader_->SetParserErrorObserver(complaints_.observer());
        reader_->SetReaderErrorObserver(complaints_.observer());
        reader_->SetFileName(where_.c_str());
        const VtkSilence silence;
        if (reader_->CanReadFile(where_.c_str()) == 0)
            throw badFile(where_, "a VTK image in XML (<VTKFile type=\"ImageData\">)", "another file");
        requireEnd(file);
        reader_->UpdateInformation();
        requireNoComplaint();
        vtkInformation& about = *reader_->GetOutputInformation(0);
        readPlace(about);
        readArray(about);
        const std::uint64_t bytes = info_.voxelCount() * bytesPerFileValue(type_);
        if (bytes / (isPackedVtk(file) ? kMostPacked : 1) > file.sizeBytes())
            throw badFile(where_, std::to_string(bytes) + " bytes of values, as its extent says",
                          "a file of " + std::to_string(file.sizeBytes()) + " bytes");
        if (isPackedVtk(file))
            checkPackedVtk(file, kMostOfVoxel * (info_.voxelCount() + kMostOfVoxel));
        if (reader_->voxelsOfPieces(extent_) != static_cast<std::int64_t>(info_.voxelCount()))
            throw badFile(where_, "pieces that hold every voxel of WholeExtent once", "others");
        info_.validate(where_);
        converter_ = SliceConverter(type_, false, [this](const auto& visit) {
            for (int z = 0; z < info_.extentVoxels.z; ++z) {
                checkInterrupted();
                visit(fileSlice(z));
            }
        });
    }

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return std::string("VTK image, ") + name(type_); }
    VoxelTally takeTally() override { return converter_.takeTally(); }
    std::size_t roomBytes() const override { return 2 * sliceBytesOf(info_); }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        const std::span<const std::byte> slice = fileSlice(z); // another pass may read others meanwhile
        slice_.assign(slice.begin(), slice.end());
        converter_.convert(slice_, out, info_);
    }

  private:
    void requireNoComplaint() const {
        if (const std::string first = complaints_.first(); !first.empty())
            throw badFile(where_, "an image that VTK reads without complaint", first);
    }

    /// VTK reads what is left of a file that was cut, and says nothing.
    void requireEnd(const InputFile& file) const {
        constexpr std::uint64_t kTail = 256; // blanks may follow the last element
        std::string tail(static_cast<std::size_t>(std::min(kTail, file.sizeBytes())), '\0');
        file.readAt(file.sizeBytes() - tail.size(), std::as_writable_bytes(std::span(tail)));
        if (tail.find("</VTKFile>") == std::string::npos)
            throw badFile(where_, "</VTKFile> at the end", "none (is it truncated?)");
    }

    void readPlace(vtkInformation& about) {
        about.Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent_.data());
        for (int axis = 0; axis < 3; ++axis) {
            const auto at = static_cast<std::size_t>(2 * axis);
            const std::int64_t count = std::int64_t{extent_[at + 1]} - extent_[at] + 1;
            if (count < 1 || count > std::numeric_limits<int>::max())
                throw badFile(where_, "a WholeExtent of at least one voxel along every axis",
                              std::to_string(count) + " along the one of number " + std::to_string(axis + 1));
            info_.extentVoxels[axis] = static_cast<int>(count);
        }
        glm::dvec3 spacing(1), origin(0);
        std::array<double, 9> direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        about.Get(vtkDataObject::SPACING(), &spacing.x);
        about.Get(vtkDataObject::ORIGIN(), &origin.x);
        if (about.Has(vtkDataObject::DIRECTION()))
            about.Get(vtkDataObject::DIRECTION(), direction.data());
        std::array<glm::dvec3, 3> step;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const glm::dvec3 along(direction[axis], direction[3 + axis], direction[6 + axis]);
            constexpr double kRounding = 1e-3; // of a length of 1
            if (!(std::abs(glm::length(along) - 1) < kRounding))
                throw badFile(where_, "a Direction whose columns have length 1 (lengths are Spacing's)",
                              "length " + std::to_string(glm::length(along)));
            if (!(spacing[static_cast<int>(axis)] > 0))
                throw badFile(where_, "a Spacing above 0", std::to_string(spacing[static_cast<int>(axis)]));
            step[axis] = spacing[static_cast<int>(axis)] * along;
            origin += static_cast<double>(extent_[2 * axis]) * step[axis];
        }
        info_.patientFromVoxel = patientFromVoxelOf(origin, step[0], step[1], step[2]);
        requirePlausibleGeometry(info_, {"Spacing", "Direction", "Origin"}, where_);
    }

    /// The scalars, or the only array of numbers.
    void readArray(vtkInformation& about) {
        vtkInformationVector* const arrays = about.Get(vtkDataObject::POINT_DATA_VECTOR());
        const int count = arrays ? arrays->GetNumberOfInformationObjects() : 0;
        vtkInformation* chosen = vtkDataObject::GetActiveFieldInformation(
            &about, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
        if (!chosen && count == 1)
            chosen = arrays->GetInformationObject(0);
        if (!chosen || !chosen->Has(vtkDataObject::FIELD_NAME()))
            throw badFile(where_, "one array of values of points, or one that is named as Scalars",
                          std::to_string(count) + (count == 1 ? " array" : " arrays"));
        array_ = chosen->Get(vtkDataObject::FIELD_NAME());
        for (int n = 0; n < reader_->GetNumberOfPointArrays(); ++n)
            reader_->SetPointArrayStatus(reader_->GetPointArrayName(n),
                                         array_ == reader_->GetPointArrayName(n) ? 1 : 0);
        for (int n = 0; n < reader_->GetNumberOfCellArrays(); ++n)
            reader_->SetCellArrayStatus(reader_->GetCellArrayName(n), 0);
        const int components = chosen->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS());
        if (components != 1)
            throw badFile(where_, "an array of one value per voxel", std::to_string(components) + " values");
        const std::optional<FileType> type = fileTypeOfVtk(chosen->Get(vtkDataObject::FIELD_ARRAY_TYPE()));
        if (!type)
            throw badFile(where_, "an array of numbers", "another");
        type_ = *type;
        info_.type = storedTypeOf(type_);
        if (array_ == "HU") // as `tessera export` names it
            info_.unit = "HU";
        info_.orientationKnown = false;
        info_.remarks.emplace_back("VTK images do not say which way their axes point; taken as LPS, mm");
        if (reader_->GetNumberOfTimeSteps() > 1)
            throw badFile(where_, "an image of one time",
                          std::to_string(reader_->GetNumberOfTimeSteps()) + " times");
    }

    std::size_t sliceBytes() const {
        return sliceBytesOf(info_) / bytesPerValue(info_.type) * bytesPerFileValue(type_);
    }

    /// Valid until the next call.
    std::span<const std::byte> fileSlice(int z) {
        if (z < firstSlice_ || z >= endSlice_)
            readGroup(z);
        return std::span(group_).subspan(static_cast<std::size_t>(z - firstSlice_) * sliceBytes(),
                                         sliceBytes());
    }

    void readGroup(int z) {
        const int most = static_cast<int>(std::max<std::size_t>(1, kGroupBytes / sliceBytes()));
        const int first = z / most * most, end = std::min(first + most, info_.extentVoxels.z);
        std::array<int, 6> wanted = extent_;
        wanted[4] = extent_[4] + first, wanted[5] = extent_[4] + end - 1;
        firstSlice_ = endSlice_ = 0; // what was here goes
        const VtkSilence silence;
        static_cast<vtkAlgorithm&>(*reader_).UpdateExtent(wanted.data());
        requireNoComplaint();
        vtkImageData* const image = reader_->GetOutput();
        vtkDataArray* const values = image ? image->GetPointData()->GetArray(array_.c_str()) : nullptr;
        const std::size_t bytes = sliceBytes() * static_cast<std::size_t>(end - first);
        int got[6] = {};
        if (image)
            image->GetExtent(got);
        if (!values || !std::equal(wanted.begin(), wanted.end(), got) ||
            values->GetNumberOfComponents() != 1 ||
            static_cast<std::size_t>(values->GetDataTypeSize()) != bytesPerFileValue(type_) ||
            static_cast<std::size_t>(values->GetNumberOfTuples()) * bytesPerFileValue(type_) != bytes)
            throw badFile(where_,
                          "the values of slices " + std::to_string(first) + " to " + std::to_string(end - 1),
                          "fewer (is it truncated?)");
        group_.resize(bytes);
        std::memcpy(group_.data(), values->GetVoidPointer(0), bytes);
        firstSlice_ = first, endSlice_ = end;
        image->Initialize(); // VTK's own memory is not kept
    }

    std::string where_, array_;
    vtkNew<PieceReader> reader_;
    VtkComplaints complaints_;
    std::array<int, 6> extent_{};
    VolumeInfo info_;
    FileType type_ = FileType::u8;
    SliceConverter converter_;
    std::vector<std::byte> group_; // slices [firstSlice_, endSlice_), as the file has them
    int firstSlice_ = 0, endSlice_ = 0;
    std::vector<std::byte> slice_; // one of them, at hand
};

} // namespace

std::unique_ptr<SlabSource> openVtkImage(const std::filesystem::path& file) {
    return std::make_unique<VtkImageSource>(file);
}

} // namespace tessera
