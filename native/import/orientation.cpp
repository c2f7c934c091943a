#include "native/import/orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

using Matrix = std::array<double, 9>;

double determinant(const Matrix& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

/// The transposed inverse. Requires det = determinant(m) ≠ 0.
Matrix inverse_transpose(const Matrix& m, double det) {
  return {(m[4] * m[8] - m[5] * m[7]) / det, (m[5] * m[6] - m[3] * m[8]) / det,
          (m[3] * m[7] - m[4] * m[6]) / det, (m[2] * m[7] - m[1] * m[8]) / det,
          (m[0] * m[8] - m[2] * m[6]) / det, (m[1] * m[6] - m[0] * m[7]) / det,
          (m[1] * m[5] - m[2] * m[4]) / det, (m[2] * m[3] - m[0] * m[5]) / det,
          (m[0] * m[4] - m[1] * m[3]) / det};
}

/// The nearest orthonormal matrix, of the same handedness: Newton's iteration for the polar
/// decomposition (Higham 1986). Each step averages the matrix with its transposed inverse.
Matrix nearest_orthonormal(Matrix m) {
  for (int i = 0; i < 50; ++i) {
    const Matrix other = inverse_transpose(m, determinant(m));
    double change = 0;
    for (size_t k = 0; k < 9; ++k) {
      const double average = (m[k] + other[k]) / 2;
      change = std::max(change, std::abs(average - m[k]));
      m[k] = average;
    }
    if (change < 1e-15) break;
  }
  return m;
}

/// Columns scaled to length 1. False where that is impossible, or the columns lie in a plane.
bool normalise_columns(Matrix& m) {
  for (size_t column = 0; column < 3; ++column) {
    const double length = std::hypot(m[column], m[3 + column], m[6 + column]);
    if (!(length > 0) || !std::isfinite(length)) return false;
    for (size_t row = 0; row < 3; ++row) m[3 * row + column] /= length;
  }
  return std::abs(determinant(m)) > 1e-3;
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
                            "single slice has no isosurface; give the folder of all slices, or "
                            "the file that holds them all",
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
    result.notes.push_back(
        fmt::format("the header's spacing {} is not a positive number: 1 is taken; --spacing sets "
                    "another",
                    *spacing));
    *spacing = 1;
  }
  grid.spacing = geometry.spacing;

  const Vec3d origin = geometry.origin;
  if (std::isfinite(origin.x) && std::isfinite(origin.y) && std::isfinite(origin.z)) {
    grid.origin = origin;
  }

  Matrix direction = geometry.direction;
  if (!normalise_columns(direction)) {
    result.notes.push_back(
        "the header's axes are no basis of space: the volume is shown along x, y and z");
    return result;
  }
  const Matrix orthonormal = nearest_orthonormal(direction);
  double error = 0;
  for (size_t k = 0; k < 9; ++k) error = std::max(error, std::abs(orthonormal[k] - direction[k]));
  if (error > 1e-3) {
    result.notes.push_back(fmt::format(
        "the header's axes are not perpendicular (off by {:.1f}°): the nearest perpendicular ones "
        "are taken",
        2 * std::asin(std::min(1.0, error / 2)) * 180 / 3.14159265358979));
  }
  grid.direction = orthonormal;

  if (determinant(orthonormal) < 0) {
    result.reverse_rows = true;
    grid.origin = grid.world({0, static_cast<double>(voxels.y - 1), 0});
    for (size_t row = 0; row < 3; ++row) grid.direction[3 * row + 1] *= -1;
  }
  for (double& d : grid.direction) d += 0.0;  // no negative zeros: they would reach metadata
  return result;
}

}  // namespace isosplat
