// render/backends/reference/cell_gradients.h: gradients of the field along a ray through one of its cells, by
// the scene's operator, for light and for gradient opacity.
#pragma once

#include "render/backends/reference/cells_on_ray.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/contract/sampler.h"

#include <array>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace tessera {

/// The samples around a cell: the support of its gradients. 4^3 of them, but of operators that reach further.
class Neighbourhood {
  public:
    Neighbourhood(LatticeReader& reader, const glm::ivec3& low, Gradient by)
        : extent_(reader.extent()), first_(low - reachOf(by)), edge_(2 * reachOf(by) + 2) {
        if (edge_ == 4)
            reader.cube<4>(first_, values_.data());
        else if (edge_ == 6)
            reader.cube<6>(first_, values_.data());
        else
            reader.cube<10>(first_, values_.data());
    }
    const glm::ivec3& extent() const { return extent_; }
    double at(const glm::ivec3& i) const {
        const glm::ivec3 local = glm::clamp(i - first_, glm::ivec3(0), glm::ivec3(edge_ - 1));
        return values_[static_cast<std::size_t>((local.z * edge_ + local.y) * edge_ + local.x)];
    }

  private:
    glm::ivec3 extent_, first_;
    int edge_;
    std::array<double, 1000> values_; // as many as it has
};

/// Distance of the planes between which every component of the gradient along a ray is a cubic, voxels.
/// Planes of sample centres, which bound the cells of the field, are among them. Differences over half a
/// pitch use values half a voxel away, which change cells at the planes between. Cubic B-splines give a
/// polynomial of the eighth degree, which on an eighth of a cell is a cubic to some 1e-7 of the gradient.
inline double planesOfGradient(Gradient gradient) {
    if (gradient == Gradient::cubic)
        return 0.125;
    return gradient == Gradient::forward || gradient == Gradient::centralHalf ? 0.5 : 1.0;
}

/// At a place in a cell of the field, voxel space. The analytic gradient jumps between cells, so there the
/// cell decides, not the rounded position.
inline glm::dvec3 gradientInCell(const Neighbourhood& around, const glm::ivec3& low, Gradient by,
                                 const glm::dvec3& p) {
    return by == Gradient::analytic ? trilinearSlope(around, low, low + 1, p - 0.5 - glm::dvec3(low)).slope
                                    : fieldGradient(around, p, 1.0, by);
}

/// In patient space, per mm, at ta, two points between and tb: between them every component is a cubic.
/// @param position  by parameter, voxels
template <typename Position>
std::array<glm::dvec3, 4> gradientsInCell(LatticeReader& samples, const glm::ivec3& low, const Optics& optics,
                                          Gradient by, const Position& position, double ta, double tb) {
    const Neighbourhood around(samples, low, by);
    const glm::dmat3 toPatient(optics.voxelFromPatientTransposed);
    const auto at = [&](double t) { return toPatient * gradientInCell(around, low, by, position(t)); };
    return {at(ta), at(ta + (tb - ta) / 3), at(ta + 2 * (tb - ta) / 3), at(tb)};
}

/// The gradient along a ray between two cuts, a cubic by component, patient space.
class GradientAlongRay {
  public:
    /// @param gradients  at 0, 1/3, 2/3 and 1
    GradientAlongRay(const Optics& optics, const std::array<glm::dvec3, 4>& gradients)
        : optics_(optics), x_(along(gradients, {1, 0, 0})), y_(along(gradients, {0, 1, 0})),
          z_(along(gradients, {0, 0, 1})) {}

    template <typename V> struct Vector { V x, y, z; };
    template <typename V> Vector<V> gradient(V u) const { return {x_(u), y_(u), z_(u)}; }
    /// Gradient opacity.
    template <typename V> V factor(V u) const {
        return leaf::gradientOpacity<V>(optics_.gradientOpacity, gradient(u),
                                        V(std::numeric_limits<double>::max()));
    }
    /// Kinks of that factor, from 0 to 1: where the gradient's length is that of a point. Kinks closer
    /// together than 1/kParts may be missed.
    template <typename Visit> void forEachCorner(const Visit& visit) const {
        constexpr int kParts = 16;
        std::array<double, kParts + 1> squares{};
        for (int n = 0; n <= kParts; ++n)
            squares[static_cast<std::size_t>(n)] = squared(static_cast<double>(n) / kParts);
        for (int i = 0; i < optics_.gradientOpacity.count; ++i) {
            const double length = optics_.gradientOpacity.length[i], square = length * length;
            for (int n = 0; n < kParts; ++n) {
                const bool below = squares[static_cast<std::size_t>(n)] < square;
                if (below == (squares[static_cast<std::size_t>(n) + 1] < square))
                    continue;
                double a = static_cast<double>(n) / kParts, b = static_cast<double>(n + 1) / kParts;
                for (int halving = 0; halving < 52; ++halving) {
                    const double middle = 0.5 * (a + b);
                    ((squared(middle) < square) == below ? a : b) = middle;
                }
                visit(b);
            }
        }
    }

  protected:
    static Cubic along(const std::array<glm::dvec3, 4>& gradients, const glm::dvec3& d) {
        return {glm::dot(gradients[0], d), glm::dot(gradients[1], d), glm::dot(gradients[2], d),
                glm::dot(gradients[3], d)};
    }
    const Optics& optics_;
    Cubic x_, y_, z_;

  private:
    double squared(double u) const {
        const Vector<double> g = gradient(u);
        return g.x * g.x + g.y * g.y + g.z * g.z;
    }
};

} // namespace tessera
