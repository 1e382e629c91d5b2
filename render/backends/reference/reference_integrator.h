// render/backends/reference/reference_integrator.h: the volume rendering integral along a line to near
// machine precision,
//   C = integral of tau(t) c(t) exp(-integral_0^t tau) dt,   A = 1 - exp(-integral tau),
// for functions that are smooth between given break points. It uses eight-point Gauss panels of small optical
// depth, with the depth inside a panel integrated by the same nodes. Panels are halved until two halves agree
// with the whole (2e-14 relative over extinction from 0 to 1e6 per length).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <type_traits>

namespace tessera {

struct RadiantPoint {
    double extinction = 0; // 1/length
    glm::dvec3 colour{0};  // not premultiplied
};

/// The same at the eight nodes of a panel.
struct RadiantNodes {
    std::array<double, 8> extinction, red, green, blue;
};

class ReferenceIntegrator {
  public:
    using Places = std::array<double, 8>;
    /// @param scale  of depths that matter: tolerances are relative to it where a panel has next to none
    explicit ReferenceIntegrator(double scale = 1) : least_(1e-3 * scale) {}
    /// Adds [t0,t1], on which what is seen is smooth. Call front to back.
    /// @param radiant  (t) -> RadiantPoint, or (Places, RadiantNodes&), which fills in all eight
    template <typename Function> void add(double t0, double t1, const Function& radiant) {
        if (!(t1 > t0) || opaque())
            return;
        refine(t0, t1, panel(t0, t1, radiant), radiant, 0);
    }
    /// Adds a surface behind what is there.
    /// @param opacity  [0,1]
    void addSurface(const glm::dvec3& colour, double opacity) {
        colour_ += std::exp(-depth_) * opacity * colour;
        depth_ -= std::log1p(-opacity); // to infinity where nothing behind is seen
    }
    /// Colour so far, premultiplied.
    glm::dvec3 colour() const { return colour_; }
    double alpha() const { return -std::expm1(-depth_); }
    double depth() const { return depth_; }
    /// Nothing behind can change a double any more: exp(-40) < 5e-18.
    bool opaque() const { return depth_ > 40; }

  private:
    struct Panel {
        double depth = 0;     // integral of tau
        glm::dvec3 colour{0}; // integral of tau c exp(-depth inside the panel)
    };
    static constexpr double kTolerance = 1e-14; // of a panel, against its own size and the picture's
    static constexpr int kMaxHalvings = 48;
    /// Scale of a colour's differences: lights can be so strong that rounding exceeds any fixed tolerance,
    /// and panels would be halved without end.
    static double brightness(double colour) {
        constexpr double kCommon = 4; // up to this, colours are told as they are
        return std::max(1.0, colour / kCommon);
    }
    static constexpr double kMaxPanelDepth = 1;

    template <typename Function>
    static void evaluate(const Function& radiant, const Places& place, RadiantNodes& at) {
        if constexpr (std::is_invocable_v<const Function&, const Places&, RadiantNodes&>) {
            radiant(place, at);
        } else {
            for (std::size_t i = 0; i < 8; ++i) {
                const RadiantPoint point = radiant(place[i]);
                at.extinction[i] = point.extinction;
                at.red[i] = point.colour.r;
                at.green[i] = point.colour.g;
                at.blue[i] = point.colour.b;
            }
        }
    }

    template <typename Function> static Panel panel(double t0, double t1, const Function& radiant) {
        const Rule& rule = gauss8();
        const double length = t1 - t0;
        Places place;
        for (std::size_t i = 0; i < 8; ++i)
            place[i] = t0 + length * rule.node[i];
        RadiantNodes at;
        evaluate(radiant, place, at);
        std::array<double, 8> before{}; // optical depth from the panel's start to node i
        for (std::size_t j = 0; j < 8; ++j)
            for (std::size_t i = 0; i < 8; ++i)
                before[i] += rule.inner[j][i] * at.extinction[j];
        Panel p;
        for (std::size_t i = 0; i < 8; ++i) {
            const double depth = length * rule.weight[i] * at.extinction[i];
            p.depth += depth;
            p.colour +=
                depth * std::exp(-length * before[i]) * glm::dvec3(at.red[i], at.green[i], at.blue[i]);
        }
        return p;
    }

    template <typename Function>
    void refine(double t0, double t1, const Panel& whole, const Function& radiant, int halvings) {
        if (opaque())
            return;
        const double middle = 0.5 * (t0 + t1);
        const Panel a = panel(t0, middle, radiant), b = panel(middle, t1, radiant);
        const double passed = std::exp(-a.depth);
        const glm::dvec3 both = a.colour + passed * b.colour;
        double difference = std::abs(a.depth + b.depth - whole.depth);
        for (int c = 0; c < 3; ++c)
            difference =
                std::max(difference, std::abs(both[c] - whole.colour[c]) / brightness(both[c] / whole.depth));
        const bool small = whole.depth <= kMaxPanelDepth;
        const bool agree = difference <= kTolerance * (least_ + std::abs(whole.depth));
        if ((small && agree) || halvings >= kMaxHalvings || !(middle > t0 && middle < t1)) {
            colour_ += std::exp(-depth_) * both;
            depth_ += a.depth + b.depth;
            return;
        }
        refine(t0, middle, a, radiant, halvings + 1);
        refine(middle, t1, b, radiant, halvings + 1);
    }

    /// Gauss-Legendre on [0,1], and inner[j][i]: the integral from 0 to node i of the
    /// j-th Lagrange polynomial.
    struct Rule {
        std::array<double, 8> node, weight;
        std::array<std::array<double, 8>, 8> inner;
    };
    static const Rule& gauss8();

    double least_;
    glm::dvec3 colour_{0};
    double depth_ = 0;
};

} // namespace tessera
