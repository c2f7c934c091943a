#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "shared/core/mesh/cell_loops.h"
#include "shared/render/passes/triangle_cases.h"

namespace isosplat::render {
namespace {

using Edges = std::map<std::pair<CellEdge, CellEdge>, int>;

/// How often each directed edge occurs in the front faces that GL draws for the slots, without
/// edges that occur in both directions.
Edges borders_of(const TriangleSlots& slots) {
  Edges edges;
  for (size_t i = 0; i + 2 < slots.size(); ++i) {
    std::array<CellEdge, 3> triangle{slots[i], slots[i + 1], slots[i + 2]};
    if (i % 2 == 1) std::swap(triangle[0], triangle[1]);
    const auto [a, b, c] = triangle;
    if (a == b || b == c || c == a) continue;
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      if (const auto other = edges.find({to, from}); other != edges.end()) {
        if (--other->second == 0) edges.erase(other);
      } else {
        ++edges[{from, to}];
      }
    }
  }
  return edges;
}

/// Whether all loops of the case fit into the slots.
bool fits(const std::vector<CellLoop>& loops) {
  size_t vertices = 0;
  for (const CellLoop& loop : loops) vertices += loop.size() + 2;
  return vertices <= TRIANGLE_SLOTS;
}

// The triangles of a cell are bounded by the lines in which the surface meets the cell's faces.
// These depend only on the values in the face, so the triangles of neighbouring cells join.
TEST(Triangles, AreBoundedByTheLoopsOfTheCell) {
  int cases = 0, not_fitting = 0;
  for (int signs = 0; signs < 256; ++signs) {
    const auto corners = static_cast<CornerSigns>(signs);
    for (uint32_t joined = 0; joined < 64; ++joined) {
      if (joined & ~ambiguous_faces(corners)) continue;
      ++cases;
      const auto loops = cell_loops(corners, joined);
      if (!fits(loops)) {
        ++not_fitting;
        EXPECT_EQ(ambiguous_faces(corners), 63u) << signs;  // only checkerboards
        continue;
      }
      Edges expected;
      for (const CellLoop& loop : loops) {
        for (size_t i = 0; i < loop.size(); ++i) ++expected[{loop[i], loop[(i + 1) % loop.size()]}];
      }
      EXPECT_EQ(borders_of(triangle_slots(corners, joined)), expected) << signs << ' ' << joined;
    }
  }
  EXPECT_GT(cases, 256);
  EXPECT_LE(not_fitting, 100);
}

// In the strip, vertices of a cell are followed by those of the next one. No triangle joins them.
TEST(Triangles, OfDifferentCellsAreNotConnected) {
  for (int signs = 0; signs < 256; ++signs) {
    for (const uint32_t joined : {0u, 63u}) {
      const auto corners = static_cast<CornerSigns>(signs);
      const TriangleSlots slots = triangle_slots(corners, joined & ambiguous_faces(corners));
      EXPECT_EQ(slots[0], slots[1]) << signs;
      EXPECT_EQ(slots[TRIANGLE_SLOTS - 2], slots[TRIANGLE_SLOTS - 1]) << signs;
    }
  }
}

}  // namespace
}  // namespace isosplat::render
