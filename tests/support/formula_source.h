// tests/support/formula_source.h: a volume that is a formula, to be imported as any other source.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
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

} // namespace tessera::test
