// Builds the store of a volume that repeats another one (a tile) along all axes, mirrored each
// second time, and prints voxels, seconds, processor time, planned and peak memory as one line of
// JSON: isosplat_wide_bench TILE.raw NX NY NZ u8|i16 X Y Z MEMORY_MIB THREADS STORE NX, NY, NZ: the
// tile's voxels, of 16 bits, of which u8 keeps eight. X, Y, Z: those of the volume. The tile is
// read from its file, as a volume of this size would be.
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "native/builder/builder.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

class RepeatedVolume : public VolumeSource {
 public:
  RepeatedVolume(PosixFile file, Index3 tile, Index3 voxels, VoxelType type)
      : file_(std::move(file)), tile_(tile) {
    header_.grid.voxels = voxels;
    header_.type = type;
    header_.format = "repeated";
    header_.name = "wide";
  }

  const VolumeHeader& header() const override { return header_; }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }
  bool reads_rows() const override { return true; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return read_rows({first, count, 0, header_.grid.voxels.y}, out);
  }

  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    const size_t row = static_cast<size_t>(header_.grid.voxels.x) * voxel_bytes(header_.type);
    std::byte* to = out.data();
    for (int32_t z = part.first_slice; z < part.first_slice + part.slices; ++z) {
      if (auto read = read_tile_slice(mirrored(z, tile_.z)); !read) return read;
      for (int32_t y = part.first_row; y < part.first_row + part.rows; ++y, to += row) {
        const size_t from =
            static_cast<size_t>(mirrored(y, tile_.y)) * static_cast<size_t>(tile_.x);
        header_.type == VoxelType::u8 ? repeat_row<uint8_t>(from, to)
                                      : repeat_row<int16_t>(from, to);
      }
    }
    return {};
  }

 private:
  static int32_t mirrored(int32_t at, int32_t size) {
    const int32_t inside = at % size;
    return at / size % 2 == 0 ? inside : size - 1 - inside;
  }

  Result<void> read_tile_slice(int32_t z) {
    if (z == slice_z_) return {};
    slice_.resize(static_cast<size_t>(tile_.x) * static_cast<size_t>(tile_.y));
    slice_z_ = z;
    return file_.read(slice_.size() * sizeof(int16_t) * static_cast<uint64_t>(z),
                      std::as_writable_bytes(std::span(slice_)));
  }

  template <class T>
  void repeat_row(size_t from, std::byte* to) {
    const auto width = static_cast<size_t>(tile_.x);
    pair_.resize(2 * width * sizeof(T));  // the tile's row, and the same mirrored
    auto* pair = reinterpret_cast<T*>(pair_.data());
    for (size_t x = 0; x < width; ++x) {
      const int16_t voxel = slice_[from + x];
      if constexpr (sizeof(T) == 1) {
        pair[x] = static_cast<T>(std::clamp(voxel / 12, 0, 255));
      } else {
        pair[x] = voxel;
      }
    }
    std::reverse_copy(pair, pair + width, pair + width);
    const size_t bytes = static_cast<size_t>(header_.grid.voxels.x) * sizeof(T);
    for (size_t done = 0; done < bytes; done += pair_.size()) {
      std::memcpy(to + done, pair_.data(), std::min(pair_.size(), bytes - done));
    }
  }

  PosixFile file_;
  const Index3 tile_;
  VolumeHeader header_;
  int32_t slice_z_ = -1;
  std::vector<int16_t> slice_;  // of the tile
  std::vector<std::byte> pair_;
};

Index3 size_of(char** arguments) {
  return {std::atoi(arguments[0]), std::atoi(arguments[1]), std::atoi(arguments[2])};
}

int run(char** arguments) {
  auto file = PosixFile::open(arguments[1]);
  if (!file) return std::fprintf(stderr, "%s\n", file.error().message.c_str()), 1;
  const VoxelType type = std::strcmp(arguments[5], "u8") == 0 ? VoxelType::u8 : VoxelType::i16;
  RepeatedVolume volume(std::move(*file), size_of(arguments + 2), size_of(arguments + 6), type);
  BuildOptions options;
  options.memory_bytes = static_cast<uint64_t>(std::atoll(arguments[9])) << 20;
  options.threads = static_cast<unsigned>(std::atoi(arguments[10]));
  const auto built = build_store_file(volume, arguments[11], options);
  if (!built) return std::fprintf(stderr, "%s\n", built.error().message.c_str()), 1;
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  const Index3 n = volume.header().grid.voxels;
  std::printf(
      "{\"voxels\":%.0f,\"seconds\":%.3f,\"processor\":%.3f,\"planned\":%.1f,\"peak\":%.1f,"
      "\"files\":%s}\n",
      double{1} * n.x * n.y * n.z, built->seconds,
      seconds(usage.ru_utime) + seconds(usage.ru_stime),
      static_cast<double>(built->needed_bytes) / (1 << 20),
      static_cast<double>(usage.ru_maxrss) / 1024, built->uses_temporary_files ? "true" : "false");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  if (count != 12) {
    std::fprintf(stderr,
                 "expected: isosplat_wide_bench TILE.raw NX NY NZ u8|i16 X Y Z MEMORY_MIB THREADS "
                 "STORE\n");
    return 2;
  }
  return isosplat::run(arguments);
}
