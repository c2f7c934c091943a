#include "shared/import/geometry/orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isosplat::import {
namespace {

/// Scales the columns to length 1. False if the result is singular.
bool normalise_columns(Matrix3d& m) {
  const auto inverse_length = [&](size_t axis) { return 1 / length(column(m, axis)); };
  m = scale_columns(m, {inverse_length(0), inverse_length(1), inverse_length(2)});
  return is_basis(m);
}

std::string shape(Vec3<int64_t> voxels) {
  return fmt::format("{} × {} × {}", voxels.x, voxels.y, voxels.z);
}

}  // namespace

Result<Orientation> orient(Vec3<int64_t> voxels, HeaderGeometry geometry) {
  const int64_t least = std::min({voxels.x, voxels.y, voxels.z});
  const int64_t most = std::max({voxels.x, voxels.y, voxels.z});
  if (least < 1) {
    return fail(Status::malformed_volume,
                fmt::format("expected at least 2 voxels along each axis, found {}: the header is "
                            "wrong; export the volume again",
                            shape(voxels)));
  }
  if (least < 2) {
    return fail(Status::no_cells,
                fmt::format("expected a volume with at least 2 voxels along each axis, found {}: a "
                            "single slice has no isosurface; give the folder of all slices, or the "
                            "file that contains them all",
                            shape(voxels)));
  }
  if (most > kMaxVoxelsPerAxis) {
    return fail(Status::volume_too_large,
                fmt::format("expected at most {} voxels along each axis, found {}: crop or "
                            "downsample the volume, or correct its header",
                            kMaxVoxelsPerAxis, shape(voxels)));
  }

  Orientation result;
  VolumeGrid& grid = result.grid;
  grid.voxels = {static_cast<int32_t>(voxels.x), static_cast<int32_t>(voxels.y),
                 static_cast<int32_t>(voxels.z)};

  for (double* spacing : {&geometry.spacing.x, &geometry.spacing.y, &geometry.spacing.z}) {
    if (*spacing > 0 && std::isfinite(*spacing)) continue;
    result.notes.push_back(fmt::format(
        "the header's spacing {} is not a positive number: 1 is assumed; --spacing sets "
        "another",
        *spacing));
    *spacing = 1;
  }
  grid.spacing = geometry.spacing;

  const Vec3d origin = geometry.origin;
  if (std::isfinite(origin.x) && std::isfinite(origin.y) && std::isfinite(origin.z)) {
    grid.origin = origin;
  } else {
    result.notes.push_back("the header's origin is not finite: 0, 0, 0 is assumed");
  }

  Matrix3d direction = geometry.direction;
  if (!normalise_columns(direction)) {
    result.notes.push_back("the header's axes lie in a plane: x, y and z are used instead");
    return result;
  }
  grid.direction = direction;

  if (determinant(direction) < 0) {
    result.reverse_rows = true;
    grid.origin = grid.world({0, static_cast<double>(voxels.y - 1), 0});
    for (size_t row = 0; row < 3; ++row) grid.direction[3 * row + 1] *= -1;
  }
  for (double& d : grid.direction) d += 0.0;  // no negative zeros, which would appear in metadata
  return result;
}

}  // namespace isosplat::import
