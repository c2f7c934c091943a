#include "shared/import/tiff/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

namespace isosplat::import {

void set_voxel_type(uint16_t bits, uint16_t format, TiffPage& page) {
  const bool is_signed = format == 2, is_float = format == 3;
  page.stored = {bits, is_float, is_signed,
                 page.separate_planes ? 1 : static_cast<unsigned>(page.samples)};
  if (format == 5 || format == 6) {
    page.unknown = "complex numbers";
  } else if (is_float && (bits == 16 || bits == 24 || bits == 32)) {
    page.type = VoxelType::f32;
  } else if (is_float && bits == 64) {
    page.type = VoxelType::f64;
  } else if (!is_float && bits >= 1 && bits <= 8) {
    page.type = is_signed ? VoxelType::i8 : VoxelType::u8;
  } else if (!is_float && bits > 8 && bits <= 16) {
    page.type = is_signed ? VoxelType::i16 : VoxelType::u16;
  } else if (!is_float && bits > 16 && bits <= 32) {
    page.type = is_signed ? VoxelType::i32 : VoxelType::u32;
  } else if (!is_float && bits == 64) {
    page.type = is_signed ? VoxelType::i64 : VoxelType::u64;
  } else {
    page.unknown = fmt::format("{} bits per voxel{}", bits, is_float ? ", float" : "");
  }
}

void TiffFile::fill_left_out(const TiffPage& page, std::span<std::byte> out) const {
  std::fill(out.begin(), out.end(), std::byte{});
  if (left_out_ == 0 || !page.stored.are_voxels()) return;
  with_voxel_type(page.type, [&]<class T>(T) {
    if (!std::is_floating_point_v<T> &&
        !(left_out_ >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
          left_out_ < static_cast<double>(std::numeric_limits<T>::max()) + 1)) {
      return;
    }
    const T value = static_cast<T>(left_out_);
    for (size_t i = 0; i + sizeof(T) <= out.size(); i += sizeof(T)) {
      std::memcpy(out.data() + i, &value, sizeof value);
    }
  });
}

std::unique_ptr<TiffFile> open_tiff(const std::filesystem::path& path, bool has_planes) {
#ifdef __EMSCRIPTEN__
  static_cast<void>(has_planes);
  return open_plain_tiff(path);
#else
  return has_planes ? open_plain_tiff(path) : open_libtiff(path);
#endif
}

}  // namespace isosplat::import
