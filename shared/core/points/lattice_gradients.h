#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/grid/grid.h"
#include "shared/core/sampling/trilinear.h"

namespace isosplat {

/// A lattice point (a cell's corner) of a block, and a sum of gradients there.
struct LatticeGradient {
  uint32_t point = 0;          ///< in the block: x | y << 7 | z << 14, each 0 to kBlockCells
  std::array<int32_t, 3> sum;  ///< quantized values per cell
};

/// The sums that a block's cells contribute to the lattice points that it shares with its
/// neighbours: a list for each neighbour, by direction_index(). 16 bytes per lattice point.
using BlockBorder = std::array<std::vector<LatticeGradient>, 27>;

/// The index of the neighbour at this offset in blocks, each −1 to 1.
constexpr size_t direction_index(Index3 offset) {
  return static_cast<size_t>(13 + offset.x + 3 * offset.y + 9 * offset.z);
}

/// Smooth gradients in one block: at each lattice point the sum of the gradients of the cells
/// around it, interpolated trilinearly. They are those of SmoothGradients (one level), and
/// continuous across blocks if the borders of all neighbours were added. Memory: 4.4 MB.
class LatticeGradients {
 public:
  LatticeGradients();

  /// Adds the cells of a block. remove() makes the sums zero again: it is faster than clearing all.
  void add(const DecodedCells& cells);
  void remove(const DecodedCells& cells);

  /// Adds the border of the neighbour at this offset in blocks, each −1 to 1.
  void add(const BlockBorder& neighbour, Index3 offset);
  void remove(const BlockBorder& neighbour, Index3 offset);

  /// The sums of a block's cells at the lattice points that it shares with neighbours. All sums
  /// must be zero before; they are zero afterwards.
  BlockBorder border_of(const DecodedCells& cells);

  /// The direction of the gradient at a point of a cell (as in DecodedCells), in_cell ∈ [0, 1]³.
  /// Its length has no meaning. Zero where no cell contributes.
  Vec3f at(uint32_t cell, Vec3f in_cell) const;

 private:
  static constexpr size_t kPoints = kBlockCells + 1;

  /// Of 16 bytes, so that a sum is one vector register.
  struct alignas(16) Sum {
    int32_t x = 0, y = 0, z = 0, unused = 0;
  };

  static size_t first_corner(uint32_t cell) {
    return (cell & 63) + kPoints * ((cell >> 6 & 63) + kPoints * (cell >> 12 & 63));
  }
  static constexpr size_t corner_offset(int corner) {
    return static_cast<size_t>(corner & 1) + kPoints * static_cast<size_t>(corner >> 1 & 1) +
           kPoints * kPoints * static_cast<size_t>(corner >> 2);
  }
  void add_cell(uint32_t cell, const CellCorners& corners);

  /// Calls f(sum, gradient) for each lattice point of the border of a neighbour.
  template <class F>
  void for_border(const BlockBorder& neighbour, Index3 offset, const F& f);

  std::vector<Sum> sums_;
};

}  // namespace isosplat
