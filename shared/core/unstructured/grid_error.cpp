// The difference between a mesh's field and the function of its grid.

#include <algorithm>
#include <cmath>

#include "shared/core/adaptive/node_values.h"
#include "shared/core/unstructured/random_points.h"
#include "shared/core/unstructured/resample.h"

namespace isosplat {
namespace {

constexpr uint64_t kMostPoints = 1'000'000;
constexpr uint64_t kPointsPerCell = 4;

/// A random position in a cell, in its coordinates (shape_weights).
Vec3d position_in(CellShape shape, RandomPoints& random) {
  Vec3d p = random.in_unit_cube();
  if (shape == CellShape::hexahedron) return p;
  if (shape == CellShape::pyramid) return {p.x * p.z, p.y * p.z, p.z};
  if (p.x + p.y > 1) p = {1 - p.x, 1 - p.y, p.z};
  if (shape == CellShape::wedge) return p;
  // Folds a prism into a tetrahedron (Rocchini and Cignoni, 2000).
  if (p.y + p.z > 1) {
    p = {p.x, 1 - p.z, 1 - p.x - p.y};
  } else if (p.x + p.y + p.z > 1) {
    p = {1 - p.y - p.z, p.y, p.x + p.y + p.z - 1};
  }
  return p;
}

}  // namespace

std::optional<double> value_at(const ResampledMesh& resampled, Vec3d point) {
  const AdaptiveGrid& grid = resampled.grid;
  const Vec3d from = point - resampled.level_0.origin, edges = resampled.level_0.spacing;
  const Vec3d at{from.x / edges.x, from.y / edges.y, from.z / edges.z};  // in cells of level 0
  const Index3 n0 = grid.cells(0);
  constexpr double kRounding = 1e-9;
  if (!(std::min({at.x, at.y, at.z}) >= -kRounding) || at.x > n0.x + kRounding ||
      at.y > n0.y + kRounding || at.z > n0.z + kRounding) {
    return std::nullopt;
  }
  int32_t cells = 1;
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    if (level > 0) cells *= grid.ratio(level - 1);
    const Index3 n = grid.cells(level);
    const auto index = [&](double position, int32_t count) {
      return std::clamp(static_cast<int32_t>(std::floor(position * cells)), 0, count - 1);
    };
    const Index3 cell{index(at.x, n.x), index(at.y, n.y), index(at.z, n.z)};
    if (grid.bricks(level).state(cell) != CellState::leaf) continue;
    const Vec3d f{at.x * cells - cell.x, at.y * cells - cell.y, at.z * cells - cell.z};
    double sum = 0;
    for (int32_t i = 0; i < 8; ++i) {
      const Index3 o{i & 1, i >> 1 & 1, i >> 2};
      const double weight = (o.x ? f.x : 1 - f.x) * (o.y ? f.y : 1 - f.y) * (o.z ? f.z : 1 - f.z);
      sum += weight * node_value(grid, level, cell + o);
    }
    return sum;
  }
  return std::nullopt;
}

ResampleError measure_error(const UnstructuredMesh& mesh, const ResampledMesh& resampled) {
  ResampleError error;
  const size_t step = mesh.cells() * kPointsPerCell / kMostPoints + 1;
  double squares = 0, volume = 0, outside = 0;
  uint64_t above = 0;
  RandomPoints random(1);
  for (size_t cell = 0; cell < mesh.cells(); cell += step) {
    if (!(mesh.size(cell) > 0)) continue;
    const CellGeometry geometry = mesh.geometry(cell);
    const double share = volume_of(geometry) / kPointsPerCell;
    for (uint64_t i = 0; i < kPointsPerCell; ++i) {
      const CornerWeights weights =
          shape_weights(geometry.shape, position_in(geometry.shape, random));
      Vec3d point{0, 0, 0};
      for (size_t k = 0; k < static_cast<size_t>(geometry.count()); ++k) {
        point = point + geometry.corners[k] * weights[k];
      }
      const auto found = value_at(resampled, point);
      volume += share;
      if (!found) {
        outside += share;
        continue;
      }
      const double difference = std::abs(*found - mesh.value(cell, weights));
      error.max = std::max(error.max, difference);
      squares += difference * difference;
      above += difference > resampled.max_error ? 1 : 0;
      ++error.points;
    }
  }
  if (error.points > 0) {
    const auto points = static_cast<double>(error.points);
    error.rms = std::sqrt(squares / points);
    error.above = static_cast<double>(above) / points;
  }
  if (volume > 0) error.outside = outside / volume;
  return error;
}

}  // namespace isosplat
