#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "shared/grid/voxel_type.h"
#include "shared/preprocess/distinct_values.h"

namespace isosplat {

/// What reading a volume's voxels once tells of them: what quantized values they can have. Voxels
/// are taken as they are in the file; slope and intercept do not matter here.
class VoxelScan {
 public:
  explicit VoxelScan(VoxelType type) : type_(type) {}

  /// Adds native-endian voxels.
  void add(std::span<const std::byte> voxels);

  /// Adds what another scan of the same type has seen.
  void add(const VoxelScan& other);

  VoxelType type() const { return type_; }

  /// No voxel with a value so far: what follows means nothing.
  bool is_empty() const { return is_empty_; }

  /// How many have no value: NaN, infinities, and doubles beyond ±1e300.
  uint64_t missing() const { return missing_; }

  /// The least and greatest voxel.
  double min() const;
  double max() const;

  /// Integers: the same as keys (key_of), and the greatest common divisor of all differences, 0
  /// where all voxels are equal.
  uint64_t low() const { return low_; }
  uint64_t high() const { return high_; }
  uint64_t step() const { return step_; }

  /// Floating-point numbers: which ones there are.
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

/// An integer as an unsigned one, in the same order: signed ones are moved up by 2^63.
template <class T>
constexpr uint64_t key_of(T voxel) {
  if constexpr (T(-1) > T(0)) return voxel;
  return static_cast<uint64_t>(static_cast<int64_t>(voxel)) ^ uint64_t { 1 } << 63;
}

/// The integer of a key, rounded where a double has no room for it.
double voxel_of_key(VoxelType type, uint64_t key);

/// Whether a voxel has a value. Doubles beyond this could not be told apart by their distance,
/// which may overflow; they are placeholders in all data that has them.
template <class T>
bool has_value(T voxel) {
  constexpr double kMax = 1e300;
  if constexpr (sizeof(T) == 8) return voxel >= -kMax && voxel <= kMax;
  return voxel >= -std::numeric_limits<T>::max() && voxel <= std::numeric_limits<T>::max();
}

}  // namespace isosplat
