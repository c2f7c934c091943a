#include "native/extract/mesh_components.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/mesh/unused_vertices.h"

namespace isosplat {
namespace {

/// The set of each vertex, identified by its first vertex.
class VertexSets {
 public:
  explicit VertexSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), uint32_t{0});
  }
  uint32_t find(uint32_t v) {
    while (parent_[v] != v) {
      parent_[v] = parent_[parent_[v]];
      v = parent_[v];
    }
    return v;
  }
  void unite(uint32_t a, uint32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

struct Component {
  uint32_t first_vertex = 0;
  double area = 0;
};

}  // namespace

size_t keep_largest_components(MeshPart& mesh, size_t count) {
  const auto& positions = mesh.vertices.positions;
  VertexSets sets(positions.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    sets.unite(a, b);
    sets.unite(a, c);
  }
  std::unordered_map<uint32_t, double> area_of;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3d normal = cross(positions[b] - positions[a], positions[c] - positions[a]);
    area_of[sets.find(a)] += length(normal) / 2;
  }
  std::vector<Component> components;
  components.reserve(area_of.size());
  // Products of huge coordinates may be NaN, which cannot be sorted.
  for (const auto& [vertex, area] : area_of) components.push_back({vertex, area >= 0 ? area : 0});
  if (components.size() <= count) return components.size();
  std::ranges::sort(components, [](const Component& a, const Component& b) {
    return a.area != b.area ? a.area > b.area : a.first_vertex < b.first_vertex;
  });
  std::vector<bool> kept(positions.size());
  for (size_t i = 0; i < count; ++i) kept[components[i].first_vertex] = true;
  std::erase_if(mesh.triangles,
                [&](const auto& triangle) { return !kept[sets.find(triangle[0])]; });
  drop_unused_vertices(mesh);
  return components.size();
}

}  // namespace isosplat
