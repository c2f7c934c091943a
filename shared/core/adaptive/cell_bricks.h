#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// What a cell of a refinement level is.
enum class CellState : uint8_t {
  none,     ///< no patch of its level has it
  leaf,     ///< it has a value, and no finer cell covers it
  hole,     ///< a patch has it without a value, and no finer cell covers it
  refined,  ///< finer cells lie in it
};

/// Cells of a brick along each axis.
inline constexpr int32_t kBrickCells = 8;
inline constexpr size_t kBrickVolume = 512;

/// 8³ cells of a refinement level: x fastest, then y, then z.
struct CellBrick {
  Index3 first;  ///< its first cell
  std::array<CellState, kBrickVolume> states{};
  std::bitset<kBrickVolume> drawn;  ///< the cells of the level's lattice (drawn_cells.h)
  std::vector<double> values;       ///< of its cells; empty: they have none
  std::vector<uint16_t> covered;    ///< while cells are resolved: their children that are full
  std::bitset<kBrickVolume> has_children;  ///< while cells are resolved
};

/// The bricks of a refinement level that have cells, by position.
class CellBricks {
 public:
  /// The index of a cell in its brick.
  static size_t index(Index3 cell) {
    return static_cast<size_t>(cell.x & 7) + 8 * static_cast<size_t>(cell.y & 7) +
           64 * static_cast<size_t>(cell.z & 7);
  }

  /// The brick of a cell, whose index is not negative; null if there is none.
  const CellBrick* find(Index3 cell) const {
    const auto found = bricks_.find(key(cell));
    return found == bricks_.end() ? nullptr : &found->second;
  }
  CellBrick* find(Index3 cell) { return const_cast<CellBrick*>(std::as_const(*this).find(cell)); }

  /// The brick of a cell, which is added if there is none. Bricks keep their addresses.
  CellBrick& at(Index3 cell) {
    const auto [found, is_new] = bricks_.try_emplace(key(cell));
    if (is_new) found->second.first = {cell.x & ~7, cell.y & ~7, cell.z & ~7};
    return found->second;
  }

  CellState state(Index3 cell) const {
    const CellBrick* const brick = find(cell);
    return brick ? brick->states[index(cell)] : CellState::none;
  }
  bool is_drawn(Index3 cell) const {
    const CellBrick* const brick = find(cell);
    return brick && brick->drawn[index(cell)];
  }

  size_t size() const { return bricks_.size(); }
  auto begin() { return bricks_.begin(); }
  auto end() { return bricks_.end(); }
  auto begin() const { return bricks_.begin(); }
  auto end() const { return bricks_.end(); }

 private:
  /// Cells have at most 2^20 per axis, so bricks need 17 bits.
  static uint64_t key(Index3 cell) {
    return static_cast<uint64_t>(cell.x >> 3) | static_cast<uint64_t>(cell.y >> 3) << 20 |
           static_cast<uint64_t>(cell.z >> 3) << 40;
  }

  std::unordered_map<uint64_t, CellBrick> bricks_;
};

/// The cell of index i of a brick.
inline Index3 cell_of(const CellBrick& brick, size_t i) {
  const auto n = static_cast<int32_t>(i);
  return brick.first + Index3{n & 7, n >> 3 & 7, n >> 6};
}

/// Memory of a brick without values, with that of the table, and of a brick with values.
inline constexpr uint64_t kEmptyBrickBytes =
    sizeof(CellBrick) + kBrickVolume * sizeof(uint16_t) + 64;
inline constexpr uint64_t kBrickBytes = kEmptyBrickBytes + kBrickVolume * sizeof(double);

}  // namespace isosplat
