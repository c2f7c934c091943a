#pragma once

#include <memory>
#include <string>

#include "native/builder/slice_window.h"

namespace isosplat {

/// How a resampled volume differs from the trilinear function of its voxels, at random points of
/// the new grid's cells.
struct ResamplingError {
  double max = 0, rms = 0;  ///< in value units, at points with values
  double outside = 0;       ///< share of the points that have no value
};

struct ResamplingOptions {
  /// How far beyond its outermost voxels a resampled volume has values, theirs:
  double voxels = 0.5;     ///< up to this many of the volume's voxels,
  double grid_voxels = 0;  ///< and this many of the new grid's
  bool nearest = false;    ///< the values of the nearest voxels, such as labels
};

/// A volume at the voxels of another grid, by trilinear interpolation or by the nearest voxel.
/// Beyond the reach, and where one of the voxels around has no value, it has none. Its voxels are
/// of type f64.
class ResampledSource : public VolumeSource {
 public:
  /// From the volume's voxels at `from`, which has as many voxels as the volume, to those of `to`.
  /// Of the volume's slices, those that one slice of `to` crosses are in memory; or those that `to`
  /// crosses, if one crosses many or they are read in descending order, and if they take at most a
  /// quarter of `memory_bytes`. `name`: of the volume, for messages. Errors: out_of_memory if the
  /// slices that one crosses take more than half of `memory_bytes`.
  static Result<std::unique_ptr<ResampledSource>> create(
      const std::string& name, std::unique_ptr<VolumeSource> volume, const VolumeGrid& from,
      const VolumeGrid& to, uint64_t memory_bytes, const ResamplingOptions& options = {});

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
                  const VolumeGrid& to, const ResamplingOptions& options);

  /// A position in voxels of the volume.
  Vec3d in_volume(Vec3d index) const { return multiply(to_volume_, index) + offset_; }
  /// The volume's slices around slices or rows of the grid, from the first to the last; none if all
  /// are outside.
  Slices crossed(double first, double last, double first_row, double last_row) const;
  Result<void> hold(Slices slices);
  /// The volume's value at a position in voxels of the grid. The window holds its slices.
  double value(Vec3d index) const;

  std::unique_ptr<VolumeSource> volume_;
  VolumeHeader header_;
  Matrix3d to_volume_;  ///< from an index of the grid to one of the volume, with offset_
  Vec3d offset_;
  Vec3d reach_;              ///< beyond the outermost voxels, in voxels of the volume
  Slices all_;               ///< that the grid crosses, if all are held; else none
  int32_t most_slices_ = 0;  ///< that one slice of the grid crosses
  bool nearest_;
  SliceWindow window_;
};

}  // namespace isosplat
