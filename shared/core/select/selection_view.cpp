#include "shared/core/select/selection_view.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

using Clip = std::array<double, 4>;

Clip transform(const std::array<double, 16>& m, Vec3d p, double w) {
  Clip result;
  for (size_t row = 0; row < 4; ++row) {
    result[row] = m[row] * p.x + m[4 + row] * p.y + m[8 + row] * p.z + m[12 + row] * w;
  }
  return result;
}

/// Lower limit of w, which keeps sizes finite for blocks at or behind the eye.
constexpr double kMinW = 1e-9;

}  // namespace

ScreenProjection::ScreenProjection(const VolumeGrid& grid, const SelectionView& view) {
  const auto& m = view.view_projection;
  const Vec3d zero = grid.world({0, 0, 0});
  const Vec3d columns[4] = {grid.world({1, 0, 0}) - zero, grid.world({0, 1, 0}) - zero,
                            grid.world({0, 0, 1}) - zero, zero};
  for (size_t column = 0; column < 4; ++column) {
    const Clip clip = transform(m, columns[column], column == 3 ? 1 : 0);
    std::copy(clip.begin(), clip.end(), clip_from_index_.begin() + 4 * column);
  }
  // A rotation does not change the length of a row, so this is the scale of the projection.
  px_per_unit_at_w1_ = std::max(length(Vec3d{m[0], m[4], m[8]}) * view.width_px,
                                length(Vec3d{m[1], m[5], m[9]}) * view.height_px) /
                       2;
  longest_spacing_ = std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z});
}

ScreenProjection::Footprint ScreenProjection::footprint(const LevelGrid& level,
                                                        Index3 block) const {
  const double cell = std::ldexp(1.0, static_cast<int>(level.level));
  const Index3 cells = block_cells(level, block);
  const auto low = [&](int32_t b) { return (static_cast<double>(b) * kBlockCells - 1) * cell; };
  const auto high = [&](int32_t b, int32_t n) {
    return (static_cast<double>(b) * kBlockCells + n + 1) * cell;
  };
  const double x[2] = {low(block.x), high(block.x, cells.x)};
  const double y[2] = {low(block.y), high(block.y, cells.y)};
  const double z[2] = {low(block.z), high(block.z, cells.z)};

  // A box is outside when all its corners are outside the same plane of the frustum.
  unsigned outside_all = 63;
  double nearest_w = INFINITY;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Vec3d p{x[corner & 1], y[corner >> 1 & 1], z[corner >> 2]};
    const Clip clip = transform(clip_from_index_, p, 1);
    unsigned outside = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (clip[axis] < -clip[3]) outside |= 1u << (2 * axis);
      if (clip[axis] > clip[3]) outside |= 2u << (2 * axis);
    }
    outside_all &= outside;
    nearest_w = std::min(nearest_w, clip[3]);
  }

  Footprint result;
  result.outside = outside_all != 0;
  result.cell_px = cell * longest_spacing_ * px_per_unit_at_w1_ / std::max(nearest_w, kMinW);
  const Clip centre =
      transform(clip_from_index_, {(x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (z[0] + z[1]) / 2}, 1);
  const double w = std::max(std::abs(centre[3]), kMinW);
  result.centre_distance = std::hypot(centre[0] / w, centre[1] / w);
  return result;
}

}  // namespace isosplat
