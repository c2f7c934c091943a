#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/volume_header.h"

namespace isosplat {

/// A volume as a stack of slices along z. Every slice can be read any number of times; reading in
/// ascending order is the fast way. One thread at a time.
class VolumeSource {
 public:
  virtual ~VolumeSource() = default;

  virtual const VolumeHeader& header() const = 0;

  /// Reads slices [first, first + count) as native-endian voxels, x fastest, then y, then z, into
  /// `out`, which has exactly count · nx · ny · voxel_bytes(type) bytes. Requires 0 ≤ first,
  /// 1 ≤ count, first + count ≤ nz. Errors: io_error, truncated, malformed_volume.
  virtual Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) = 0;

  /// Memory that the source itself holds: 0 for streamed raw data, the whole volume for formats
  /// that can only be read whole.
  virtual uint64_t resident_bytes() const = 0;

  /// Every file that the voxels and what is said of them come from: header, data files, slices.
  /// None of them may be written to, and where one has changed the volume has. Empty for volumes
  /// that are in memory.
  virtual std::vector<std::filesystem::path> files() const = 0;
};

}  // namespace isosplat
