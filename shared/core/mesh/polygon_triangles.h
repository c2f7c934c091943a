#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isosplat {

/// A point of a plane.
struct PlanePoint {
  double x = 0, y = 0;
};

/// Triangles of a polygon with holes, by a sweep that triangulates as it goes (K. Mehlhorn,
/// "Multi-dimensional Searching and Computational Geometry", 1984, section VIII.4.2; S. Hertel and
/// K. Mehlhorn, "Fast triangulation of the plane with respect to simple polygons", 1985). Takes
/// O(n log n) for sides of similar length.
///
/// points: the vertices, finite. next: the vertex after each one; every vertex is the next of
/// exactly one. So the vertices form loops: counter-clockwise ones around the polygon, clockwise
/// ones around holes. Loops may touch or cross each other: whatever the coordinates are, each side
/// belongs to exactly one triangle, in the direction of its loop, and each other edge is used as
/// often in one direction as in the other. So the signed area is that of the loops. If no loops
/// cross, no triangles overlap.
std::vector<std::array<uint32_t, 3>> polygon_triangles(std::span<const PlanePoint> points,
                                                       std::span<const uint32_t> next);

}  // namespace isosplat
