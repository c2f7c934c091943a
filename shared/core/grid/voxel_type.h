#pragma once

#include <cstddef>
#include <cstdint>

namespace isosplat {

/// The type of a volume's voxels in the file.
enum class VoxelType : uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

/// Bytes of one voxel: 1, 2, 4 or 8.
constexpr size_t voxel_bytes(VoxelType type) {
  constexpr size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

/// "u8", "i16", …: the name in the command line and in the metadata.
constexpr const char* voxel_type_name(VoxelType type) {
  constexpr const char* kNames[] = {"u8",  "i8",  "u16", "i16", "u32",
                                    "i32", "u64", "i64", "f32", "f64"};
  return kNames[static_cast<size_t>(type)];
}

/// Calls f with a zero of the corresponding C++ type.
template <class F>
auto with_voxel_type(VoxelType type, F f) {
  switch (type) {
    case VoxelType::u8:
      return f(uint8_t{});
    case VoxelType::i8:
      return f(int8_t{});
    case VoxelType::u16:
      return f(uint16_t{});
    case VoxelType::i16:
      return f(int16_t{});
    case VoxelType::u32:
      return f(uint32_t{});
    case VoxelType::i32:
      return f(int32_t{});
    case VoxelType::u64:
      return f(uint64_t{});
    case VoxelType::i64:
      return f(int64_t{});
    case VoxelType::f32:
      return f(float{});
    case VoxelType::f64:
      break;
  }
  return f(double{});
}

}  // namespace isosplat
