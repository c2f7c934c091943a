#include "shared/core/mesh/cell_surface.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "shared/core/mesh/cell_loops.h"
#include "shared/core/mesh/interior_regions.h"

namespace isosplat {
namespace {

/// For each corner, a number of the part of the cell's faces that contains it.
std::array<int, 8> face_regions(CornerSigns signs, uint32_t joined) {
  SmallSets<8> sets;
  const uint32_t ambiguous = ambiguous_faces(signs);
  for (int edge = 0; edge < kCellEdges; ++edge) {
    const int a = low_corner(edge), b = high_corner(edge);
    if (is_above(signs, a) == is_above(signs, b)) sets.unite(a, b);
  }
  for (int face = 0; face < kCellFaces; ++face) {
    if (!(ambiguous >> face & 1)) continue;
    const auto c = corners_of_face(face);
    const size_t first = is_above(signs, c[0]) == bool(joined >> face & 1) ? 0 : 1;
    sets.unite(c[first], c[first + 2]);
  }
  std::array<int, 8> regions{};
  for (int corner = 0; corner < 8; ++corner) regions[size_t(corner)] = sets.find(corner);
  return regions;
}

void append(const CellTriangles& more, CellTriangles& surface) {
  const size_t shift = surface.means.size();
  for (CellTriangle triangle : more.triangles) {
    for (uint8_t& vertex : triangle) {
      if (vertex >= kCellEdges) vertex = static_cast<uint8_t>(vertex + shift);
    }
    surface.triangles.push_back(triangle);
  }
  surface.means.insert(surface.means.end(), more.means.begin(), more.means.end());
}

/// The surfaces of cells with the same loops.
struct LoopCase {
  std::vector<CellLoop> loops;
  std::array<int, 8> regions{};  ///< face_regions
  CellTriangles disks;           ///< each loop is filled by a disk
  struct Tunnel {
    size_t a, b;  ///< loops, a < b
    CellTriangles surface;
  };
  std::vector<Tunnel> tunnels;  ///< for each two loops
};

LoopCase make_case(CornerSigns signs, uint32_t joined) {
  LoopCase result;
  result.loops = cell_loops(signs, joined);
  result.regions = face_regions(signs, joined);
  const auto& loops = result.loops;
  for (const CellLoop& loop : loops) append(fill_loop(loop), result.disks);
  for (size_t a = 0; a < loops.size(); ++a) {
    for (size_t b = a + 1; b < loops.size(); ++b) {
      // The ring of a tunnel needs few vertices if it follows the smaller loop.
      const bool swaps = loops[b].size() < loops[a].size();
      CellTriangles surface = connect_loops(loops[swaps ? b : a], loops[swaps ? a : b]);
      for (size_t other = 0; other < loops.size(); ++other) {
        if (other != a && other != b) append(fill_loop(loops[other]), surface);
      }
      result.tunnels.push_back({a, b, std::move(surface)});
    }
  }
  return result;
}

/// Gathers the bits of `bits` at the positions of the set bits of `mask`.
uint32_t gather_bits(uint32_t bits, uint32_t mask) {
  uint32_t result = 0;
  for (int bit = 0; mask != 0; mask &= mask - 1, ++bit) {
    result |= (bits >> std::countr_zero(mask) & 1) << bit;
  }
  return result;
}

/// All cases, by the signs and the ambiguous faces whose upper corners are connected.
class CaseTable {
 public:
  CaseTable() {
    for (uint32_t signs = 0; signs < 256; ++signs) {
      const uint32_t faces = ambiguous_faces(static_cast<CornerSigns>(signs));
      ambiguous_[signs] = faces;
      first_[signs] = cases_.size();
      for (uint32_t joined = 0; joined < 64; ++joined) {
        if (joined & ~faces) continue;
        cases_.push_back(make_case(static_cast<CornerSigns>(signs), joined));
      }
    }
  }

  uint32_t ambiguous(CornerSigns signs) const { return ambiguous_[signs]; }
  const LoopCase& find(CornerSigns signs, uint32_t joined) const {
    return cases_[first_[signs] + gather_bits(joined, ambiguous_[signs])];
  }

 private:
  std::array<uint32_t, 256> ambiguous_{};
  std::array<size_t, 256> first_{};
  std::vector<LoopCase> cases_;
};

const CaseTable& cases() {
  static const CaseTable table;
  return table;
}

CornerSigns signs_of(const std::array<double, 8>& values) {
  uint32_t signs = 0;
  for (size_t corner = 0; corner < 8; ++corner) signs |= uint32_t{values[corner] > 0} << corner;
  return static_cast<CornerSigns>(signs);
}

/// The ambiguous faces whose upper corners are connected: those whose bilinear function is above 0
/// at its saddle. Both cells of a face compare the same products.
uint32_t joined_faces(const std::array<double, 8>& values, uint32_t ambiguous) {
  uint32_t joined = 0;
  for (int face = 0; face < kCellFaces; ++face) {
    if (!(ambiguous >> face & 1)) continue;
    const auto c = corners_of_face(face);
    const auto at = [&](size_t i) { return values[size_t(c[i])]; };
    const double even = at(0) * at(2), odd = at(1) * at(3);
    if (at(0) > 0 ? even > odd : odd > even) joined |= 1u << face;
  }
  return joined;
}

/// Two loops that a tunnel connects.
struct LoopPair {
  size_t a, b;
};

/// The loops between two regions of the faces, if there are exactly two.
std::optional<LoopPair> loops_between(const LoopCase& found, CornerSigns signs, int from, int to) {
  const auto region = [&](int corner) { return found.regions[size_t(corner)]; };
  const auto has_side = [&](const CellLoop& loop, bool above, int wanted) {
    const int low = low_corner(loop[0]), high = high_corner(loop[0]);
    return region(is_above(signs, low) == above ? low : high) == wanted;
  };
  const auto& loops = found.loops;
  const bool above = is_above(signs, from);
  for (size_t a = 0; a < loops.size(); ++a) {
    if (!has_side(loops[a], above, from)) continue;
    for (size_t b = 0; b < loops.size(); ++b) {
      if (!has_side(loops[b], above, to)) continue;
      const int low = low_corner(loops[a][0]);
      const int between = region(is_above(signs, low) == above ? high_corner(loops[a][0]) : low);
      if (has_side(loops[b], !above, between)) return LoopPair{std::min(a, b), std::max(a, b)};
    }
  }
  return std::nullopt;
}

/// The loops that a tunnel connects: it connects two regions of the faces inside of the cell.
std::optional<LoopPair> find_tunnel(const LoopCase& found, CornerSigns signs,
                                    std::array<double, 8> values) {
  // Corners on the isosurface are below it.
  for (double& value : values) {
    if (value <= 0) value = std::min(value, -1e-9);
  }
  const auto inside = interior_regions(values);
  for (int a = 0; a < 8; ++a) {
    for (int b = a + 1; b < 8; ++b) {
      if (is_above(signs, a) != is_above(signs, b)) continue;
      const int from = found.regions[size_t(a)], to = found.regions[size_t(b)];
      if (from == to || inside[size_t(a)] != inside[size_t(b)]) continue;
      if (const auto loops = loops_between(found, signs, from, to)) return loops;
    }
  }
  return std::nullopt;
}

}  // namespace

const CellTriangles* simple_cell_surface(CornerSigns signs) {
  const CaseTable& table = cases();
  if (table.ambiguous(signs) != 0) return nullptr;
  const LoopCase& found = table.find(signs, 0);
  return found.loops.size() <= 1 ? &found.disks : nullptr;
}

const CellTriangles& cell_surface(const std::array<double, 8>& values) {
  const CaseTable& table = cases();
  const CornerSigns signs = signs_of(values);
  const uint32_t ambiguous = table.ambiguous(signs);
  const LoopCase& found = table.find(signs, ambiguous == 0 ? 0 : joined_faces(values, ambiguous));
  if (found.loops.size() <= 1) return found.disks;
  const auto pair = find_tunnel(found, signs, values);
  if (!pair) return found.disks;
  return std::find_if(
             found.tunnels.begin(), found.tunnels.end(),
             [&](const auto& tunnel) { return tunnel.a == pair->a && tunnel.b == pair->b; })
      ->surface;
}

}  // namespace isosplat
