#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/core/sampling/cell.h"

namespace isosplat {

/// Finds the active cells of an isovalue in time proportional to their number (H. Edelsbrunner,
/// "Dynamic data structures for orthogonal intersection queries", 1980; for isosurfaces: P.
/// Cignoni, P. Marino, C. Montani, E. Puppo, R. Scopigno, "Speeding up isosurface extraction using
/// interval trees", IEEE TVCG 3 (2), 1997).
///
/// A node has a value, and the cells whose intervals contain it, in two orders: by ascending min
/// and by descending max. Cells below the value are in its left subtree, those above in its right
/// one. Memory: 16 bytes per cell.
class IntervalTree {
 public:
  struct Cell {
    CellInterval interval;  ///< cells with min = max are never active, and are left out
    uint32_t id = 0;
  };

  explicit IntervalTree(std::vector<Cell> cells);

  /// Calls use(id) for each cell with min ≤ isovalue < max, each once, in no particular order.
  template <class Use>
  void for_each_active(float isovalue, const Use& use) const {
    const Node* node = root_.get();
    while (node) {
      if (isovalue < static_cast<float>(node->value)) {
        for (const Entry& entry : entries_of(by_min_, *node)) {
          if (static_cast<float>(entry.bound) > isovalue) break;
          use(entry.id);
        }
        node = node->below.get();
      } else {
        for (const Entry& entry : entries_of(by_max_, *node)) {
          if (static_cast<float>(entry.bound) <= isovalue) break;
          use(entry.id);
        }
        node = node->above.get();
      }
    }
  }

  /// The size of the tree in bytes.
  size_t memory() const;

 private:
  struct Node {
    QuantizedValue value = 0;
    size_t first = 0, count = 0;  ///< in by_min_ and by_max_
    std::unique_ptr<Node> below, above;
  };
  struct Entry {
    uint32_t id = 0;
    QuantizedValue bound = 0;  ///< min in by_min_, max in by_max_
  };

  static std::span<const Entry> entries_of(const std::vector<Entry>& entries, const Node& node) {
    return std::span(entries).subspan(node.first, node.count);
  }
  std::unique_ptr<Node> make(std::span<Cell> cells);

  std::vector<Entry> by_min_, by_max_;
  size_t nodes_ = 0;
  std::unique_ptr<Node> root_;
};

}  // namespace isosplat
