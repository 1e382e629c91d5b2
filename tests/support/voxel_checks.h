// tests/support/voxel_checks.h: voxels of triangles by definitions of the tests' own.
#pragma once

#include "core/base/triangle_mesh.h"
#include "render/geometry/mesh_bits.h"
#include "render/geometry/mesh_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>
#include <vector>

namespace tessera::test {

using Corners = std::array<glm::dvec3, 3>; // of a triangle, in voxels

inline SceneMesh sceneMesh(TriangleMesh triangles, MemoryBudget& ram, double opacity = 1) {
    SceneMesh mesh;
    mesh.path = "a.ply";
    mesh.opacity = opacity;
    mesh.shape = std::make_shared<const MeshShape>(std::move(triangles), ram, "a mesh");
    return mesh;
}

inline std::vector<Corners> inVoxels(const TriangleMesh& mesh, const VoxelGrid& grid) {
    std::vector<Corners> all;
    for (const glm::uvec3& t : mesh.triangles) {
        const auto at = [&](std::uint32_t n) {
            return glm::dvec3(grid.fromPatient * glm::dvec4(glm::dvec3(mesh.points[n]), 1));
        };
        all.push_back({at(t.x), at(t.y), at(t.z)});
    }
    return all;
}

/// The distance of a point to a triangle, degenerate ones too.
inline double distanceTo(const Corners& t, const glm::dvec3& p) {
    double least = 1e300;
    for (int e = 0; e < 3; ++e) {
        const glm::dvec3 &a = t[static_cast<std::size_t>(e)], &b = t[static_cast<std::size_t>((e + 1) % 3)];
        const double squared = glm::dot(b - a, b - a);
        const double at = squared > 0 ? std::clamp(glm::dot(p - a, b - a) / squared, 0.0, 1.0) : 0;
        least = std::min(least, glm::distance(p, a + at * (b - a)));
    }
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    if (!(glm::dot(n, n) > 0))
        return least;
    bool inside = true;
    for (int e = 0; e < 3; ++e) {
        const glm::dvec3 &a = t[static_cast<std::size_t>(e)], &b = t[static_cast<std::size_t>((e + 1) % 3)];
        inside = inside && glm::dot(glm::cross(n, b - a), p - a) >= 0;
    }
    return inside ? std::min(least, std::abs(glm::dot(n, p - t[0])) / glm::length(n)) : least;
}

/// The depth of a triangle along an axis at a centre across it, and how far inside of its edges that is, as
/// a share of it; below 0: outside.
inline double depthAt(const Corners& t, int w, double x, double y, double& within) {
    const int u = (w + 1) % 3, v = (w + 2) % 3;
    long double area[3], sum = 0;
    for (std::size_t e = 0; e < 3; ++e) {
        const glm::dvec3 &a = t[(e + 1) % 3], &b = t[(e + 2) % 3];
        area[e] = (static_cast<long double>(a[u]) - x) * (static_cast<long double>(b[v]) - y) -
                  (static_cast<long double>(b[u]) - x) * (static_cast<long double>(a[v]) - y);
        sum += area[e];
    }
    within = -1;
    if (sum == 0)
        return 0;
    within = static_cast<double>(std::min({area[0] / sum, area[1] / sum, area[2] / sum}));
    return static_cast<double>((area[0] * t[0][w] + area[1] * t[1][w] + area[2] * t[2][w]) / sum);
}

/// Calls visit(voxel, depth, within) for all centres across an axis in a triangle's box.
template <typename Visit> void forEachCentre(const Corners& t, int w, const Visit& visit) {
    const int u = (w + 1) % 3, v = (w + 2) % 3;
    const glm::dvec3 low = glm::min(glm::min(t[0], t[1]), t[2]), high = glm::max(glm::max(t[0], t[1]), t[2]);
    for (int y = static_cast<int>(std::floor(low[v])); y <= static_cast<int>(high[v]); ++y)
        for (int x = static_cast<int>(std::floor(low[u])); x <= static_cast<int>(high[u]); ++x) {
            double within = 0;
            const double depth = depthAt(t, w, x + 0.5, y + 0.5, within);
            glm::ivec3 voxel;
            voxel[u] = x, voxel[v] = y, voxel[w] = static_cast<int>(std::floor(depth));
            visit(voxel, depth, within);
        }
}

struct VoxelFaults {
    std::size_t set = 0, holes = 0, beyond = 0; // holes: centres within half a voxel along the main axis
};

/// By brute force: which voxels must be set, and how far from all triangles none may be.
inline VoxelFaults faultsOf(const MeshBits& bits, const std::vector<Corners>& triangles) {
    VoxelFaults faults;
    const glm::ivec3 extent = bits.grid().extent;
    std::vector<bool> near(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) *
                           static_cast<std::size_t>(extent.z));
    const auto index = [&](const glm::ivec3& i) {
        return static_cast<std::size_t>((i.z * extent.y + i.y) * extent.x + i.x);
    };
    for (const Corners& t : triangles) {
        const glm::dvec3 n = glm::abs(glm::cross(t[1] - t[0], t[2] - t[0]));
        const int w = n.x > n.y ? (n.x > n.z ? 0 : 2) : (n.y > n.z ? 1 : 2);
        forEachCentre(t, w, [&](const glm::ivec3& voxel, double depth, double within) {
            const double off = std::abs(depth - std::floor(depth) - 0.5);
            faults.holes += within > 1e-9 && off < 0.5 - 1e-9 && !bits.isSet(voxel) ? 1 : 0;
        });
        const glm::ivec3 low = glm::max(glm::ivec3(glm::min(glm::min(t[0], t[1]), t[2])) - 1, glm::ivec3(0)),
                         high = glm::min(glm::ivec3(glm::max(glm::max(t[0], t[1]), t[2])) + 1, extent - 1);
        glm::ivec3 i;
        for (i.z = low.z; i.z <= high.z; ++i.z)
            for (i.y = low.y; i.y <= high.y; ++i.y)
                for (i.x = low.x; i.x <= high.x; ++i.x)
                    if (bits.isSet(i) && !near[index(i)] &&
                        distanceTo(t, glm::dvec3(i) + 0.5) <= std::sqrt(0.75) + 1e-9)
                        near[index(i)] = true;
    }
    faults.set = bits.count();
    faults.beyond = faults.set - static_cast<std::size_t>(std::count(near.begin(), near.end(), true));
    return faults;
}

} // namespace tessera::test
