#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/adaptive/cell_bricks.h"
#include "shared/core/base/status.h"

namespace isosplat {

/// A box of cells: the first cell, and one after the last along each axis.
struct CellBox {
  Index3 low, high;

  int64_t cells() const { return int64_t{high.x - low.x} * (high.y - low.y) * (high.z - low.z); }
};

/// The largest ratio between the cells of two consecutive refinement levels.
inline constexpr int32_t kMaxRefinement = 16;
inline constexpr size_t kMaxRefinementLevels = 32;

/// Where the values of an adaptive grid are.
enum class Centring : uint8_t { cells, nodes };

/// An adaptive grid (AMR, adaptive mesh refinement): patches, which are boxes of cells, on several
/// refinement levels. Level 0 is the coarsest; a cell of level l has ratio³ cells of level l + 1.
/// Where patches of several levels overlap, the finest one is valid: the domain consists of *leaf
/// cells* of all levels, each with the size of its level.
///
/// Memory is proportional to the cells of the patches, rounded up to bricks of 8³ cells.
class AdaptiveGrid {
 public:
  /// `cells`: of level 0 along each axis, from 0. `ratios`: of each level to the next finer one;
  /// there is one more level than ratios. `memory_bytes`: limit of the memory of all cells. Errors:
  /// volume_too_large, invalid_argument.
  static Result<AdaptiveGrid> create(Index3 cells, std::span<const int32_t> ratios,
                                     Centring centring, uint64_t memory_bytes);

  /// Adds a patch. `values`: one for each cell, or for each of the (n + 1)³ nodes of a grid with
  /// Centring::nodes; x fastest, then y, then z. A cell with a value that is not finite is a hole,
  /// also if a coarser cell there has one. Where patches of one level overlap, the first is valid.
  /// Errors: malformed_volume (outside of the domain, or empty), out_of_memory.
  Result<void> add(uint32_t level, const CellBox& box, std::span<const double> values);

  /// Finds the leaf cells, after all patches have been added. Finer cells that cover a cell with
  /// data only in part are dropped; returns their number.
  uint64_t resolve();

  /// Appends a level without patches.
  void add_level(int32_t ratio);

  /// Counts the memory of the bricks of a box that do not exist in `bricks`, those of a level,
  /// before they are added. Errors: out_of_memory.
  Result<void> reserve(const CellBricks& bricks, const CellBox& box) {
    return reserve(bricks, box, cell_brick_bytes());
  }

  uint32_t levels() const { return static_cast<uint32_t>(levels_.size()); }
  /// The ratio of a level to the next finer one.
  int32_t ratio(uint32_t level) const { return ratios_[level]; }
  /// The number of cells of level `fine` along an edge of a cell of level `coarse` ≤ `fine`.
  int32_t cells_per_edge(uint32_t coarse, uint32_t fine) const;
  /// The cells of a level along each axis of the domain.
  Index3 cells(uint32_t level) const;
  bool is_inside(uint32_t level, Index3 cell) const;
  uint64_t memory_bytes() const { return bytes_; }
  uint64_t memory_limit() const { return limit_; }
  Centring centring() const { return centring_; }

  const CellBricks& bricks(uint32_t level) const { return levels_[level].cells; }
  CellBricks& bricks(uint32_t level) { return levels_[level].cells; }

  /// The value of a leaf cell. Requires Centring::cells.
  double cell_value(uint32_t level, Index3 cell) const {
    return levels_[level].cells.find(cell)->values[CellBricks::index(cell)];
  }
  /// The value of a node of a leaf cell. Requires Centring::nodes.
  double node_value(uint32_t level, Index3 node) const {
    return levels_[level].nodes.find(node)->values[CellBricks::index(node)];
  }

 private:
  struct Level {
    CellBricks cells;
    CellBricks nodes;  ///< with Centring::nodes: the values of nodes; a node is leaf or none
  };

  AdaptiveGrid() = default;
  /// With Centring::nodes, bricks of cells have no values.
  uint64_t cell_brick_bytes() const {
    return centring_ == Centring::cells ? kBrickBytes : kEmptyBrickBytes;
  }
  Result<void> reserve(const CellBricks& bricks, const CellBox& box, uint64_t brick_bytes);
  Result<void> take(uint64_t bytes);
  Result<void> add_cell(Level& to, Index3 cell, std::span<const double> values);
  Index3 cells_;
  std::vector<int32_t> ratios_;
  std::vector<Level> levels_;
  Centring centring_ = Centring::cells;
  uint64_t bytes_ = 0, limit_ = 0;
};

}  // namespace isosplat
