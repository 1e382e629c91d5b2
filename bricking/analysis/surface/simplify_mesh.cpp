// bricking/analysis/surface/simplify_mesh.cpp: see simplify_mesh.h. Rounds: the cheapest edges are collapsed,
// none beside another of the round, so that costs stay true without a queue.
#include "bricking/analysis/surface/simplify_mesh.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint32_t kEnd = 0xFFFFFFFF;
constexpr double kLeastTurn = 0.1;      // cosine between a triangle's normals before and after
constexpr double kShareOfRound = 0.35;  // of the edges, at most
constexpr double kLeastThinness = 0.02; // of a triangle that was less thin

/// Squared distances to planes, weighted by area, as a polynomial of a place.
struct Quadric {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, x = 0, y = 0, z = 0, one = 0, weight = 0;

    void add(const glm::dvec3& n, double d, double w) {
        xx += w * n.x * n.x, xy += w * n.x * n.y, xz += w * n.x * n.z;
        yy += w * n.y * n.y, yz += w * n.y * n.z, zz += w * n.z * n.z;
        x += w * n.x * d, y += w * n.y * d, z += w * n.z * d, one += w * d * d, weight += w;
    }
    Quadric& operator+=(const Quadric& o) {
        xx += o.xx, xy += o.xy, xz += o.xz, yy += o.yy, yz += o.yz, zz += o.zz;
        x += o.x, y += o.y, z += o.z, one += o.one, weight += o.weight;
        return *this;
    }
    /// Mean squared distance of a place.
    double at(const glm::dvec3& p) const {
        const double sum = p.x * (xx * p.x + 2 * (xy * p.y + xz * p.z + x)) +
                           p.y * (yy * p.y + 2 * (yz * p.z + y)) + p.z * (zz * p.z + 2 * z) + one;
        return weight > 0 ? std::max(0.0, sum / weight) : 0;
    }
};

struct Edge {
    float cost;
    std::uint32_t a, b;
    bool operator<(const Edge& o) const {
        return cost != o.cost ? cost < o.cost : a != o.a ? a < o.a : b < o.b;
    }
};

/// Twice a triangle's area over its longest side squared: 0.87 of an even one.
double thinnessOf(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double longest = std::max({glm::dot(a - b, a - b), glm::dot(b - c, b - c), glm::dot(c - a, c - a)});
    return longest > 0 ? glm::length(glm::cross(b - a, c - a)) / longest : 0;
}

class Simplifier {
  public:
    Simplifier(TriangleMesh& mesh, const SimplifyRequest& request)
        : mesh_(mesh), request_(request),
          origin_(mesh.points.empty() ? glm::dvec3(0) : glm::dvec3(mesh.points[0])),
          quadrics_(mesh.points.size()), first_(mesh.points.size(), kEnd), round_(mesh.points.size(), 0),
          next_(3 * mesh.triangles.size(), kEnd), alive_(mesh.triangles.size()) {
        edges_.reserve(3 * mesh.triangles.size() / 2);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const glm::dvec3 a = place(t, 0), b = place(t, 1), c = place(t, 2);
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            const double length = glm::length(normal);
            for (std::uint32_t i = 0; i < 3; ++i) {
                const std::uint32_t point = corner(3 * t + i);
                next_[3 * t + i] = std::exchange(first_[point], 3 * t + i);
                if (length > 0)
                    quadrics_[point].add(normal / length, -glm::dot(normal / length, a), length / 2);
            }
        }
    }

    double run(const ShareDone& progress) {
        const std::uint64_t before = alive_;
        bool all = false; // of the edges are looked at, not only the cheapest
        for (std::uint32_t round = 1; alive_ > request_.mostTriangles; ++round) {
            checkInterrupted();
            if (progress)
                progress(static_cast<double>(before - alive_) /
                         static_cast<double>(before - request_.mostTriangles));
            const std::uint64_t had = alive_;
            collapseRound(round, all);
            const bool few = had - alive_ < 2 + had / 1000; // edges that can be collapsed
            if (few && all)
                break;
            all = few;
        }
        pack();
        return std::sqrt(worst_);
    }

  private:
    std::uint32_t& corner(std::uint32_t at) { return mesh_.triangles[at / 3][static_cast<int>(at % 3)]; }
    glm::dvec3 placeOf(std::uint32_t point) const { return glm::dvec3(mesh_.points[point]) - origin_; }
    glm::dvec3 place(std::uint32_t triangle, int i) const { return placeOf(mesh_.triangles[triangle][i]); }
    bool isGone(std::uint32_t triangle) const { return mesh_.triangles[triangle].x == kEnd; }

    /// Calls visit(corner) for the corners of triangles at a point.
    template <typename Visit> void around(std::uint32_t point, const Visit& visit) const {
        for (std::uint32_t at = first_[point]; at != kEnd; at = next_[at])
            visit(at);
    }

    /// Where the edge's quadric is least, else its better end or middle.
    glm::dvec3 bestPlace(std::uint32_t a, std::uint32_t b, const Quadric& q) const {
        const glm::dvec3 p = placeOf(a), r = placeOf(b), middle = 0.5 * (p + r);
        glm::dvec3 best = middle;
        for (const glm::dvec3& place : {p, r})
            if (q.at(place) < q.at(best))
                best = place;
        const glm::dmat3 m(q.xx, q.xy, q.xz, q.xy, q.yy, q.yz, q.xz, q.yz, q.zz);
        const double size = q.xx + q.yy + q.zz;
        if (std::abs(glm::determinant(m)) > 1e-4 * size * size * size / 27) {
            const glm::dvec3 least = glm::inverse(m) * -glm::dvec3(q.x, q.y, q.z);
            if (glm::length(least - middle) <= glm::length(r - p) && q.at(least) < q.at(best))
                best = least;
        }
        return best;
    }

    void collapseRound(std::uint32_t round, bool all) {
        edges_.clear();
        const double most = request_.mostErrorMm * request_.mostErrorMm;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            for (std::uint32_t i = 0; i < 3 && !isGone(t); ++i) {
                const std::uint32_t a = corner(3 * t + i), b = corner(3 * t + (i + 1) % 3);
                if (a > b)
                    continue; // the triangle beside it has the edge the other way round
                Quadric q = quadrics_[a];
                q += quadrics_[b];
                const double cost = q.at(bestPlace(a, b, q));
                if (cost <= most)
                    edges_.push_back({static_cast<float>(cost), a, b});
            }
        const std::uint64_t wanted = (alive_ - request_.mostTriangles + 1) / 2;
        const std::size_t taken =
            all ? edges_.size()
                : std::min(edges_.size(),
                           16 + static_cast<std::size_t>(kShareOfRound * static_cast<double>(edges_.size())));
        std::nth_element(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(taken), edges_.end());
        std::sort(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(taken));
        std::uint64_t done = 0;
        for (std::size_t n = 0; n < taken && done < wanted; ++n) {
            const auto [cost, a, b] = edges_[n];
            if (round_[a] != round && round_[b] != round)
                done += collapse(a, b, round);
        }
    }

    /// The two triangles of an edge and the points across it; false where the surface would change.
    bool mayCollapse(std::uint32_t a, std::uint32_t b) {
        beside_.clear();
        around(a, [&](std::uint32_t at) {
            for (std::uint32_t i = 1; i < 3; ++i)
                beside_.push_back(corner(at / 3 * 3 + (at + i) % 3));
        });
        // of a's neighbours those of b: on a closed surface each is named by two triangles
        std::array<std::uint32_t, 2> across{kEnd, kEnd};
        std::size_t shared = 0;
        bool more = false;
        around(b, [&](std::uint32_t at) {
            const std::uint32_t point = corner(at / 3 * 3 + (at + 1) % 3);
            if (point == a || std::ranges::find(beside_, point) == beside_.end())
                return;
            if (shared < 2)
                across[shared] = point;
            more = ++shared > 2;
        });
        if (more || shared != 2)
            return false;
        const auto hasTriangle = [&](std::uint32_t point) {
            bool has = false;
            around(point, [&](std::uint32_t at) {
                const std::uint32_t p = corner(at / 3 * 3 + (at + 1) % 3),
                                    q = corner(at / 3 * 3 + (at + 2) % 3);
                has = has || (p == across[0] && q == across[1]) || (p == across[1] && q == across[0]);
            });
            return has;
        };
        return !(hasTriangle(a) && hasTriangle(b));
    }

    /// True if a triangle at the point `from` turns over or gets too thin with the point at `to`, but for
    /// those that have `gone` as well.
    bool turnsOver(std::uint32_t from, std::uint32_t gone, const glm::dvec3& to) {
        bool turns = false;
        around(from, [&](std::uint32_t at) {
            const std::uint32_t p = corner(at / 3 * 3 + (at + 1) % 3), q = corner(at / 3 * 3 + (at + 2) % 3);
            if (turns || p == gone || q == gone)
                return;
            const glm::dvec3 b = placeOf(p), c = placeOf(q);
            const glm::dvec3 before = glm::cross(b - placeOf(from), c - placeOf(from)),
                             after = glm::cross(b - to, c - to);
            const double thin = thinnessOf(b, c, to);
            turns = !(glm::dot(before, after) > kLeastTurn * glm::length(before) * glm::length(after)) ||
                    (thin < kLeastThinness && thin < thinnessOf(b, c, placeOf(from)));
        });
        return turns;
    }

    bool collapse(std::uint32_t a, std::uint32_t b, std::uint32_t round) {
        if (!mayCollapse(a, b))
            return false;
        Quadric q = quadrics_[a];
        q += quadrics_[b];
        // as it will be kept, in 32 bits
        const glm::vec3 kept(bestPlace(a, b, q) + origin_);
        const glm::dvec3 to = glm::dvec3(kept) - origin_;
        if (turnsOver(a, b, to) || turnsOver(b, a, to))
            return false;
        worst_ = std::max(worst_, q.at(to));
        mesh_.points[a] = kept;
        quadrics_[a] = q;
        std::uint32_t list = kEnd; // of a's corners, and b's that become a's
        for (const std::uint32_t point : {a, b})
            for (std::uint32_t at = first_[point]; at != kEnd;) {
                const std::uint32_t after = next_[at], t = at / 3;
                const glm::uvec3& corners = mesh_.triangles[t];
                const std::uint32_t other = point == a ? b : a;
                const bool goes = isGone(t) || corners.x == other || corners.y == other || corners.z == other;
                if (!goes) { // a's triangles of the edge are gone once b's come
                    corner(at) = a;
                    next_[at] = std::exchange(list, at);
                } else if (point == a) {
                    unlinkAcross(t, a, b);
                }
                at = after;
            }
        first_[a] = list, first_[b] = kEnd;
        around(a, [&](std::uint32_t at) { // costs beside it have changed
            for (std::uint32_t i = 0; i < 3; ++i)
                round_[corner(at / 3 * 3 + i)] = round;
        });
        return true;
    }

    /// A triangle of the edge a b goes: out of the list of its third point.
    void unlinkAcross(std::uint32_t t, std::uint32_t a, std::uint32_t b) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t point = corner(3 * t + i);
            if (point == a || point == b)
                continue;
            std::uint32_t* link = &first_[point];
            while (*link != 3 * t + i)
                link = &next_[*link];
            *link = next_[3 * t + i];
        }
        mesh_.triangles[t].x = kEnd;
        --alive_;
    }

    void pack() {
        std::vector<glm::vec3>& points = mesh_.points;
        std::uint32_t kept = 0;
        for (std::uint32_t point = 0; point < points.size(); ++point)
            if (first_[point] != kEnd) {
                points[kept] = points[point];
                round_[point] = kept++;
            }
        points.resize(kept);
        std::size_t triangles = 0;
        for (const glm::uvec3& t : mesh_.triangles)
            if (t.x != kEnd)
                mesh_.triangles[triangles++] = {round_[t.x], round_[t.y], round_[t.z]};
        mesh_.triangles.resize(triangles);
    }

    TriangleMesh& mesh_;
    const SimplifyRequest& request_;
    glm::dvec3 origin_; // of places, so that quadrics keep their digits
    std::vector<Quadric> quadrics_;
    std::vector<std::uint32_t> first_, round_; // of a point: its first corner; when it was last changed
    std::vector<std::uint32_t> next_;          // corner of the same point
    std::uint64_t alive_;                      // triangles
    std::vector<Edge> edges_;
    std::vector<std::uint32_t> beside_;
    double worst_ = 0; // squared
};

} // namespace

std::size_t simplifyBytes(std::uint64_t points, std::uint64_t triangles) {
    return static_cast<std::size_t>(points * (sizeof(Quadric) + 2 * sizeof(std::uint32_t)) +
                                    triangles * (3 * sizeof(std::uint32_t) + 3 * sizeof(Edge) / 2)) +
           (std::size_t{1} << 16);
}

double simplifyMesh(TriangleMesh& mesh, const SimplifyRequest& request, MemoryBudget& ram,
                    const ShareDone& progress) {
    const Charge charge = ram.charge(simplifyBytes(mesh.points.size(), mesh.triangles.size()),
                                     "simplifying " + std::to_string(mesh.triangles.size()) + " triangles");
    return Simplifier(mesh, request).run(progress);
}

} // namespace tessera
