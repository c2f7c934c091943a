#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/mesh/cell_edges.h"

namespace isosplat {

/// Three vertices of a cell's surface, counter-clockwise seen from the side of lower values: cut
/// edges, or kCellEdges + i for an additional vertex i inside of the cell.
using CellTriangle = std::array<uint8_t, 3>;

/// Triangles of a surface in a cell. The vertices kCellEdges + i are additional ones, the means of
/// the cut edges means[i], of which some are repeated.
struct CellTriangles {
  std::vector<CellTriangle> triangles;
  std::vector<std::vector<CellEdge>> means;
};

/// Triangles of a disk that fills a loop of cut edges (3 to 12), of the least total length of inner
/// edges. No inner edge lies in a face of the cell: the neighbouring cell might have the same edge,
/// and four triangles would then meet there. Where this is not possible, the triangles are a fan
/// around the mean.
CellTriangles fill_loop(std::span<const CellEdge> loop);

/// Triangles of a tunnel between two loops, also without inner edges in faces. If that is not
/// possible with cut edges alone, there is a ring of additional vertices in the middle.
CellTriangles connect_loops(std::span<const CellEdge> a, std::span<const CellEdge> b);

}  // namespace isosplat
