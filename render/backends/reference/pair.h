// render/backends/reference/pair.h: two doubles computed side by side, with the operations that the
// contract's templates need (render/contract/leaves.h). Each has exactly the value of a scalar computation.
#pragma once

#include <cmath>

namespace tessera {

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

} // namespace tessera
