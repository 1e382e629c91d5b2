// bricking/import/labels/label_values.h: LabelValues: from the numbers of a file to label values, or a
// refusal that names the first number that is none.
#pragma once

#include "bricking/import/source/slice_converter.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>

namespace tessera {

class LabelValues {
  public:
    /// @param file  for messages
    /// @param extent  of the file's voxels, in its own order: messages name a voxel by it
    LabelValues(FileType type, bool bigEndian, std::string file, const glm::ivec3& extent)
        : type_(type), bigEndian_(bigEndian), file_(std::move(file)), extent_(extent) {}
    /// Of a file whose values are slope * number + intercept; such a value may be off a whole number by 1e-5
    /// of itself, because the slope is a rounded number.
    void scale(double slope, double intercept) { slope_ = slope, intercept_ = intercept; }

    /// The next out.size() voxels of the file, of in.size() == out.size() * bytesPerFileValue(type) bytes.
    /// Throws InputError naming file, voxel and number for a fraction, for no number, and outside [0, 2^32).
    void convert(std::span<const std::byte> in, std::span<std::uint32_t> out);

  private:
    FileType type_;
    bool bigEndian_;
    std::string file_;
    glm::ivec3 extent_;
    double slope_ = 1, intercept_ = 0;
    std::uint64_t done_ = 0; // voxels
};

} // namespace tessera
