#pragma once

#include <memory>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_source.h"
#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {

/// An interval of a volume's values: after slope and intercept. low < high.
struct ValueRange {
  double low = 0, high = 0;
};

/// Numbers of voxels that had values outside of a range.
struct ClampedVoxels {
  uint64_t below = 0, above = 0;
};

/// A volume whose values are limited to a range: those outside are set to its ends. Voxels without
/// a value stay so.
class ClampedSource : public VolumeSource {
 public:
  /// Borrows the volume. Errors: invalid_argument if voxels of its type cannot have two different
  /// values in the range.
  static Result<ClampedSource> create(VolumeSource& volume, ValueRange range);

  const VolumeHeader& header() const override { return volume_.header(); }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override;
  bool reads_rows() const override { return volume_.reads_rows(); }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override;
  uint64_t resident_bytes() const override { return volume_.resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return volume_.files(); }

  /// For StoreOptions::scan: any value of the range may occur, and voxels may have none. It does
  /// not depend on the volume's voxels.
  std::shared_ptr<const VoxelScan> all_values() const;

  /// Of the slices that were read, each once. Rows count if all before them in their slice were
  /// read before.
  ClampedVoxels clamped() const;
  /// The same for each slice; those that were not read have none.
  const std::vector<ClampedVoxels>& of_slices() const { return of_slices_; }
  /// Adds what another process has counted of this volume, as of_slices().
  void add_slices(std::span<const ClampedVoxels> of_slices);

 private:
  ClampedSource(VolumeSource& volume, double low, double high);

  VolumeSource& volume_;
  double low_, high_;  ///< in the file's voxels, before slope and intercept
  std::vector<ClampedVoxels> of_slices_;
  std::vector<int32_t> counted_rows_;  ///< per slice: the first rows, which of_slices_ counts
};

}  // namespace isosplat
