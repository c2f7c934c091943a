#include "shared/import/voxels/absent_voxels.h"

#include <cstring>
#include <limits>

namespace isosplat::import {
namespace {

template <class T>
void fill(std::span<std::byte> voxels, T value) {
  for (size_t at = 0; at + sizeof(T) <= voxels.size(); at += sizeof(T)) {
    std::memcpy(voxels.data() + at, &value, sizeof(T));
  }
}

}  // namespace

VoxelType type_with_absent(VoxelType type) {
  if (type == VoxelType::f64 || type == VoxelType::f32) return type;
  return voxel_bytes(type) <= 2 ? VoxelType::f32 : VoxelType::f64;
}

void make_absent(VoxelType type, std::span<std::byte> voxels) {
  if (type == VoxelType::f32) return fill(voxels, std::numeric_limits<float>::quiet_NaN());
  fill(voxels, std::numeric_limits<double>::quiet_NaN());
}

void convert_voxels(VoxelType from, std::span<const std::byte> in, VoxelType to,
                    std::span<std::byte> out) {
  with_voxel_type(from, [&]<class From>(From) {
    const auto convert = [&]<class To>(To) {
      for (size_t i = 0; i < in.size() / sizeof(From); ++i) {
        From voxel;
        std::memcpy(&voxel, in.data() + i * sizeof(From), sizeof(From));
        const To converted = static_cast<To>(voxel);
        std::memcpy(out.data() + i * sizeof(To), &converted, sizeof(To));
      }
    };
    to == VoxelType::f32 ? convert(float{}) : convert(double{});
  });
}

}  // namespace isosplat::import
