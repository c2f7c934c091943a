#include "shared/core/unstructured/values_on_leaves.h"

#include <bitset>
#include <limits>

#include "shared/core/unstructured/border_values.h"
#include "shared/core/unstructured/cell_bins.h"
#include "shared/core/unstructured/level_plan.h"

namespace isosplat {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr int32_t kBrickNodes = kBrickCells + 1;

/// The values of a mesh at the nodes of a brick, each found once.
class BrickNodes {
 public:
  /// `edge`: of the brick's cells. `origin`: of its first node.
  BrickNodes(const UnstructuredMesh& mesh, const Bins& cells, Vec3d origin, Vec3d edge)
      : mesh_(mesh), cells_(cells), origin_(origin), edge_(edge) {}

  /// The values at the corners of a cell, by its index in the brick.
  std::array<double, 8> corners(Index3 cell) {
    std::array<std::optional<double>, 8> found;
    std::array<double, 8> values{};
    bool are_inside = true;
    for (int32_t i = 0; i < 8; ++i) {
      const auto k = static_cast<size_t>(i);
      found[k] = at_node(cell + Index3{i & 1, i >> 1 & 1, i >> 2});
      are_inside = are_inside && found[k];
      values[k] = found[k].value_or(kNoValue);
    }
    if (are_inside) return values;
    const Box box{place(cell), place(cell + Index3{1, 1, 1})};
    const auto border = border_values(box, found, [&](Vec3d point) { return at(point); });
    if (!border) values.fill(kNoValue);
    return border.value_or(values);
  }

 private:
  Vec3d place(Index3 node) const {
    return origin_ + Vec3d{edge_.x * node.x, edge_.y * node.y, edge_.z * node.z};
  }

  std::optional<double> at(Vec3d point) const {
    const auto found = locate(mesh_, cells_, point);
    return found ? std::optional(found->value) : std::nullopt;
  }

  std::optional<double> at_node(Index3 node) {
    const auto i = static_cast<size_t>((node.z * kBrickNodes + node.y) * kBrickNodes + node.x);
    if (!is_known_[i]) {
      is_known_.set(i);
      nodes_[i] = at(place(node));
    }
    return nodes_[i];
  }

  const UnstructuredMesh& mesh_;
  const Bins& cells_;
  Vec3d origin_, edge_;
  std::bitset<kBrickNodes * kBrickNodes * kBrickNodes> is_known_;
  std::array<std::optional<double>, kBrickNodes * kBrickNodes * kBrickNodes> nodes_;
};

}  // namespace

Result<AdaptiveGrid> values_on_leaves(const UnstructuredMesh& mesh, const AdaptiveGrid& grid,
                                      const VolumeGrid& level_0, uint64_t memory_bytes) {
  const auto survey = survey_mesh(mesh);
  if (!survey) return tl::unexpected(survey.error());
  const auto cell_box = [&](size_t cell) -> std::optional<Box> {
    if (!(survey->sizes[cell] > 0)) return std::nullopt;
    return box_of(mesh.geometry(cell));
  };
  const auto cells = Bins::create(plan_bins(*survey), mesh.cells(), cell_box, memory_bytes / 2);
  if (!cells) return tl::unexpected(cells.error());
  std::vector<int32_t> ratios;
  for (uint32_t level = 0; level + 1 < grid.levels(); ++level) ratios.push_back(grid.ratio(level));
  auto made = AdaptiveGrid::create(grid.cells(0), ratios, Centring::nodes,
                                   memory_bytes - cells->memory_bytes());
  if (!made) return made;
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    const Vec3d edge = level_0.spacing * (1.0 / grid.cells_per_edge(0, level));
    for (const auto& [key, brick] : grid.bricks(level)) {
      const Index3 first = brick.first;
      const Vec3d origin =
          level_0.origin + Vec3d{edge.x * first.x, edge.y * first.y, edge.z * first.z};
      BrickNodes nodes(mesh, *cells, origin, edge);
      for (size_t i = 0; i < kBrickVolume; ++i) {
        if (brick.states[i] != CellState::leaf) continue;
        const Index3 cell = cell_of(brick, i);
        const auto values = nodes.corners(cell - first);
        auto added = made->add(level, {cell, cell + Index3{1, 1, 1}}, values);
        if (!added) return tl::unexpected(added.error());
      }
    }
  }
  made->resolve();
  return made;
}

}  // namespace isosplat
