#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/grid/voxel_type.h"
#include "shared/import/volume/allowances.h"

namespace isosplat::import {

/// One of several volumes in a file: the options that choose it, and a description.
struct VolumeChoice {
  std::string label = {};  ///< a text that distinguishes it from the others
  std::string name =
      {};  ///< its name in the file, and sizes, without words of Isosplat. May be empty
  std::string dataset = {}, series = {}, segment = {};
  std::optional<int64_t> channel = {}, time_step = {};
  std::optional<double> time = {};                  ///< of the time step, if the file states it
  std::string time_unit = {};                       ///< may be empty
  std::optional<std::array<float, 3>> colour = {};  ///< of the channel, sRGB, if the file states it
  std::optional<Allowance> allowance = {};          ///< not another volume, but a fault to accept
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
  std::string dataset;             ///< HDF5: the path of a dataset. .npz: the name of an array
  uint64_t memory_bytes = uint64_t{1} << 30;  ///< memory limit of a reader's child process
  Allowances allowed;                         ///< every format: faults that are not errors

  /// Every format: voxels of this value are absent. The value is in the user's units, after slope
  /// and intercept.
  std::optional<double> missing_value;
  /// If missing_value is not set: whether voxels with a fill value become absent. The fill value is
  /// that of the header, or a value that programs use for "no value", far outside the range of all
  /// others.
  bool finds_missing_values = true;

  /// If not null, receives the choices that these options leave open. If open_volume fails because
  /// of several volumes, the options of one choice, added to these, select that volume. If it
  /// succeeds, the list has all volumes that it could read, including the one that it has chosen by
  /// itself. If an error recommends an allowance, the list has this allowance. Must outlive the
  /// call of open_volume.
  std::vector<VolumeChoice>* choices = nullptr;
};

}  // namespace isosplat::import
