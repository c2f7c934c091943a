#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_header.h"

namespace isosplat {

/// The rows [first_row, first_row + rows) along y of the slices [first_slice, first_slice +
/// slices).
struct SliceRows {
  int32_t first_slice = 0, slices = 0;
  int32_t first_row = 0, rows = 0;

  /// How many voxels they have, in a volume with nx voxels along x.
  size_t voxels(int32_t nx) const {
    return static_cast<size_t>(nx) * static_cast<size_t>(rows) * static_cast<size_t>(slices);
  }
};

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

  /// Whether read_rows() reads only the rows that it returns. Then volumes with large slices are
  /// built in bands of rows.
  virtual bool reads_rows() const { return false; }

  /// As read_slices(), for some rows of the slices: x fastest, then the rows, then the slices. If
  /// reads_rows() is false, each slice is read as a whole, to temporary memory.
  virtual Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) {
    const Index3 n = header().grid.voxels;
    if (part.rows == n.y) return read_slices(part.first_slice, part.slices, out);
    const size_t row = static_cast<size_t>(n.x) * voxel_bytes(header().type);
    const size_t bytes = row * static_cast<size_t>(part.rows);
    std::vector<std::byte> slice(row * static_cast<size_t>(n.y));
    for (int32_t z = 0; z < part.slices; ++z) {
      if (auto read = read_slices(part.first_slice + z, 1, slice); !read) return read;
      std::copy_n(slice.data() + row * static_cast<size_t>(part.first_row), bytes,
                  out.data() + bytes * static_cast<size_t>(z));
    }
    return {};
  }

  /// Memory that the source uses: 0 for streamed raw data, the whole volume for formats that can
  /// only be read as a whole.
  virtual uint64_t resident_bytes() const = 0;

  /// All files that the volume is read from: header, data files, slices. Callers must not write to
  /// them; if one changes, the volume has changed. Empty for volumes in memory.
  virtual std::vector<std::filesystem::path> files() const = 0;
};

/// How many rows of a slice have about `bytes` bytes, at least one; all rows if the source reads
/// whole slices.
inline int32_t rows_per_read(const VolumeSource& source, size_t bytes) {
  const Index3 n = source.header().grid.voxels;
  if (!source.reads_rows()) return n.y;
  const size_t row = static_cast<size_t>(n.x) * voxel_bytes(source.header().type);
  return static_cast<int32_t>(std::clamp<size_t>(bytes / row, 1, static_cast<size_t>(n.y)));
}

}  // namespace isosplat
