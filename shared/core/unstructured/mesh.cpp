#include "shared/core/unstructured/mesh.h"

#include <algorithm>
#include <cmath>
#include <compare>

namespace isosplat {

CellGeometry UnstructuredMesh::geometry(size_t cell) const {
  CellGeometry geometry;
  geometry.shape = shapes[cell];
  const auto from = corners_of(cell);
  for (size_t i = 0; i < from.size(); ++i) geometry.corners[i] = points[from[i]];
  return geometry;
}

Box UnstructuredMesh::box(size_t cell) const {
  const auto from = corners_of(cell);
  Box box{points[from[0]], points[from[0]]};
  for (size_t i = 1; i < from.size(); ++i) box.add(points[from[i]]);
  return box;
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
  const double scale = kPositionsPerExtent / std::max({extent.x, extent.y, extent.z, 1e-290});
  // Rounded positions are from 0 to kPositionsPerExtent.
  struct Place {
    uint64_t xy;
    uint32_t z, point;
    auto operator<=>(const Place&) const = default;
  };
  std::vector<Place> places(points.size());
  const auto rounded = [](double at) { return static_cast<uint32_t>(std::round(at)); };
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3d at = (points[i] - box.low) * scale;
    places[i] = {uint64_t{rounded(at.x)} << 32 | rounded(at.y), rounded(at.z),
                 static_cast<uint32_t>(i)};
  }
  std::sort(places.begin(), places.end());
  std::vector<uint32_t> first(points.size());
  for (size_t i = 0; i < places.size(); ++i) {
    const bool is_same =
        i > 0 && places[i].xy == places[i - 1].xy && places[i].z == places[i - 1].z;
    first[places[i].point] = is_same ? first[places[i - 1].point] : places[i].point;
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
