#include "shared/core/preprocess/coarsen.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "shared/core/preprocess/coarse_levels.h"
#include "shared/core/preprocess/coarse_voxels.h"

namespace isosplat {
namespace {

constexpr std::array<uint32_t, 3> kWeight = {1, 2, 1};

/// The type of a weighted sum over nine voxels with equal x. The weights sum to 16.
template <class T>
using Sum = std::conditional_t<sizeof(T) == 1, uint16_t, uint32_t>;
template <class T>
using RowSums = std::array<Sum<T>, kBlockCells + 4>;

/// The nine fine rows from which a coarse row is computed, y fastest.
template <class T>
using NineRows = std::array<const T*, 9>;

template <class T>
void sum_rows(const NineRows<T>& rows, size_t count, RowSums<T>& sums) {
  const auto& [a, b, c, d, e, f, g, h, i] = rows;
  Sum<T>* const __restrict to = sums.data();
  for (size_t x = 0; x < count; ++x) {
    const uint32_t corners = a[x] + c[x] + g[x] + i[x], sides = b[x] + d[x] + f[x] + h[x];
    to[x] = static_cast<Sum<T>>(corners + 2 * sides + 4u * e[x]);
  }
}

/// As sum_rows(), without missing voxels. weights: the sum of the weights of the others.
template <class T>
void sum_present(const NineRows<T>& rows, size_t count, RowSums<T>& sums, RowSums<T>& weights) {
  sums.fill(0);
  weights.fill(0);
  for (size_t r = 0; r < rows.size(); ++r) {
    const uint32_t weight = kWeight[r / 3] * kWeight[r % 3];
    for (size_t x = 0; x < count; ++x) {
      const uint32_t w = rows[r][x] == kMissingVoxel ? 0 : weight;
      sums[x] = static_cast<Sum<T>>(sums[x] + w * rows[r][x]);
      weights[x] = static_cast<Sum<T>>(weights[x] + w);
    }
  }
}

/// The weighted sum of three such sums around a coarse voxel. sums[0] belongs to position first_x.
template <class T>
uint32_t sum_around(const RowSums<T>& sums, int32_t coarse, int32_t last, int32_t first_x) {
  const auto [left, centre, right] = finer_voxels<1>(coarse, last);
  const auto at = [&](int32_t x) { return uint32_t{sums[static_cast<size_t>(x - first_x)]}; };
  return at(left) + 2 * at(centre) + at(right);
}

template <class T>
void average_voxels(const Layer& layer, const GatheredBlock& block, const CoarserLayer& coarser) {
  const Index3 cells = layer.grid.cells;
  const auto* voxels = reinterpret_cast<const T*>(layer.voxels);
  auto* out = reinterpret_cast<T*>(coarser.voxels);
  const LevelBox written = coarse_voxels_of(layer.grid, block.index);
  const Index3 first = written.first, end = written.end();
  // The fine positions along x that the row needs, clamped to the volume.
  const int32_t first_x = std::max(2 * first.x - 1, 0);
  const int32_t last_x = std::min(2 * (end.x - 1) + 1, cells.x);
  const auto count = static_cast<size_t>(last_x - first_x + 1);
  // The coarse voxels whose three positions are all inside the volume.
  const int32_t inner = std::max(first.x, 1), inner_end = std::min(end.x, (cells.x + 1) / 2);
  RowSums<T> sums, weights;
  for (int32_t k = first.z; k < end.z; ++k) {
    const auto z_rows = finer_voxels<1>(k, cells.z);
    for (int32_t j = first.y; j < end.y; ++j) {
      const auto y_rows = finer_voxels<1>(j, cells.y);
      NineRows<T> rows;
      for (size_t r = 0; r < rows.size(); ++r) {
        rows[r] = voxels + layer.voxel_box.at({first_x, y_rows[r % 3], z_rows[r / 3]});
      }
      T* const __restrict to = out + coarser.voxel_box.at({first.x, j, k});
      const auto around = [&](const RowSums<T>& of, int32_t i) {
        return sum_around<T>(of, i, cells.x, first_x);
      };
      if (layer.has_missing) {
        sum_present<T>(rows, count, sums, weights);
        for (int32_t i = first.x; i < end.x; ++i) {
          const uint32_t sum = around(sums, i), weight = around(weights, i);
          to[i - first.x] = static_cast<T>(weight ? (sum + weight / 2) / weight : kMissingVoxel);
        }
        continue;
      }
      sum_rows<T>(rows, count, sums);
      for (int32_t i = inner; i < inner_end; ++i) {
        const Sum<T>* const three = &sums[static_cast<size_t>(2 * i - 1 - first_x)];
        const uint32_t sum = uint32_t{three[0]} + 2u * three[1] + three[2];
        to[i - first.x] = static_cast<T>((sum + 32) >> 6);
      }
      for (int32_t i = first.x; i < inner; ++i) {
        to[i - first.x] = static_cast<T>((around(sums, i) + 32) >> 6);
      }
      for (int32_t i = std::max(inner, inner_end); i < end.x; ++i) {
        to[i - first.x] = static_cast<T>((around(sums, i) + 32) >> 6);
      }
    }
  }
}

template <class T>
void unite_intervals(const GatheredBlock& block, const CoarserLayer& coarser) {
  const Index3 first{block.index.x * (kBlockCells / 2), block.index.y * (kBlockCells / 2),
                     block.index.z * (kBlockCells / 2)};
  auto* out = reinterpret_cast<T*>(coarser.intervals);
  const auto row = static_cast<size_t>(block.cells.x);
  const size_t slice = row * static_cast<size_t>(block.cells.y);
  std::array<QuantizedValue, kBlockCells + 1> low, high;
  for (int32_t k = 0; k < block.cells.z; k += 2) {
    const size_t above = k + 1 < block.cells.z ? slice : 0;
    for (int32_t j = 0; j < block.cells.y; j += 2) {
      const size_t next = j + 1 < block.cells.y ? row : 0;
      const CellInterval* a =
          block.intervals.data() + static_cast<size_t>(k) * slice + static_cast<size_t>(j) * row;
      for (size_t i = 0; i < row; ++i) {
        const CellInterval *b = a + next, *c = a + above, *d = a + above + next;
        low[i] = std::min(std::min(a[i].min, b[i].min), std::min(c[i].min, d[i].min));
        high[i] = std::max(std::max(a[i].max, b[i].max), std::max(c[i].max, d[i].max));
      }
      low[row] = low[row - 1];
      high[row] = high[row - 1];
      T* to = out + 2 * coarser.cell_box.at({first.x, first.y + j / 2, first.z + k / 2});
      for (size_t i = 0; i < row; i += 2, to += 2) {
        to[0] = static_cast<T>(std::min(low[i], low[i + 1]));
        to[1] = static_cast<T>(std::max(high[i], high[i + 1]));
      }
    }
  }
}

}  // namespace

void coarsen_block(const Layer& layer, const GatheredBlock& block, const CoarserLayer& coarser) {
  const bool has_bytes = layer.bits == 8;
  if (layer.coarse_levels) {
    layer.coarse_levels->coarsen_voxels(layer, block, coarser);
  } else {
    has_bytes ? average_voxels<uint8_t>(layer, block, coarser)
              : average_voxels<uint16_t>(layer, block, coarser);
  }
  has_bytes ? unite_intervals<uint8_t>(block, coarser) : unite_intervals<uint16_t>(block, coarser);
}

}  // namespace isosplat
