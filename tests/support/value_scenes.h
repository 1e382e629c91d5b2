// tests/support/value_scenes.h: scenes whose rays keep one value, and the field along rays by code of its
// own.
#pragma once

#include "render/contract/lattice.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace tessera::test {

/// A mode, or a slab of a slice.
struct ValueCase {
    const char* store;
    Mode mode;
    int camera;
    double thicknessMm = 0; // of a slice
    Reduction reduction = Reduction::average;
    ValueColour colour = ValueColour::window;
};
inline std::ostream& operator<<(std::ostream& out, const ValueCase& c) {
    out << c.store << ", " << modeNames()[static_cast<std::size_t>(c.mode)] << ", camera " << c.camera;
    if (c.mode == Mode::slice)
        out << ", " << c.thicknessMm << " mm";
    if (c.thicknessMm > 0)
        out << ", " << reductionNames()[static_cast<std::size_t>(c.reduction) - 1];
    return out << (c.colour == ValueColour::window ? "" : ", colours of the function");
}

inline glm::dvec3 middleOf(const VolumeInfo& info) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
}

inline Scene valueScene(const ValueCase& c, const VolumeInfo& info, const glm::ivec2& size) {
    Scene scene = sceneOn(info, "soft-tissue", c.camera, size);
    scene.mode = c.mode;
    scene.valueColour = c.colour;
    scene.window = GreyWindow{20, 900}; // of tissue and some bone: values lie on both sides of it
    scene.slice.orientation = Orientation::oblique;
    scene.slice.point = middleOf(info) + glm::dvec3(3.1, -2.3, 1.7);
    scene.slice.normal = {0.3, -0.5, 0.8};
    scene.slice.thicknessMm = c.thicknessMm;
    scene.slice.reduction = c.reduction;
    return scene;
}

/// All voxels of a store, in physical units, and trilinear interpolation between them in double.
class PlainVolume {
  public:
    explicit PlainVolume(const std::string& store) : ram_("RAM", "--ram", std::size_t{1} << 30) {
        const StoreReader reader(storePath(store), ram_);
        info_ = reader.info();
        BrickCache cache(reader, ram_, std::size_t{64} << 20, 1);
        LatticeReader samples(cache, info_, 0, nullptr);
        const glm::ivec3 n = info_.extentVoxels;
        for (int z = 0; z < n.z; ++z)
            for (int y = 0; y < n.y; ++y)
                for (int x = 0; x < n.x; ++x)
                    values_.push_back(info_.rescaleSlope * samples.at({x, y, z}) + info_.rescaleIntercept);
    }
    const VolumeInfo& info() const { return info_; }
    /// @param p  voxels
    double at(const glm::dvec3& p) const {
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            std::size_t index = 0;
            for (int axis = 2; axis >= 0; --axis) {
                const int last = info_.extentVoxels[axis] - 1;
                const double x = std::clamp(p[axis] - 0.5, 0.0, static_cast<double>(last));
                const int low = std::min(static_cast<int>(x), std::max(last - 1, 0));
                const bool upper = corner >> axis & 1;
                weight *= upper ? x - low : 1 - (x - low);
                index = index * static_cast<std::size_t>(last + 1) +
                        static_cast<std::size_t>(std::min(upper ? low + 1 : low, last));
            }
            sum += weight * values_[index];
        }
        return sum;
    }

  private:
    MemoryBudget ram_;
    VolumeInfo info_;
    std::vector<double> values_;
};

/// What a display shows of a linear light: IEC 61966-2-1, inverted by hand.
inline double greyOf(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// The same everywhere: what is seen of it is how much of a ray is left.
inline TransferFunction fog(double perMm) {
    return TransferFunction::fromExtinction({{-5000, perMm}, {5000, perMm}}, {{0, {1, 1, 1}}});
}

} // namespace tessera::test
