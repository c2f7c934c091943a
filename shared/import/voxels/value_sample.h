#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "shared/core/grid/volume_source.h"
#include "shared/import/volume/opened_volume.h"

// Statistics of a volume's values and their positions, from some of its slices. They distinguish a
// fill value, which means "no value", from an object or a background with one value.
namespace isosplat::import {

/// Whether a voxel has the fill value. A header or a user may have written it with fewer digits: a
/// floating-point voxel may differ in its seventh digit, an integer by 1/1000.
bool has_fill_value(const VolumeHeader& header, double voxel, const FillValue& fill);

/// Whether some voxel of the header's type can have the fill value.
bool can_have(const VolumeHeader& header, const FillValue& fill);

/// One end of the value range: the extreme value, its positions, and the next value.
struct RangeEnd {
  double value = std::numeric_limits<double>::infinity();
  double next = std::numeric_limits<double>::infinity();
  uint64_t count = 0;    ///< voxels with the extreme value
  uint64_t at_edge = 0;  ///< of these, on the four edges of their slices
  uint64_t at_face = 0;  ///< of these, on the six faces of the volume
  uint64_t joined = 0;   ///< of these, beside another one in the row or the column
};

/// The values of up to 64 slices, spread over the volume; the first and the last are among them.
struct ValueSample {
  RangeEnd low, high;         ///< the values of `high` are negated
  uint64_t count = 0;         ///< finite voxels, without those of the fill value
  uint64_t filled = 0;        ///< voxels with the fill value
  uint64_t edges = 0;         ///< voxels on the edges of slices
  uint64_t faces = 0;         ///< voxels on the faces of the volume
  bool is_whole = false;      ///< all slices were sampled
  bool is_label_map = false;  ///< fewer than 64 different values, all of them integers
};

/// Samples a volume. `fill`: a value that is counted, but left out of the range. Errors: those of
/// the source.
Result<ValueSample> sample_values(VolumeSource& source, const std::optional<FillValue>& fill);

/// A single value far outside the range of all others, in at least 1 of 2000 voxels.
struct OutlyingValue {
  enum class Place : uint8_t {
    objects,   ///< it fills compact regions
    around,    ///< it fills a quarter of the slices' edges or more: a background
    scattered  ///< neither
  };
  double value = 0;
  Place place = Place::scattered;
  /// Whether it means "no value": programs use it for that, its distance to the others exceeds
  /// their range, and it is not the value of objects inside the volume.
  bool is_fill = false;
};

std::optional<OutlyingValue> outlying_value(const ValueSample& sample, VoxelType type);

}  // namespace isosplat::import
