#pragma once

#include <memory>
#include <string>
#include <vector>

#include "native/import/byte_reader.h"
#include "native/import/orientation.h"
#include "native/import/stored_voxels.h"

namespace isosplat {

/// A volume as one array of voxels, x fastest, in a file.
struct ArrayVolume {
  std::string format;       ///< for VolumeHeader
  std::string name;         ///< for VolumeHeader
  std::string path;         ///< for messages
  Vec3<int64_t> voxels;     ///< as the header says
  HeaderGeometry geometry;  ///< as the header says
  StoredVoxels stored;      ///< how a voxel is stored
  uint64_t offset = 0;      ///< in the reader, of the first voxel of time step 0
  uint64_t time_step = 0;   ///< which of the volumes that follow each other in the reader
  bool plain = true;        ///< the reader's size is exact, and says how many voxels there are
};

/// A source that reads the array slice by slice and holds nothing. Adds to `notes` what a person
/// should know. Errors: those of orient, and truncated where the reader cannot have all voxels.
Result<std::unique_ptr<VolumeSource>> make_array_source(ArrayVolume volume,
                                                        std::unique_ptr<ByteReader> reader,
                                                        std::vector<std::string>& notes);

/// Reverses the order of the rows of one slice. `row_bytes` divides slice.size().
void reverse_rows(std::span<std::byte> slice, size_t row_bytes);

/// nx · ny · nz · voxel bytes. Cannot overflow for voxels that orient accepts.
uint64_t volume_bytes(Vec3<int64_t> voxels, size_t voxel_bytes);

}  // namespace isosplat
