#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "native/builder/slice_window.h"

namespace isosplat {

/// A scalar that follows from a volume.
enum class Derived : uint8_t {
  gradient,  ///< the magnitude of the gradient in the world, in value units per unit of length
  /// The mean curvature of the isosurface through each voxel, in 1 / unit of length: above 0 where
  /// it bends around greater values, as on a ball with greater values inside. At most 1 / the
  /// shortest edge of a cell, since voxels resolve nothing smaller.
  curvature,
};

/// "gradient" or "curvature". No value for other texts.
std::optional<Derived> derived_of(std::string_view text);

/// A derived scalar at each voxel of a volume, by central differences, on the volume's border by
/// those one voxel inside. No value where one of the voxels around has none, and no curvature where
/// the gradient is 0. (Kindlmann et al. 2003, "Curvature-based transfer functions", section 3.)
class DerivedSource : public VolumeSource {
 public:
  DerivedSource(std::unique_ptr<VolumeSource> volume, Derived derived);

  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override;
  uint64_t resident_bytes() const override {
    return volume_->resident_bytes() + window_.memory_bytes(3);
  }
  std::vector<std::filesystem::path> files() const override { return volume_->files(); }

 private:
  double value(Index3 voxel) const;

  std::unique_ptr<VolumeSource> volume_;
  VolumeHeader header_;
  Derived derived_;
  SliceWindow window_;
  Matrix3d dual_edges_;
  double most_curvature_;
};

}  // namespace isosplat
