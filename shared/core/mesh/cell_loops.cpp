#include "shared/core/mesh/cell_loops.h"

#include <array>
#include <cstddef>

namespace isosplat {
namespace {

/// Whether the corners of a face have alternating signs.
bool is_ambiguous(CornerSigns signs, int face) {
  const auto c = corners_of_face(face);
  return is_above(signs, c[0]) != is_above(signs, c[1]) &&
         is_above(signs, c[0]) == is_above(signs, c[2]) &&
         is_above(signs, c[1]) == is_above(signs, c[3]);
}

/// For each cut edge, the next edge of its loop.
struct NextEdges {
  std::array<CellEdge, kCellEdges> next;
  NextEdges() { next.fill(kCellEdges); }

  /// Adds the line on a face between two edges, from the one where the upper corner is on the right
  /// seen from outside: loops are then counter-clockwise seen from the side of lower values.
  void add(CornerSigns signs, int face, int a, int b) {
    const int axis = face >> 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto middle = [](int edge, int along) {
      return along == axis_of(edge) ? 1 : 2 * (low_corner(edge) >> along & 1);
    };
    const int upper = is_above(signs, low_corner(a)) ? low_corner(a) : high_corner(a);
    const auto from_a = [&](int along) { return 2 * (upper >> along & 1) - middle(a, along); };
    const auto line = [&](int along) { return middle(b, along) - middle(a, along); };
    const int left = line(u) * from_a(v) - line(v) * from_a(u);
    const bool is_right = face & 1 ? left < 0 : left > 0;
    next[size_t(is_right ? a : b)] = static_cast<CellEdge>(is_right ? b : a);
  }
};

}  // namespace

uint32_t ambiguous_faces(CornerSigns signs) {
  uint32_t faces = 0;
  for (int face = 0; face < kCellFaces; ++face)
    faces |= uint32_t{is_ambiguous(signs, face)} << face;
  return faces;
}

std::vector<CellLoop> cell_loops(CornerSigns signs, uint32_t joined) {
  NextEdges edges;
  for (int face = 0; face < kCellFaces; ++face) {
    const auto c = corners_of_face(face);
    const auto edge = [&c](size_t i) { return edge_between(c[i % 4], c[(i + 1) % 4]); };
    if (is_ambiguous(signs, face)) {
      // A line around each corner that is alone.
      const bool alone = !(joined >> face & 1);
      for (size_t i = 0; i < 4; ++i) {
        if (is_above(signs, c[i]) == alone) edges.add(signs, face, edge(i + 3), edge(i));
      }
      continue;
    }
    std::vector<int> cut;
    for (size_t i = 0; i < 4; ++i) {
      if (is_above(signs, c[i]) != is_above(signs, c[(i + 1) % 4])) cut.push_back(edge(i));
    }
    if (!cut.empty()) edges.add(signs, face, cut[0], cut[1]);
  }
  std::vector<CellLoop> loops;
  std::array<bool, kCellEdges> seen{};
  for (CellEdge first = 0; first < kCellEdges; ++first) {
    if (edges.next[first] == kCellEdges || seen[first]) continue;
    CellLoop& loop = loops.emplace_back();
    for (CellEdge edge = first; !seen[edge]; edge = edges.next[edge]) {
      seen[edge] = true;
      loop.push_back(edge);
    }
  }
  return loops;
}

}  // namespace isosplat
