#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/voxel_type.h"
#include "shared/core/preprocess/distinct_values.h"

namespace isosplat {

/// Collects the properties of voxels that determine their quantized values. Voxels are those of the
/// file, before slope and intercept.
class VoxelScan {
 public:
  explicit VoxelScan(VoxelType type) : type_(type) {}

  /// Adds native-endian voxels.
  void add(std::span<const std::byte> voxels);

  /// Adds the voxels of another scan of the same type.
  void add(const VoxelScan& other);

  /// Writes the scan as a message, and adds the scan of a message. Numbers are little-endian.
  /// Errors: invalid_argument (not such a message, or one of another type of voxels).
  std::vector<std::byte> bytes() const;
  Result<void> add_message(std::span<const std::byte> bytes);

  VoxelType type() const { return type_; }

  /// Whether there was no voxel with a value. Then the following functions are meaningless, except
  /// missing().
  bool is_empty() const { return is_empty_; }

  /// The number of voxels without a value: NaN, infinities, and doubles beyond ±1e300.
  uint64_t missing() const { return missing_; }

  /// The least and greatest voxel.
  double min() const;
  double max() const;

  /// For integers: the least and greatest voxel as keys (key_of), and the greatest common divisor
  /// of all differences, which is 0 if all voxels are equal.
  uint64_t low() const { return low_; }
  uint64_t high() const { return high_; }
  uint64_t step() const { return step_; }

  /// For floating-point numbers: the distinct voxels.
  const DistinctValues& distinct() const { return distinct_; }

  /// Whether more voxels cannot change the choice of quantized values: integers of up to 16 bits
  /// whose differences have no common divisor above 1 are their own quantized values.
  bool is_settled() const { return voxel_bytes(type_) <= 2 && step_ == 1; }

 private:
  template <class T>
  void add_integers(const T* voxels, size_t count);
  template <class T>
  void add_floats(const T* voxels, size_t count);

  VoxelType type_;
  bool is_empty_ = true;
  uint64_t missing_ = 0;
  uint64_t low_ = 0, high_ = 0, step_ = 0;
  double min_ = 0, max_ = 0;
  DistinctValues distinct_;
};

/// Whether the type's voxels are integers.
constexpr bool is_integer(VoxelType type) {
  return type != VoxelType::f32 && type != VoxelType::f64;
}

/// Maps integers of any type to unsigned ones in the same order, by adding 2^63 to signed ones.
template <class T>
constexpr uint64_t key_of(T voxel) {
  if constexpr (T(-1) > T(0)) return voxel;
  return static_cast<uint64_t>(static_cast<int64_t>(voxel)) ^ uint64_t { 1 } << 63;
}

/// The integer of a key, rounded to double precision.
double voxel_of_key(VoxelType type, uint64_t key);

/// Whether a voxel has a value. Doubles beyond ±1e300 do not: differences of them could overflow,
/// and they are used as placeholders.
template <class T>
bool has_value(T voxel) {
  constexpr double kMax = 1e300;
  if constexpr (sizeof(T) == 8) return voxel >= -kMax && voxel <= kMax;
  return voxel >= -std::numeric_limits<T>::max() && voxel <= std::numeric_limits<T>::max();
}

}  // namespace isosplat
