#include "shared/core/mesh/surface_extent.h"

#include <algorithm>
#include <cmath>

#include "shared/core/base/matrix3.h"

namespace isosplat {

SurfaceExtent::SurfaceExtent(const VolumeGrid& grid, float quantized_isovalue,
                             QuantizedValue lowest)
    : edges_(grid.cell_edges()),
      cell_volume_(std::abs(determinant(edges_))),
      last_{grid.voxels.x - 1.0, grid.voxels.y - 1.0, grid.voxels.z - 1.0},
      isovalue_(quantized_isovalue),
      is_last_above_(static_cast<float>(lowest) > quantized_isovalue) {
  voxels_ = last_.x * last_.y * last_.z;
}

void SurfaceExtent::add(const DecodedCells& cells, const BlockMesh& mesh, Index3 origin) {
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (!is_active(cells.interval[i], isovalue_)) continue;
    const uint64_t packed = cells.cell[i];
    const auto along = [packed](int32_t low, int shift) {
      return static_cast<uint64_t>(low) + (packed >> shift & 63);
    };
    // At most 2^20 cells along each axis.
    const uint64_t order =
        (along(origin.z, 12) << 42 | along(origin.y, 6) << 21 | along(origin.x, 0)) + 1;
    if (order < last_active_) continue;
    last_active_ = order;
    is_last_above_ = static_cast<float>(cells.corners[i][7]) > isovalue_;
  }
  const Vec3d corner{double(origin.x), double(origin.y), double(origin.z)};
  const auto position = [&](uint32_t vertex) {
    const Vec3f p = mesh.vertices[vertex].position;
    return corner + Vec3d{double(p.x), double(p.y), double(p.z)};
  };
  for (const auto& triangle : mesh.triangles) {
    // Triangles are oriented so that their normals point out of the region above the isovalue.
    const Vec3d p[3] = {position(triangle[0]), position(triangle[1]), position(triangle[2])};
    const Vec3d first = p[1] - p[0], second = p[2] - p[0];
    area_ += 0.5 * length(cross(multiply(edges_, first), multiply(edges_, second)));
    flux_ += 0.5 * cross(first, second).x * (p[0].x + p[1].x + p[2].x) / 3;
    for (int i = 0; i < 3; ++i) {
      const Vec3d a = p[i], b = p[(i + 1) % 3];
      if (a.x != last_.x || b.x != last_.x) continue;
      // The cap's boundary has the opposite direction, and y dz along it sums up to the cap's area.
      flux_ += last_.x * 0.5 * (a.y + b.y) * (a.z - b.z);
      // Where the boundary meets the edge of the grid with the largest y, it continues along that
      // edge.
      if (a.y == last_.y) flux_ -= last_.x * last_.y * a.z;
      if (b.y == last_.y) flux_ += last_.x * last_.y * b.z;
    }
  }
}

double SurfaceExtent::volume_above() const {
  return std::clamp(flux_ + (is_last_above_ ? voxels_ : 0), 0.0, voxels_) * cell_volume_;
}

}  // namespace isosplat
