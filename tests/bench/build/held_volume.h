#pragma once

#include <cstring>
#include <filesystem>
#include <vector>

#include "shared/import/open_volume.h"

namespace isosplat {

/// A volume in memory, so that benchmarks do not measure the disk.
class HeldVolume : public VolumeSource {
 public:
  VolumeHeader header_;
  std::vector<std::byte> voxels;
  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t slice = out.size() / static_cast<size_t>(count);
    std::memcpy(out.data(), voxels.data() + slice * static_cast<size_t>(first), out.size());
    return {};
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }
};

/// Reads all voxels of a volume. Errors: those of open_volume and of its source.
inline Result<HeldVolume> hold_volume(const std::filesystem::path& path) {
  auto opened = import::open_volume(path, {});
  if (!opened) return tl::unexpected(opened.error());
  HeldVolume volume;
  volume.header_ = opened->source->header();
  const Index3 n = volume.header_.grid.voxels;
  volume.voxels.resize(static_cast<size_t>(n.x) * static_cast<size_t>(n.y) *
                       static_cast<size_t>(n.z) * voxel_bytes(volume.header_.type));
  if (auto read = opened->source->read_slices(0, n.z, volume.voxels); !read) {
    return tl::unexpected(read.error());
  }
  return volume;
}

}  // namespace isosplat
