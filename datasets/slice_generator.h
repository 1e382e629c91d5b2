// datasets/slice_generator.h: a phantom inside this room: a volume's description and a pure function from
// slice number to voxels. Being pure, slices can be made in any order, by any number of threads.
#pragma once

#include "core/base/volume.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>

namespace tessera {

class SliceGenerator {
  public:
    virtual ~SliceGenerator() = default;
    virtual const VolumeInfo& info() const = 0;
    /// Writes slice z, [y][x], x fastest, stored values. out.size() is one slice in bytes. Called from
    /// several threads at once; the bytes depend on z alone.
    virtual void slice(int z, std::span<std::byte> out) const = 0;
};

/// Description of a volume whose box, bodyMm in size and centred on 0, is cut into extentVoxels. Axes are
/// LPS. Throws InputError naming the phantom for an extent below 1 or above
/// what VolumeInfo::validate() allows.
VolumeInfo centredVolume(const std::string& name, const glm::ivec3& extentVoxels, const glm::dvec3& bodyMm,
                         ValueType type);

/// One of the phantoms of analytic_field.h. The name has been checked.
std::unique_ptr<SliceGenerator> makeAnalytic(const std::string& name, const glm::ivec3& extentVoxels);
std::unique_ptr<SliceGenerator> makeTorso(const glm::ivec3& extentVoxels, bool colonCollapsed);

} // namespace tessera
