#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_header.h"
#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {

/// Converts a volume's voxels to quantized values, and states which values these stand for.
///
/// Quantized values rise with the *values*: where the slope is negative, the greatest voxel has
/// quantized value 0. So an interval of quantized values is an interval of values, and "active
/// where min ≤ isovalue < max" means the same for both.
class Quantization {
 public:
  /// The mapping that the store records: value = offset + scale · quantized value.
  const ValueMapping& mapping() const { return mapping_; }

  /// Converts native-endian voxels to quantized values, one for each voxel. `quantized_values`
  /// points to 8-bit numbers if mapping().bits is 8, otherwise to 16-bit numbers. It may be the
  /// same memory as `voxels` if both have the same width.
  void encode(std::span<const std::byte> voxels, void* quantized_values) const;

  friend Result<Quantization> choose_quantization(const VolumeHeader& header, const VoxelScan& scan,
                                                  double max_error);

 private:
  template <class T>
  QuantizedValue quantize(T voxel) const;
  template <class T>
  void encode_typed(const T* voxels, size_t count, void* quantized_values) const;
  void fill_table();

  VoxelType type_ = VoxelType::u8;
  ValueMapping mapping_;
  bool is_plain_ = false;  ///< quantized value = integer − constant
  /// True: first_ and pitch_ are used (double precision). False: first_key_ and step_ (integers).
  bool is_quantized_ = false;
  /// The slope is negative: the quantized value is (first − voxel) / step.
  bool is_reversed_ = false;
  uint64_t first_key_ = 0;        ///< key (key_of) of the voxel with quantized value 0
  uint64_t step_ = 1;             ///< between two quantized values
  double first_ = 0, pitch_ = 1;  ///< first_key_ and step_ in double precision
  QuantizedValue max_ = 0;        ///< no voxel with a value has a greater quantized value
  /// Look-up by the voxel's bits, for 8- and 16-bit integers that are not plain.
  std::vector<QuantizedValue> table_;
};

/// Chooses quantized values:
/// - Integers of up to 16 bits, and wider ones whose range is small enough, are kept without loss.
///   One quantized step is the greatest common divisor of all differences.
/// - So are floating-point numbers on an evenly spaced lattice of at most 65536 values
///   (value_lattice.h).
/// - All others are rounded to 65535 evenly spaced values over the range.
/// Quantized values have 8 bits if 256 values suffice. But integers that are their own quantized
/// values keep their number of bits. scan: of all voxels, or of a part of them if it is_settled().
///
/// max_error, in the volume's values: if it is greater than 0, there may be fewer quantized values;
/// no stored value differs from the voxel's by more than max_error. Errors:
/// invalid_argument (max_error is too small; the message states the smallest possible one),
/// malformed_volume (with this slope, different voxels get equal values).
Result<Quantization> choose_quantization(const VolumeHeader& header, const VoxelScan& scan,
                                         double max_error = 0);

}  // namespace isosplat
