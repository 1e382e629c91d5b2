// bricking/analysis/surface/cell_cases.h: the triangles that a surface of one value has in a cell of eight
// samples, for every way in which its corners and its faces can lie to the value.
//
// Where two opposite corners of a face alone are inside, their parts are joined or apart: by the value that
// the bilinear face has at its saddle (Nielson and Hamann 1991, "The asymptotic decider"). That depends on
// the face alone, so the cells on both sides of it cut it alike, in opposite directions. In a cell the cuts
// of its faces form closed loops; each is filled with triangles. No edge inside a loop lies in a face, so
// every edge of the surface has two triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace tessera {

// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2). Edge e runs along axis e / 4 from its low corner;
// bit 0 of e is that corner's place along the next axis, bit 1 along the one after that, cyclically. Face f
// is at right angles to axis f / 2, at its low end or its high end by f & 1.

constexpr int kCellEdges = 12;
/// The low corner of an edge. Its high corner has the bit of the edge's axis set as well.
constexpr int lowCornerOf(int edge) {
    const int axis = edge / 4;
    return (edge & 1) << (axis + 1) % 3 | (edge >> 1 & 1) << (axis + 2) % 3;
}
/// Corners of a face in a circle: opposite ones are two apart.
constexpr std::array<int, 4> cornersOf(int face) {
    const int axis = face / 2, base = (face & 1) << axis, u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
    return {base, base | u, base | u | v, base | v};
}

/// A point in the middle of a loop, where no triangulation without it avoids the faces: the mean of the
/// loop's points.
struct LoopMiddle {
    std::uint8_t count = 0;
    std::array<std::uint8_t, kCellEdges> edges{}; // in the loop's order
};
struct CellCase {
    /// Three for each triangle: an edge of the cell, or kCellEdges + the number of a middle. Seen from
    /// outside, where values are lower, they turn left in a right-handed space.
    std::span<const std::uint8_t> corners;
    std::span<const LoopMiddle> middles;
};

/// @param inside  bit c: the value at corner c is not below that of the surface
/// @return bit f for each face of which two opposite corners alone are inside
std::uint8_t ambiguousFaces(std::uint8_t inside);
/// @param joined  bit f: the parts of the two corners inside face f are joined; 0 for other faces
CellCase cellCase(std::uint8_t inside, std::uint8_t joined);

} // namespace tessera
