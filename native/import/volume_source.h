#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/grid.h"

namespace isosplat {

/// The type of a volume's voxels, as it is in the file.
enum class VoxelType : uint8_t { u8, i8, u16, i16, u32, i32, f32, f64 };

/// Bytes of one voxel: 1, 2, 4 or 8.
constexpr size_t voxel_bytes(VoxelType type) {
  switch (type) {
    case VoxelType::u8:
    case VoxelType::i8:
      return 1;
    case VoxelType::u16:
    case VoxelType::i16:
      return 2;
    case VoxelType::u32:
    case VoxelType::i32:
    case VoxelType::f32:
      return 4;
    case VoxelType::f64:
      return 8;
  }
  return 0;
}

/// "u8", "i16", …: as the command line and the metadata write it.
constexpr const char* voxel_type_name(VoxelType type) {
  constexpr const char* kNames[] = {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"};
  return kNames[static_cast<size_t>(type)];
}

/// What a volume file says of itself, before a voxel is read.
struct VolumeHeader {
  VolumeGrid grid;
  VoxelType type = VoxelType::u8;
  std::string format;  ///< "NRRD", "NIfTI", "raw", …
  std::string name;    ///< the file's or folder's name without its suffixes
};

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
