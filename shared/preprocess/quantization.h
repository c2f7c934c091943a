#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/volume_header.h"
#include "shared/preprocess/voxel_scan.h"

namespace isosplat {

/// How a volume's voxels become quantized values, and what values the quantized values stand for.
///
/// Quantized values rise with the *values*: where the slope is negative, the greatest voxel has
/// quantized value 0. So an interval of quantized values is an interval of values, and "active
/// where min ≤ isovalue < max" means the same for both.
class Quantization {
 public:
  /// What the store records: value = offset + scale · quantized value.
  const ValueMapping& mapping() const { return mapping_; }

  /// Turns native-endian voxels into quantized values, as many as `voxels` holds. `codes` points to
  /// bytes where mapping().bits is 8, else to 16-bit numbers. It may be the same memory as `voxels`
  /// where quantized values are as wide as voxels.
  void encode(std::span<const std::byte> voxels, void* quantized_values) const;

  friend Result<Quantization> choose_quantization(const VolumeHeader& header, const VoxelScan& scan,
                                                  double max_error);

 private:
  template <class T>
  QuantizedValue quantize(T voxel) const;
  template <class T>
  void encode_typed(const T* voxels, size_t count, void* quantized_values) const;

  VoxelType type_ = VoxelType::u8;
  ValueMapping mapping_;
  bool is_plain_ = false;      ///< integers that are their own quantized values, but for a constant
  bool is_quantized_ = false;  ///< places are numbers of double precision; else integers
  bool is_reversed_ =
      false;  ///< the slope is negative: the quantized value is (first − voxel) / step
  uint64_t first_key_ = 0;             ///< the voxel of quantized value 0: of integers, as a key
  uint64_t step_ = 1;                  ///< between two quantized values
  double first_ = 0, pitch_ = 1;       ///< the same, where places are numbers of double precision
  QuantizedValue max_ = 0;             ///< no voxel with a value has a greater quantized value
  std::vector<QuantizedValue> table_;  ///< of narrow integers that are not plain, by their bits
};

/// Chooses quantized values:
/// - integers of up to 16 bits, and wider ones whose range allows, are kept: a step of the
/// quantized value is
///   what all differences are multiples of;
/// - floating-point numbers that lie on an even lattice of up to 65536 values, too
/// (value_lattice.h);
/// - all others are quantized evenly to 65535 quantized values over the range.
/// Quantized values have 8 bits where that is enough, except that integers which are their own
/// quantized values keep the bits they have. `scan`: of all voxels, or a settled one.
///
/// `max_error`, in the volume's values: 0 for the above; otherwise as few quantized values as leave
/// no value further from the voxel's. Errors: invalid_argument where `max_error` cannot be reached,
/// with the least that can; malformed_volume for a slope with which values cannot be told apart.
Result<Quantization> choose_quantization(const VolumeHeader& header, const VoxelScan& scan,
                                         double max_error = 0);

}  // namespace isosplat
