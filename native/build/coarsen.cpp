#include "native/build/coarsen.h"

#include <algorithm>
#include <array>
#include <type_traits>

namespace isosplat {
namespace {

/// The coarse voxels that a block is responsible for along one axis: [begin, end). The last block
/// also has the level's last voxel.
struct Span1 {
  int32_t begin, end;
};

Span1 coarse_voxels(int32_t block, int32_t block_cells, int32_t cells, int32_t coarse_cells) {
  const int32_t begin = block * (kBlockCells / 2);
  const bool is_last = block * kBlockCells + block_cells == cells;
  return {begin, is_last ? coarse_cells + 1 : begin + kBlockCells / 2};
}

/// Voxels at the places 2c − 1, 2c, 2c + 1, where 2c is at most the last place, as are the others.
std::array<int32_t, 3> neighbours(int32_t coarse, int32_t last) {
  const int32_t centre = std::min(2 * coarse, last);
  return {std::max(centre - 1, 0), centre, std::min(centre + 1, last)};
}

constexpr std::array<uint32_t, 3> kWeight = {1, 2, 1};

/// Sums of a row of the volume along x with a place more at either end. Four times four times the
/// greatest code fits 16 bits where codes have eight: vectors hold twice as many.
template <class T>
struct PaddedRow {
  using Sum = std::conditional_t<sizeof(T) == 1, uint16_t, uint32_t>;
  std::array<Sum, kBlockCells + 4> sum, weight;
};

template <class T>
void average_voxels(const Layer& layer, const GatheredBlock& block, const CoarserLayer& coarser) {
  const Index3 cells = layer.grid.cells, coarse = coarser.grid.cells;
  const auto nx = static_cast<size_t>(cells.x + 1), ny = static_cast<size_t>(cells.y + 1);
  const auto* slices = reinterpret_cast<const T*>(layer.voxels);
  auto* out = reinterpret_cast<T*>(coarser.voxels);
  const auto out_nx = static_cast<size_t>(coarse.x + 1), out_ny = static_cast<size_t>(coarse.y + 1);
  const Span1 xs = coarse_voxels(block.index.x, block.cells.x, cells.x, coarse.x);
  const Span1 ys = coarse_voxels(block.index.y, block.cells.y, cells.y, coarse.y);
  const Span1 zs = coarse_voxels(block.index.z, block.cells.z, cells.z, coarse.z);
  // Fine places along x that the row needs, clamped into the volume.
  const int32_t first_x = std::max(2 * xs.begin - 1, 0);
  const int32_t last_x = std::min(2 * (xs.end - 1) + 1, cells.x);
  const auto count = static_cast<size_t>(last_x - first_x + 1);
  using Sum = typename PaddedRow<T>::Sum;
  PaddedRow<T> row;
  for (int32_t k = zs.begin; k < zs.end; ++k) {
    const auto z_places = neighbours(k, cells.z);
    for (int32_t j = ys.begin; j < ys.end; ++j) {
      const auto y_places = neighbours(j, cells.y);
      row.sum.fill(0);
      if (layer.has_missing) row.weight.fill(0);
      for (size_t dz = 0; dz < 3; ++dz) {
        for (size_t dy = 0; dy < 3; ++dy) {
          const auto weight = static_cast<Sum>(kWeight[dz] * kWeight[dy]);
          const T* from = slices +
                          (static_cast<size_t>(z_places[dz] - layer.first_voxel_slice) * ny +
                           static_cast<size_t>(y_places[dy])) *
                              nx +
                          static_cast<size_t>(first_x);
          if (layer.has_missing) {
            for (size_t i = 0; i < count; ++i) {
              const Sum w = from[i] == kMissingCode ? Sum{0} : weight;
              row.sum[i] = static_cast<Sum>(row.sum[i] + w * from[i]);
              row.weight[i] = static_cast<Sum>(row.weight[i] + w);
            }
          } else {
            for (size_t i = 0; i < count; ++i) {
              row.sum[i] = static_cast<Sum>(row.sum[i] + weight * from[i]);
            }
          }
        }
      }
      T* to =
          out +
          (static_cast<size_t>(k - coarser.first_voxel_slice) * out_ny + static_cast<size_t>(j)) *
              out_nx +
          static_cast<size_t>(xs.begin);
      for (int32_t i = xs.begin; i < xs.end; ++i, ++to) {
        const auto places = neighbours(i, cells.x);
        uint32_t sum = 0, weight = 0;
        for (size_t dx = 0; dx < 3; ++dx) {
          const auto at = static_cast<size_t>(places[dx] - first_x);
          sum += kWeight[dx] * row.sum[at];
          if (layer.has_missing) weight += kWeight[dx] * row.weight[at];
        }
        if (!layer.has_missing) {
          *to = static_cast<T>((sum + 32) >> 6);
        } else {
          *to = static_cast<T>(weight ? (sum + weight / 2) / weight : kMissingCode);
        }
      }
    }
  }
}

template <class T>
void unite_intervals(const GatheredBlock& block, const CoarserLayer& coarser) {
  const Index3 coarse = coarser.grid.cells;
  auto* out = reinterpret_cast<T*>(coarser.intervals);
  const auto row = static_cast<size_t>(block.cells.x);
  const size_t slice = row * static_cast<size_t>(block.cells.y);
  std::array<Code, kBlockCells + 1> low, high;
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
      const auto z =
          static_cast<size_t>(block.index.z * (kBlockCells / 2) + k / 2 - coarser.first_cell_slice);
      const auto y = static_cast<size_t>(block.index.y * (kBlockCells / 2) + j / 2);
      T* to = out + 2 * ((z * static_cast<size_t>(coarse.y) + y) * static_cast<size_t>(coarse.x) +
                         static_cast<size_t>(block.index.x * (kBlockCells / 2)));
      for (size_t i = 0; i < row; i += 2, to += 2) {
        to[0] = static_cast<T>(std::min(low[i], low[i + 1]));
        to[1] = static_cast<T>(std::max(high[i], high[i + 1]));
      }
    }
  }
}

}  // namespace

void coarsen_block(const Layer& layer, const GatheredBlock& block, const CoarserLayer& coarser) {
  if (layer.bits == 8) {
    average_voxels<uint8_t>(layer, block, coarser);
    unite_intervals<uint8_t>(block, coarser);
  } else {
    average_voxels<uint16_t>(layer, block, coarser);
    unite_intervals<uint16_t>(block, coarser);
  }
}

}  // namespace isosplat
