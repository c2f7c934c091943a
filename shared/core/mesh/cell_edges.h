#pragma once

#include <array>
#include <cstdint>

namespace isosplat {

/// An edge of a cell: 4 · axis + k. Bits 0 and 1 of k are its coordinates along the other two axes,
/// in ascending order.
using CellEdge = uint8_t;
inline constexpr int kCellEdges = 12;

constexpr int axis_of(int edge) {
  return edge >> 2;
}

/// The corner (see CellCorners) at the low end of an edge. The other one is + (1 << axis).
constexpr int low_corner(int edge) {
  const int axis = axis_of(edge), k = edge & 3;
  switch (axis) {
    case 0:
      return k << 1;
    case 1:
      return (k & 1) | (k & 2) << 1;
    default:
      return k;
  }
}
constexpr int high_corner(int edge) {
  return low_corner(edge) | 1 << axis_of(edge);
}

/// A face of a cell: 2 · axis + side, where side is its coordinate along the axis.
inline constexpr int kCellFaces = 6;

/// The corners of a face, each next to the one before.
constexpr std::array<int, 4> corners_of_face(int face) {
  const int axis = face >> 1, base = (face & 1) << axis;
  const int u = 1 << (axis == 0 ? 1 : 0), v = 1 << (axis == 2 ? 1 : 2);
  return {base, base | u, base | u | v, base | v};
}

/// Bit f: the edge lies on face f. Each edge lies on two faces.
constexpr uint32_t faces_of_edge(int edge) {
  uint32_t faces = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != axis_of(edge)) faces |= 1u << (2 * axis + (low_corner(edge) >> axis & 1));
  }
  return faces;
}

/// Bit i: corner i is above the isovalue.
using CornerSigns = uint8_t;

constexpr bool is_above(CornerSigns signs, int corner) {
  return signs >> corner & 1;
}

/// The edge between two neighbouring corners.
constexpr CellEdge edge_between(int a, int b) {
  for (int edge = 0; edge < kCellEdges; ++edge) {
    if (low_corner(edge) == (a & b) && high_corner(edge) == (a | b)) {
      return static_cast<CellEdge>(edge);
    }
  }
  return kCellEdges;
}

}  // namespace isosplat
