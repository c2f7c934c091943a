#include "shared/core/preprocess/gradient_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isosplat {
namespace {

/// One of so many cells is compared with others. It has no factor in common with the cells of a
/// row, so the compared cells lie in all columns.
constexpr size_t kStride = 97;

using Gradient = std::array<int64_t, 3>;

int64_t dot(const Gradient& a, const Gradient& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Four times the gradient at the centre of a cell, per cell edge.
Gradient gradient_of(const GatheredBlock& block, Index3 cell) {
  const auto row = static_cast<size_t>(block.cells.x + 1);
  const size_t slice = row * static_cast<size_t>(block.cells.y + 1);
  const QuantizedValue* corner = block.voxels.data() + static_cast<size_t>(cell.z) * slice +
                                 static_cast<size_t>(cell.y) * row + static_cast<size_t>(cell.x);
  Gradient gradient{};
  for (size_t z = 0; z < 2; ++z) {
    for (size_t y = 0; y < 2; ++y) {
      for (size_t x = 0; x < 2; ++x) {
        const int64_t voxel = corner[z * slice + y * row + x];
        gradient[0] += x ? voxel : -voxel;
        gradient[1] += y ? voxel : -voxel;
        gradient[2] += z ? voxel : -voxel;
      }
    }
  }
  return gradient;
}

/// Rounded, and the same on all machines: division and square root are exact to the last bit.
int64_t scaled_cosine(const Gradient& a, const Gradient& b) {
  const double squares = static_cast<double>(dot(a, a)) * static_cast<double>(dot(b, b));
  if (squares <= 0) return 0;
  const double cosine = static_cast<double>(dot(a, b)) / std::sqrt(squares);
  return static_cast<int64_t>(
      std::floor(cosine * static_cast<double>(GradientAgreement::kOne) + 0.5));
}

}  // namespace

void GradientAgreement::add(const GatheredBlock& block) {
  const int32_t nx = block.cells.x, ny = block.cells.y, nz = block.cells.z;
  const auto slice = static_cast<size_t>(nx) * static_cast<size_t>(ny);
  for (size_t i = 0; i < block.intervals.size(); i += kStride) {
    const CellInterval interval = block.intervals[i];
    if (interval.min >= interval.max) continue;
    const Index3 cell{static_cast<int32_t>(i % static_cast<size_t>(nx)),
                      static_cast<int32_t>(i / static_cast<size_t>(nx) % static_cast<size_t>(ny)),
                      static_cast<int32_t>(i / slice)};
    const Gradient gradient = gradient_of(block, cell);
    const auto compare = [&](Index3 other, size_t at) {
      if (other.x >= nx || other.y >= ny || other.z >= nz) return;
      const QuantizedValue from = std::max(interval.min, block.intervals[at].min);
      const QuantizedValue to = std::min(interval.max, block.intervals[at].max);
      if (from >= to) return;
      const int64_t cosine = scaled_cosine(gradient, gradient_of(block, other));
      cosines[from] += cosine;
      cosines[to] -= cosine;
      ++pairs[from];
      --pairs[to];
    };
    compare({cell.x + 2, cell.y, cell.z}, i + 2);
    compare({cell.x, cell.y + 2, cell.z}, i + 2 * static_cast<size_t>(nx));
    compare({cell.x, cell.y, cell.z + 2}, i + 2 * slice);
  }
}

}  // namespace isosplat
