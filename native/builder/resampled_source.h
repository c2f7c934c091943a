#pragma once

#include <memory>

#include "native/builder/slice_window.h"

namespace isosplat {

/// How a resampled volume differs from the trilinear function of its voxels, at random points of
/// the new grid's cells.
struct ResamplingError {
  double max = 0, rms = 0;  ///< in value units, at points with values
  double outside = 0;       ///< share of the points that have no value
};

/// A volume at the voxels of another grid, by trilinear interpolation. Up to half a voxel beyond
/// its outermost voxels it has their values; farther outside, and where one of the voxels around
/// has no value, none. Its voxels are of type f32.
class ResampledSource : public VolumeSource {
 public:
  /// From the volume's voxels at `from`, which has as many voxels as the volume, to those of `to`.
  /// Of the volume's slices, those that one slice of `to` crosses are in memory; or all, if they
  /// are many or are read in descending order, and take at most a quarter of `memory_bytes`.
  /// Errors: out_of_memory if the slices that one crosses take more than half of `memory_bytes`.
  static Result<std::unique_ptr<ResampledSource>> create(std::unique_ptr<VolumeSource> volume,
                                                         const VolumeGrid& from,
                                                         const VolumeGrid& to,
                                                         uint64_t memory_bytes);

  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return read_rows({first, count, 0, header_.grid.voxels.y}, out);
  }
  bool reads_rows() const override { return true; }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override;
  uint64_t resident_bytes() const override;
  std::vector<std::filesystem::path> files() const override { return volume_->files(); }

  /// Measures at 4,096 points in 16 slabs of cells. Errors: those of the volume.
  Result<ResamplingError> measure();

 private:
  ResampledSource(std::unique_ptr<VolumeSource> volume, const VolumeGrid& from,
                  const VolumeGrid& to);

  struct Slices {
    int32_t first = 0, end = 0;  ///< empty: first = end
  };
  /// The volume's slices around the slices [first, end − 1] of the grid, or around rows of them.
  Slices crossed(double first, double last, double first_row, double last_row) const;
  Result<void> hold(Slices slices);
  /// The volume's value at a position in voxels of the grid. The window holds its slices.
  float value(Vec3d index) const;

  std::unique_ptr<VolumeSource> volume_;
  VolumeHeader header_;
  Matrix3d to_volume_;  ///< from an index of the grid to one of the volume, with offset_
  Vec3d offset_;
  bool holds_all_ = false;
  int32_t most_slices_ = 0;  ///< that one slice of the grid crosses
  SliceWindow window_;
};

}  // namespace isosplat
