// core/base/volume.h: a volume apart from its voxels: extent, type, physical units, position in the patient.
// Spaces are those of docs/sampling.md. Voxel space has the centre of voxel (i,j,k) at (i,j,k)+1/2, and the
// volume is [0,extent]. Patient space is DICOM LPS in millimetres. Transforms are named dstFromSrc. The
// affine gives the mean spacing of voxels and the tilt of slices as well.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

inline constexpr const char* kSuvUnit = "SUVbw"; // g/ml, by body weight

/// The types that a store holds; importers convert others without loss (i8 to i16) or report the loss.
enum class ValueType : std::uint8_t { u8, i16, u16, f32 };

std::size_t bytesPerValue(ValueType type);
/// "uint8", "int16", "uint16", "float32": the names of Zarr.
const char* name(ValueType type);

/// Calls body with a value, 0, of the C++ type that a ValueType names.
template <typename Body> auto withValueType(ValueType type, const Body& body) {
    switch (type) {
    case ValueType::u8:
        return body(std::uint8_t{});
    case ValueType::i16:
        return body(std::int16_t{});
    case ValueType::u16:
        return body(std::uint16_t{});
    case ValueType::f32:
        break;
    }
    return body(float{});
}

/// One stored value widened to double, which holds all four types exactly.
/// @param at  need not be aligned
inline double storedValue(ValueType type, const std::byte* at) {
    return withValueType(type, [at](auto typed) {
        std::memcpy(&typed, at, sizeof typed);
        return static_cast<double>(typed);
    });
}

/// The source axis of each axis of the volume, before the lossless reordering to the nearest LPS order.
struct AxisOrder {
    std::array<int, 3> sourceAxis = {0, 1, 2};
    std::array<bool, 3> flipped = {false, false, false};
    bool operator==(const AxisOrder&) const = default;
};

/// The whitelist of values that are copied from a clinical header, besides geometry. It has no identifiers.
/// (VolumeInfo::frameOfReference is the one identifier that belongs to the geometry.)
struct Acquisition {
    std::string modality;        // "CT", "MR", "" unknown
    std::string kernel;          // convolution kernel, "" unknown
    double tubeVoltageKv = 0;    // 0 unknown
    double sliceThicknessMm = 0; // 0 unknown
    bool operator==(const Acquisition&) const = default;
};

/// A box of voxels, half open.
struct FileBox {
    glm::ivec3 low{0}, high{0};
    bool operator==(const FileBox&) const = default;
};
/// What of a file a volume is, where that is not all of its finest level. Along the axes of the volume, in
/// nearest LPS order.
struct FilePart {
    int level = 0;                              // 0: the file's finest
    glm::ivec3 finestVoxels{0}, levelVoxels{0}; // extents of that one, and of this
    FileBox box;                                // of this level's voxels
    bool operator==(const FilePart&) const = default;
};

struct VolumeInfo {
    glm::ivec3 extentVoxels{0};
    ValueType type = ValueType::i16;
    /// physical value = rescaleSlope * stored + rescaleIntercept
    double rescaleSlope = 1, rescaleIntercept = 0;
    std::string unit;               // "HU", or "" where the physical unit is unknown
    double fillStored = 0;          // padding or air, as stored; chunks of nothing else are not written
    glm::dmat4 patientFromVoxel{1}; // affine; may be oblique, sheared, left-handed
    /// True if the source states the patient's orientation; else patientFromVoxel is a convention, and left
    /// may be right.
    bool orientationKnown = true;
    /// UID of a DICOM source's FrameOfReferenceUID (0020,0052): positions of two objects can be compared
    /// where it is the same. "" unknown. Of an object, not of a patient; pictures and their manifests have
    /// none.
    std::string frameOfReference;
    AxisOrder originalOrder;
    Acquisition acquisition;
    bool lossy = false;                // some of the source had lossy compression
    double lossyRatio = 0;             // of that compression, as the source's header says; 0 unknown
    std::uint64_t nonFiniteVoxels = 0; // NaN and infinite values: absent, and stored as absentStored
    double absentStored = 0;           // the lowest physical value of the data, where a voxel is absent
    std::uint64_t clampedVoxels =
        0;                  // values clamped into the stored type, or a lossy stream's into its range
    double suvPerValue = 0; // of a PET: SUV by body weight = this * physical value; 0 unknown
    /// Irregularities of the source that were accepted, one per line. They quote no file name, and of a
    /// header only numbers and code words.
    std::vector<std::string> remarks;
    std::optional<FilePart> filePart; // none: all of its file

    /// Lengths of the columns of patientFromVoxel, millimetres per voxel.
    glm::dvec3 spacingMm() const;
    /// extent product; extents are checked to be at least 1 and the product to stay below 2^62 bytes by
    /// validate(), so this cannot overflow.
    std::uint64_t voxelCount() const;
    /// Throws InputError naming where for extents below 1, products that overflow, spacing that is not
    /// positive and finite, or a singular affine (|det| < 1e-6 * product of spacings).
    void validate(const std::string& where) const;
};

/// An affine from a first voxel's *centre* (DICOM ImagePositionPatient) and the three voxel steps in mm.
glm::dmat4 patientFromVoxelOf(const glm::dvec3& firstCentreMm, const glm::dvec3& stepX,
                              const glm::dvec3& stepY, const glm::dvec3& stepZ);
/// Position of the centre of voxel (0,0,0) in patient space, mm.
glm::dvec3 firstVoxelCentreMm(const VolumeInfo& info);

/// The smallest box along the patient's axes that holds the volume, outer faces of its voxels included, mm.
struct PatientBox {
    glm::dvec3 low{0}, high{0};
};
PatientBox patientBoxOf(const VolumeInfo& info);

/// Writes the fill value once, as stored: bytesPerValue() bytes.
void storeFill(const VolumeInfo& info, std::byte* out);

/// Millimetres: the mean of the three spacings.
inline double meanSpacingMm(const VolumeInfo& info) {
    const glm::dvec3 spacing = info.spacingMm();
    return (spacing.x + spacing.y + spacing.z) / 3;
}

// The tilt of a volume's slices against their stacking direction, from its affine. A CT's tilted gantry
// appears there as a shear.

/// Degrees between the slices' normal and the direction in which slices follow each other; 0 for a box.
/// Positive where the slices' anterior edge lies nearer to the head than their posterior edge, negative the
/// other way. Positive is a gantry whose top leans away from the table (patient on the back, head first).
/// @param stackAxis  the axis along which slices follow each other
double gantryTiltDegrees(const glm::dmat4& patientFromVoxel, int stackAxis = 2);
/// Of a volume; its originalOrder gives the slice axis of its source.
double gantryTiltDegrees(const VolumeInfo& info);

} // namespace tessera
