#include "shared/core/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "shared/core/base/matrix3.h"

namespace isosplat {

bool looks_like_scene(std::string_view first_bytes) {
  const size_t first = first_bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string_view::npos || first_bytes[first] != '{') return false;
  // A volume without a header may begin with any byte. Text has no control characters.
  return std::none_of(first_bytes.begin(), first_bytes.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && c != '\t' && c != '\r' && c != '\n';
  });
}

bool is_path_below(std::string_view path) {
  constexpr size_t kMaxPath = 1024;
  if (path.empty() || path.size() > kMaxPath) return false;
  for (const char c : path) {
    if (static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == ':') return false;
  }
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return true;
}

std::vector<std::string> store_paths(const Scene& scene) {
  std::vector<std::string> paths;
  std::set<std::string> seen;
  const size_t steps = scene.time ? scene.time->values.size() : 1;
  for (size_t i = 0; i < steps; ++i) {
    const size_t step = (first_step(scene) + i) % steps;
    for (const SceneLayer& layer : scene.layers) {
      const std::string& path = store_at(layer, step);
      if (seen.insert(path).second) paths.push_back(path);
    }
  }
  return paths;
}

Result<VolumeGrid> transformed(const VolumeGrid& grid, const AffineTransform& m) {
  const auto along = [&](Vec3d v) {
    return Vec3d{m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
                 m[8] * v.x + m[9] * v.y + m[10] * v.z};
  };
  const Matrix3d edges = grid.cell_edges();
  const std::array<Vec3d, 3> axes{along(column(edges, 0)), along(column(edges, 1)),
                                  along(column(edges, 2))};
  VolumeGrid result = grid;
  result.spacing = {length(axes[0]), length(axes[1]), length(axes[2])};
  const Vec3d origin = along(grid.origin);
  result.origin = {origin.x + m[3], origin.y + m[7], origin.z + m[11]};
  const auto unit = [](Vec3d v, double by) { return Vec3d{v.x / by, v.y / by, v.z / by}; };
  const Vec3d x = unit(axes[0], result.spacing.x), y = unit(axes[1], result.spacing.y),
              z = unit(axes[2], result.spacing.z);
  result.direction = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
  if (!is_basis(result.direction)) {
    return fail(Status::invalid_argument,
                "transform: expected a matrix that keeps a volume a volume, found one that makes "
                "its axes lie nearly in a plane");
  }
  return result;
}

}  // namespace isosplat
