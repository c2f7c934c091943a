#include "shared/core/points/field_lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isosplat {
namespace {

constexpr int32_t kPoints = kBlockCells + 1;

size_t index_of(int32_t x, int32_t y, int32_t z) {
  return (static_cast<size_t>(z) * kPoints + static_cast<size_t>(y)) * kPoints +
         static_cast<size_t>(x);
}

Index3 low_corner_of(uint32_t cell) {
  return {static_cast<int32_t>(cell & 63), static_cast<int32_t>(cell >> 6 & 63),
          static_cast<int32_t>(cell >> 12 & 63)};
}

}  // namespace

FieldLattice::FieldLattice(const ValueMapping& mapping, bool is_category)
    : mapping_(mapping), is_category_(is_category), values_(size_t{kPoints} * kPoints * kPoints) {}

void FieldLattice::set(std::span<const uint32_t> cells, std::span<const CellCorners> corners) {
  for (size_t i = 0; i < corners.size(); ++i) {
    const Index3 low = low_corner_of(cells[i]);
    for (int32_t k = 0; k < 8; ++k) {
      values_[index_of(low.x + (k & 1), low.y + (k >> 1 & 1), low.z + (k >> 2))] =
          corners[i][static_cast<size_t>(k)];
    }
  }
}

/// low: the low corner of the cell; t: the point in the cell. needs_all: also the corners without
/// weight must have values.
float FieldLattice::interpolate(Index3 low, Vec3d t, bool needs_all) const {
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  const auto nearest = [](double part) { return part < 0.5 ? 0.0 : 1.0; };
  if (is_category_) t = {nearest(t.x), nearest(t.y), nearest(t.z)};
  double sum = 0;
  for (int32_t k = 0; k < 8; ++k) {
    const double weight =
        (k & 1 ? t.x : 1 - t.x) * (k & 2 ? t.y : 1 - t.y) * (k & 4 ? t.z : 1 - t.z);
    if (weight == 0 && (is_category_ || !needs_all)) continue;
    const QuantizedValue value =
        values_[index_of(low.x + (k & 1), low.y + (k >> 1 & 1), low.z + (k >> 2))];
    if (mapping_.has_missing && value == kMissingVoxel) return kMissing;
    sum += weight * value;
  }
  return static_cast<float>(mapping_.value(sum));
}

float FieldLattice::at(uint32_t cell, Vec3f in_cell) const {
  const auto inside = [](float t) { return std::clamp(double{t}, 0.0, 1.0); };
  return interpolate(low_corner_of(cell), {inside(in_cell.x), inside(in_cell.y), inside(in_cell.z)},
                     true);
}

float FieldLattice::at(Vec3f position) const {
  // The last lattice point has no cell beyond it.
  const auto low_of = [](float x) {
    return std::clamp(static_cast<int32_t>(std::floor(x)), 0, kBlockCells - 1);
  };
  const Index3 low{low_of(position.x), low_of(position.y), low_of(position.z)};
  return interpolate(
      low, {double{position.x} - low.x, double{position.y} - low.y, double{position.z} - low.z},
      false);
}

}  // namespace isosplat
