#include "shared/core/sampling/smooth_gradients.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

/// Bits of an index along an axis in the key of a cell. Indices begin at −1.
constexpr int kIndexBits = 21;

uint64_t key_of(int32_t x, int32_t y, int32_t z) {
  const auto bits = [](int32_t index) { return static_cast<uint64_t>(index + 1); };
  return bits(x) | bits(y) << kIndexBits | bits(z) << (2 * kIndexBits);
}

}  // namespace

CornerGradients corner_gradients(const std::array<float, 8>& corners, Vec3f p) {
  CornerGradients share;
  const Trilinear field(corners);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3f at{static_cast<float>(corner & 1), static_cast<float>(corner >> 1 & 1),
                   static_cast<float>(corner >> 2)};
    const auto hat = [](float distance) { return std::max(0.0f, 1 - std::abs(distance)); };
    const float weight = hat(p.x - at.x) * hat(p.y - at.y) * hat(p.z - at.z);
    share.gradient = share.gradient + field.at(at).gradient * weight;
    share.weight += weight;
  }
  return share;
}

void SmoothGradients::add(uint32_t level, Index3 cell, const std::array<float, 8>& corners) {
  levels_[level][key_of(cell.x, cell.y, cell.z)] = corners;
}

Vec3d SmoothGradients::at(Vec3d position) const {
  Vec3d sum;
  for (const auto& [level, cells] : levels_) {
    const double per_cell = std::ldexp(1.0, -static_cast<int>(level));
    const Vec3d p = position * per_cell;
    const auto index = [](double x) { return static_cast<int32_t>(std::floor(x)); };
    const Index3 own{index(p.x), index(p.y), index(p.z)};
    for (int i = 0; i < 27; ++i) {
      const Index3 cell{own.x + i % 3 - 1, own.y + i / 3 % 3 - 1, own.z + i / 9 - 1};
      if (std::min({cell.x, cell.y, cell.z}) < 0) continue;
      const auto found = cells.find(key_of(cell.x, cell.y, cell.z));
      if (found == cells.end()) continue;
      const Vec3f in_cell{static_cast<float>(p.x - cell.x), static_cast<float>(p.y - cell.y),
                          static_cast<float>(p.z - cell.z)};
      const Vec3f gradient = corner_gradients(found->second, in_cell).gradient;
      // One factor for cells to voxels, three for the volume.
      const double weight = per_cell * per_cell * per_cell * per_cell;
      sum = sum + Vec3d{gradient.x, gradient.y, gradient.z} * weight;
    }
  }
  return sum;
}

}  // namespace isosplat
