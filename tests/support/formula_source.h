// tests/support/formula_source.h: a volume that is a formula, to be imported as any other source.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <utility>

namespace tessera::test {

/// Of a point in voxel space, in voxels.
using Formula = std::function<double(const glm::dvec3&)>;

/// Its values at voxel centres, as floats or rounded to i16.
class FormulaSource : public SlabSource {
  public:
    /// @param info  of type f32
    FormulaSource(const VolumeInfo& info, Formula value) : info_(info), value_(std::move(value)) {}
    const VolumeInfo& info() const override { return info_; }
    void readSlices(int count, std::span<std::byte> out) override {
        std::size_t n = 0;
        for (int z = next_; z < next_ + count; ++z)
            for (int y = 0; y < info_.extentVoxels.y; ++y)
                for (int x = 0; x < info_.extentVoxels.x; ++x) {
                    const double v = value_(glm::dvec3(x, y, z) + 0.5);
                    if (info_.type == ValueType::i16) {
                        const auto whole = static_cast<std::int16_t>(std::lround(v));
                        std::memcpy(out.data() + 2 * n++, &whole, 2);
                    } else {
                        const float number = static_cast<float>(v);
                        std::memcpy(out.data() + 4 * n++, &number, 4);
                    }
                }
        next_ += count;
    }
    std::string describe() const override { return "a formula"; }

  private:
    VolumeInfo info_;
    Formula value_;
    int next_ = 0;
};

/// The physical value at a place by trilinear interpolation between voxels, written out once more; clamped
/// beyond the outermost voxels' centres.
/// @param at  voxels
inline double trilinearOf(const VolumeInfo& info, const Formula& stored, const glm::dvec3& at) {
    const glm::dvec3 x = glm::clamp(at - 0.5, glm::dvec3(0), glm::dvec3(info.extentVoxels - 1));
    const glm::ivec3 low(glm::floor(x));
    const glm::dvec3 f = x - glm::dvec3(low);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 o(corner & 1, corner >> 1 & 1, corner >> 2);
        const glm::ivec3 i = glm::min(low + o, info.extentVoxels - 1);
        sum += (o.x ? f.x : 1 - f.x) * (o.y ? f.y : 1 - f.y) * (o.z ? f.z : 1 - f.z) *
               stored(glm::dvec3(i) + 0.5);
    }
    return info.rescaleSlope * sum + info.rescaleIntercept;
}

} // namespace tessera::test
