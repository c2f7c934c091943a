#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// The distance from the border of labels, at each voxel of their volume: negative inside, in units
/// of the world (signed_distances). It is computed when slices are first read, and is then in
/// memory.
class DistanceSource : public VolumeSource {
 public:
  /// The largest size of a label: beyond it, voxels of type f64 do not tell integers apart.
  static constexpr int64_t kMaxLabel = int64_t{1} << 53;

  /// `grid`: where the voxels of `volume` are, whatever its header states; of as many voxels.
  /// `labels`: whose border it is, as one region, up to ±kMaxLabel; empty: all values but 0. Voxels
  /// without a value have no label. `name`: of the field, for messages. Errors: out_of_memory if
  /// the distances, 4 bytes per voxel, take more than `memory_bytes`; unsupported_format for
  /// sheared grids.
  static Result<std::unique_ptr<DistanceSource>> create(const std::string& name,
                                                        std::unique_ptr<VolumeSource> volume,
                                                        const VolumeGrid& grid,
                                                        std::vector<int64_t> labels,
                                                        uint64_t memory_bytes);

  const VolumeHeader& header() const override { return header_; }
  /// Errors: those of the volume; malformed_volume for values that are not integers up to
  /// ±kMaxLabel, and if no voxel has the labels, or all have.
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override;
  uint64_t resident_bytes() const override;
  std::vector<std::filesystem::path> files() const override { return volume_->files(); }

 private:
  DistanceSource(const std::string& name, std::unique_ptr<VolumeSource> volume,
                 const VolumeGrid& grid, std::vector<int64_t> labels);
  bool has_label(double value) const;
  Result<void> compute();

  std::string name_;
  std::unique_ptr<VolumeSource> volume_;
  VolumeHeader header_;
  std::vector<int64_t> labels_;   ///< ascending
  std::vector<float> distances_;  ///< empty: not yet computed
};

}  // namespace isosplat
