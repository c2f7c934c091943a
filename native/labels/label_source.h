#pragma once

#include <memory>

#include "native/labels/label_scan.h"
#include "shared/core/preprocess/label_field.h"
#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {

/// The surface of a label.
enum class LabelSurface : uint8_t {
  smooth,  ///< of its field (label_field.h)
  raw      ///< of its indicator: kLabelFieldInside in its voxels, 0 elsewhere
};

/// The grid of a label's volume: its bounding box and kLabelFieldReach voxels around it, or up to
/// three more after it, so that the cells of level 2 fill the box. Positions are those in the
/// world. `grid`: of all labels.
VolumeGrid label_grid(const VolumeGrid& grid, const FoundLabel& label);

/// A label as a volume of 8 bits on its label_grid(). Its isosurface at kLabelFieldIsovalue is that
/// of the label.
class LabelSource : public VolumeSource {
 public:
  /// Borrows the rows of `volume`. `labels`: the header of the volume of all labels. `name`: of the
  /// label.
  LabelSource(const LabelVolume& volume, const VolumeHeader& labels, const FoundLabel& label,
              LabelSurface surface, std::string name);

  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override;
  uint64_t resident_bytes() const override;
  std::vector<std::filesystem::path> files() const override { return {}; }

  /// For StoreOptions::scan: the values of any label, so that a build does not read it twice.
  static std::shared_ptr<const VoxelScan> all_values();

 private:
  VolumeHeader header_;
  LabelVolume volume_;
  uint16_t label_;
  LabelBox box_;
  std::unique_ptr<LabelField> field_;  ///< null: raw
};

}  // namespace isosplat
