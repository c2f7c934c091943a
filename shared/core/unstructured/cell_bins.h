#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/unstructured/mesh.h"

namespace isosplat {

/// Evenly spaced boxes over a mesh.
struct BinGrid {
  Index3 bins;
  Vec3d origin, spacing;

  size_t count() const {
    return static_cast<size_t>(bins.x) * static_cast<size_t>(bins.y) * static_cast<size_t>(bins.z);
  }
  size_t flat(Index3 bin) const {
    return (static_cast<size_t>(bin.z) * static_cast<size_t>(bins.y) + static_cast<size_t>(bin.y)) *
               static_cast<size_t>(bins.x) +
           static_cast<size_t>(bin.x);
  }
  /// The bin of a point; of the nearest bin for points outside.
  Index3 bin_of(Vec3d point) const;
  /// The first and the last bin along each axis that a box overlaps, also those that it only
  /// touches.
  std::pair<Index3, Index3> bins_of(const Box& box) const;
};

/// For each bin, the items whose boxes overlap it.
class Bins {
 public:
  /// `box`: that of an item; nothing for items that are left out. `memory_bytes`: limit. Errors:
  /// out_of_memory.
  static Result<Bins> create(const BinGrid& grid, size_t items,
                             const std::function<std::optional<Box>(size_t)>& box,
                             uint64_t memory_bytes);

  const BinGrid& grid() const { return grid_; }
  std::span<const uint32_t> items(Index3 bin) const {
    const size_t i = grid_.flat(bin);
    const auto begin = static_cast<size_t>(begins_[i]);
    return std::span(items_).subspan(begin, static_cast<size_t>(begins_[i + 1]) - begin);
  }
  uint64_t memory_bytes() const {
    return begins_.size() * sizeof(uint64_t) + items_.size() * sizeof(uint32_t);
  }

 private:
  BinGrid grid_;
  std::vector<uint64_t> begins_;
  std::vector<uint32_t> items_;
};

/// A point in a cell of the mesh.
struct Located {
  uint32_t cell = 0;
  double value = 0;
};

/// The first cell around a point, and the value there. Nothing outside of the mesh.
std::optional<Located> locate(const UnstructuredMesh& mesh, const Bins& cells, Vec3d point);

}  // namespace isosplat
