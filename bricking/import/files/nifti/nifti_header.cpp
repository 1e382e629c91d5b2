// bricking/import/files/nifti/nifti_header.cpp: parseNiftiHeader of nifti.h. Offsets are those of nifti1.h
// and nifti2.h.
#include "bricking/import/files/nifti/nifti.h"
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

namespace tessera {
namespace {

/// Offsets of the fields; NIfTI-1 has 16- and 32-bit numbers, NIfTI-2 64-bit ones.
struct Offsets {
    std::size_t magic, datatype, bitpix, dim, pixdim, voxOffset, slope, intercept, units, qformCode,
        sformCode, quaternion, qoffset, srow;
};
constexpr Offsets kOffsets1 = {344, 70, 72, 40, 76, 108, 112, 116, 123, 252, 254, 256, 268, 280};
constexpr Offsets kOffsets2 = {4, 12, 14, 16, 104, 168, 176, 184, 500, 344, 348, 352, 376, 400};

class Fields {
  public:
    Fields(std::span<const std::byte> bytes, bool bigEndian, int version)
        : bytes_(bytes), bigEndian_(bigEndian), version_(version), at_(version == 1 ? kOffsets1 : kOffsets2) {
    }

    const Offsets& at() const { return at_; }
    template <class T> T get(std::size_t offset) const {
        std::array<std::byte, sizeof(T)> raw;
        for (std::size_t i = 0; i < sizeof(T); ++i)
            raw[i] = bytes_[offset + (bigEndian_ ? sizeof(T) - 1 - i : i)];
        return std::bit_cast<T>(raw);
    }
    /// The i-th number of a field that is float in version 1 and double in version 2.
    double real(std::size_t field, std::size_t i = 0) const {
        return version_ == 1 ? static_cast<double>(get<float>(field + 4 * i)) : get<double>(field + 8 * i);
    }
    std::int64_t dim(std::size_t i) const {
        return version_ == 1 ? get<std::int16_t>(at_.dim + 2 * i) : get<std::int64_t>(at_.dim + 8 * i);
    }
    int code(std::size_t field) const {
        return version_ == 1 ? get<std::int16_t>(field) : get<std::int32_t>(field);
    }
    int units() const {
        return version_ == 1 ? std::to_integer<int>(bytes_[at_.units]) : get<std::int32_t>(at_.units);
    }

  private:
    std::span<const std::byte> bytes_;
    bool bigEndian_;
    int version_;
    Offsets at_;
};

std::optional<FileType> fileTypeOfCode(int code) {
    switch (code) {
    case 2:
        return FileType::u8;
    case 4:
        return FileType::i16;
    case 8:
        return FileType::i32;
    case 16:
        return FileType::f32;
    case 64:
        return FileType::f64;
    case 256:
        return FileType::i8;
    case 512:
        return FileType::u16;
    case 768:
        return FileType::u32;
    case 1024:
        return FileType::i64;
    case 1280:
        return FileType::u64;
    default:
        return std::nullopt;
    }
}

/// The largest stored magnitude of whole numbers, 0 for floating-point types.
double largestMagnitude(FileType type) {
    if (type == FileType::f32 || type == FileType::f64)
        return 0;
    constexpr std::size_t kExactBits = 24; // of whole numbers in a float, which holds the longer types
    return std::ldexp(1.0, static_cast<int>(std::min(8 * bytesPerFileValue(type), kExactBits)));
}

/// The format's own affine: RAS millimetres of the centre of voxel (i,j,k), as origin and three steps.
struct RasAffine {
    std::array<glm::dvec3, 3> step;
    glm::dvec3 origin{0};
    const char* source;
};

RasAffine fromSform(const Fields& f) {
    RasAffine ras{.step = {}, .source = "sform"};
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column)
            ras.step[column][static_cast<int>(row)] = f.real(f.at().srow, 4 * row + column);
        ras.origin[static_cast<int>(row)] = f.real(f.at().srow, 4 * row + 3);
    }
    return ras;
}

RasAffine fromQform(const Fields& f, const glm::dvec3& spacing, const std::string& where) {
    const double b = f.real(f.at().quaternion, 0), c = f.real(f.at().quaternion, 1),
                 d = f.real(f.at().quaternion, 2);
    constexpr double kMostLength = 1.01; // of a unit quaternion's part, with its rounding
    if (const double length = std::sqrt(b * b + c * c + d * d); !(length <= kMostLength))
        throw badFile(where, "qform (quatern_b, quatern_c, quatern_d) of length 1 at most",
                      std::isfinite(length) ? "length " + std::to_string(length)
                                            : "a value that is not finite");
    // The quaternion is of unit length, so its first number follows from the others; rounding may leave them
    // slightly longer than one, then the angle is a half turn.
    double bb = b, cc = c, dd = d;
    const double rest = 1 - (b * b + c * c + d * d);
    if (rest < 0) {
        const double scale = 1 / std::sqrt(b * b + c * c + d * d);
        bb *= scale, cc *= scale, dd *= scale;
    }
    const double a = rest > 0 ? std::sqrt(rest) : 0;
    const double qfac = f.real(f.at().pixdim, 0) < 0 ? -1 : 1;
    RasAffine ras{.step = {}, .source = "qform"};
    ras.step[0] = spacing.x * glm::dvec3(a * a + bb * bb - cc * cc - dd * dd, 2 * (bb * cc + a * dd),
                                         2 * (bb * dd - a * cc));
    ras.step[1] = spacing.y * glm::dvec3(2 * (bb * cc - a * dd), a * a + cc * cc - bb * bb - dd * dd,
                                         2 * (cc * dd + a * bb));
    ras.step[2] =
        qfac * spacing.z *
        glm::dvec3(2 * (bb * dd + a * cc), 2 * (cc * dd - a * bb), a * a + dd * dd - cc * cc - bb * bb);
    for (std::size_t i = 0; i < 3; ++i)
        ras.origin[static_cast<int>(i)] = f.real(f.at().qoffset, i);
    return ras;
}

glm::dmat4 lpsAffine(const RasAffine& ras, double mmPerUnit) {
    const glm::dvec3 toLps = glm::dvec3(-1, -1, 1) * mmPerUnit;
    return patientFromVoxelOf(toLps * ras.origin, toLps * ras.step[0], toLps * ras.step[1],
                              toLps * ras.step[2]);
}

Fields recognise(std::span<const std::byte> bytes, const std::string& where, int& version, bool& bigEndian) {
    if (bytes.size() < 348)
        throw badFile(where, "a NIfTI header", std::to_string(bytes.size()) + " bytes in all");
    for (const bool big : {false, true}) {
        const auto size = Fields(bytes, big, 1).get<std::int32_t>(0);
        if (size != 348 && size != 540)
            continue;
        version = size == 348 ? 1 : 2;
        bigEndian = big;
        if (version == 2 && bytes.size() < 540)
            throw badFile(where, "a NIfTI-2 header of 540 bytes",
                          std::to_string(bytes.size()) + " bytes in all");
        const Fields fields(bytes, big, version);
        const char* magic = reinterpret_cast<const char*>(bytes.data() + fields.at().magic);
        if (std::memcmp(magic, version == 1 ? "ni1" : "ni2", 4) == 0)
            throw badFile(where, "a single-file NIfTI (.nii or .nii.gz)",
                          "a detached header (.hdr and .img)");
        if (std::memcmp(magic, version == 1 ? "n+1" : "n+2", 4) != 0)
            throw badFile(where, "a NIfTI-1 or NIfTI-2 header", "its size but not its magic (Analyze 7.5?)");
        return fields;
    }
    throw badFile(where, "a NIfTI-1 or NIfTI-2 header", "a file that does not begin as one");
}

/// The fourth dimension is time: volumes behind one another.
glm::ivec3 readExtent(const Fields& f, const std::string& where, int& times) {
    constexpr std::int64_t kMostTimes = 65535;
    const std::int64_t rank = f.dim(0);
    if (rank < 1 || rank > 7)
        throw badFile(where, "1 to 7 dimensions", std::to_string(rank));
    glm::ivec3 extent{1};
    for (std::size_t i = 1; i <= static_cast<std::size_t>(rank); ++i) {
        const std::int64_t size = f.dim(i);
        if (i == 4 && size > 1 && size <= kMostTimes) {
            times = static_cast<int>(size);
            continue;
        }
        if (i > 3 && size != 1 && size != 0) // 0: not used
            throw badFile(where, "one volume of one value per voxel",
                          "dim[" + std::to_string(i) + "] = " + std::to_string(size) +
                              " (vectors are not opened)");
        if (i <= 3 && (size < 1 || size > std::numeric_limits<int>::max()))
            throw badFile(where, "dim[" + std::to_string(i) + "] of at least 1", std::to_string(size));
        if (i <= 3)
            extent[static_cast<int>(i) - 1] = static_cast<int>(size);
    }
    return extent;
}

} // namespace

NiftiHeader parseNiftiHeader(std::span<const std::byte> bytes, const std::string& where) {
    NiftiHeader header;
    const Fields f = recognise(bytes, where, header.version, header.bigEndian);
    header.info.extentVoxels = readExtent(f, where, header.times);

    const int typeCode = f.get<std::int16_t>(f.at().datatype); // 16 bits in both versions
    const auto type = fileTypeOfCode(typeCode);
    if (!type)
        throw badFile(where, "a scalar number type", "NIfTI datatype " + std::to_string(typeCode));
    header.type = *type;
    const int bitpix = f.get<std::int16_t>(f.at().bitpix); // 16 bits in both versions
    if (bitpix == 0)
        header.info.remarks.push_back("bitpix is 0: datatype tells the size of a value");
    else if (bitpix != static_cast<int>(8 * bytesPerFileValue(*type)))
        throw badFile(where,
                      std::string("bitpix ") + std::to_string(8 * bytesPerFileValue(*type)) + " for " +
                          name(*type),
                      std::to_string(bitpix));
    header.info.type = storedTypeOf(*type);

    const double voxOffset = header.version == 1 ? f.real(f.at().voxOffset)
                                                 : static_cast<double>(f.get<std::int64_t>(f.at().voxOffset));
    const double smallest = header.version == 1 ? 352 : 544; // header and four extension bytes
    const bool isBare = voxOffset == smallest - 4;           // without the four extension bytes
    if (voxOffset != 0 && !isBare && !(voxOffset >= smallest && voxOffset < 0x1p53))
        throw badFile(where, "voxels that begin after the header", "vox_offset " + std::to_string(voxOffset));
    header.dataOffsetBytes = static_cast<std::uint64_t>(voxOffset == 0 ? smallest : voxOffset);

    const double slope = f.real(f.at().slope), intercept = f.real(f.at().intercept);
    if (slope != 0 && !std::isnan(slope)) { // 0 and, as some programs write, NaN mean: not scaled
        requirePlausibleRescale(slope, intercept, largestMagnitude(*type), false, "scl_slope", "scl_inter",
                                where);
        header.info.rescaleSlope = slope;
        header.info.rescaleIntercept = intercept;
    }

    glm::dvec3 spacing;
    for (std::size_t i = 0; i < 3; ++i)
        spacing[static_cast<int>(i)] = f.real(f.at().pixdim, i + 1);
    const auto checkSpacing = [&] {
        for (int i = 0; i < 3; ++i)
            if (!(spacing[i] > 0) || !std::isfinite(spacing[i]))
                throw badFile(where, "a positive, finite voxel spacing",
                              "pixdim[" + std::to_string(i + 1) + "] = " + std::to_string(spacing[i]));
    };
    RasAffine ras{
        .step = {glm::dvec3(spacing.x, 0, 0), glm::dvec3(0, spacing.y, 0), glm::dvec3(0, 0, spacing.z)},
        .source = "spacing only"};
    if (f.code(f.at().sformCode) > 0) {
        ras = fromSform(f);
    } else {
        checkSpacing();
        if (f.code(f.at().qformCode) > 0)
            ras = fromQform(f, spacing, where);
    }
    const int lengthUnit = f.units() & 7; // 1 metre, 2 millimetre, 3 micrometre; 0 unknown, taken as mm
    const double mmPerUnit = lengthUnit == 1 ? 1000 : lengthUnit == 3 ? 0.001 : 1;
    header.info.patientFromVoxel = lpsAffine(ras, mmPerUnit);
    const int timeUnit = f.units() & 56; // 8 seconds, 16 milliseconds, 24 microseconds
    const double step = f.real(f.at().pixdim, 4);
    if (header.times > 1 && std::isfinite(step) && step > 0)
        header.stepSeconds = timeUnit == 8    ? step
                             : timeUnit == 16 ? step / 1e3
                             : timeUnit == 24 ? step / 1e6
                                              : 0;
    header.orientation = ras.source;
    const bool isSform = f.code(f.at().sformCode) > 0, isQform = !isSform && f.code(f.at().qformCode) > 0;
    header.info.orientationKnown = isSform || isQform;
    const char* const field = isSform   ? "sform (srow_x, srow_y, srow_z)"
                              : isQform ? "qform (quatern_b, quatern_c, quatern_d)"
                                        : "pixdim";
    requirePlausibleGeometry(
        header.info,
        {isSform ? field : "pixdim", field, isSform ? field : "qform (qoffset_x, qoffset_y, qoffset_z)"},
        where);
    header.info.validate(where);
    return header;
}

} // namespace tessera
