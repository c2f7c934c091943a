#pragma once

#include <memory>
#include <string>
#include <vector>

#include "native/import/byte_reader.h"
#include "native/import/data_files.h"
#include "native/import/open_volume.h"
#include "native/import/orientation.h"
#include "native/import/stored_voxels.h"

namespace isosplat {

/// A volume as one array of voxels, x fastest, in a file. Beside x, y and z the array may have one
/// more axis, of which one step is taken.
struct ArrayVolume {
  std::string format;          ///< for VolumeHeader
  std::string name;            ///< for VolumeHeader
  std::string path;            ///< of the file with the header
  Vec3<int64_t> voxels;        ///< as the header says
  HeaderGeometry geometry;     ///< as the header says
  StoredVoxels stored;         ///< how a voxel is stored
  uint64_t offset = 0;         ///< in the reader, of the first voxel of all
  size_t step_axis = 3;        ///< where the other axis is among the four: 0 fastest, 3 slowest
  uint64_t steps = 1;          ///< its size
  uint64_t step = 0;           ///< the one taken
  bool plain = true;           ///< the reader's size is exact, and says how many voxels there are
  bool ends_with_file = true;  ///< nothing may follow the last voxel
  std::vector<ByteRange> missing = {};  ///< of the reader, ascending: no value
  Allowances allowed = {};
};

/// An array with the file's name and path, and what options say of it; how its voxels are stored,
/// and where, is still to be filled in.
ArrayVolume make_array(std::string format, const std::filesystem::path& path, Vec3<int64_t> voxels,
                       const HeaderGeometry& geometry, const ImportOptions& options);

/// Opens an array as a source that reads it slice by slice and holds nothing. `notes`: what a
/// person should know so far. Voxels that are missing are absent (absent_voxels.h). Errors: those
/// of orient, and truncated or malformed_volume where the reader has too few bytes or too many; of
/// compressed data that shows when its end is read.
Result<OpenVolume> open_array(ArrayVolume volume, std::unique_ptr<ByteReader> reader,
                              std::vector<std::string> notes = {});

/// Bytes of the array with all its steps; the greatest number where that is more.
uint64_t array_bytes(Vec3<int64_t> voxels, uint64_t steps, size_t voxel_bytes);

/// Reverses the order of the rows of one slice. `row_bytes` divides slice.size().
void reverse_rows(std::span<std::byte> slice, size_t row_bytes);

/// nx · ny · nz · voxel bytes. Cannot overflow for voxels that orient accepts.
uint64_t volume_bytes(Vec3<int64_t> voxels, size_t voxel_bytes);

}  // namespace isosplat
