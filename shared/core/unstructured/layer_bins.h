#pragma once

#include <functional>
#include <vector>

#include "shared/core/unstructured/level_plan.h"

namespace isosplat {

/// Cells or faces of a mesh by the grid cells of level 0 that their boxes overlap, for some layers
/// of grid cells at a time.
class LayerBins {
 public:
  /// The box of an item; nothing for items that are left out.
  using BoxOf = std::function<std::optional<Box>(size_t)>;

  /// Counts the items of each layer along z. `margin`: in edges of grid cells, by which the boxes
  /// of items are extended.
  LayerBins(const LevelPlan& plan, size_t items, BoxOf box, double margin);

  /// The memory of a layer's lists, in bytes.
  uint64_t layer_bytes(int32_t layer) const;

  /// Makes the lists of the layers from `first` to before `last`.
  void fill(int32_t first, int32_t last);

  /// The items near a grid cell of these layers, in ascending order.
  std::span<const uint32_t> items(Index3 cell) const {
    const size_t i = flat(cell);
    return std::span(items_).subspan(begins_[i], begins_[i + 1] - begins_[i]);
  }

 private:
  struct Range {
    Index3 low, high;  ///< the first and the last grid cell
  };
  std::optional<Range> range_of(size_t item) const;
  size_t flat(Index3 cell) const {
    return (static_cast<size_t>(cell.z - first_) * static_cast<size_t>(plan_.cells.y) +
            static_cast<size_t>(cell.y)) *
               static_cast<size_t>(plan_.cells.x) +
           static_cast<size_t>(cell.x);
  }
  template <class Visit>
  void for_each(int32_t last, const Visit& visit) const;

  LevelPlan plan_;
  size_t count_;
  BoxOf box_;
  double margin_;
  std::vector<uint64_t> totals_;  ///< of each layer
  int32_t first_ = 0;
  std::vector<size_t> begins_;
  std::vector<uint32_t> items_;
};

}  // namespace isosplat
