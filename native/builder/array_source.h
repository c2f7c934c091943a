#pragma once

#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "native/builder/builder.h"

namespace isosplat {

template <class T>
constexpr VoxelType voxel_type_of() {
  if constexpr (std::is_same_v<T, uint8_t>) return VoxelType::u8;
  if constexpr (std::is_same_v<T, int8_t>) return VoxelType::i8;
  if constexpr (std::is_same_v<T, uint16_t>) return VoxelType::u16;
  if constexpr (std::is_same_v<T, int16_t>) return VoxelType::i16;
  if constexpr (std::is_same_v<T, uint32_t>) return VoxelType::u32;
  if constexpr (std::is_same_v<T, int32_t>) return VoxelType::i32;
  if constexpr (std::is_same_v<T, uint64_t>) return VoxelType::u64;
  if constexpr (std::is_same_v<T, int64_t>) return VoxelType::i64;
  if constexpr (std::is_same_v<T, float>) return VoxelType::f32;
  if constexpr (std::is_same_v<T, double>) return VoxelType::f64;
}

/// A volume in memory, x fastest. Borrows the voxels.
template <class T>
class ArraySource : public VolumeSource {
 public:
  ArraySource(const VolumeGrid& grid, std::span<const T> voxels, std::string name = "array",
              double slope = 1, double intercept = 0)
      : header_{grid, voxel_type_of<T>(), "memory", std::move(name), slope, intercept},
        voxels_(voxels) {}

  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t, std::span<std::byte> out) override {
    const size_t slice = static_cast<size_t>(header_.grid.voxels.x) *
                         static_cast<size_t>(header_.grid.voxels.y) * sizeof(T);
    std::memcpy(out.data(), std::as_bytes(voxels_).data() + slice * static_cast<size_t>(first),
                out.size());
    return {};
  }
  bool reads_rows() const override { return true; }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    const Index3 n = header_.grid.voxels;
    if (part.rows == n.y) return read_slices(part.first_slice, part.slices, out);
    const size_t row = static_cast<size_t>(n.x) * sizeof(T);
    const size_t bytes = row * static_cast<size_t>(part.rows);
    for (int32_t z = 0; z < part.slices; ++z) {
      const size_t first = static_cast<size_t>(part.first_slice + z) * static_cast<size_t>(n.y) +
                           static_cast<size_t>(part.first_row);
      std::memcpy(out.data() + bytes * static_cast<size_t>(z),
                  std::as_bytes(voxels_).data() + row * first, bytes);
    }
    return {};
  }
  uint64_t resident_bytes() const override { return voxels_.size_bytes(); }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  VolumeHeader header_;
  std::span<const T> voxels_;
};

/// Builds a store file from a volume in memory.
template <class T>
Result<BuildReport> build_store_file(const VolumeGrid& grid, std::span<const T> voxels,
                                     const std::filesystem::path& target,
                                     const BuildOptions& options = {}) {
  ArraySource<T> source(grid, voxels, target.stem().string());
  return build_store_file(source, target, options);
}

/// Builds a store in memory from a volume in memory. Returns the store's bytes.
template <class T>
Result<std::vector<std::byte>> build_store_bytes(const VolumeGrid& grid, std::span<const T> voxels,
                                                 const BuildOptions& options = {}) {
  ArraySource<T> source(grid, voxels);
  MemorySink sink;
  if (auto built = build_store(source, sink, options); !built) {
    return tl::unexpected(built.error());
  }
  return std::move(sink.bytes);
}

}  // namespace isosplat
