#include "shared/core/unstructured/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

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

std::vector<uint32_t> first_at_position(const std::vector<Vec3d>& points) {
  if (points.empty()) return {};
  Box box{points.front(), points.front()};
  for (const Vec3d point : points) box.add(point);
  const Vec3d extent = box.high - box.low;
  const double scale = kPositionsPerExtent / std::max({extent.x, extent.y, extent.z, 1e-300});
  const auto rounded = [&](uint32_t i) {
    const Vec3d at = (points[i] - box.low) * scale;
    return std::tuple(std::round(at.x), std::round(at.y), std::round(at.z));
  };
  std::vector<uint32_t> order(points.size()), first(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const auto p = rounded(a), q = rounded(b);
    return p != q ? p < q : a < b;
  });
  for (size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && rounded(order[i]) == rounded(order[i - 1]);
    first[order[i]] = is_same ? first[order[i - 1]] : order[i];
  }
  return first;
}

std::vector<double> values_at_points(const UnstructuredMesh& mesh,
                                     std::span<const double> cell_values) {
  const std::vector<uint32_t> first = first_at_position(mesh.points);
  std::vector<double> sums(mesh.points.size()), volumes(mesh.points.size());
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    if (!std::isfinite(cell_values[cell])) continue;
    const double volume = volume_of(mesh.geometry(cell));
    for (const uint32_t point : mesh.corners_of(cell)) {
      sums[first[point]] += volume * cell_values[cell];
      volumes[first[point]] += volume;
    }
  }
  for (size_t i = 0; i < sums.size(); ++i) {
    sums[i] = first[i] < i ? sums[first[i]] : sums[i] / volumes[i];  // NaN without a volume
  }
  return sums;
}

}  // namespace isosplat
