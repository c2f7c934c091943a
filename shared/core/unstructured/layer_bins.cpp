#include "shared/core/unstructured/layer_bins.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace isosplat {
namespace {

/// In edges: boxes that only touch a grid cell, but for rounding, are near it.
constexpr double kRounding = 1e-6;

int32_t index_of(double position, int32_t count) {
  return static_cast<int32_t>(std::clamp(std::floor(position), 0.0, count - 1.0));
}

}  // namespace

LayerBins::LayerBins(const LevelPlan& plan, size_t items, BoxOf box, double margin)
    : plan_(plan),
      count_(items),
      box_(std::move(box)),
      margin_(margin + kRounding),
      totals_(static_cast<size_t>(plan.cells.z)) {
  for (size_t item = 0; item < count_; ++item) {
    const auto range = range_of(item);
    if (!range) continue;
    const auto [low, high] = *range;
    const uint64_t each =
        static_cast<uint64_t>(high.x - low.x + 1) * static_cast<uint64_t>(high.y - low.y + 1);
    for (int32_t z = low.z; z <= high.z; ++z) totals_[static_cast<size_t>(z)] += each;
  }
}

std::optional<LayerBins::Range> LayerBins::range_of(size_t item) const {
  const auto box = box_(item);
  if (!box) return std::nullopt;
  const Vec3d low = box->low - plan_.origin, high = box->high - plan_.origin;
  const Vec3d edge = plan_.spacing;
  const Index3 n = plan_.cells;
  return Range{{index_of(low.x / edge.x - margin_, n.x), index_of(low.y / edge.y - margin_, n.y),
                index_of(low.z / edge.z - margin_, n.z)},
               {index_of(high.x / edge.x + margin_, n.x), index_of(high.y / edge.y + margin_, n.y),
                index_of(high.z / edge.z + margin_, n.z)}};
}

uint64_t LayerBins::layer_bytes(int32_t layer) const {
  return totals_[static_cast<size_t>(layer)] * sizeof(uint32_t) +
         static_cast<uint64_t>(plan_.cells.x) * static_cast<uint64_t>(plan_.cells.y) *
             sizeof(size_t);
}

/// Calls visit(item, bin) for the bins of the layers from first_ to before `last`.
template <class Visit>
void LayerBins::for_each(int32_t last, const Visit& visit) const {
  for (size_t item = 0; item < count_; ++item) {
    const auto range = range_of(item);
    if (!range) continue;
    const auto [low, high] = *range;
    for (int32_t z = std::max(low.z, first_); z <= std::min(high.z, last - 1); ++z) {
      for (int32_t y = low.y; y <= high.y; ++y) {
        for (int32_t x = low.x; x <= high.x; ++x) {
          visit(static_cast<uint32_t>(item), flat({x, y, z}));
        }
      }
    }
  }
}

void LayerBins::fill(int32_t first, int32_t last) {
  first_ = first;
  uint64_t total = 0;
  for (int32_t z = first; z < last; ++z) total += totals_[static_cast<size_t>(z)];
  const size_t bins = flat({0, 0, last});
  begins_.assign(bins + 1, 0);
  items_.resize(static_cast<size_t>(total));
  // At first begins_[bin + 1] counts the items of a bin. Then it is where its next one goes.
  for_each(last, [&](uint32_t, size_t bin) { ++begins_[bin + 1]; });
  size_t sum = 0;
  for (size_t bin = 0; bin < bins; ++bin) {
    const size_t own = begins_[bin + 1];
    begins_[bin + 1] = sum;
    sum += own;
  }
  for_each(last, [&](uint32_t item, size_t bin) { items_[begins_[bin + 1]++] = item; });
}

}  // namespace isosplat
