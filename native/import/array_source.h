#pragma once

#include <memory>
#include <string>
#include <vector>

#include "native/import/byte_reader.h"
#include "native/import/itk_reader.h"
#include "native/import/open_volume.h"
#include "native/import/orientation.h"
#include "native/import/stored_voxels.h"

namespace isosplat {

/// A volume as one array of voxels, x fastest, in a file.
struct ArrayVolume {
  std::string format;       ///< for VolumeHeader
  std::string name;         ///< for VolumeHeader
  std::string path;         ///< of the file with the header
  Vec3<int64_t> voxels;     ///< as the header says
  HeaderGeometry geometry;  ///< as the header says
  StoredVoxels stored;      ///< how a voxel is stored
  uint64_t offset = 0;      ///< in the reader, of the first voxel of time step 0
  uint64_t time_step = 0;   ///< which of the volumes that follow each other in the reader
  bool plain = true;        ///< the reader's size is exact, and says how many voxels there are
};

/// An array with the file's name and path, and what options say of it; how its voxels are stored,
/// and where, is still to be filled in. `sizes`: at least three, fastest first.
ArrayVolume make_array(std::string format, const std::filesystem::path& path,
                       std::span<const int64_t> sizes, const HeaderGeometry& geometry,
                       const ImportOptions& options);

/// The array of a file whose header ITK has read; byte order and offset are still to be filled in.
/// `type`: as the header names it, for messages. Errors: unsupported_type, and those of
/// choose_time_step.
Result<ArrayVolume> make_array(std::string format, const std::filesystem::path& path,
                               const ItkHeader& header, std::string_view type,
                               const ImportOptions& options);

/// Opens an array as a source that reads it slice by slice and holds nothing. `notes`: what a
/// person should know so far. Errors: those of orient, and truncated where the reader cannot have
/// all voxels.
Result<OpenVolume> open_array(ArrayVolume volume, std::unique_ptr<ByteReader> reader,
                              std::vector<std::string> notes = {});

/// Where an array begins that ends with the file; the file's end where it cannot.
uint64_t offset_from_end(uint64_t file_bytes, std::span<const int64_t> sizes, size_t voxel_bytes);

/// Reverses the order of the rows of one slice. `row_bytes` divides slice.size().
void reverse_rows(std::span<std::byte> slice, size_t row_bytes);

/// nx · ny · nz · voxel bytes. Cannot overflow for voxels that orient accepts.
uint64_t volume_bytes(Vec3<int64_t> voxels, size_t voxel_bytes);

}  // namespace isosplat
