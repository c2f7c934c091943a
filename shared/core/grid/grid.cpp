#include "shared/core/grid/grid.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

int32_t divide_up(int32_t a, int32_t b) {
  return (a + b - 1) / b;
}

Index3 cells_at(Index3 voxels, uint32_t level) {
  Index3 cells{voxels.x - 1, voxels.y - 1, voxels.z - 1};
  for (uint32_t l = 0; l < level; ++l) {
    cells = {divide_up(cells.x, 2), divide_up(cells.y, 2), divide_up(cells.z, 2)};
  }
  return cells;
}

/// Whether two values are the same up to rounding; see quantized_isovalue().
bool is_same(const ValueMapping& mapping, double a, double b) {
  const double max_magnitude = std::abs(mapping.offset) + 65536 * mapping.scale;
  if (std::abs(a - b) <= std::min(max_magnitude * 0x1p-50, mapping.scale / 4)) return true;
  const bool singles_differ = max_magnitude * 0x1p-21 <= mapping.scale;
  return singles_differ && static_cast<float>(a) == static_cast<float>(b);
}

}  // namespace

float ValueMapping::quantized_isovalue(double isovalue) const {
  // Beyond the range of quantized values, the distance has no effect.
  const double quantized = std::clamp((isovalue - offset) / scale, -65536.0, 131072.0);
  if (std::isnan(quantized)) return static_cast<float>(quantized);
  const double nearest = std::floor(quantized + 0.5);
  if (is_same(*this, isovalue, value(nearest))) return static_cast<float>(nearest);
  // It lies between two quantized values, and must do so after the rounding of the division and of
  // single precision.
  double below = std::floor(quantized);
  if (value(below) > isovalue) below -= 1;
  if (value(below + 1) < isovalue) below += 1;
  // The distance from a quantized value is at least this: GPUs may flush smaller numbers to 0.
  constexpr float kMin = 0x1p-24f;
  const auto low = static_cast<float>(below), high = static_cast<float>(below + 1);
  return std::clamp(static_cast<float>(quantized), std::max(std::nextafter(low, high), low + kMin),
                    std::min(std::nextafter(high, low), high - kMin));
}

Vec3d VolumeGrid::world(Vec3d index) const {
  return origin +
         multiply(direction, {index.x * spacing.x, index.y * spacing.y, index.z * spacing.z});
}

Vec3d VolumeGrid::world_gradient(Vec3d index_gradient) const {
  return multiply(dual_edges(), index_gradient);
}

bool is_basis(const Matrix3d& direction) {
  for (size_t axis = 0; axis < 3; ++axis) {
    // The negation also rejects NaN.
    if (!(std::abs(length(column(direction, axis)) - 1) <= 1e-6)) return false;
  }
  return std::abs(determinant(direction)) >= 1e-3;
}

double shear_degrees(const Matrix3d& axes) {
  const auto cosine = [&](size_t one, size_t other) {
    const Vec3d a = column(axes, one), b = column(axes, other);
    return std::abs(dot(a, b)) / (length(a) * length(b));
  };
  const double max_cosine = std::max({cosine(0, 1), cosine(1, 2), cosine(2, 0)});
  return std::asin(std::min(max_cosine, 1.0)) * (180 / 3.14159265358979323846);
}

uint32_t level_count(Index3 voxels) {
  uint32_t levels = 1;
  for (;; ++levels) {
    const Index3 cells = cells_at(voxels, levels - 1);
    if (std::max({cells.x, cells.y, cells.z}) <= kCoarsestCells) return levels;
  }
}

LevelGrid level_grid(Index3 voxels, uint32_t level) {
  const Index3 cells = cells_at(voxels, level);
  return {level,
          cells,
          {divide_up(cells.x, kBlockCells), divide_up(cells.y, kBlockCells),
           divide_up(cells.z, kBlockCells)}};
}

std::string block_name(BlockKey block) {
  return std::to_string(block.level) + "/" + std::to_string(block.index.x) + "." +
         std::to_string(block.index.y) + "." + std::to_string(block.index.z);
}

std::string chunk_name(BlockKey block, uint32_t band) {
  return block_name(block) + "/" + std::to_string(band);
}

Index3 block_cells(const LevelGrid& level, Index3 block) {
  return {std::min(kBlockCells, level.cells.x - block.x * kBlockCells),
          std::min(kBlockCells, level.cells.y - block.y * kBlockCells),
          std::min(kBlockCells, level.cells.z - block.z * kBlockCells)};
}

}  // namespace isosplat
