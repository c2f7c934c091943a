#include "shared/core/mesh/unused_vertices.h"

#include <limits>
#include <vector>

namespace isosplat {

void drop_unused_vertices(MeshPart& mesh) {
  constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();
  auto& positions = mesh.vertices.positions;
  auto& normals = mesh.vertices.normals;
  std::vector<uint32_t> number(positions.size(), kUnused);
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t v : triangle) number[v] = 0;
  }
  uint32_t next = 0;
  for (uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kUnused) continue;
    positions[next] = positions[v];
    normals[next] = normals[v];
    for (auto& values : mesh.vertices.fields) values[next] = values[v];
    number[v] = next++;
  }
  positions.resize(next);
  normals.resize(next);
  for (auto& values : mesh.vertices.fields) values.resize(next);
  for (auto& triangle : mesh.triangles) {
    for (uint32_t& v : triangle) v = number[v];
  }
}

}  // namespace isosplat
