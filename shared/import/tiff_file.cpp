#include "shared/import/tiff_file.h"

#include <fmt/format.h>

namespace isosplat {

void set_voxel_type(uint16_t bits, uint16_t format, TiffPage& page) {
  const bool is_signed = format == 2, is_float = format == 3;
  if (format == 5 || format == 6) {
    page.unknown = "complex numbers";
  } else if (bits == 8 && !is_float) {
    page.type = is_signed ? VoxelType::i8 : VoxelType::u8;
  } else if (bits == 16 && !is_float) {
    page.type = is_signed ? VoxelType::i16 : VoxelType::u16;
  } else if (bits == 32) {
    page.type = is_float ? VoxelType::f32 : is_signed ? VoxelType::i32 : VoxelType::u32;
  } else if (bits == 64) {
    page.type = is_float ? VoxelType::f64 : is_signed ? VoxelType::i64 : VoxelType::u64;
  } else {
    page.unknown = fmt::format("{} bits per voxel{}", bits, is_float ? ", float" : "");
  }
}

std::unique_ptr<TiffFile> open_tiff(const std::filesystem::path& path) {
#ifdef __EMSCRIPTEN__
  return open_plain_tiff(path);
#else
  return open_libtiff(path);
#endif
}

}  // namespace isosplat
