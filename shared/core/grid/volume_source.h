#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_header.h"

namespace isosplat {

/// A volume as a stack of slices along z. Every slice can be read any number of times; ascending
/// order is the fastest. Not thread-safe.
class VolumeSource {
 public:
  virtual ~VolumeSource() = default;

  virtual const VolumeHeader& header() const = 0;

  /// Reads slices [first, first + count) as native-endian voxels, x fastest, then y, then z, into
  /// `out`, which has exactly count · nx · ny · voxel_bytes(type) bytes. Requires 0 ≤ first,
  /// 1 ≤ count, first + count ≤ nz. Errors: io_error, truncated, malformed_volume.
  virtual Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) = 0;

  /// Memory that the source uses: 0 for streamed raw data, the whole volume for formats that can
  /// only be read as a whole.
  virtual uint64_t resident_bytes() const = 0;

  /// All files that the volume is read from: header, data files, slices. Callers must not write to
  /// them; if one changes, the volume has changed. Empty for volumes in memory.
  virtual std::vector<std::filesystem::path> files() const = 0;
};

}  // namespace isosplat
