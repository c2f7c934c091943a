#include "native/extract/simplify_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <new>
#include <vector>

#include "shared/core/mesh/unused_vertices.h"

namespace isosplat {

Result<double> simplify_mesh(MeshPart& mesh, double max_error) try {
  if (mesh.triangles.empty()) return 0.0;
  // Relative to the first vertex, so that single precision suffices.
  const Vec3d origin = mesh.vertices.positions[0];
  std::vector<Vec3f> positions;
  positions.reserve(mesh.vertices.positions.size());
  for (const Vec3d& at : mesh.vertices.positions) {
    positions.push_back({static_cast<float>(at.x - origin.x), static_cast<float>(at.y - origin.y),
                         static_cast<float>(at.z - origin.z)});
  }
  const float* const coordinates = &positions[0].x;
  // meshoptimizer's errors are fractions of the mesh's extent.
  const float extent = meshopt_simplifyScale(coordinates, positions.size(), sizeof(Vec3f));
  if (!(extent > 0)) return 0.0;
  std::vector<std::array<uint32_t, 3>> triangles(mesh.triangles.size());
  float error = 0;
  const size_t indices =
      meshopt_simplify(triangles[0].data(), mesh.triangles[0].data(), 3 * mesh.triangles.size(),
                       coordinates, positions.size(), sizeof(Vec3f), 0,
                       static_cast<float>(max_error / static_cast<double>(extent)), 0, &error);
  triangles.resize(indices / 3);
  mesh.triangles = std::move(triangles);
  drop_unused_vertices(mesh);
  return static_cast<double>(error) * static_cast<double>(extent);
} catch (const std::bad_alloc&) {
  return fail(Status::out_of_memory,
              "the system refused memory while the mesh was simplified: close other programs, or "
              "choose a coarser --level");
}

}  // namespace isosplat
