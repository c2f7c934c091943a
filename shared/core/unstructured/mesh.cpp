#include "shared/core/unstructured/mesh.h"

#include <algorithm>
#include <cmath>

namespace isosplat {

CellGeometry UnstructuredMesh::geometry(size_t cell) const {
  CellGeometry geometry;
  geometry.shape = shapes[cell];
  const auto from = corners_of(cell);
  for (size_t i = 0; i < from.size(); ++i) geometry.corners[i] = points[from[i]];
  return geometry;
}

bool UnstructuredMesh::has_values(size_t cell) const {
  const auto from = corners_of(cell);
  return std::all_of(from.begin(), from.end(),
                     [&](uint32_t point) { return std::isfinite(values[point]); });
}

float UnstructuredMesh::size(size_t cell) const {
  if (!has_values(cell)) return 0;
  const CellGeometry of_cell = geometry(cell);
  const auto size = static_cast<float>(size_of(of_cell));
  return volume_of(of_cell) > 0 && size > 0 && std::isfinite(size) ? size : 0;
}

double UnstructuredMesh::value(size_t cell, const CornerWeights& weights) const {
  const auto from = corners_of(cell);
  double sum = 0;
  for (size_t i = 0; i < from.size(); ++i) sum += weights[i] * values[from[i]];
  return sum;
}

uint64_t UnstructuredMesh::memory_bytes() const {
  return points.size() * (sizeof(Vec3d) + sizeof(double)) +
         shapes.size() * (sizeof(CellShape) + sizeof(uint32_t)) + corners.size() * sizeof(uint32_t);
}

void Box::add(Vec3d p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

Box box_of(const CellGeometry& cell) {
  Box box{cell.corners[0], cell.corners[0]};
  for (size_t i = 1; i < static_cast<size_t>(cell.count()); ++i) box.add(cell.corners[i]);
  return box;
}

std::vector<double> values_at_points(const UnstructuredMesh& mesh,
                                     std::span<const double> cell_values) {
  std::vector<double> sums(mesh.points.size()), volumes(mesh.points.size());
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    if (!std::isfinite(cell_values[cell])) continue;
    const double volume = volume_of(mesh.geometry(cell));
    for (const uint32_t point : mesh.corners_of(cell)) {
      sums[point] += volume * cell_values[cell];
      volumes[point] += volume;
    }
  }
  for (size_t i = 0; i < sums.size(); ++i) sums[i] /= volumes[i];  // NaN without a volume
  return sums;
}

}  // namespace isosplat
