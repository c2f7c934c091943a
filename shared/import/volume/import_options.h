#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/grid/voxel_type.h"
#include "shared/import/volume/allowances.h"

namespace isosplat::import {

/// One of several volumes in a file: the options that choose it, and what tells it from the others.
struct VolumeChoice {
  std::string label = {};  ///< a text that tells it from the others
  std::string name = {};   ///< what the file calls it, and sizes: no words of ours. May be empty
  std::string dataset = {}, series = {}, segment = {};
  std::optional<int64_t> channel = {}, time_step = {};
  std::optional<Allowance> allowance = {};  ///< not another volume: a fault that is to be accepted
};

/// Options that complete or override the file's header.
struct ImportOptions {
  std::optional<Vec3<int64_t>> dims;  ///< raw files only: voxels along x, y, z
  std::optional<VoxelType> type;      ///< raw files only
  std::optional<bool> big_endian;     ///< raw files only; nothing: little-endian, with a note
  uint64_t skip_bytes = 0;            ///< raw files only: bytes before the first voxel
  std::optional<Vec3d> spacing;       ///< every format: overrides the header's spacing
  std::optional<int64_t> time_step;   ///< time step of a 4D volume, from 0
  /// DICOM: a series, by its number in messages or its UID. TIFF: an image, by its number in
  /// messages or its name.
  std::string series;
  std::optional<int64_t> channel;  ///< channel of a volume with several, from 0
  std::string segment;             ///< DICOM segmentations: a segment, by its number or label
  std::string dataset;             ///< HDF5: the path of a dataset
  uint64_t memory_bytes = uint64_t{1} << 30;  ///< memory limit of a reader's child process
  Allowances allowed;                         ///< every format: faults that are not errors

  /// Every format: voxels of this value are absent. The value is in the user's units, after slope
  /// and intercept.
  std::optional<double> missing_value;
  /// If missing_value is not set: whether voxels become absent that have a header's fill value, or
  /// a value that programs use for "no value", far outside the range of all others.
  bool finds_missing_values = true;

  /// If not null: is given the volumes among which these options do not choose. Where open_volume
  /// fails for that reason, each one's options, added to these, choose. If it succeeds, these are
  /// all that it could read, the one that it chose by itself included. Where an error advises an
  /// allowance, it is given that one. Must outlive the call of open_volume.
  std::vector<VolumeChoice>* choices = nullptr;
};

}  // namespace isosplat::import
