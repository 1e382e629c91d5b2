// bricking/analysis/surface/mesh_parts.cpp: see mesh_parts.h.
#include "bricking/analysis/surface/mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// Six times the volume between a triangle and the origin, with its sign.
double sixfoldVolume(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return glm::dot(a, glm::cross(b, c));
}

} // namespace

HeldSurface::HeldSurface(std::uint64_t points, std::uint64_t triangles) {
    mesh.points.reserve(static_cast<std::size_t>(points));
    mesh.triangles.reserve(static_cast<std::size_t>(triangles));
}

std::size_t HeldSurface::heldBytes(std::uint64_t points, std::uint64_t triangles) {
    return static_cast<std::size_t>(points * sizeof(glm::vec3) + triangles * sizeof(glm::uvec3));
}

MeshMeasures measuresOf(const TriangleMesh& mesh) {
    MeshMeasures measures;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 origin(mesh.points[0]); // near, so that digits are kept
        const glm::dvec3 a = glm::dvec3(mesh.points[t.x]) - origin, b = glm::dvec3(mesh.points[t.y]) - origin,
                         c = glm::dvec3(mesh.points[t.z]) - origin;
        measures.volumeMm3 += sixfoldVolume(a, b, c) / 6;
        measures.areaMm2 += glm::length(glm::cross(b - a, c - a)) / 2;
    }
    return measures;
}

std::size_t partsBytes(std::uint64_t points) {
    return static_cast<std::size_t>(points) * (sizeof(std::uint32_t) + sizeof(double));
}

PartsFound keepParts(TriangleMesh& mesh, const PartsChoice& choice) {
    std::vector<std::uint32_t> root(mesh.points.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&root](std::uint32_t at) {
        while (root[at] != at)
            at = root[at] = root[root[at]];
        return at;
    };
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        root[std::max(a, b)] = std::min(a, b); // the first point of a part is its root
    };
    for (const glm::uvec3& t : mesh.triangles)
        join(t.x, t.y), join(t.y, t.z);
    std::vector<double> volume(mesh.points.size(), 0.0); // sixfold, of a part at its root
    for (const glm::uvec3& t : mesh.triangles) {
        const std::uint32_t part = find(t.x);
        const glm::dvec3 origin(mesh.points[part]);
        volume[part] +=
            sixfoldVolume(glm::dvec3(mesh.points[t.x]) - origin, glm::dvec3(mesh.points[t.y]) - origin,
                          glm::dvec3(mesh.points[t.z]) - origin);
    }
    PartsFound found;
    std::uint32_t largest = 0;
    for (std::uint32_t at = 0; at < root.size(); ++at)
        if (find(at) == at) {
            ++found.parts;
            if (volume[at] > volume[largest])
                largest = at;
        }
    const auto keeps = [&](std::uint32_t part) {
        return (!choice.largest || part == largest) && std::abs(volume[part]) / 6 >= choice.leastVolumeMm3;
    };
    for (std::uint32_t at = 0; at < root.size(); ++at) {
        root[at] = find(at);
        found.kept += root[at] == at && keeps(at);
    }
    std::size_t triangles = 0;
    for (const glm::uvec3& t : mesh.triangles)
        if (keeps(root[t.x]))
            mesh.triangles[triangles++] = t;
    mesh.triangles.resize(triangles);
    std::uint32_t points = 0;
    for (std::uint32_t at = 0; at < root.size(); ++at) // root becomes the new number
        if (keeps(root[at])) {
            mesh.points[points] = mesh.points[at];
            root[at] = points++;
        }
    mesh.points.resize(points);
    for (glm::uvec3& t : mesh.triangles)
        t = {root[t.x], root[t.y], root[t.z]};
    return found;
}

} // namespace tessera
