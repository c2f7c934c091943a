#include "shared/core/preprocess/volume_sample.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "shared/core/base/portable_math.h"

namespace isosplat {
namespace {

/// Estimates the entropy, in bits, of the residual of a voxel of active cells. Two simple
/// predictors are tried in each row: the mean of three neighbours, and the plane through them. With
/// pure noise, their errors are 1.15 and 2 times the noise; with a pure gradient, the second one's
/// is zero. The codec's fitted predictor comes near the better of the two.
double voxel_bits(const GatheredBlock& block) {
  const auto row = static_cast<size_t>(block.cells.x + 1);
  const size_t slice = row * static_cast<size_t>(block.cells.y + 1);
  double bits = 0;
  uint64_t cells = 0;
  const CellInterval* interval = block.intervals.data();
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y, interval += block.cells.x) {
      // The corner of each cell with the greatest coordinates, and its neighbours towards the
      // origin.
      const QuantizedValue* here = block.voxels.data() + static_cast<size_t>(z + 1) * slice +
                                   static_cast<size_t>(y + 1) * row;
      const QuantizedValue *up = here - row, *back = here - slice;
      uint64_t active = 0, from_mean = 0, from_plane = 0;
      for (int32_t x = 0; x < block.cells.x; ++x) {
        const int32_t v = here[x + 1], left = here[x], above = up[x + 1];
        const uint32_t is_active = interval[x].min < interval[x].max;
        active += is_active;
        from_mean +=
            is_active * static_cast<uint32_t>(std::abs(3 * v - left - above - back[x + 1]));
        from_plane += is_active * static_cast<uint32_t>(std::abs(v - left - above + up[x]));
      }
      if (active == 0) continue;
      const auto count = static_cast<double>(active);
      const double error = 1.08 *
                           std::min(static_cast<double>(from_mean) / (3 * 1.1547),
                                    static_cast<double>(from_plane) / 2) /
                           count;
      // The entropy of a normal distribution with this mean absolute value, rounded to integers.
      const double variance = error * error * 1.5708 + 1.0 / 12;
      bits += count * 0.5 * portable::log2(17.0795 * variance);
      cells += active;
    }
  }
  return cells > 0 ? bits / static_cast<double>(cells) : 0;
}

}  // namespace

SampleColumn sample_column(const Layer& layer, Index3 block, GatheredBlock& scratch) {
  gather_block(layer, block, scratch);
  return {scratch.cells, scratch.intervals, voxel_bits(scratch)};
}

}  // namespace isosplat
