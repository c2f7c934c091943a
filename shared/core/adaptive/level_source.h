#pragma once

#include <optional>
#include <vector>

#include "shared/core/adaptive/adaptive_grid.h"
#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// The lattice of a refinement level as a volume: the nodes of its drawn cells (drawn_cells.h), in
/// their bounding box. All other voxels are missing (NaN). The values are those of node_value().
///
/// Computes two layers of cells at a time, whatever the size of the volume.
class LevelSource : public VolumeSource {
 public:
  /// Borrows the grid, whose drawn cells are chosen. `header`: its grid has the nodes of level 0:
  /// the origin is the first corner of the first cell. Nothing if no cell of the level is drawn.
  static std::optional<LevelSource> create(const AdaptiveGrid& grid, uint32_t level,
                                           const VolumeHeader& header);

  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override;
  uint64_t resident_bytes() const override;
  std::vector<std::filesystem::path> files() const override { return {}; }

  uint32_t level() const { return level_; }
  /// The first node, in nodes of the level.
  Index3 low() const { return low_; }

 private:
  /// The cells that touch a slice on one side, with one more around them.
  struct Layer {
    int32_t z = -2;  ///< in cells of the level; -2: not read
    std::vector<double> values;
    std::vector<uint8_t> flags;
  };

  explicit LevelSource(const AdaptiveGrid& grid) : grid_(&grid) {}
  void read_layer(int32_t z, Layer& layer) const;
  void read_slice(int32_t z, double* out);

  const AdaptiveGrid* grid_;
  uint32_t level_ = 0;
  Index3 low_;
  VolumeHeader header_;
  Layer below_, above_;
};

}  // namespace isosplat
