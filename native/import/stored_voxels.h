#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "native/import/volume_source.h"

namespace isosplat {

/// The type of voxels as a file stores them: VoxelType, and 64-bit integers, which are read as f64.
enum class StoredType : uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

/// How stored voxels become a volume's values: value = intercept + slope · stored.
struct StoredVoxels {
  StoredType type = StoredType::u8;
  bool big_endian = false;
  double slope = 1;
  double intercept = 0;

  bool is_rescaled() const { return slope != 1 || intercept != 0; }
};

/// Bytes of one stored voxel: 1, 2, 4 or 8.
size_t stored_bytes(StoredType type);

/// The type that voxels are read as: the stored one, except that 64-bit integers become f64, and
/// rescaled ones f32 (f64 where they have more than 16 bits).
VoxelType read_type(const StoredVoxels& voxels);

/// Whether `decode` can work in place: no change of type, at most a change of byte order.
bool decodes_in_place(const StoredVoxels& voxels);

/// Swaps bytes where the file's order is not this machine's. Requires decodes_in_place(voxels).
void decode_in_place(const StoredVoxels& voxels, std::span<std::byte> bytes);

/// Turns `stored` into native-endian voxels of type `to`, which must be able to hold their values.
/// `out` has room for exactly as many voxels as `stored` holds; the two do not overlap.
void decode(const StoredVoxels& voxels, std::span<const std::byte> stored, VoxelType to,
            std::span<std::byte> out);

}  // namespace isosplat
