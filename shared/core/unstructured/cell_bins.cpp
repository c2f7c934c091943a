#include "shared/core/unstructured/cell_bins.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

int32_t index_of(double position, int32_t count) {
  const double most = count - 1;
  return static_cast<int32_t>(std::clamp(std::floor(position), 0.0, most));
}

/// Calls visit(bin) for the bins that a box overlaps, also those that it only touches.
template <class Visit>
void for_each_bin(const BinGrid& grid, const Box& box, const Visit& visit) {
  const auto [low, high] = grid.bins_of(box);
  for (int32_t z = low.z; z <= high.z; ++z) {
    for (int32_t y = low.y; y <= high.y; ++y) {
      for (int32_t x = low.x; x <= high.x; ++x) visit(grid.flat({x, y, z}));
    }
  }
}

}  // namespace

Index3 BinGrid::bin_of(Vec3d point) const {
  const Vec3d p = point - origin;
  return {index_of(p.x / spacing.x, bins.x), index_of(p.y / spacing.y, bins.y),
          index_of(p.z / spacing.z, bins.z)};
}

std::pair<Index3, Index3> BinGrid::bins_of(const Box& box) const {
  const Vec3d margin = spacing * 1e-5;
  return {bin_of(box.low - margin), bin_of(box.high + margin)};
}

Result<Bins> Bins::create(const BinGrid& grid, size_t items,
                          const std::function<std::optional<Box>(size_t)>& box,
                          uint64_t memory_bytes) {
  const auto too_large = [&] {
    return fail(Status::out_of_memory,
                "an unstructured grid: expected cells whose search table "
                "needs at most " +
                    std::to_string(memory_bytes >> 20) + " MiB, found more: raise --memory");
  };
  Bins bins;
  bins.grid_ = grid;
  uint64_t left = memory_bytes;
  if (grid.count() + 1 > left / sizeof(uint64_t)) return too_large();
  left -= (grid.count() + 1) * sizeof(uint64_t);
  bins.begins_.assign(grid.count() + 1, 0);
  uint64_t total = 0;
  for (size_t i = 0; i < items; ++i) {
    const auto of_item = box(i);
    if (!of_item) continue;
    const auto [low, high] = grid.bins_of(*of_item);
    total += uint64_t{1} * static_cast<uint64_t>(high.x - low.x + 1) *
             static_cast<uint64_t>(high.y - low.y + 1) * static_cast<uint64_t>(high.z - low.z + 1);
    if (total > left / sizeof(uint32_t)) return too_large();
    for_each_bin(grid, *of_item, [&](size_t bin) { ++bins.begins_[bin + 1]; });
  }
  for (size_t i = 0; i < grid.count(); ++i) bins.begins_[i + 1] += bins.begins_[i];
  bins.items_.resize(static_cast<size_t>(total));
  // Filled from the end: begins_[bin + 1] moves to the bin's first item.
  for (size_t i = items; i-- > 0;) {
    const auto of_item = box(i);
    if (!of_item) continue;
    for_each_bin(grid, *of_item, [&](size_t bin) {
      bins.items_[static_cast<size_t>(--bins.begins_[bin + 1])] = static_cast<uint32_t>(i);
    });
  }
  std::rotate(bins.begins_.begin(), bins.begins_.begin() + 1, bins.begins_.end());
  bins.begins_.back() = total;
  return bins;
}

std::optional<Located> locate(const UnstructuredMesh& mesh, const Bins& cells, Vec3d point) {
  for (const uint32_t cell : cells.items(cells.grid().bin_of(point))) {
    const CellGeometry geometry = mesh.geometry(cell);
    Box box = box_of(geometry);
    const Vec3d margin = (box.high - box.low) * 1e-5;
    box.low = box.low - margin;
    box.high = box.high + margin;
    if (!box.contains(point)) continue;
    if (const auto weights = weights_in_cell(geometry, point)) {
      return Located{cell, mesh.value(cell, *weights)};
    }
  }
  return std::nullopt;
}

}  // namespace isosplat
