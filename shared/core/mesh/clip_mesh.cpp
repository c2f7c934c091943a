#include "shared/core/mesh/clip_mesh.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "shared/core/base/vec3.h"
#include "shared/core/mesh/mesh_cap.h"

namespace isosplat {
namespace {

/// Vertices where a plane cuts edges.
class CutVertices {
 public:
  CutVertices(MeshPart& mesh, const std::vector<double>& heights,
              const std::vector<bool>& is_category)
      : vertices_(mesh.vertices),
        heights_(heights),
        is_category_(is_category),
        first_(static_cast<uint32_t>(mesh.vertices.positions.size())) {}

  /// The vertex on the edge between a vertex inside of the half-space and one outside. is_of_cap:
  /// of the triangle. Fields have values where an edge is also that of another triangle.
  uint32_t between(uint32_t inside, uint32_t outside, bool is_of_cap) {
    const uint64_t key = uint64_t{std::min(inside, outside)} << 32 | std::max(inside, outside);
    const auto number = static_cast<uint32_t>(vertices_.positions.size());
    const auto [found, is_new] = number_.try_emplace(key, number);
    if (is_new) shares_.push_back(append(inside, outside));
    if (!is_of_cap) interpolate_fields(inside, outside, found->second);
    return found->second;
  }

 private:
  /// Adds a vertex. Returns its distance from the inner end, as a share of the edge.
  double append(uint32_t inside, uint32_t outside) {
    const Vec3d from = vertices_.positions[inside], line = vertices_.positions[outside] - from;
    const double size = length(line);
    const double least = size > 0 ? std::min(0.25, 0x1p-14 / size) : 0.25;
    const double share = heights_[inside] / (heights_[inside] - heights_[outside]);
    const double t = std::clamp(share, least, 1 - least);
    const Vec3f a = vertices_.normals[inside], b = vertices_.normals[outside];
    vertices_.positions.push_back(from + line * t);
    vertices_.normals.push_back(a + (b - a) * static_cast<float>(t));
    for (auto& values : vertices_.fields) values.push_back(NAN);
    return t;
  }

  void interpolate_fields(uint32_t inside, uint32_t outside, uint32_t vertex) {
    const double t = shares_[vertex - first_];
    for (size_t i = 0; i < vertices_.fields.size(); ++i) {
      std::vector<float>& values = vertices_.fields[i];
      const double a = values[inside], b = values[outside];
      const bool is_category = i < is_category_.size() && is_category_[i];
      values[vertex] = static_cast<float>(!is_category ? a + (b - a) * t : t < 0.5 ? a : b);
    }
  }

  PointsWithFields& vertices_;
  const std::vector<double>& heights_;
  const std::vector<bool>& is_category_;
  const uint32_t first_;        ///< the first one
  std::vector<double> shares_;  ///< of each: see append()
  std::unordered_map<uint64_t, uint32_t> number_;
};

Vec3d any_perpendicular(Vec3d n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const Vec3d least = x <= y && x <= z ? Vec3d{1, 0, 0} : y <= z ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  const Vec3d across = cross(n, least);
  return across * (1 / length(across));
}

}  // namespace

Result<void> clip_closed(MeshPart& mesh, std::vector<bool>& is_cap, const HalfSpace& half_space,
                         const std::vector<bool>& is_category) {
  std::vector<double> heights;
  heights.reserve(mesh.vertices.positions.size());
  for (const Vec3d at : mesh.vertices.positions) {
    heights.push_back(dot(half_space.normal, at) - half_space.offset);
  }
  const auto is_inside = [&](uint32_t vertex) { return heights[vertex] >= 0; };
  CutVertices cuts(mesh, heights, is_category);
  std::vector<CapSide> sides;
  std::vector<std::array<uint32_t, 3>> more;
  std::vector<bool> more_is_cap;
  size_t kept = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::array<uint32_t, 3> t = mesh.triangles[i];
    const int inside = int{is_inside(t[0])} + int{is_inside(t[1])} + int{is_inside(t[2])};
    if (inside == 0) continue;
    if (inside < 3) {
      // First the one that is alone on its side.
      while (is_inside(t[0]) != (inside == 1) || is_inside(t[1]) != (inside == 2)) {
        t = {t[1], t[2], t[0]};
      }
      const bool is_of_cap = is_cap[i];
      const auto cut = [&](uint32_t other) {
        return inside == 1 ? cuts.between(t[0], other, is_of_cap)
                           : cuts.between(other, t[0], is_of_cap);
      };
      const uint32_t first = cut(t[1]), last = cut(t[2]);
      if (inside == 1) {
        t = {t[0], first, last};
        sides.push_back({last, first});
      } else {
        more.push_back({first, t[1], t[2]});
        more_is_cap.push_back(is_of_cap);
        t = {first, t[2], last};
        sides.push_back({first, last});
      }
    }
    is_cap[kept] = is_cap[i];
    mesh.triangles[kept++] = t;
  }
  mesh.triangles.resize(kept);
  mesh.triangles.insert(mesh.triangles.end(), more.begin(), more.end());
  is_cap.resize(kept);
  is_cap.insert(is_cap.end(), more_is_cap.begin(), more_is_cap.end());
  // The removed side is outside.
  const Vec3d outwards = half_space.normal * -1;
  const Vec3d u = any_perpendicular(outwards);
  auto closed = append_cap(mesh, std::move(sides), u, cross(outwards, u));
  is_cap.resize(mesh.triangles.size(), true);
  return closed;
}

}  // namespace isosplat
