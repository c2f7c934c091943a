#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/volume_header.h"
#include "shared/preprocess/voxel_scan.h"

namespace isosplat {

/// How a volume's voxels become codes, and what values the codes stand for.
///
/// Codes rise with the *values*: where the slope is negative, the greatest voxel has code 0. So an
/// interval of codes is an interval of values, and "active where min ≤ isovalue < max" means the
/// same for both.
class ValueCodes {
 public:
  /// What the store records: value = offset + scale · code.
  const ValueMapping& mapping() const { return mapping_; }

  /// Turns native-endian voxels into codes, as many as `voxels` holds. `codes` points to bytes
  /// where mapping().bits is 8, else to 16-bit numbers. It may be the same memory as `voxels` where
  /// codes are as wide as voxels.
  void encode(std::span<const std::byte> voxels, void* codes) const;

  friend Result<ValueCodes> choose_codes(const VolumeHeader& header, const VoxelScan& scan,
                                         double max_error);

 private:
  template <class T>
  Code code_of(T voxel) const;
  template <class T>
  void encode_typed(const T* voxels, size_t count, void* codes) const;

  VoxelType type_ = VoxelType::u8;
  ValueMapping mapping_;
  bool is_plain_ = false;         ///< integers that are their own codes, but for a constant
  bool is_quantised_ = false;     ///< places are numbers of double precision; else integers
  bool is_reversed_ = false;      ///< the slope is negative: the code is (first − voxel) / step
  uint64_t first_key_ = 0;        ///< the voxel of code 0: of integers, as a key
  uint64_t step_ = 1;             ///< between two codes
  double first_ = 0, pitch_ = 1;  ///< the same, where places are numbers of double precision
  Code most_ = 0;                 ///< no voxel with a value has a greater code
  std::vector<Code> table_;       ///< of narrow integers that are not plain, by their bits
};

/// Chooses codes:
/// - integers of up to 16 bits, and wider ones whose range allows, are kept: a step of the code is
///   what all differences are multiples of;
/// - floating-point numbers that lie on an even lattice of up to 65536 values, too
/// (value_lattice.h);
/// - all others are quantised evenly to 65535 codes over the range.
/// Codes have 8 bits where that is enough, except that integers which are their own codes keep the
/// bits they have. `scan`: of all voxels, or a settled one.
///
/// `max_error`, in the volume's values: 0 for the above; otherwise as few codes as leave no value
/// further from the voxel's. Errors: invalid_argument where `max_error` cannot be reached, with the
/// least that can; malformed_volume for a slope with which values cannot be told apart.
Result<ValueCodes> choose_codes(const VolumeHeader& header, const VoxelScan& scan,
                                double max_error = 0);

}  // namespace isosplat
