// render/backends/reference/piece_of_ray.h: the integrand of the reference: the stored value as a cubic, the
// transfer function between two of its points, and light, two nodes of a panel side by side.
#pragma once

#include "render/backends/reference/cell_gradients.h"
#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/labels_along_ray.h"
#include "render/backends/reference/light_between.h"
#include "render/backends/reference/reference_integrator.h"
#include "render/backends/reference/stored_function.h"
#include "render/contract/leaves.h"
#include "render/contract/optics.h"

#include <array>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// The light of docs/sampling.md along a ray between two planes of samples. Every kind of gradient is a cubic
/// there, component by component. As a cubic it costs a few multiplications per point, instead of many values
/// of the field. It is also free of the noise of their differences, which would make panels halve without
/// end.
class LightAlongRay : public GradientAlongRay {
  public:
    /// Patient space.
    /// @param gradients  at 0, 1/3, 2/3 and 1
    /// @param from, to  places of 0 and 1, voxels
    /// @param received  light that arrives, by u; none: all of it, everywhere
    LightAlongRay(const Optics& optics, const glm::dvec3& direction,
                  const std::array<glm::dvec3, 4>& gradients, const glm::dvec3& from, const glm::dvec3& to,
                  const LightBetween* received)
        : GradientAlongRay(optics, gradients), received_(received), toPatient_(optics.patientFromVoxel),
          direction_(direction), from_(from), path_(to - from), facing_(along(gradients, direction)) {}

    /// Kinks of the light, from 0 to 1: where the gradient turns away from the ray, or from a light.
    template <typename Visit> void forEachTurn(const Visit& visit) const {
        turnsOf(facing_, visit);
        for (int i = 0; i < optics_.lighting.count; ++i) {
            const leaf::LightNumbers& light = optics_.lighting.lights[i];
            if (light.sort == leaf::LightSort::directional)
                turnsOf(towards(placeOf(light)), visit);
            else if (light.sort == leaf::LightSort::point)
                turnsOfPoint(toPatient_ * (placeOf(light) - from_), toPatient_ * path_, visit);
        }
    }

    /// Lit colours: colour * scale + add.
    template <typename V> leaf::Lit<V> at(V u, const leaf::Material<double>& material) const {
        const Vector<V> gradient = this->gradient(u);
        const Vector<V> direction{V(direction_.x), V(direction_.y), V(direction_.z)};
        if (optics_.hasLights) {
            const auto toPoint = [&](const leaf::LightNumbers& light) {
                const glm::dvec3 first = toPatient_ * (placeOf(light) - from_), way = toPatient_ * path_;
                return Vector<V>{V(first.x) - u * V(way.x), V(first.y) - u * V(way.y),
                                 V(first.z) - u * V(way.z)};
            };
            const leaf::Material<V> answer{V(material.ambient), V(material.diffuse), V(material.specular),
                                           material.power};
            const V most(std::numeric_limits<double>::max());
            leaf::Lit<V> lit = received_ ? leaf::litBy<V>(optics_.lighting, gradient, direction, answer, most,
                                                          toPoint, received_->at(u, optics_.lighting))
                                         : leaf::litBy<V>(optics_.lighting, gradient, direction, answer, most,
                                                          toPoint, leaf::AllLight());
            for (int c = 0; c < 3 && optics_.lighting.emits; ++c)
                lit.add[c] = lit.add[c] + V(material.emission[c]);
            return lit;
        }
        const auto isLit = leaf::isHeadLit(gradient, direction, V(std::numeric_limits<double>::max()));
        const leaf::HeadLight<V> light =
            leaf::headLight(gradient, direction, V(double{optics_.phong.x}), V(double{optics_.phong.y}),
                            V(double{optics_.phong.z}), optics_.specularPower);
        using leaf::select;
        const V scale = select(isLit, light.scale, V(1.0)), add = select(isLit, light.add, V(0.0));
        return {{scale, scale, scale}, {add, add, add}};
    }
    glm::dvec3 lit(const glm::dvec3& colour, double u, const leaf::Material<double>& material) const {
        const leaf::Lit<double> light = at(u, material);
        return {colour.x * light.scale[0] + light.add[0], colour.y * light.scale[1] + light.add[1],
                colour.z * light.scale[2] + light.add[2]};
    }

  private:
    static glm::dvec3 placeOf(const leaf::LightNumbers& light) {
        return {light.place[0], light.place[1], light.place[2]};
    }
    Cubic towards(const glm::dvec3& d) const {
        const auto at = [&](double u) { return x_(u) * d.x + y_(u) * d.y + z_(u) * d.z; };
        return {at(0), at(1.0 / 3), at(2.0 / 3), at(1)};
    }
    template <typename Visit> static void turnsOf(const Cubic& f, const Visit& visit) {
        std::array<double, 4> ends{};
        const std::size_t count = f.monotonePieces(ends);
        for (std::size_t i = 0; i + 1 < count; ++i)
            if ((f(ends[i]) < 0) != (f(ends[i + 1]) < 0))
                visit(crossing(f, 0, ends[i], ends[i + 1]));
    }
    /// Towards a point light it is of the fourth degree, with extrema at roots of a cubic.
    template <typename Visit>
    void turnsOfPoint(const glm::dvec3& first, const glm::dvec3& way, const Visit& visit) const {
        const auto value = [&](double u) {
            return x_(u) * (first.x - u * way.x) + y_(u) * (first.y - u * way.y) +
                   z_(u) * (first.z - u * way.z);
        };
        const auto slope = [&](double u) {
            return x_.slope(u) * (first.x - u * way.x) - x_(u) * way.x + y_.slope(u) * (first.y - u * way.y) -
                   y_(u) * way.y + z_.slope(u) * (first.z - u * way.z) - z_(u) * way.z;
        };
        std::vector<double> ends = {0};
        turnsOf(Cubic(slope(0), slope(1.0 / 3), slope(2.0 / 3), slope(1)),
                [&](double u) { ends.push_back(u); });
        ends.push_back(1);
        for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
            double a = ends[i], b = ends[i + 1];
            const bool below = value(a) < 0;
            if (below == (value(b) < 0))
                continue;
            for (int halving = 0; halving < 60; ++halving) {
                const double middle = 0.5 * (a + b);
                ((value(middle) < 0) == below ? a : b) = middle;
            }
            visit(b);
        }
    }
    const LightBetween* received_;
    glm::dmat3 toPatient_;
    glm::dvec3 direction_, from_, path_;
    Cubic facing_;
};

/// The integrand on a piece of a ray between two cuts: two nodes side by side.
struct PieceOfRay {
    const Cubic& cubic; // stored value
    const FunctionPiece& function;
    const LightAlongRay* light; // none: colours are unlit
    double length;              // mm from 0 to 1
    leaf::Material<double> material;
    const GradientAlongRay* gradient = nullptr; // of gradient opacity; may be none
    const LabelsAlongRay* labels = nullptr;     // may be none
    const LightAlongRay* ofMedium = nullptr;    // light on the labels' medium; none: as on the function

    void operator()(const ReferenceIntegrator::Places& u, RadiantNodes& at) const {
        for (std::size_t i = 0; i < u.size(); i += 2) {
            const Pair place(u[i], u[i + 1]), value = function.value(cubic(place));
            const Pair extinction = function.hasOneExtinction() ? Pair(function.extinction())
                                                                : Pair(function.extinctionAt(value.first()),
                                                                       function.extinctionAt(value.second()));
            const Pair graded = gradient ? extinction * gradient->factor(place) : extinction;
            Pair red = function.colourAt(value, 0), green = function.colourAt(value, 1),
                 blue = function.colourAt(value, 2);
            bool isMedium = false; // wherever the piece is: it is cut where that changes
            if (!labels) {
                set(at.extinction, i, graded);
            } else {
                const leaf::LabelShares<Pair> shares = labels->at(place);
                const Pair ofFunction = labels->function(place, graded), medium = labels->medium(place),
                           sum = ofFunction + medium;
                set(at.extinction, i, sum);
                isMedium = medium.first() > ofFunction.first();
                if (labels->hasColour() && sum.first() > 0 && sum.second() > 0) {
                    const Pair part = leaf::labelledPart(shares, graded, medium, sum);
                    red = leaf::labelledColour(shares, red, shares.red, part);
                    green = leaf::labelledColour(shares, green, shares.green, part);
                    blue = leaf::labelledColour(shares, blue, shares.blue, part);
                }
            }
            if (light) {
                const leaf::Lit<Pair> shade = (isMedium && ofMedium ? ofMedium : light)->at(place, material);
                red = red * shade.scale[0] + shade.add[0];
                green = green * shade.scale[1] + shade.add[1];
                blue = blue * shade.scale[2] + shade.add[2];
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
