// bricking/export/vti_writer.cpp: VTK's XML image data, with its values appended raw, or deflated in blocks
// (vtkZLibDataCompressor). The format has no slope and intercept, so values are physical ones. VTK does not
// say which way its axes point: they are those of DICOM (LPS), mm.
#include "bricking/export/exported_place.h"
#include "bricking/export/exported_values.h"
#include "bricking/export/volume_file.h"
#include "bricking/export/volume_writer.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::array kVtkTypes = {FileType::u8, FileType::i16, FileType::u16, FileType::i32, FileType::f32};
constexpr std::size_t kBlockBytes = std::size_t{1} << 20; // of values that are deflated together

std::string vtkType(FileType type) {
    switch (type) {
    case FileType::u8:
        return "UInt8";
    case FileType::i16:
        return "Int16";
    case FileType::u16:
        return "UInt16";
    case FileType::i32:
        return "Int32";
    default:
        return "Float32";
    }
}

std::string vtiHeader(const VolumeInfo& info, FileType type, bool isPacked) {
    const ExportedPlace place = placeOf(info);
    const glm::dvec3 spacing = place.spacing();
    const glm::ivec3 last = info.extentVoxels - 1;
    const std::string extent =
        "0 " + std::to_string(last.x) + " 0 " + std::to_string(last.y) + " 0 " + std::to_string(last.z);
    std::string direction; // rows of the matrix whose columns are the axes
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            direction += (direction.empty() ? "" : " ") +
                         exactText(place.step[static_cast<std::size_t>(column)][row] / spacing[column]);
    // A unit's letters alone could end the attribute or the element.
    const std::string array = info.unit == "HU" ? "HU" : "values";
    return "<?xml version=\"1.0\"?>\n"
           "<VTKFile type=\"ImageData\" version=\"2.2\" byte_order=\"LittleEndian\" header_type=\"UInt64\"" +
           std::string(isPacked ? " compressor=\"vtkZLibDataCompressor\"" : "") +
           ">\n  <ImageData WholeExtent=\"" + extent + "\" Origin=\"" + exactText(place.firstCentre) +
           "\" Spacing=\"" + exactText(spacing) + "\" Direction=\"" + direction +
           "\">\n    <Piece Extent=\"" + extent + "\">\n      <PointData Scalars=\"" + array +
           "\">\n        <DataArray type=\"" + vtkType(type) + "\" Name=\"" + array +
           "\" format=\"appended\" offset=\"0\"/>\n"
           "      </PointData>\n      <CellData/>\n    </Piece>\n  </ImageData>\n"
           "  <AppendedData encoding=\"raw\">\n   _";
}

/// Values in blocks that are deflated, behind a table of their sizes: the number of blocks, bytes of a block
/// and of the last one if it is shorter, then each one's bytes in the file.
class PackedBlocks {
  public:
    PackedBlocks(VolumeFile& file, std::uint64_t bytes)
        : file_(file), table_(file.size()),
          sizes_(3 + static_cast<std::size_t>((bytes + kBlockBytes - 1) / kBlockBytes)) {
        sizes_[0] = sizes_.size() - 3;
        sizes_[1] = kBlockBytes;
        sizes_[2] = bytes % kBlockBytes;
        block_.reserve(kBlockBytes);
        file_.append(std::as_bytes(std::span(sizes_)));
    }
    static std::size_t bytesNeeded(std::uint64_t bytes) {
        return 3 * kBlockBytes + static_cast<std::size_t>(bytes / kBlockBytes + 4) * sizeof(std::uint64_t);
    }
    void append(std::span<const std::byte> bytes) {
        while (!bytes.empty()) {
            const std::size_t now = std::min(bytes.size(), kBlockBytes - block_.size());
            block_.insert(block_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(now));
            bytes = bytes.subspan(now);
            if (block_.size() == kBlockBytes)
                flush();
        }
    }
    void finish() {
        if (!block_.empty())
            flush();
        TESSERA_CHECK(next_ == sizes_.size());
        file_.replace(table_, std::as_bytes(std::span(sizes_)));
    }

  private:
    void flush() {
        uLongf size = compressBound(static_cast<uLong>(block_.size()));
        packed_.resize(size);
        const int result =
            compress(reinterpret_cast<Bytef*>(packed_.data()), &size,
                     reinterpret_cast<const Bytef*>(block_.data()), static_cast<uLong>(block_.size()));
        TESSERA_CHECK(result == Z_OK);
        file_.append(std::span(packed_).first(size));
        sizes_[next_++] = size;
        block_.clear();
    }
    VolumeFile& file_;
    std::uint64_t table_;
    std::vector<std::uint64_t> sizes_;
    std::size_t next_ = 3;
    std::vector<std::byte> block_, packed_;
};

} // namespace

ExportReport writeVti(BoxSource& box, const ExportRequest& request) {
    const VolumeInfo& info = box.info();
    if (placeOf(info).shear() > kMostShear)
        throw badFile(request.out.string(),
                      "axes at right angles, which alone a .vti holds (.nrrd and .nii hold others)",
                      "slices that are tilted against their stack");
    VolumeFile file(request.out, request.existing());
    const ExportedValues values = physicalValues(box, kVtkTypes, request.ram, request.progress);
    const std::uint64_t bytes = info.voxelCount() * bytesPerFileValue(values.type);
    file.append(vtiHeader(info, values.type, request.compress));
    request.progress.stage("writing " + request.out.string());
    if (request.compress) {
        const Charge charge = request.ram.charge(PackedBlocks::bytesNeeded(bytes), "blocks to deflate");
        PackedBlocks blocks(file, bytes);
        streamNumbers(box, values, request.ram, request.progress,
                      [&](std::span<const std::byte> numbers) { blocks.append(numbers); });
        blocks.finish();
    } else {
        file.append(bytesOf(bytes));
        streamNumbers(box, values, request.ram, request.progress,
                      [&](std::span<const std::byte> numbers) { file.append(numbers); });
    }
    file.append("\n  </AppendedData>\n</VTKFile>\n");
    file.finish();
    return {file.size(), sayValues(info, values, false), {"axes are those of DICOM (LPS), mm"}};
}

} // namespace tessera
