// tests/support/closed_mesh.h: meshes that are held, and what makes them closed surfaces.
#pragma once

#include "bricking/analysis/surface/surface_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {

using Corners = std::array<std::uint32_t, 3>;

struct HeldMesh final : MeshSink {
    std::vector<glm::dvec3> points;
    std::vector<Corners> triangles;
    std::size_t wrongPlaces = 0; // of corners, that are not their points'

    void point(const glm::dvec3& mm) override { points.push_back(mm); }
    void triangle(const Corners& numbers, const std::array<glm::dvec3, 3>& places) override {
        triangles.push_back(numbers);
        for (std::size_t i = 0; i < 3; ++i)
            wrongPlaces += numbers[i] >= points.size() || points[numbers[i]] != places[i];
    }
};

/// "" for a closed surface: every edge has two triangles, in opposite directions; the triangles around every
/// point are one fan; no triangle has an area of 0, in numbers of 32 bits too.
inline std::string faultOf(const HeldMesh& mesh) {
    if (mesh.wrongPlaces > 0)
        return "corners that are not at their points";
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    std::vector<std::map<std::uint32_t, std::uint32_t>> around(mesh.points.size());
    for (const Corners& t : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
            if (a == b)
                return "a triangle with one point twice";
            if (++edges[{a, b}] > 1)
                return "an edge with two triangles on one side";
            around[a][b] = c;
        }
    for (const auto& [edge, count] : edges)
        if (!edges.contains({edge.second, edge.first}))
            return "an edge with one triangle";
    for (const auto& fan : around) {
        if (fan.empty())
            return "a point without triangles";
        std::size_t steps = 0;
        std::uint32_t at = fan.begin()->first;
        do {
            at = fan.at(at);
            ++steps;
        } while (at != fan.begin()->first && steps <= fan.size());
        if (steps != fan.size())
            return "two fans around a point";
    }
    for (const Corners& t : mesh.triangles) {
        const glm::vec3 a(mesh.points[t[0]]), b(mesh.points[t[1]]), c(mesh.points[t[2]]);
        if (!(glm::length(glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a))) > 0))
            return "a triangle without an area";
    }
    return "";
}

struct Shape {
    int components = 0;
    int euler = 0;    // of all: points - edges + triangles
    bool each = true; // every component's is even and at most 2
    double volume = 0;
};

inline Shape shapeOf(const HeldMesh& mesh) {
    std::vector<std::uint32_t> root(mesh.points.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t at) {
        while (root[at] != at)
            at = root[at] = root[root[at]];
        return at;
    };
    for (const Corners& t : mesh.triangles)
        root[find(t[0])] = find(t[1]), root[find(t[1])] = find(t[2]);
    std::map<std::uint32_t, int> euler; // 2 V - 2 E + 2 F, with 2 E = 3 F
    for (std::uint32_t at = 0; at < root.size(); ++at)
        euler[find(at)] += 2;
    Shape shape;
    for (const Corners& t : mesh.triangles) {
        --euler[find(t[0])];
        const glm::dvec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        shape.volume += glm::dot(a - mesh.points[0], glm::cross(b - mesh.points[0], c - mesh.points[0])) / 6;
    }
    shape.components = static_cast<int>(euler.size());
    for (const auto& [at, twice] : euler) {
        shape.euler += twice / 2;
        shape.each = shape.each && twice % 4 == 0 && twice <= 4;
    }
    return shape;
}

/// How often the surface winds around a place, by the solid angles of its triangles: 1 inside.
inline double windingOf(const HeldMesh& mesh, const glm::dvec3& place) {
    double angle = 0;
    for (const Corners& t : mesh.triangles) {
        const glm::dvec3 a = mesh.points[t[0]] - place, b = mesh.points[t[1]] - place,
                         c = mesh.points[t[2]] - place;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        angle += 2 * std::atan2(glm::dot(a, glm::cross(b, c)), la * lb * lc + glm::dot(a, b) * lc +
                                                                   glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return angle / (4 * std::acos(-1.0));
}

/// Triangles by the places of their corners, whatever their order and numbers.
inline std::set<std::array<std::array<double, 3>, 3>> placesOf(const HeldMesh& mesh) {
    std::set<std::array<std::array<double, 3>, 3>> all;
    for (const Corners& t : mesh.triangles) {
        std::array<std::array<double, 3>, 3> places;
        for (std::size_t i = 0; i < 3; ++i)
            places[i] = {mesh.points[t[i]].x, mesh.points[t[i]].y, mesh.points[t[i]].z};
        std::rotate(places.begin(), std::min_element(places.begin(), places.end()), places.end());
        all.insert(places);
    }
    return all;
}

} // namespace tessera::test
