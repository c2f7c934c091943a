#include "shared/core/mesh/block_mesh.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "shared/core/mesh/cell_surface.h"

namespace isosplat {

/// The properties of a cell's edge that the mesher needs.
struct BlockMesher::EdgeFrame {
  uint8_t axis, low, high;    ///< low, high: the corners at its ends
  std::array<uint8_t, 3> at;  ///< of the low corner, in the cell
  uint32_t entry;             ///< in its EdgePlane, relative to that of the cell's low corner
  /// For each of the two axes across the edge: the corners next to its ends, and the sign of the
  /// direction to them.
  struct Across {
    uint8_t axis, low, high;
    float sign;
  };
  std::array<Across, 2> across;
};

namespace {

/// Lattice points of a block along each axis.
constexpr uint32_t kPoints = kBlockCells + 1;

/// Entries of an EdgePlane.
constexpr uint32_t kPlaneEdges = 3 * kPoints * kPoints;

/// The trilinear gradient at a point of a cell, in values per cell.
std::array<float, 3> gradient_at(const std::array<double, 8>& v, double x, double y, double z) {
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  return {static_cast<float>(
              mix(mix(v[1] - v[0], v[3] - v[2], y), mix(v[5] - v[4], v[7] - v[6], y), z)),
          static_cast<float>(
              mix(mix(v[2] - v[0], v[3] - v[1], x), mix(v[6] - v[4], v[7] - v[5], x), z)),
          static_cast<float>(
              mix(mix(v[4] - v[0], v[5] - v[1], x), mix(v[6] - v[2], v[7] - v[3], x), y))};
}

constexpr std::array<BlockMesher::EdgeFrame, kCellEdges> kEdgeFrames = [] {
  std::array<BlockMesher::EdgeFrame, kCellEdges> frames{};
  for (int edge = 0; edge < kCellEdges; ++edge) {
    BlockMesher::EdgeFrame& frame = frames[static_cast<size_t>(edge)];
    const int axis = axis_of(edge), low = low_corner(edge), high = high_corner(edge);
    frame.axis = static_cast<uint8_t>(axis);
    frame.low = static_cast<uint8_t>(low);
    frame.high = static_cast<uint8_t>(high);
    for (int i = 0; i < 3; ++i) frame.at[static_cast<size_t>(i)] = low >> i & 1;
    frame.entry = 3 * static_cast<uint32_t>(frame.at[1] * kPoints + frame.at[0]) +
                  static_cast<uint32_t>(axis);
    size_t next = 0;
    for (int other = 0; other < 3; ++other) {
      if (other == axis) continue;
      frame.across[next++] = {static_cast<uint8_t>(other), static_cast<uint8_t>(low ^ 1 << other),
                              static_cast<uint8_t>(high ^ 1 << other),
                              low >> other & 1 ? -1.0f : 1.0f};
    }
  }
  return frames;
}();

/// The edges that no earlier cell has: those at the cell's high corner.
constexpr uint32_t kLastEdges =
    1u << edge_between(6, 7) | 1u << edge_between(5, 7) | 1u << edge_between(3, 7);

/// For each CornerSigns, the edges that are cut: bit e for edge e.
constexpr std::array<uint16_t, 256> kCutEdges = [] {
  std::array<uint16_t, 256> cut{};
  for (uint32_t signs = 0; signs < 256; ++signs) {
    for (int edge = 0; edge < kCellEdges; ++edge) {
      if ((signs >> low_corner(edge) & 1) != (signs >> high_corner(edge) & 1)) {
        cut[signs] = static_cast<uint16_t>(cut[signs] | 1u << edge);
      }
    }
  }
  return cut;
}();

bool is_on_border(Index3 low, int axis, Index3 cells) {
  const auto touches = [](int32_t at, int32_t count) { return at == 0 || at == count; };
  return (axis != 0 && touches(low.x, cells.x)) || (axis != 1 && touches(low.y, cells.y)) ||
         (axis != 2 && touches(low.z, cells.z));
}

}  // namespace

void BlockMesher::EdgePlane::clear() {
  for (const uint32_t entry : used) vertex_of[entry] = 0;
  used.clear();
}

BlockMesher::BlockMesher() {
  for (EdgePlane& plane : planes_) plane.vertex_of.resize(kPlaneEdges);
  for (uint32_t signs = 0; signs < 256; ++signs) {
    simple_surfaces_[signs] = simple_cell_surface(static_cast<CornerSigns>(signs));
  }
}

/// Prepares for the cells with this z. The cells of a block ascend in z.
void BlockMesher::move_to(int32_t z) {
  if (z == z_) return;
  if (z == z_ + 1) {
    std::swap(planes_[0], planes_[1]);
  } else {
    planes_[0].clear();
  }
  planes_[1].clear();
  z_ = z;
}

/// Makes the vertex on an edge of the cell at `low`.
uint32_t BlockMesher::make_vertex(const EdgeFrame& edge, Index3 low, float t, BlockMesh& mesh) {
  const Index3 at{low.x + edge.at[0], low.y + edge.at[1], low.z + edge.at[2]};
  Vec3f position{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
  (edge.axis == 0   ? position.x
   : edge.axis == 1 ? position.y
                    : position.z) += std::clamp(t, least_t_, 1 - least_t_);
  const auto index = static_cast<uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back({position, {}});
  if (is_on_border(at, edge.axis, cells_)) {
    mesh.border.push_back(
        {index, {{origin_.x + at.x, origin_.y + at.y, origin_.z + at.z}, edge.axis}});
  }
  return index;
}

/// Returns the vertex on an edge of the cell at `low`, and adds the cell's gradient to it.
/// cell_entry: the entry of the cell's low corner in its EdgePlane.
inline uint32_t BlockMesher::vertex_at(const EdgeFrame& edge, Index3 low, uint32_t cell_entry,
                                       const std::array<float, 8>& values, BlockMesh& mesh) {
  const float first = values[edge.low], last = values[edge.high];
  const float t = first / (first - last);
  EdgePlane& plane = planes_[edge.at[2]];
  uint32_t& known = plane.vertex_of[cell_entry + edge.entry];
  if (known == 0) {
    known = make_vertex(edge, low, t, mesh) + 1;
    plane.used.push_back(cell_entry + edge.entry);
  }
  // gradient_at() on the edge, where it has fewer terms.
  std::array<float, 3>& gradient = mesh.vertices[known - 1].gradient_xyz;
  gradient[edge.axis] += last - first;
  for (const EdgeFrame::Across& across : edge.across) {
    const float at_low = values[across.low] - first, at_high = values[across.high] - last;
    gradient[across.axis] += across.sign * (at_low + t * (at_high - at_low));
  }
  return known - 1;
}

void BlockMesher::add_cell(uint32_t cell, const CellCorners& corners, BlockMesh& mesh) {
  // The differences are rounded, but keep their signs.
  std::array<float, 8> values;
  uint32_t signs = 0;
  for (size_t i = 0; i < 8; ++i) {
    values[i] = static_cast<float>(corners[i]) - isovalue_;
    signs |= uint32_t{values[i] > 0} << i;
  }
  // The interval of a coarse cell goes beyond its corners.
  if (signs == 0 || signs == 255) return;
  const auto exact_values = [&] {
    std::array<double, 8> exact;
    for (size_t i = 0; i < 8; ++i) exact[i] = double{1} * corners[i] - double{isovalue_};
    return exact;
  };
  const CellTriangles* surface = simple_surfaces_[signs];
  if (!surface) surface = &cell_surface(exact_values());
  const Index3 low{static_cast<int32_t>(cell & 63), static_cast<int32_t>(cell >> 6 & 63),
                   static_cast<int32_t>(cell >> 12 & 63)};
  move_to(low.z);
  const uint32_t cell_entry =
      3 * (static_cast<uint32_t>(low.y) * kPoints + static_cast<uint32_t>(low.x));
  std::array<uint32_t, kCellEdges> vertices;
  const auto find_vertices = [&](uint32_t cut) {
    for (; cut != 0; cut &= cut - 1) {
      const auto edge = static_cast<size_t>(std::countr_zero(cut));
      vertices[edge] = vertex_at(kEdgeFrames[edge], low, cell_entry, values, mesh);
    }
  };
  // Earlier cells have nearly all vertices of the first loop, and none of the second one: so the
  // processor predicts the branches of both loops.
  find_vertices(kCutEdges[signs] & ~kLastEdges);
  find_vertices(kCutEdges[signs] & kLastEdges);
  const auto first_mean = static_cast<uint32_t>(mesh.vertices.size());
  for (const auto& loop : surface->means) {
    MeshVertex mean{};
    const float share = 1 / static_cast<float>(loop.size());
    for (const CellEdge edge : loop) {
      mean.position = mean.position + mesh.vertices[vertices[edge]].position * share;
    }
    const Vec3f at = mean.position;
    mean.gradient_xyz = gradient_at(exact_values(), at.x - double(low.x), at.y - double(low.y),
                                    at.z - double(low.z));
    mesh.vertices.push_back(mean);
  }
  for (const CellTriangle& triangle : surface->triangles) {
    std::array<uint32_t, 3> indices;
    for (size_t i = 0; i < 3; ++i) {
      indices[i] =
          triangle[i] < kCellEdges ? vertices[triangle[i]] : first_mean + triangle[i] - kCellEdges;
    }
    mesh.triangles.push_back(indices);
  }
}

void BlockMesher::run(const DecodedCells& cells, Index3 block_cells, Index3 origin,
                      float quantized_isovalue, BlockMesh& mesh) {
  mesh.vertices.clear();
  mesh.border.clear();
  mesh.triangles.clear();
  mesh.fields.clear();
  cells_ = block_cells;
  origin_ = origin;
  isovalue_ = quantized_isovalue;
  z_ = 0;
  const auto is_drawn = [&](const CellInterval& interval) {
    return is_active(interval, quantized_isovalue);
  };
  const auto active =
      static_cast<size_t>(std::count_if(cells.interval.begin(), cells.interval.end(), is_drawn));
  // A large surface has about one vertex and two triangles in each of its cells.
  mesh.vertices.reserve(active);
  mesh.triangles.reserve(2 * active);
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (!is_drawn(cells.interval[i])) continue;
    add_cell(cells.cell[i], cells.corners[i], mesh);
  }
  for (EdgePlane& plane : planes_) plane.clear();
}

}  // namespace isosplat
