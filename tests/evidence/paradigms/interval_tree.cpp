#include "tests/evidence/paradigms/interval_tree.h"

#include <algorithm>

namespace isosplat {

IntervalTree::IntervalTree(std::vector<Cell> cells) {
  std::erase_if(cells, [](const Cell& cell) { return cell.interval.min >= cell.interval.max; });
  by_min_.reserve(cells.size());
  by_max_.reserve(cells.size());
  root_ = make(cells);
}

std::unique_ptr<IntervalTree::Node> IntervalTree::make(std::span<Cell> cells) {
  if (cells.empty()) return nullptr;
  auto node = std::make_unique<Node>();
  ++nodes_;
  // The value is the median of the lower ends: at least one cell contains it, and each subtree has
  // at most half of the cells.
  const auto middle = cells.begin() + static_cast<ptrdiff_t>(cells.size() / 2);
  std::ranges::nth_element(cells, middle, {}, [](const Cell& cell) { return cell.interval.min; });
  const QuantizedValue value = middle->interval.min;
  node->value = value;
  const auto below = std::ranges::partition(
      cells, [value](const Cell& cell) { return cell.interval.max <= value; });
  const auto begin_of_here = below.begin();
  const auto above = std::ranges::partition(
      below, [value](const Cell& cell) { return cell.interval.min <= value; });
  const std::span here(begin_of_here, above.begin());
  node->first = by_min_.size();
  node->count = here.size();
  for (const Cell& cell : here) {
    by_min_.push_back({cell.id, cell.interval.min});
    by_max_.push_back({cell.id, cell.interval.max});
  }
  const auto begin = static_cast<ptrdiff_t>(node->first);
  std::stable_sort(by_min_.begin() + begin, by_min_.end(),
                   [](const Entry& a, const Entry& b) { return a.bound < b.bound; });
  std::stable_sort(by_max_.begin() + begin, by_max_.end(),
                   [](const Entry& a, const Entry& b) { return a.bound > b.bound; });
  node->below = make({cells.begin(), begin_of_here});
  node->above = make({above.begin(), above.end()});
  return node;
}

size_t IntervalTree::memory() const {
  return (by_min_.size() + by_max_.size()) * sizeof(Entry) + nodes_ * sizeof(Node);
}

}  // namespace isosplat
