// render/engines/reference/piece_of_ray.h: what the reference integrates: the stored value as a cubic, the
// transfer function between two of its points, and light, two nodes of a panel side by side.
#pragma once

#include "render/contract/leaves.h"
#include "render/contract/optics.h"
#include "render/engines/reference/cubic.h"
#include "render/engines/reference/pair.h"
#include "render/engines/reference/reference_integrator.h"
#include "render/engines/reference/stored_function.h"

#include <array>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace tessera {

/// The light of docs/sampling.md along a ray between two planes of samples. Every kind of gradient is a cubic
/// there, component by component; taken as one, it costs a few multiplications at a place, not the many
/// values that it is the difference of, and is free of the noise of their differences, which would have
/// panels halved without end.
class LightAlongRay {
  public:
    /// Patient space. @param gradients  at 0, 1/3, 2/3 and 1
    LightAlongRay(const Optics& optics, const glm::dvec3& direction,
                  const std::array<glm::dvec3, 4>& gradients)
        : optics_(optics), direction_(direction), x_(along(gradients, {1, 0, 0})),
          y_(along(gradients, {0, 1, 0})), z_(along(gradients, {0, 0, 1})),
          facing_(along(gradients, direction)) {}

    /// Below 0 where the gradient points towards the eye.
    const Cubic& facing() const { return facing_; }

    /// What becomes of colours: colour * scale + add.
    template <typename V> leaf::HeadLight<V> at(V u) const {
        struct Vector {
            V x, y, z;
        };
        const Vector gradient{x_(u), y_(u), z_(u)};
        const Vector direction{V(direction_.x), V(direction_.y), V(direction_.z)};
        decltype(u > u) isLit{};
        const leaf::HeadLight<V> light = leaf::headLight<V>(
            gradient, direction, V(double{optics_.phong.x}), V(double{optics_.phong.y}),
            V(double{optics_.phong.z}), optics_.specularPower, V(std::numeric_limits<double>::max()), isLit);
        using leaf::select;
        return {select(isLit, light.scale, V(1.0)), select(isLit, light.add, V(0.0))};
    }
    glm::dvec3 lit(const glm::dvec3& colour, double u) const {
        const leaf::HeadLight<double> light = at(u);
        return colour * light.scale + light.add;
    }

  private:
    static Cubic along(const std::array<glm::dvec3, 4>& gradients, const glm::dvec3& d) {
        return {glm::dot(gradients[0], d), glm::dot(gradients[1], d), glm::dot(gradients[2], d),
                glm::dot(gradients[3], d)};
    }
    const Optics& optics_;
    glm::dvec3 direction_;
    Cubic x_, y_, z_, facing_;
};

/// What the integrator asks of a piece of a ray between two cuts: two nodes side by side.
struct PieceOfRay {
    const Cubic& cubic; // stored value
    const FunctionPiece& function;
    const LightAlongRay* light; // none: colours stay as they are
    double length;              // mm from 0 to 1

    void operator()(const ReferenceIntegrator::Places& u, RadiantNodes& at) const {
        for (std::size_t i = 0; i < u.size(); i += 2) {
            const Pair place(u[i], u[i + 1]), value = function.value(cubic(place));
            set(at.extinction, i,
                function.hasOneExtinction()
                    ? Pair(function.extinction())
                    : Pair(function.extinctionAt(value.first()), function.extinctionAt(value.second())));
            Pair red = function.colourAt(value, 0), green = function.colourAt(value, 1),
                 blue = function.colourAt(value, 2);
            if (light) {
                const leaf::HeadLight<Pair> shade = light->at(place);
                red = red * shade.scale + shade.add;
                green = green * shade.scale + shade.add;
                blue = blue * shade.scale + shade.add;
            }
            set(at.red, i, red);
            set(at.green, i, green);
            set(at.blue, i, blue);
        }
        for (double& extinction : at.extinction)
            extinction *= length;
    }

  private:
    static void set(std::array<double, 8>& all, std::size_t i, Pair value) {
        all[i] = value.first();
        all[i + 1] = value.second();
    }
};

} // namespace tessera
