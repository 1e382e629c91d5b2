// datasets/analytic.cpp: the phantoms that are one formula each. See analytic_field.h.
// Marschner-Lobb: S. Marschner, R. Lobb, "An Evaluation of Reconstruction Filters for Volume Rendering",
// IEEE Visualization 1994: rho = (1 - sin(pi z/2) + alpha (1 + rho_r(sqrt(x^2+y^2)))) / (2 (1 + alpha)),
// rho_r(r) = cos(2 pi fM cos(pi r/2)), on [-1,1]^3.
#include "datasets/analytic_field.h"

#include "core/base/error.h"
#include "datasets/slice_generator.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>

namespace tessera {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kHalfMm = kAnalyticBodyMm / 2;

double marschnerLobb(const glm::dvec3& p) {
    const double ring =
        std::cos(2 * kPi * kMarschnerLobbFrequency * std::cos(kPi / 2 * std::hypot(p.x, p.y)));
    return (1 - std::sin(kPi / 2 * p.z) + kMarschnerLobbAlpha * (1 + ring)) / (2 * (1 + kMarschnerLobbAlpha));
}

glm::dvec3 marschnerLobbGradient(const glm::dvec3& p) {
    const double scale = 1 / (2 * (1 + kMarschnerLobbAlpha));
    const double r = std::hypot(p.x, p.y);
    const double inner = 2 * kPi * kMarschnerLobbFrequency * std::cos(kPi / 2 * r);
    const double innerSlope = -2 * kPi * kMarschnerLobbFrequency * (kPi / 2) * std::sin(kPi / 2 * r);
    const double ringSlope = -std::sin(inner) * innerSlope;
    // the slope falls to 0 with r, so the direction does not matter on the axis
    const double radial = r > 0 ? scale * kMarschnerLobbAlpha * ringSlope / r : 0;
    return {radial * p.x, radial * p.y, -scale * kPi / 2 * std::cos(kPi / 2 * p.z)};
}

double sphere(const glm::dvec3& p) {
    return std::clamp(kSphereSlopePerMm * (kSphereRadiusMm - glm::length(p)), -kSphereClamp, kSphereClamp);
}

double checkerboard(const glm::dvec3& p, const glm::ivec3& extentVoxels) {
    int boxes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double voxel = std::floor((p[axis] + kHalfMm) * extentVoxels[axis] / kAnalyticBodyMm);
        const int last = extentVoxels[axis] - 1;
        boxes += static_cast<int>(std::clamp(voxel, 0.0, static_cast<double>(last))) / kCheckerboardVoxels;
    }
    return boxes % 2 == 0 ? 0 : 255;
}

template <class T> void put(std::span<std::byte> out, std::size_t at, T value) {
    std::memcpy(out.data() + at * sizeof(T), &value, sizeof(T));
}

ValueType storedType(AnalyticField::Kind kind) {
    if (kind == AnalyticField::Kind::sphere)
        return ValueType::i16;
    return kind == AnalyticField::Kind::checkerboard ? ValueType::u8 : ValueType::f32;
}

class AnalyticSlices final : public SliceGenerator {
  public:
    AnalyticSlices(const std::string& name, const glm::ivec3& extentVoxels)
        : field_(AnalyticField::named(name, extentVoxels)),
          info_(centredVolume(name, extentVoxels, glm::dvec3(kAnalyticBodyMm), storedType(field_.kind))) {
        if (field_.kind == AnalyticField::Kind::sphere)
            info_.fillStored = -kSphereClamp; // its surroundings
    }

    const VolumeInfo& info() const override { return info_; }

    void slice(int z, std::span<std::byte> out) const override {
        const glm::ivec3 n = info_.extentVoxels;
        // divided last, so that positions, and with them the ramp, are exact where n is a power of two
        const auto position = [](int i, int count) { return (i + 0.5) * kAnalyticBodyMm / count - kHalfMm; };
        std::size_t at = 0;
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x, ++at) {
                const double v = field_.value({position(x, n.x), position(y, n.y), position(z, n.z)});
                switch (info_.type) {
                case ValueType::u8:
                    put(out, at, static_cast<std::uint8_t>(v));
                    break;
                case ValueType::i16:
                    put(out, at, static_cast<std::int16_t>(std::lround(v)));
                    break;
                default:
                    put(out, at, static_cast<float>(v));
                    break;
                }
            }
        }
    }

  private:
    AnalyticField field_;
    VolumeInfo info_;
};

} // namespace

AnalyticField AnalyticField::named(const std::string& name, const glm::ivec3& extentVoxels) {
    if (name == "marschner-lobb")
        return {Kind::marschnerLobb, extentVoxels};
    if (name == "sphere")
        return {Kind::sphere, extentVoxels};
    if (name == "ramp")
        return {Kind::ramp, extentVoxels};
    if (name == "checkerboard")
        return {Kind::checkerboard, extentVoxels};
    throw badFile("phantom", "marschner-lobb, sphere, ramp or checkerboard", "'" + name + "'");
}

double AnalyticField::value(const glm::dvec3& patientMm) const {
    switch (kind) {
    case Kind::marschnerLobb:
        return marschnerLobb(patientMm / kHalfMm);
    case Kind::sphere:
        return sphere(patientMm);
    case Kind::ramp:
        return (patientMm.x + kHalfMm) / kAnalyticBodyMm;
    case Kind::checkerboard:
        return checkerboard(patientMm, extentVoxels);
    }
    return 0;
}

glm::dvec3 AnalyticField::gradient(const glm::dvec3& patientMm) const {
    switch (kind) {
    case Kind::marschnerLobb:
        return marschnerLobbGradient(patientMm / kHalfMm) / kHalfMm;
    case Kind::sphere: {
        const double r = glm::length(patientMm);
        const bool clamped = std::abs(kSphereSlopePerMm * (kSphereRadiusMm - r)) >= kSphereClamp;
        return clamped ? glm::dvec3(0) : -kSphereSlopePerMm / r * patientMm;
    }
    case Kind::ramp:
        return {1 / kAnalyticBodyMm, 0, 0};
    case Kind::checkerboard:
        return glm::dvec3(0);
    }
    return glm::dvec3(0);
}

std::unique_ptr<SliceGenerator> makeAnalytic(const std::string& name, const glm::ivec3& extentVoxels) {
    return std::make_unique<AnalyticSlices>(name, extentVoxels);
}

} // namespace tessera
