// bricking/export/nifti_writer.cpp: NIfTI-1 and NIfTI-2 in single files, .nii or .nii.gz. Offsets are those
// of nifti1.h and nifti2.h. Slope and intercept are kept as scl_slope and scl_inter.
#include "bricking/export/exported_place.h"
#include "bricking/export/exported_values.h"
#include "bricking/export/volume_file.h"
#include "bricking/export/volume_writer.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

constexpr std::size_t kBytes1 = 348, kBytes2 = 540, kExtension = 4; // no extension follows
constexpr int kMostNifti1 = std::numeric_limits<std::int16_t>::max();

/// A header that is filled in by offsets.
class NiftiBytes {
  public:
    explicit NiftiBytes(int version)
        : version_(version), bytes_((version == 1 ? kBytes1 : kBytes2) + kExtension) {}
    template <class T> void put(std::size_t at, T value) {
        std::memcpy(bytes_.data() + at, &value, sizeof value);
    }
    /// A field that is float in version 1 and double in version 2.
    void real(std::size_t at1, std::size_t at2, std::size_t i, double value) {
        if (version_ == 1)
            put(at1 + 4 * i, static_cast<float>(value));
        else
            put(at2 + 8 * i, value);
    }
    /// A field that has 16 bits in version 1 and `Wide` in version 2.
    template <class Wide> void whole(std::size_t at1, std::size_t at2, std::size_t i, std::int64_t value) {
        if (version_ == 1)
            put(at1 + 2 * i, static_cast<std::int16_t>(value));
        else
            put(at2 + sizeof(Wide) * i, static_cast<Wide>(value));
    }
    std::span<const std::byte> all() const { return bytes_; }

  private:
    int version_;
    std::vector<std::byte> bytes_;
};

std::int16_t niftiType(FileType type) {
    switch (type) {
    case FileType::u8:
        return 2;
    case FileType::i16:
        return 4;
    case FileType::u16:
        return 512;
    default:
        return 16; // float32
    }
}

struct Quaternion {
    double b = 0, c = 0, d = 0, qfac = 1;
};

/// Of axes at right angles; the method of nifti1_io.c, nifti_mat44_to_quatern.
/// @param axes  of length 1, as columns
Quaternion quaternionOf(glm::dmat3 axes) {
    Quaternion q;
    if (glm::determinant(axes) < 0) {
        axes[2] = -axes[2];
        q.qfac = -1;
    }
    const auto at = [&](int row, int column) { return axes[column][row]; };
    const double w = at(0, 0) + at(1, 1) + at(2, 2) + 1;
    double a = 0;
    if (w > 0.5) {
        a = 0.5 * std::sqrt(w);
        q.b = 0.25 * (at(2, 1) - at(1, 2)) / a;
        q.c = 0.25 * (at(0, 2) - at(2, 0)) / a;
        q.d = 0.25 * (at(1, 0) - at(0, 1)) / a;
        return q;
    }
    const double x = 1 + at(0, 0) - (at(1, 1) + at(2, 2)), y = 1 + at(1, 1) - (at(0, 0) + at(2, 2)),
                 z = 1 + at(2, 2) - (at(0, 0) + at(1, 1));
    if (x > 1) {
        q.b = 0.5 * std::sqrt(x);
        q.c = 0.25 * (at(0, 1) + at(1, 0)) / q.b;
        q.d = 0.25 * (at(0, 2) + at(2, 0)) / q.b;
        a = 0.25 * (at(2, 1) - at(1, 2)) / q.b;
    } else if (y > 1) {
        q.c = 0.5 * std::sqrt(y);
        q.b = 0.25 * (at(0, 1) + at(1, 0)) / q.c;
        q.d = 0.25 * (at(1, 2) + at(2, 1)) / q.c;
        a = 0.25 * (at(0, 2) - at(2, 0)) / q.c;
    } else {
        q.d = 0.5 * std::sqrt(z);
        q.b = 0.25 * (at(0, 2) + at(2, 0)) / q.d;
        q.c = 0.25 * (at(1, 2) + at(2, 1)) / q.d;
        a = 0.25 * (at(1, 0) - at(0, 1)) / q.d;
    }
    if (a < 0)
        q.b = -q.b, q.c = -q.c, q.d = -q.d;
    return q;
}

NiftiBytes niftiHeader(const VolumeInfo& info, FileType type, int version, bool isBox) {
    NiftiBytes header(version);
    const bool isFirst = version == 1;
    header.put<std::int32_t>(0, static_cast<std::int32_t>(isFirst ? kBytes1 : kBytes2));
    constexpr std::string_view kMagic1("n+1\0", 4), kMagic2("n+2\0\r\n\x1a\n", 8);
    const std::string_view magic = isFirst ? kMagic1 : kMagic2;
    for (std::size_t i = 0; i < magic.size(); ++i)
        header.put((isFirst ? 344 : 4) + i, magic[i]);
    header.put(isFirst ? 70 : 12, niftiType(type));
    header.put(isFirst ? 72 : 14, static_cast<std::int16_t>(8 * bytesPerFileValue(type)));
    const std::array<int, 8> dims = {
        3, info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z, 1, 1, 1, 1};
    for (std::size_t i = 0; i < dims.size(); ++i)
        header.whole<std::int64_t>(40, 16, i, dims[i]);
    const auto offset = isFirst ? kBytes1 + kExtension : kBytes2 + kExtension;
    if (isFirst)
        header.put(108, static_cast<float>(offset));
    else
        header.put(168, static_cast<std::int64_t>(offset));
    header.real(112, 176, 0, info.rescaleSlope);
    header.real(116, 184, 0, info.rescaleIntercept);
    constexpr std::int32_t kMillimetres = 2;
    if (isFirst)
        header.put(123, static_cast<std::uint8_t>(kMillimetres));
    else
        header.put(500, kMillimetres);

    const ExportedPlace place = placeOf(info);
    const glm::dvec3 ras(-1, -1, 1), spacing = place.spacing(), origin = ras * place.firstCentre;
    glm::dmat3 axes(1);
    for (int axis = 0; axis < 3; ++axis)
        axes[axis] = ras * place.step[static_cast<std::size_t>(axis)] / spacing[axis];
    const Quaternion q = isBox ? quaternionOf(axes) : Quaternion{};
    header.real(76, 104, 0, q.qfac);
    for (int axis = 0; axis < 3; ++axis)
        header.real(76, 104, static_cast<std::size_t>(axis) + 1, spacing[axis]);
    constexpr std::int64_t kScanner = 1; // NIFTI_XFORM_SCANNER_ANAT
    const std::int64_t code = info.orientationKnown ? kScanner : 0;
    header.whole<std::int32_t>(252, 344, 0, isBox ? code : 0);
    header.whole<std::int32_t>(254, 348, 0, code);
    for (const auto& [i, value] : {std::pair{0, q.b}, {1, q.c}, {2, q.d}})
        header.real(256, 352, static_cast<std::size_t>(i), value);
    for (int row = 0; row < 3; ++row) {
        const auto r = static_cast<std::size_t>(row);
        if (isBox)
            header.real(268, 376, r, origin[row]);
        for (std::size_t column = 0; column < 3; ++column)
            header.real(280, 400, 4 * r + column, ras[row] * place.step[column][row]);
        header.real(280, 400, 4 * r + 3, origin[row]);
    }
    return header;
}

bool isExactFloat(double value) {
    return static_cast<double>(static_cast<float>(value)) == value;
}

ExportReport writeVersion(BoxSource& box, const ExportRequest& request, int version) {
    const VolumeInfo& info = box.info();
    const std::string outName = request.out.string();
    const std::string ending = request.out.extension().string();
    const bool isPacked = ending.size() == 3 && (ending[1] | 0x20) == 'g' && (ending[2] | 0x20) == 'z';
    if (request.compress && !isPacked)
        throw badFile(outName, "a name ending in .nii.gz for --compress", "\"" + ending + "\"");
    const ExportedPlace place = placeOf(info);
    const bool isBox = place.shear() <= kMostShear;
    const ExportedValues values = storedValues(info);
    VolumeFile file(request.out, request.existing());
    const NiftiBytes header = niftiHeader(info, values.type, version, isBox);
    std::optional<DeflateStream> packed;
    if (isPacked)
        packed.emplace(file, DeflateStream::Wrapper::gzip);
    const auto append = [&](std::span<const std::byte> bytes) {
        packed ? packed->append(bytes) : file.append(bytes);
    };
    append(header.all());
    request.progress.stage("writing " + outName);
    streamNumbers(box, values, request.ram, request.progress, append);
    if (packed)
        packed->finish();
    file.finish();
    ExportReport report{file.size(), sayValues(info, values, true), {}};
    bool isExactPlace = isExactFloat(place.firstCentre.x) && isExactFloat(place.firstCentre.y) &&
                        isExactFloat(place.firstCentre.z);
    for (const glm::dvec3& step : place.step)
        isExactPlace = isExactPlace && isExactFloat(step.x) && isExactFloat(step.y) && isExactFloat(step.z);
    if (version == 1 && !isExactPlace)
        report.notes.emplace_back("positions are rounded to float32 in NIfTI-1; --format nifti2 keeps them");
    if (version == 1 && !(isExactFloat(info.rescaleSlope) && isExactFloat(info.rescaleIntercept)))
        report.notes.emplace_back("slope and intercept are rounded to float32 in NIfTI-1");
    if (!isBox)
        report.notes.emplace_back("the slices are tilted, which sform alone says: there is no qform");
    if (!info.unit.empty())
        report.notes.push_back("NIfTI does not say that values are in " + info.unit);
    return report;
}

} // namespace

ExportReport writeNifti(BoxSource& box, const ExportRequest& request) {
    const glm::ivec3 n = box.info().extentVoxels;
    return writeVersion(box, request, std::max({n.x, n.y, n.z}) > kMostNifti1 ? 2 : 1);
}

ExportReport writeNifti2(BoxSource& box, const ExportRequest& request) {
    return writeVersion(box, request, 2);
}

} // namespace tessera
