#pragma once

#include <memory>
#include <string>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/geometry/orientation.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/voxels/data_files.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// A volume that is stored as one array of voxels in a file, x fastest. The array may have a fourth
/// axis; one step along it is read.
struct ArrayVolume {
  std::string format;       ///< for VolumeHeader
  std::string name;         ///< for VolumeHeader
  std::string path;         ///< of the header file
  Vec3<int64_t> voxels;     ///< as in the header
  HeaderGeometry geometry;  ///< as in the header
  StoredVoxels stored;      ///< how each voxel is stored
  uint64_t offset = 0;      ///< of the first voxel of the array, in the reader's bytes
  size_t step_axis = 3;     ///< position of the fourth axis among the four: 0 fastest, 3 slowest
  uint64_t steps = 1;       ///< number of steps along the fourth axis
  uint64_t step = 0;        ///< the selected step
  bool plain =
      true;  ///< the reader's size is exact, so the number of voxels can be checked before reading
  bool ends_with_file = true;           ///< data after the last voxel are an error
  std::vector<ByteRange> missing = {};  ///< byte ranges of the reader without data, ascending
  Allowances allowed = {};
};

/// An array with the file's name and path, the header's sizes and geometry, and the values that the
/// options override. The caller sets the type and the location of the voxels.
ArrayVolume make_array(std::string format, const std::filesystem::path& path, Vec3<int64_t> voxels,
                       const HeaderGeometry& geometry, const ImportOptions& options);

/// Opens an array as a source that reads slice by slice and keeps no voxels in memory. `notes`:
/// existing notes, to which new ones are added. Missing voxels become absent (absent_voxels.h).
/// Errors: those of orient; unsupported_format if a row with all its steps is too long to be read;
/// truncated or malformed_volume if the reader has too few or too many bytes. For compressed data
/// these errors may occur only when the end of the data is read.
Result<OpenVolume> open_array(ArrayVolume volume, std::unique_ptr<ByteReader> reader,
                              std::vector<std::string> notes = {});

/// Size of the array with all its steps, in bytes; the largest uint64_t if it overflows.
uint64_t array_bytes(Vec3<int64_t> voxels, uint64_t steps, size_t voxel_bytes);

/// Reverses the order of the rows of one slice. `row_bytes` divides slice.size().
void reverse_rows(std::span<std::byte> slice, size_t row_bytes);

/// nx · ny · nz · voxel bytes. Cannot overflow for sizes that orient accepts.
uint64_t volume_bytes(Vec3<int64_t> voxels, size_t voxel_bytes);

}  // namespace isosplat::import
