// bricking/analysis/surface/cell_cases.cpp: see cell_cases.h.
#include "bricking/analysis/surface/cell_cases.h"

#include <algorithm>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr int kFaces = 6;
using Loop = std::vector<int>; // of edges

int edgeBetween(int a, int b) {
    const int low = a & b, axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
    return 4 * axis + (low >> (axis + 1) % 3 & 1) + 2 * (low >> (axis + 2) % 3 & 1);
}

/// Corners counterclockwise, seen from outside of the cell.
std::array<int, 4> turnOf(int face) {
    std::array<int, 4> corners = cornersOf(face);
    if (!(face & 1))
        std::swap(corners[1], corners[3]);
    return corners;
}

bool shareFace(int a, int b) {
    const auto facesOf = [](int edge) {
        const int axis = edge / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
        return std::array<int, 2>{2 * u + (edge & 1), 2 * v + (edge >> 1 & 1)};
    };
    for (const int f : facesOf(a))
        for (const int g : facesOf(b))
            if (f == g)
                return true;
    return false;
}

glm::dvec3 middleOf(int edge) {
    const int low = lowCornerOf(edge), axis = edge / 4;
    glm::dvec3 place(low & 1, low >> 1 & 1, low >> 2 & 1);
    place[axis] += 0.5;
    return place;
}

/// The loops of a case: edge to edge, with the inside on the left seen from outside of the cell.
std::vector<Loop> loopsOf(std::uint8_t inside, std::uint8_t joined) {
    std::array<int, kCellEdges> next;
    next.fill(-1);
    const auto in = [inside](int corner) { return (inside >> corner & 1) != 0; };
    for (int face = 0; face < kFaces; ++face) {
        const std::array<int, 4> turn = turnOf(face);
        const auto edge = [&turn](int i) {
            return edgeBetween(turn[static_cast<std::size_t>(i & 3)],
                               turn[static_cast<std::size_t>((i + 1) & 3)]);
        };
        for (int i = 0; i < 4; ++i) { // a cut begins where the turn leaves the inside
            if (!in(turn[static_cast<std::size_t>(i)]) || in(turn[static_cast<std::size_t>((i + 1) & 3)]))
                continue;
            // joined: on around what is outside; else back around what is inside
            int to = joined >> face & 1 ? i + 1 : i + 3;
            const int step = joined >> face & 1 ? 1 : 3;
            const auto enters = [&](int at) {
                return !in(turn[static_cast<std::size_t>(at & 3)]) &&
                       in(turn[static_cast<std::size_t>((at + 1) & 3)]);
            };
            while (!enters(to))
                to += step;
            next[static_cast<std::size_t>(edge(i))] = edge(to);
        }
    }
    std::vector<Loop> loops;
    for (int first = 0; first < kCellEdges; ++first) {
        Loop loop;
        for (int at = first; next[static_cast<std::size_t>(at)] >= 0;) {
            loop.push_back(at);
            at = std::exchange(next[static_cast<std::size_t>(at)], -1);
        }
        if (!loop.empty())
            loops.push_back(std::move(loop));
    }
    return loops;
}

/// Triangles of a loop with the least sum of squared edges (through the middles of the cell's edges), none
/// of whose inner edges lies in a face. False: there are none.
class LoopTriangles {
  public:
    explicit LoopTriangles(const Loop& loop) : loop_(loop), n_(loop.size()), cost_(n_ * n_), apex_(n_ * n_) {
        for (std::size_t length = 2; length < n_; ++length)
            for (std::size_t first = 0; first + length < n_; ++first)
                settle(first, first + length);
    }
    bool exist() const { return cost_[n_ - 1] < kNever; }
    void write(std::vector<std::uint8_t>& out) const { write(0, n_ - 1, out); }

  private:
    static constexpr double kNever = 1e9;
    double edgeCost(std::size_t a, std::size_t b) const {
        if (b - a == 1 || b - a == n_ - 1)
            return 0;
        if (shareFace(loop_[a], loop_[b]))
            return kNever;
        const glm::dvec3 d = middleOf(loop_[a]) - middleOf(loop_[b]);
        return glm::dot(d, d);
    }
    void settle(std::size_t first, std::size_t last) {
        double best = 2 * kNever;
        for (std::size_t k = first + 1; k < last; ++k) {
            const double cost = cost_[first * n_ + k] + cost_[k * n_ + last];
            if (cost < best) {
                best = cost;
                apex_[first * n_ + last] = k;
            }
        }
        cost_[first * n_ + last] = std::min(kNever, best + edgeCost(first, last));
    }
    void write(std::size_t first, std::size_t last, std::vector<std::uint8_t>& out) const {
        if (last - first < 2)
            return;
        const std::size_t k = apex_[first * n_ + last];
        write(first, k, out);
        for (const std::size_t at : {first, last, k}) // against the loop's turn: see cellCase()
            out.push_back(static_cast<std::uint8_t>(loop_[at]));
        write(k, last, out);
    }

    const Loop& loop_;
    std::size_t n_;
    std::vector<double> cost_;
    std::vector<std::size_t> apex_;
};

/// All cases. The inside lies to the left of a loop seen from outside of the cell, so a loop turns to the
/// right seen from where values are lower: triangles turn against it.
struct AllCases {
    struct Range {
        std::uint32_t first = 0, firstMiddle = 0;
        std::uint16_t count = 0, middles = 0;
    };
    std::vector<Range> ranges = std::vector<Range>(256 * 64);
    std::vector<std::uint8_t> corners;
    std::vector<LoopMiddle> middles;

    AllCases() {
        for (unsigned inside = 0; inside < 256; ++inside) {
            const unsigned ambiguous = ambiguousFaces(static_cast<std::uint8_t>(inside));
            for (unsigned joined = 0; joined < 64; ++joined)
                if ((joined & ~ambiguous) == 0)
                    add(static_cast<std::uint8_t>(inside), static_cast<std::uint8_t>(joined));
        }
    }
    void add(std::uint8_t inside, std::uint8_t joined) {
        Range& range = ranges[inside * 64u + joined];
        range.first = static_cast<std::uint32_t>(corners.size());
        range.firstMiddle = static_cast<std::uint32_t>(middles.size());
        for (const Loop& loop : loopsOf(inside, joined)) {
            if (const LoopTriangles triangles(loop); triangles.exist()) {
                triangles.write(corners);
                continue;
            }
            LoopMiddle middle;
            for (const int edge : loop)
                middle.edges[middle.count++] = static_cast<std::uint8_t>(edge);
            const auto number =
                static_cast<std::uint8_t>(kCellEdges + static_cast<int>(middles.size() - range.firstMiddle));
            for (std::size_t i = 0; i < loop.size(); ++i) {
                corners.push_back(static_cast<std::uint8_t>(loop[(i + 1) % loop.size()]));
                corners.push_back(static_cast<std::uint8_t>(loop[i]));
                corners.push_back(number);
            }
            middles.push_back(middle);
        }
        range.count = static_cast<std::uint16_t>(corners.size() - range.first);
        range.middles = static_cast<std::uint16_t>(middles.size() - range.firstMiddle);
    }
};

} // namespace

std::uint8_t ambiguousFaces(std::uint8_t inside) {
    unsigned faces = 0;
    for (int face = 0; face < kFaces; ++face) {
        const std::array<int, 4> c = cornersOf(face);
        const auto in = [&](std::size_t i) { return inside >> c[i] & 1; };
        faces |= static_cast<unsigned>(in(0) == in(2) && in(1) == in(3) && in(0) != in(1)) << face;
    }
    return static_cast<std::uint8_t>(faces);
}

CellCase cellCase(std::uint8_t inside, std::uint8_t joined) {
    static const AllCases all;
    const AllCases::Range& range = all.ranges[inside * 64u + joined];
    return {std::span(all.corners).subspan(range.first, range.count),
            std::span(all.middles).subspan(range.firstMiddle, range.middles)};
}

} // namespace tessera
