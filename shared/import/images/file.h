#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/voxel_type.h"

// Pictures that are slices of a volume: PNG, JPEG and JPEG 2000.
namespace isosplat::import {

/// The contents of a picture's header.
struct ImageInfo {
  std::string_view format;  ///< "PNG", "JPEG" or "JPEG 2000"
  int64_t width = 0, height = 0;
  int channels = 1;  ///< an alpha channel counts; a palette is three
  int bits = 8;      ///< of a sample
  bool is_signed = false;
  bool is_interlaced = false;  ///< PNG
  /// Pixels per metre along x and y. They are often those of a screen.
  std::optional<double> density_x, density_y;

  VoxelType type() const {
    if (bits <= 8) return is_signed ? VoxelType::i8 : VoxelType::u8;
    return is_signed ? VoxelType::i16 : VoxelType::u16;
  }
  bool same_kind(const ImageInfo& other) const {
    return width == other.width && height == other.height && type() == other.type() &&
           channels == other.channels;
  }
};

/// "PNG", "JPEG" or "JPEG 2000" by a file's first bytes; empty for others.
std::string_view image_format_of(std::string_view beginning);

/// Reads the header. Errors: io_error, malformed_volume if the file is damaged or not a picture.
Result<ImageInfo> read_image_info(const std::filesystem::path& path);

/// Decodes a picture of one channel and up to 16 bits: native-endian samples, rows from the top.
/// `out` has exactly its size. Errors: io_error, malformed_volume for damaged files,
/// unsupported_format for JPEG and JPEG 2000 in WebAssembly.
Result<void> decode_image(const std::filesystem::path& path, const ImageInfo& info,
                          uint64_t memory_bytes, std::span<std::byte> out);

// Functions of each format. `file`: all bytes of the file. Nothing or false: the file is damaged.
std::optional<ImageInfo> png_info(std::span<const uint8_t> file);
bool decode_png(std::span<const uint8_t> file, const ImageInfo& info, std::span<std::byte> out);
std::optional<ImageInfo> jpeg_info(std::span<const uint8_t> file);
std::optional<ImageInfo> jpeg2000_info(std::span<const uint8_t> file);

/// With libjpeg and OpenJPEG, in a child process: native only. Errors: those of decode_image.
Result<void> decode_with_library(const std::filesystem::path& path, std::span<const uint8_t> file,
                                 const ImageInfo& info, uint64_t memory_bytes,
                                 std::span<std::byte> out);

/// The error for a damaged picture.
tl::unexpected<Error> damaged_image(const std::filesystem::path& path);

}  // namespace isosplat::import
