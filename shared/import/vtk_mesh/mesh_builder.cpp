#include "shared/import/vtk_mesh/mesh_builder.h"

#include <algorithm>
#include <tuple>

namespace isosplat::import {

void MeshBuilder::add_cell(CellShape shape, std::span<const uint32_t> corners) {
  mesh.begins.push_back(static_cast<uint32_t>(mesh.corners.size()));
  mesh.shapes.push_back(shape);
  mesh.corners.insert(mesh.corners.end(), corners.begin(), corners.end());
}

uint32_t MeshBuilder::add_point(std::span<const uint32_t> corners,
                                std::span<const uint32_t> middles) {
  const auto is_before = [&](uint32_t a, uint32_t b) {
    const Vec3d &p = mesh.points[a], &q = mesh.points[b];
    return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
  };
  const size_t first = nodes_.size();
  for (const auto some : {corners, middles}) {
    nodes_.insert(nodes_.end(), some.begin(), some.end());
    std::sort(nodes_.end() - static_cast<std::ptrdiff_t>(some.size()), nodes_.end(), is_before);
  }
  const auto point = static_cast<uint32_t>(mesh.points.size());
  added_.push_back(
      {point, static_cast<uint32_t>(corners.size()), static_cast<uint32_t>(middles.size())});
  mesh.points.push_back(
      combined(mesh.points, std::span(nodes_).subspan(first), corners.size(), Vec3d{0, 0, 0}));
  return point;
}

void MeshBuilder::set_values() {
  mesh.values.resize(mesh.points.size());
  size_t first = 0;
  for (const Added& each : added_) {
    const size_t count = size_t{each.corners} + each.middles;
    mesh.values[each.point] =
        combined(mesh.values, std::span(nodes_).subspan(first, count), each.corners, 0.0);
    first += count;
  }
}

uint64_t MeshBuilder::memory_bytes() const {
  return mesh.memory_bytes() + added_.size() * sizeof(Added) + nodes_.size() * sizeof(uint32_t);
}

uint64_t MeshBuilder::point_bytes(uint64_t nodes) {
  return sizeof(Vec3d) + sizeof(double) + sizeof(Added) + nodes * sizeof(uint32_t);
}

template <class T>
T MeshBuilder::combined(const std::vector<T>& of, std::span<const uint32_t> nodes, size_t corners,
                        T zero) const {
  const auto sum = [&](std::span<const uint32_t> some) {
    T all = zero;
    for (const uint32_t node : some) all = all + of[node];
    return all;
  };
  const auto count = static_cast<double>(corners);
  const T of_corners = sum(nodes.first(corners));
  if (nodes.size() == corners) return of_corners * (1 / count);
  const double share = (1 + count / 4) / static_cast<double>(nodes.size() - corners);
  return of_corners * -0.25 + sum(nodes.subspan(corners)) * share;
}

}  // namespace isosplat::import
