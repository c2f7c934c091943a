#include "shared/core/mesh/solid_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/core/mesh/close_mesh.h"
#include "shared/core/mesh/mesh_cap.h"
#include "shared/core/mesh/unused_vertices.h"

namespace isosplat {
namespace {

/// Rounding errors of positions, in voxels.
constexpr double kRounding = 1e-6;

double floor_of(double x) {
  const double nearest = std::round(x);
  return std::abs(x - nearest) < kRounding ? nearest : std::floor(x);
}

double ceiling_of(double x) {
  return -floor_of(-x);
}

}  // namespace

SolidRegion::SolidRegion(const VolumeGrid& grid, uint32_t level)
    : grid_(grid), cell_size_(std::ldexp(1.0, static_cast<int>(level))), low_{} {
  const std::array<int32_t, 3> voxels{grid.voxels.x, grid.voxels.y, grid.voxels.z};
  for (size_t axis = 0; axis < 3; ++axis) {
    const double last = voxels[axis] - 1;
    high_[axis] = std::ceil(last / cell_size_) * cell_size_;
    // The last cell of a coarse level reaches beyond the last voxel.
    const auto towards_low = [&](size_t i) { return i == axis ? -1.0 : 0.0; };
    if (high_[axis] > last) {
      cuts_.push_back({{towards_low(0), towards_low(1), towards_low(2)}, -last});
    }
  }
}

/// Limits the cells along an axis, to whole cells.
void SolidRegion::shrink(int axis, double low, double high) {
  const auto i = static_cast<size_t>(axis);
  low_[i] = std::max(low_[i], floor_of(low / cell_size_) * cell_size_);
  high_[i] = std::min(high_[i], ceiling_of(high / cell_size_) * cell_size_);
}

/// Adds a half-space of voxels, unless all cells are inside.
void SolidRegion::clip_voxels(Vec3d normal, double offset) {
  const std::array<double, 3> n{normal.x, normal.y, normal.z};
  double least = -offset;
  for (size_t axis = 0; axis < 3; ++axis) least += n[axis] * (n[axis] > 0 ? low_ : high_)[axis];
  if (least < -kRounding) cuts_.push_back({normal, offset});
}

Result<void> SolidRegion::clip(const HalfSpace& half_space) {
  const auto& [normal, offset] = half_space;
  // normal · (origin + edges · voxel) ≥ offset
  const Vec3d in_voxels = multiply_transposed(grid_.cell_edges(), normal);
  const double size = length(in_voxels);
  const double rest = (offset - dot(normal, grid_.origin)) / size;
  if (!std::isfinite(size) || !(size > 0) || !std::isfinite(rest)) {
    return fail(Status::invalid_argument,
                "expected a clip plane with a finite normal other than 0,0,0 and a finite offset, "
                "found others: state the plane in world units");
  }
  clip_voxels(in_voxels * (1 / size), rest);
  return {};
}

Result<void> SolidRegion::clip_to_voxels(Vec3d low, Vec3d high) {
  const std::array<double, 3> from{low.x, low.y, low.z}, to{high.x, high.y, high.z};
  for (size_t axis = 0; axis < 3; ++axis) {
    if (std::isnan(from[axis]) || std::isnan(to[axis])) {
      return fail(Status::invalid_argument, "expected a box of numbers, found NaN");
    }
    shrink(static_cast<int>(axis), from[axis], to[axis]);
  }
  const std::array<Vec3d, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (size_t axis = 0; axis < 3; ++axis) {
    if (std::isfinite(from[axis])) clip_voxels(axes[axis], from[axis]);
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    if (std::isfinite(to[axis])) clip_voxels(axes[axis] * -1, -to[axis]);
  }
  return {};
}

Result<void> SolidRegion::clip_to_box(Vec3d low, Vec3d high) {
  std::array<double, 3> least, most;
  least.fill(std::numeric_limits<double>::infinity());
  most.fill(-std::numeric_limits<double>::infinity());
  const Matrix3d dual = grid_.dual_edges();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at{corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                   corner & 4 ? high.z : low.z};
    const Vec3d voxel = multiply_transposed(dual, at - grid_.origin);
    const std::array<double, 3> coordinates{voxel.x, voxel.y, voxel.z};
    for (size_t axis = 0; axis < 3; ++axis) {
      // A sum of infinities may be NaN: then this corner limits nothing.
      if (std::isnan(coordinates[axis])) {
        least[axis] = -std::numeric_limits<double>::infinity();
        most[axis] = std::numeric_limits<double>::infinity();
      }
      least[axis] = std::min(least[axis], coordinates[axis]);
      most[axis] = std::max(most[axis], coordinates[axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    shrink(axis, least[static_cast<size_t>(axis)], most[static_cast<size_t>(axis)]);
  }
  const auto limit = [&](Vec3d normal, double offset) -> Result<void> {
    return std::isinf(offset) ? Result<void>{} : clip({normal, offset});
  };
  Result<void> done;
  if (done) done = limit({1, 0, 0}, low.x);
  if (done) done = limit({0, 1, 0}, low.y);
  if (done) done = limit({0, 0, 1}, low.z);
  if (done) done = limit({-1, 0, 0}, -high.x);
  if (done) done = limit({0, -1, 0}, -high.y);
  if (done) done = limit({0, 0, -1}, -high.z);
  return done;
}

CellRegion SolidRegion::cells() const {
  return CellRegion::in_grid({low_[0], low_[1], low_[2]}, {high_[0], high_[1], high_[2]});
}

Result<void> SolidRegion::close(MeshPart& mesh, const std::vector<bool>& is_category) const {
  std::vector<bool> is_cap(mesh.triangles.size());
  auto done = close_at_box(mesh, {low_[0], low_[1], low_[2]}, {high_[0], high_[1], high_[2]});
  is_cap.resize(mesh.triangles.size(), true);
  for (size_t i = 0; done && i < cuts_.size(); ++i) {
    done = clip_closed(mesh, is_cap, cuts_[i], is_category);
  }
  if (!done) return done;
  if (!is_closed(mesh)) return tl::unexpected(not_closable());
  drop_unused_vertices(mesh);
  for (Vec3d& at : mesh.vertices.positions) at = grid_.world(at);
  const Matrix3d dual = grid_.dual_edges();
  for (Vec3f& normal : mesh.vertices.normals) {
    const Vec3d n = multiply(dual, Vec3d{normal.x, normal.y, normal.z});
    const double size = length(n);
    const double factor = size > 0 ? 1 / size : 0;
    normal = {static_cast<float>(n.x * factor), static_cast<float>(n.y * factor),
              static_cast<float>(n.z * factor)};
  }
  if (determinant(grid_.direction) < 0) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  return {};
}

VolumeGrid lattice_grid(Index3 voxels) {
  VolumeGrid grid;
  grid.voxels = voxels;
  return grid;
}

}  // namespace isosplat
