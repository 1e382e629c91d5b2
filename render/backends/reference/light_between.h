// render/backends/reference/light_between.h: light along a piece of a ray, between points whose light is
// known. Rays of light are too expensive for every point of the integrator. A parabola through three points
// is used if it agrees with two more between them; else the piece is halved.
#pragma once

#include "render/backends/reference/light_rays.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tessera {

// Two doubles computed side by side, with the operations that the contract's templates need
// (render/contract/leaves.h). Each has exactly the value of a scalar computation.

class Pair {
    using Vector [[gnu::vector_size(16)]] = double;

  public:
    using Condition [[gnu::vector_size(16)]] = long long;

    explicit Pair(double both) : v_{both, both} {}
    Pair(double first, double second) : v_{first, second} {}
    double first() const { return v_[0]; }
    double second() const { return v_[1]; }

    friend Pair operator+(Pair a, Pair b) { return Pair(a.v_ + b.v_); }
    friend Pair operator-(Pair a, Pair b) { return Pair(a.v_ - b.v_); }
    friend Pair operator*(Pair a, Pair b) { return Pair(a.v_ * b.v_); }
    friend Pair operator/(Pair a, Pair b) { return Pair(a.v_ / b.v_); }
    friend Condition operator>(Pair a, Pair b) { return a.v_ > b.v_; }
    friend Condition operator<=(Pair a, Pair b) { return a.v_ <= b.v_; }
    friend Pair select(Condition condition, Pair a, Pair b) { return Pair(condition ? a.v_ : b.v_); }
    friend Pair min(Pair a, Pair b) { return Pair(b.v_ < a.v_ ? b.v_ : a.v_); }
    friend Pair max(Pair a, Pair b) { return Pair(a.v_ < b.v_ ? b.v_ : a.v_); }
    friend Pair abs(Pair a) { return Pair(std::abs(a.v_[0]), std::abs(a.v_[1])); }
    friend Pair sqrt(Pair a) { return Pair(std::sqrt(a.v_[0]), std::sqrt(a.v_[1])); }

  private:
    explicit Pair(Vector v) : v_(v) {}
    Vector v_;
};

/// By parameter u from 0 to 1 on an interval of a ray.
class LightBetween {
  public:
    /// Required accuracy of light.
    struct Need {
        double tolerance = 0; // of shares
        double weight = 1;    // upper bound on the piece's contribution to its ray's colour
        double part = 1;      // share of the ray's path through the volume
    };

    void clear() { pieces_.clear(); }
    /// Adds [u0,u1] behind the existing pieces. Errors of a ray's pieces, times their weights, sum to at most
    /// about twice the tolerance.
    /// @param light  (u) -> LightShares
    template <typename Light>
    void add(double u0, double u1, int channels, const Need& need, const Light& light) {
        const double middle = 0.5 * (u0 + u1);
        const LightShares a = light(u0), m = light(middle), b = light(u1);
        refine({u0, middle, u1}, {a, m, b}, channels, need, light, 0);
    }
    /// Adds a piece with constant light.
    void add(double u0, double u1, const LightShares& light) {
        pieces_.push_back({u0, u1, light, light, light});
    }

    /// Light at the end.
    const LightShares& last() const { return pieces_.back().b; }
    /// Calls visit at the joints of pieces.
    template <typename Visit> void forEachJoint(const Visit& visit) const {
        for (std::size_t i = 0; i + 1 < pieces_.size(); ++i)
            visit(pieces_[i].to);
    }
    /// V: both of a pair are in the same piece.
    template <typename V> leaf::ReceivedLight<V> at(V u, const leaf::LightingNumbers& lighting) const {
        const double first = firstOf(u);
        std::size_t n = 0;
        while (n + 1 < pieces_.size() && first > pieces_[n].to)
            ++n;
        const Piece& p = pieces_[n];
        const double scale = p.to > p.from ? 1 / (p.to - p.from) : 0;
        const V x = (u - V(p.from)) * V(scale);
        return leaf::receivedLight<V>(lighting, [&](int channel) {
            const auto c = static_cast<std::size_t>(channel);
            return V(p.a[c]) +
                   x * (V(4 * p.m[c] - 3 * p.a[c] - p.b[c]) + x * V(2 * (p.a[c] + p.b[c]) - 4 * p.m[c]));
        });
    }

  private:
    static constexpr int kMostHalvings = 8;
    struct Piece {
        double from, to;
        LightShares a, m, b; // at its ends and in its middle
    };
    struct Places {
        double a, m, b;
    };
    struct Shares {
        LightShares a, m, b;
    };
    static double firstOf(double u) { return u; }
    static double firstOf(Pair u) { return u.first(); }

    static double largest(const LightShares& light, int channels, const LightShares& expected) {
        double largest = 0;
        for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
            largest = std::max(largest, std::abs(light[c] - expected[c]));
        return largest;
    }
    template <typename Combine> static LightShares combined(const Combine& combine) {
        LightShares out{};
        for (std::size_t c = 0; c < out.size(); ++c)
            out[c] = combine(c);
        return out;
    }
    static bool isGood(double difference, const Need& need, double share) {
        return difference <= need.tolerance || difference * need.weight <= need.tolerance * need.part * share;
    }
    template <typename Light>
    void refine(const Places& u, const Shares& s, int channels, const Need& need, const Light& light,
                int halvings) {
        const double share = std::ldexp(1, -halvings);
        const LightShares line = combined([&](std::size_t c) { return 0.5 * (s.a[c] + s.b[c]); });
        if (isGood(largest(s.m, channels, line), need, share) || halvings >= kMostHalvings) {
            pieces_.push_back({u.a, u.b, s.a, s.m, s.b});
            return;
        }
        const double first = 0.5 * (u.a + u.m), second = 0.5 * (u.m + u.b);
        const LightShares l = light(first), r = light(second);
        const LightShares left =
            combined([&](std::size_t c) { return (3 * s.a[c] + 6 * s.m[c] - s.b[c]) / 8; });
        const LightShares right =
            combined([&](std::size_t c) { return (3 * s.b[c] + 6 * s.m[c] - s.a[c]) / 8; });
        if (isGood(std::max(largest(l, channels, left), largest(r, channels, right)), need, share)) {
            pieces_.push_back({u.a, u.m, s.a, l, s.m});
            pieces_.push_back({u.m, u.b, s.m, r, s.b});
            return;
        }
        refine({u.a, first, u.m}, {s.a, l, s.m}, channels, need, light, halvings + 1);
        refine({u.m, second, u.b}, {s.m, r, s.b}, channels, need, light, halvings + 1);
    }

    std::vector<Piece> pieces_;
};

} // namespace tessera
