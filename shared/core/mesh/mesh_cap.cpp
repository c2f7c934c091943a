#include "shared/core/mesh/mesh_cap.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "shared/core/base/vec3.h"
#include "shared/core/mesh/polygon_triangles.h"

namespace isosplat {

Error not_closable() {
  return {
      Status::invalid_argument,
      "expected a surface without holes inside of the volume, found holes, which missing voxels "
      "leave, and coarse levels where details are lost: choose the finest level, or leave the "
      "surface open (--open)"};
}

Result<void> append_cap(MeshPart& mesh, std::vector<CapSide> sides, Vec3d u, Vec3d v) {
  // A vertex of the polygon is the beginning of a side. The side that ends at a vertex is joined
  // with one that begins there; where loops touch, there are several.
  std::sort(sides.begin(), sides.end(), [](const CapSide& a, const CapSide& b) {
    return std::tuple(a.from, a.to) < std::tuple(b.from, b.to);
  });
  std::vector<uint32_t> by_end(sides.size());
  std::iota(by_end.begin(), by_end.end(), uint32_t{0});
  std::sort(by_end.begin(), by_end.end(), [&](uint32_t a, uint32_t b) {
    return std::tuple(sides[a].to, a) < std::tuple(sides[b].to, b);
  });
  std::vector<uint32_t> next(sides.size());
  std::vector<PlanePoint> points(sides.size());
  for (uint32_t i = 0; i < sides.size(); ++i) {
    if (sides[by_end[i]].to != sides[i].from) return tl::unexpected(not_closable());
    next[by_end[i]] = i;
    const Vec3d at = mesh.vertices.positions[sides[i].from];
    points[i] = {dot(u, at), dot(v, at)};
  }
  for (const auto& [a, b, c] : polygon_triangles(points, next)) {
    mesh.triangles.push_back({sides[a].from, sides[b].from, sides[c].from});
  }
  return {};
}

}  // namespace isosplat
